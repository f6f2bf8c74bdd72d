"""Options of the command line: those of one scene in groups, lists, what has no effect, completion."""

from __future__ import annotations

import re
import subprocess
from dataclasses import fields
from pathlib import Path

import pytest

from workflow.cli.main import COMMANDS, main, parser
from workflow.scene.parameter import GROUPS, quantity_of
from workflow.scene.registry import SCENES


def help_of(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as end:
        main([*words, "--help"])
    assert end.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", SCENES)
def test_help_shows_the_options_of_that_scene_in_groups(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = help_of(["run", name], capsys)
    titles = [line[:-1] for line in text.splitlines() if line[:-1] in GROUPS and line.endswith(":")]
    assert titles == list(GROUPS)
    flat = re.sub(r"\s+", " ", text)
    own = {item.name: quantity_of(item) for item in fields(SCENES[name])}
    shown = set(re.findall(r"^  (?:--n N, )?(--[a-z0-9-]+)", text, re.MULTILINE))
    assert shown >= {"--" + item.replace("_", "-") for item in own}
    others = {item.name for scene in SCENES.values() for item in fields(scene)} - set(own) - {"n"}
    assert not shown & {"--" + item.replace("_", "-") for item in others}
    for known in own.values():
        assert not known.unit or f"[{known.unit}]" in flat
    assert "T0" not in text if name == "heap" else "sqrt(sigma/g)" not in text


def test_help_without_a_scene_says_where_its_parameters_are(capsys: pytest.CaptureFixture[str]) -> None:
    text = help_of(["run"], capsys)
    assert "'wf run SCENE --help'" in text.replace("\n                   ", " ") and "--kappa" not in text


@pytest.mark.parametrize("words", [["--mu", "0.3", "method1"], ["--rolling", "method1"], ["--out", "method2", "method1"]])
def test_the_scene_may_stand_anywhere(words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert parser("deck").parse_args(["deck", *words, "--kappa", "1e4"]).kappa == 1e4


@pytest.mark.parametrize("flag", ["--n", "--grains"])
def test_a_heap_has_its_number_of_grains_under_two_names(flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["deck", "heap", flag, "20", "--dry-run"]) == 0
    assert capsys.readouterr().out == _deck(["heap", "--grains", "20"], capsys)


def _deck(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["deck", *words, "--dry-run"]) == 0
    return capsys.readouterr().out


IDLE = {
    "method1 --no-cohesion --pstar 1": "--pstar", "method1 --no-cohesion --d0 0.01": "--d0", "method1 --mur 0.1": "--mur",
    "method1 --berendsen-rate 1": "--berendsen-rate",
    "method1 --mu 0 --kt-ratio 0.5": "--kt-ratio", "method1 --step 1e-5 --steps-per-period 30": "--steps-per-period",
    "method2 --stiffening 3": "--stiffening", "method2 --v0 0 --velocities same": "--velocities",
    "method1 --barostat berendsen --hold 1 --cell-mass 1": "--cell-mass",
    "heap --hooke 500 --index 12": "--index", "heap --start pyramid --feed-rate 0.3": "--feed-rate",
}  # fmt: skip


@pytest.mark.parametrize("words", IDLE)
def test_an_option_without_effect_is_told_and_has_none(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    flag = IDLE[words]
    parts = [*words.split(), "--grains" if words.startswith("heap") else "--n", "60"]
    at = parts.index(flag)
    told = _run_deck(parts, capsys)
    assert f"note: {flag} has no effect: " in told[1]
    without = _run_deck([*parts[:at], *parts[at + 2 :]], capsys)
    assert f"note: {flag}" not in without[1]
    pairs = list(zip(told[0].splitlines(), without[0].splitlines(), strict=True))
    assert sum(one != other for one, other in pairs) <= 1  # its own variable, which nothing reads then


def _run_deck(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    assert main(["deck", *words, "--dry-run"]) == 0
    text = capsys.readouterr()
    return text.out, text.err


@pytest.mark.parametrize("words", [["--n", "50,60"], ["--n", "50", "--n", "60"], ["--n", "50, 60"], ["--n=50", "--n=60"]])
def test_a_list_takes_commas_and_repetition(words: list[str]) -> None:
    from workflow.cli.lists import grains, listed

    for command in ("bench", "scale"):
        given = parser(command).parse_args([command, *words]).n
        assert listed("--n", given, grains(50)) == [50, 60]


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh", "fish"])
def test_completion_scripts_know_every_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert not [name for name in COMMANDS if name not in script]
    assert "barostat" in script and "berendsen" in script


def test_bash_completes_options_scenes_and_choices(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bash"]) == 0
    (tmp_path / "wf.sh").write_text(capsys.readouterr().out)
    for words, expected in {
        "wf sta": {"status", "stability"}, "wf run met": {"method1", "method2"}, "wf run method1 --baro": {"--barostat"},
        "wf run method1 --initial fl": {"fluid"},
    }.items():  # fmt: skip
        parts = words.split()
        line = f"source wf.sh; COMP_WORDS=({words}); COMP_CWORD={len(parts) - 1}; _shtab_wf; echo ${{COMPREPLY[@]}}"
        done = subprocess.run(["bash", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=True)
        assert set(done.stdout.split()) == expected, done.stderr
