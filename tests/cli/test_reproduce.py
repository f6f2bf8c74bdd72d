"""`wf reproduce` from the data to the scoreboard, on a paper small enough for a test."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from workflow.cli.main import main
from workflow.reproduce import papers

TINY = """
paper = "A paper of sixty grains"
short = "T1"
uncertainty = "as printed"
[quick]
n = 60
samples = 1
[[block]]
table = "1"
title = "tiny packings"
options = { scene = "method1", cohesion = false, kappa = 1e3, hold = 1 }
row = [{ name = "small", samples = [[60, 2]] }]
column = [{ name = "rough", options = { mu = 0.5 } }, { name = "smooth", options = { mu = 0.1 } }]
  [[block.number]]
  name = "Phi"
  measure = "solid_fraction"
  value = [[0.79, 0.1]]
  error = [[0.05, 0.01]]
  reason = "made up"
  [[block.number]]
  name = "rattlers"
  measure = "rattler_fraction"
  high = 1.0
  [[block.number]]
  name = "z at the end of the compression"
  measure = "coordination"
  value = [[3.0, nan]]
  error = [[5.0, nan]]
[[block]]
table = "2"
title = "no scene"
row = [{ name = "" }]
column = [{ name = "" }]
  [[block.number]]
  name = "the answer"
  value = 42
  reason = "no scene gives it"
[[block]]
table = "figure"
title = "not computed here"
options = { scene = "method1", cohesion = false }
row = [{ name = "large" }]
column = [{ name = "rough" }]
[[figure]]
number = "1a"
plot = "coordination"
of = [["1", "small", "rough"]]
shows = "bars"
[[figure]]
number = "2"
plot = "density"
of = [["1", "small", "rough"], ["1", "small", "smooth"]]
most = 1
shows = "two curves"
[[figure]]
number = "3"
plot = "continuous_law"
shows = "two laws"
[[figure]]
number = "4"
plot = "density"
of = [["1", "small", "rough"], ["figure", "large", "rough"]]
partial = true
shows = "what there is"
[[figure]]
number = "5"
plot = "density"
of = [["figure", "large", "rough"]]
shows = "nothing yet"
"""


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of papers with one, and the place to work in."""
    (tmp_path / "papers").mkdir()
    (tmp_path / "papers" / "tiny.toml").write_text(TINY)
    monkeypatch.setattr(papers, "_folder", lambda: tmp_path / "papers")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_from_the_data_to_the_scoreboard(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "tiny", "--no-run"]) == 0  # nothing is there yet
    assert "6 not run" in capsys.readouterr().out
    assert main(["reproduce", "tiny", "--jobs", "2"]) == 0
    out = capsys.readouterr().out
    assert "4 agrees, 1 differs, 0 misprint suspected, 0 not judged, 1 not run" in out
    with open("runs/tiny/scoreboard.csv", newline="") as file:
        table = {(row["column"], row["quantity"]): row for row in csv.DictReader(file)}
    rough = table["rough", "Phi"]
    each = []
    for name in rough["digests"].split():
        each.append(json.loads(Path(f"runs/tiny/points/{name}/measures.json").read_text())["solid_fraction"])
    assert len(each) == 2
    assert float(rough["ours"]) == pytest.approx(sum(each) / 2.0, rel=1e-14)
    assert float(rough["standard_error"]) == pytest.approx(abs(each[0] - each[1]) / 2.0, rel=1e-12)
    assert rough["at_rest"] == "2"
    assert table["smooth", "Phi"]["verdict"] == "differs"
    assert table["smooth", "Phi"]["reason"] == "made up"
    assert table["", "the answer"]["reason"] == "no scene gives it"
    text = Path("runs/tiny/scoreboard.md").read_text()
    page = Path("runs/tiny/scoreboard.html").read_text()
    assert "<h2>Table 2" in page and "agrees" in page
    assert "4 of 4 finished" in text
    assert "[figures/fig2.png]" in text
    assert "| 5 | not all of its samples are finished |" in text
    for name in ("fig1a", "fig2", "fig3", "fig4"):
        assert Path(f"runs/tiny/figures/{name}.png").stat().st_size > 5000
    before = {path: path.stat().st_mtime_ns for path in Path("runs/tiny/points").glob("*/run.json")}
    assert main(["reproduce", "tiny", "--json"]) == 0  # nothing is computed again
    assert json.loads(capsys.readouterr().out)["counts"]["agrees"] == 4
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert main(["reproduce", "tiny", "--quick", "--adopt", "runs/tiny", "--table", "1"]) == 0
    said = capsys.readouterr()
    assert "adopted 2 finished runs" in said.err
    assert "not the paper's size" in said.err
    assert "Not the paper's size" in Path("runs/tiny-quick/scoreboard.md").read_text()


def test_measures_of_an_earlier_stage_are_kept(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The frame at the end of `compress` is not the end of the run; what was measured of it is read the next time."""
    text = TINY.replace("samples = [[60, 2]]", 'samples = [[60, 1]], stage = "compress"')
    (tiny / "papers" / "tiny.toml").write_text(text)
    assert main(["reproduce", "tiny", "--table", "1"]) == 0
    capsys.readouterr()
    runs = {kept: json.loads(kept.read_text()) for kept in Path("runs/tiny/measures").iterdir()}
    ends = {kept: json.loads(Path(f"runs/tiny/points/{kept.stem}/measures.json").read_text())["step"] for kept in runs}
    # a sample that is at rest when it is compressed has no later stage; the other goes on
    kept = max(runs, key=lambda one: ends[one] - runs[one]["compress standard"]["step"])
    table = runs[kept]
    assert table["compress standard"]["step"] < ends[kept]
    table["compress standard"]["solid_fraction"] = 0.5
    kept.write_text(json.dumps(table))
    assert main(["reproduce", "tiny", "--table", "1", "--json"]) == 0
    assert 0.5 in [row["ours"] for row in json.loads(capsys.readouterr().out)["numbers"]]


@pytest.mark.parametrize(("stage", "options", "known"), [
    ("free", "pstar = 0", True),
    ("stiffen", "soft_kappa = 100, pstar = 0", False),  # still soft
    ("settle", "pstar = 0.01", False),  # without its load
])  # fmt: skip
def test_sample_whose_time_was_over_before_the_stage(
    stage: str, options: str, known: bool, tiny: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two aggregates that never meet: the sample is measured as it is, and is not at rest."""
    text = TINY.replace(
        'scene = "method1", cohesion = false, kappa = 1e3, hold = 1', f'scene = "method2", max_time = 1, {options}'
    )
    (tiny / "papers" / "tiny.toml").write_text(text.replace("samples = [[60, 2]]", f'samples = [[60, 1]], stage = "{stage}"'))
    assert main(["reproduce", "tiny", "--table", "1", "--json"]) == 0
    lines = json.loads(capsys.readouterr().out)["numbers"]
    for line in lines:
        assert (line["ours"] is not None) == known
        assert (line["samples"], line["at_rest"]) == ((1, 0) if known else (0, 0))
        assert known or f"no frame of stage {stage}" in line["reason"]


def test_samples_of_a_scoreboard_made_elsewhere_are_pooled(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All samples here, some here and some there, all there: the numbers are the same."""
    assert main(["reproduce", "tiny", "--jobs", "2"]) == 0
    whole = json.loads(Path("runs/tiny/scoreboard.json").read_text())
    Path("runs/tiny").rename("elsewhere")
    capsys.readouterr()
    pooling = ["reproduce", "tiny", "--no-run", "--pool", "elsewhere/scoreboard.json"]
    for folder, own in (("none", 0), ("half", 1), ("all", 2)):
        for name in whole["numbers"][0]["digests"].split()[:own]:
            shutil.copytree(Path("elsewhere/points") / name, Path("runs") / folder / "points" / name)
        assert main([*pooling, "--out", f"runs/{folder}"]) == 0
        found = json.loads(Path(f"runs/{folder}/scoreboard.json").read_text())
        assert found["counts"] == whole["counts"]
        for one, line in zip(found["numbers"], whole["numbers"], strict=True):
            for name in ("ours", "standard_error", "difference"):
                assert one[name] == (None if line[name] is None else pytest.approx(line[name], rel=1e-12)), one
            assert [one[name] for name in ("digests", "seeds", "values", "at_rest", "verdict")] == [
                line[name] for name in ("digests", "seeds", "values", "at_rest", "verdict")
            ]
        here = {line["pooled"] for line in found["numbers"] if line["column"] == "rough"}
        assert here == {2 - own}
        figures = {one["number"]: one["file"] for one in found["figures"]}
        assert figures["1a"] == "figures/fig1a.png" and not figures["5"]
        taken = found["provenance"]["pooled with"]
        assert ("1a" in taken) == (own < 2)
        assert found["provenance"]["scoreboard 1: file"] == "elsewhere/scoreboard.json"
        assert found["provenance"]["scoreboard 1: runs"].startswith("4 of 4 finished")
        assert ("made with" in found["provenance"]) == (own > 0)
    # pooled once more, with both: each is named once
    assert main([*pooling, "--pool", "runs/none/scoreboard.json", "--out", "runs/again"]) == 0
    again = json.loads(Path("runs/again/scoreboard.json").read_text())["provenance"]
    assert [again[f"scoreboard {k}: file"] for k in (1, 2)] == ["elsewhere/scoreboard.json", "runs/none/scoreboard.json"]
    assert not any(name.startswith("scoreboard 3") for name in again)
    # of other scenes nothing is taken
    assert main([*pooling, "--quick", "--out", "runs/quick"]) == 0
    assert not any(line["samples"] for line in json.loads(Path("runs/quick/scoreboard.json").read_text())["numbers"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "cannot be read"),
        ("{", "is no scoreboard.json"),
        ("[]", "is no scoreboard.json"),
        ('{"numbers": [{"table": "1"}], "figures": [], "provenance": {}}', "is no scoreboard.json"),
    ],
)
def test_a_file_that_is_no_scoreboard_is_named(
    text: str | None, said: str, tiny: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if text is not None:
        Path("board.json").write_text(text)
    assert main(["reproduce", "tiny", "--no-run", "--pool", "board.json"]) == 2
    assert f"--pool board.json {said}" in capsys.readouterr().err
    assert not Path("runs").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["tini"], "unknown paper 'tini'; did you mean tiny?"),
        (["tiny", "--table", "7"], "--table 7 is not known in T1; there are: 1, 2"),
        (["tiny", "--table", "2..a"], "--table 2..a is not allowed"),
        (["tiny", "--figure", "6"], "--figure 6 is not known in T1; there are: 1, 2, 3, 4, 5"),
        (["tiny", "--samples", "0"], "--samples 0 is not allowed"),
        (["tiny", "--jobs", "0"], "--jobs 0 is not allowed"),
    ],
)
def test_misuse_of_reproduce_is_named_and_starts_no_run(
    words: list[str], said: str, tiny: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", *words]) == 2
    assert said in capsys.readouterr().err
    assert not Path("runs").exists()


def test_dry_run_lists_points_and_figures(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "tiny", "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "4 points, 0 done" in out
    assert "figure 2: density: two curves" in out
    assert not Path("runs").exists()


def test_the_job_array_has_a_task_for_every_point(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The script of the array for the four runs; a machine without Slurm says so and computes nothing."""
    assert main(["reproduce", "tiny", "--scheduler", "slurm", "--time", "1:00:00", "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "4 points as 4 tasks" in out
    assert "#SBATCH --array=0-3" in out and "#SBATCH --time=01:00:00" in out
    assert main(["reproduce", "tiny", "--time", "1:00:00"]) == 2
    assert "--scheduler" in capsys.readouterr().err
