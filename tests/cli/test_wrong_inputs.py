"""A hundred wrong inputs over all commands: status 2, one sentence that names what is wrong and the way out, nothing written.

They run in this process, where an exception that reaches the top is a failed test.
"""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.cli.main import COMMANDS, main, parser

# command line -> words of the sentence, the last one of the way out
WRONG: dict[str, list[str]] = {
    # names of commands, scenes and options
    "rnu": ["COMMAND 'rnu'", "did you mean run?"],
    "meassure packing": ["'meassure'", "did you mean measure?"],
    "--verson": ["--verson", "did you mean --version?"],
    "": ["COMMAND is missing", "wf --help"],
    "run": ["SCENE is missing", "wf run --help"],
    "run metod1": ["'metod1'", "did you mean method1?"],
    "run heep": ["'heep'", "did you mean heap?"],
    "run method1 --fricton 0.3": ["--fricton", "wf run method1 --help"],
    "run method1 --kapa 1e4": ["--kapa", "did you mean --kappa"],
    "run method1 --max_time 3": ["--max_time", "did you mean --max-time"],
    "run method1 --no-cohesio": ["--no-cohesio", "did you mean --no-cohesion"],
    "run method1 --barost berendsen": ["--barost", "did you mean --barostat"],
    "run method1 --as-print": ["--as-print", "did you mean --as-printed"],
    "run method1 --step-per-period 30": ["--step-per-period", "did you mean --steps-per-period"],
    "run heap --grain 20": ["--grain", "did you mean --grains"],
    "run heap --pstar 0.1": ["--pstar is an option of", "not of heap", "wf run heap --help"],
    "run heap --kappa 1e4": ["--kappa is an option of", "not of heap", "wf run heap --help"],
    "run method1 --hooke 500": ["--hooke is an option of heap, not of method1", "wf run method1 --help"],
    "run method1 --v0 3": ["--v0 is an option of", "not of method1", "wf run method1 --help"],
    "run method2 --unload": ["--unload is an option of consolidation", "wf run method2 --help"],
    "run method1 --grains 20": ["--grains is an option of heap", "wf run method1 --help"],
    "deck method1 --anew": ["--anew", "wf deck method1 --help"],
    "resume packing --anw": ["--anw", "did you mean --anew"],
    "measure packing --ony forces": ["--ony", "did you mean --only"],
    "plot packing --figur forces": ["--figur", "did you mean --figure"],
    "report packing --output x.html": ["--output", "did you mean --out"],
    "export packing --al": ["--al", "did you mean --all"],
    "sweep study.toml --dryrun": ["--dryrun", "did you mean --dry-run"],
    "reproduce gilabert2007 --quik": ["--quik", "did you mean --quick"],
    "status --jsn": ["--jsn", "did you mean --json"],
    "verify packing --lst": ["--lst", "did you mean --last"],
    "bench --engine exact": ["--engine", "did you mean --engines"],
    "scale --step 10": ["--step", "did you mean --steps"],
    "crosscheck --seed 1": ["--seed", "did you mean --seeds"],
    "accuracy --eror 1e-2": ["--eror", "did you mean --error"],
    "stability --quck": ["--quck", "did you mean --quick"],
    "doctor --jason": ["--jason", "did you mean --json"],
    "units --diametre 1um": ["--diametre", "did you mean --diameter"],
    "completion dos": ["SHELL 'dos'", "bash"],
    # one word too many, one too few
    "run method1 heap": ["'heap' is one word too many", "wf run method1 --help"],
    "resume": ["DIR is missing", "wf resume --help"],
    "verify a b": ["'b' is one word too many", "wf verify --help"],
    "run method1 --mu": ["--mu needs a value", "wf run method1 --help"],
    "resume packing --max-time": ["--max-time needs a value", "wf resume --help"],
    "run method1 --rolling=yes": ["--rolling", "takes no value", "wf run method1 --help"],
    "measure packing --window 1": ["--window needs 2 values", "wf measure --help"],
    # values
    "run method1 --mu rough": ["--mu 'rough'", "number", "wf run method1 --help"],
    "run method1 --mu -0.1": ["mu = -0.1", "not below 0"],
    "run method1 --mu nan": ["mu = nan", "a number"],
    "run method1 --n 1.5": ["--n", "1.5 is not a whole number", "wf run method1 --help"],
    "run method1 --n ten": ["--n 'ten'", "whole number", "wf run method1 --help"],
    "run method1 --n -5": ["n = -5", "not below 1"],
    "run method1 --n 1e10": ["n = 10000000000", "not above 1e+09"],
    "run method1 --phi0 0.9": ["phi0 = 0.9", "not above 0.6"],
    "run method1 --kappa 0": ["kappa = 0", "not below 100"],
    "run method1 --zeta 3": ["zeta = 3", "not above 2"],
    "run method1 --pstar 0": ["pstar = 0", "above 0"],
    "run method1 --seed -1": ["seed = -1", "not below 0"],
    "run method1 --initial solid": ["--initial 'solid'", "fluid", "wf run method1 --help"],
    "run method1 --scheme third": ["--scheme 'third'", "second", "wf run method1 --help"],
    "run method1 --cell stain": ["--cell 'stain'", "did you mean strain?"],
    "run method1 --step 1": ["step = 1", "use at most"],
    "run method1 --skin 1e-4": ["skin = 0.0001", "leave it out"],
    "run method1 --hold 1e300": ["hold = 1e+300", "not above"],
    "run method2 --no-cohesion": ["cohesion = false", "use method1"],
    "run method2 --barostat berendsen": ["barostat = 'berendsen'", "use inertial"],
    "run method2 --series C": ["--series 'C'", "A"],
    "run consolidation --pstar-first 20": ["pstar_first = 20", "must not exceed"],
    "run consolidation --per-decade 100 --pstar 100": ["per_decade = 100", "use fewer"],
    "run heap --n 0": ["grains = 0", "not below 1"],
    "run heap --feed-rate 5": ["feed_rate = 5", "use at most"],
    "run heap --n 10 --grains 20 --feed-half-width 90": ["feed_half_width = 90", "widen --base-half-width"],
    "run heap --base soft": ["--base 'soft'", "rough"],
    "run method1 --ranks 0": ["--ranks 0", "at least 1"],
    "run method1 --ranks 999": ["999", "--oversubscribe"],
    "run method1 --ranks two": ["--ranks 'two'", "whole number", "wf run method1 --help"],
    "run absent.toml": ["'absent.toml'", "give the path of a TOML file"],
    "run note.toml": ["'note.toml'", "example"],
    "run other.toml": ["'methud1'", "did you mean method1"],
    "run method1 --n 60 --out note.toml": ["'note.toml' exists", "--out DIR"],
    "deck method1 --time 1:00": ["--time", "add --scheduler or --profile"],
    "deck method1 --scheduler condor": ["--scheduler 'condor'", "slurm"],
    "deck method1 --scheduler slurm --time soon": ["soon", "HH:MM:SS"],
    "resume absent": ["'absent' does not exist", "give the directory"],
    "measure": ["name a run directory or a dump"],
    "measure absent": ["'absent' does not exist", "give the directory"],
    "measure absent --only forzes": ["forzes", "did you mean forces?", "choose from forces"],
    "measure absent --window 2 1": ["--window 2 1", "ascend"],
    "measure absent --mu 0.3": ["--mu is for dumps of other programs", "leave it out"],
    "measure absent --kn 2": ["--kn is for dumps of other programs", "leave it out"],
    "plot absent --columns fx=c_2": ["--columns is for dumps of other programs", "leave it out"],
    "measure absent --frame last": ["--frame 'last'", "whole number", "wf measure --help"],
    "measure 'x*.dump'": ["'x*.dump' names no file", "check the pattern"],
    "plot absent --figure all": ["'absent' does not exist", "give the directory"],
    "report absent --out page.pdf": ["--out page.pdf", "ends in .html"],
    "report absent --diameter 3um": ["--diameter", "add --si"],
    "report absent --si": ["--si needs a powder", "--diameter"],
    "export absent": ["'absent' does not exist", "give the directory"],
    "sweep absent.toml": ["'absent.toml'", "give the path of a TOML file"],
    "sweep note.toml --jobs 0": ["0", "at least 1"],
    "reproduce gilbert2007": ["gilbert2007", "gilabert2007"],
    "reproduce gilabert2007 --table 2..x": ["--table 2..x", "a range as 2..5"],
    "reproduce gilabert2007 --samples 0": ["--samples 0", "at least 1"],
    "status absent": ["'absent' does not exist", "give the directory"],
    "verify absent": ["'absent' does not exist", "give the directory"],
    "bench --engines exactly": ["--engines 'exactly'", "did you mean exact?", "known are: exact"],
    "bench --n 1,2": ["--n '1'", "at least 50"],
    "bench absent --n 1400": ["leave out DIR"],
    "scale --n 10": ["--n '10'", "at least 2000"],
    "scale --ranks 2": ["--ranks 2", "give 1 too"],
    "crosscheck --seeds 1,x": ["--seeds 'x'", "give whole numbers"],
    "crosscheck --parts many": ["--parts 'many'", "known are: few"],
    "accuracy --error 0": ["--error 0", "for example 1e-3"],
    "accuracy --error small": ["--error 'small'", "number", "wf accuracy --help"],
    "units --diameter 10um --density 1200": ["found 0 of them", "--force"],
    "units --diameter 10s --density 1200 --force 1nN": ["--diameter '10s'", "for example 10um"],
    "units --diameter 10um --density heavy --force 1nN": ["--density 'heavy'", "for example 1200kg/m^3"],
    "units --diameter 10um --density 1 --force 0N": ["--force '0N'", "above 0", "30nN"],
    "units --diameter 1m --density 1 --force 1N --convert 5K": ["'5K'", "such as 5Pa"],
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current directory, with two files."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "note.toml").write_text("no scene, no study")
    (tmp_path / "other.toml").write_text('scene = "methud1"')
    return tmp_path


def test_there_are_a_hundred() -> None:
    assert len(WRONG) >= 100


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_refuses_an_option_that_it_has_not(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, *(["method1"] if name in ("run", "deck") else []), "--nonsense=3"]) == 2
    text = capsys.readouterr()
    assert text.out == "" and text.err.startswith("wf: unknown option --nonsense") and f"wf {name}" in text.err


@pytest.mark.parametrize("words", WRONG)
def test_it_is_refused_in_one_sentence_with_the_way_out(words: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(here.rglob("*"))
    assert main(shlex.split(words)) == 2
    text = capsys.readouterr()
    said = [line for line in text.err.splitlines() if not line.startswith("note: ")]
    assert text.out == "" and len(said) == 1 and said[0].startswith("wf: "), text.err
    missing = [part for part in WRONG[words] if part not in text.err]
    assert not missing, text.err
    assert sorted(here.rglob("*")) == before


def flags(command: str) -> list[str]:
    """The long options of a command, those of method1 for one that takes a scene."""
    found = next(one for one in parser(command).commands())
    if found.prepare:
        found.prepare(["method1"])
    return sorted(flag for action in found.arguments() for flag in action.option_strings if flag.startswith("--"))


KNOWN = {name: flags(name) for name in COMMANDS}


@given(data=st.data())
def test_an_option_that_lost_its_end_is_refused_and_named(data: st.DataObject) -> None:
    """No abbreviation: every beginning of an option that is none itself is refused, with the option among the suggestions."""
    command = data.draw(st.sampled_from(sorted(KNOWN)))
    flag = data.draw(st.sampled_from(KNOWN[command]))
    short = flag[: data.draw(st.integers(max(len(flag) - 2, min(4, len(flag))), len(flag)))]
    if short in KNOWN[command]:
        return
    words = [command, *(["method1"] if command in ("run", "deck") else []), f"{short}=1"]
    with pytest.MonkeyPatch.context() as patch:
        said: list[str] = []
        patch.setattr("workflow.cli.main._failed", lambda text, status=1: said.append(text) or status)
        assert main(words) == 2
    assert short in said[0] and "--help" in said[0]
