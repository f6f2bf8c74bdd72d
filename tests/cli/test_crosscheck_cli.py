"""wf crosscheck as a user calls it."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
from pathlib import Path

import pytest
from wf_process import Wf


def test_decks_are_written_and_run_alone(wf: Wf, tmp_path: Path) -> None:
    done = wf("crosscheck", "--deck-only", "--n", "50", "--seeds", "3", "--out", "with space")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[:2] == [f"with space/seed3/{name}/run.sh" for name in ("liggghts", "yade")]
    folder = tmp_path / "with space" / "seed3" / "liggghts"
    assert {path.name for path in folder.iterdir()} == {"crosscheck_liggghts.in", "liggghts.data", "liggghts.law", "run.sh"}
    if not shutil.which("liggghts"):
        pytest.skip("liggghts is not installed: apt-get install liggghts")
    script = folder / "run.sh"
    words = script.read_text().split()
    words[words.index("steps") + 1], words[words.index("relax_steps") + 1] = "200", "100"
    script.write_text("#!/bin/sh\n" + " ".join(words[1:]) + "\n")
    assert subprocess.run(["sh", "run.sh"], cwd=folder, check=False, capture_output=True).returncode == 0
    assert "ITEM: NUMBER OF ATOMS\n50\n" in (folder / "grains.dump").read_text()


def test_without_other_programs_it_says_how_to_get_them(wf: Wf, tmp_path: Path) -> None:
    done = wf("crosscheck", "--parts", "packings", "--n", "50", "--seeds", "1", "--out", "out", PATH=str(tmp_path))
    assert done.returncode == 1
    for name in ("liggghts", "yade"):
        assert f"{name} not installed: apt-get install {name}" in done.stderr
    with open(tmp_path / "out" / "packings.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["engine"] for row in rows] == ["exact", "exact, half the step"]
    for row in rows:
        assert 0.7 < float(row["solid_fraction"]) < 0.9, row
    assert (tmp_path / "out" / "packings.png").stat().st_size > 10_000


@pytest.mark.validation  # half a minute of LIGGGHTS
@pytest.mark.skipif(not shutil.which("liggghts"), reason="liggghts is not installed: apt-get install liggghts")
def test_packing_of_another_program_is_measured_like_ours(wf: Wf, tmp_path: Path) -> None:
    words = ["--parts", "packings", "--n", "50", "--seeds", "1", "--engines", "liggghts", "--out", "out", "--json"]
    done = wf("crosscheck", *words)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    ours, _, theirs = result["packings"]
    assert (ours["engine"], theirs["engine"]) == ("exact", "liggghts")
    # one sample of 50 grains: the numbers scatter by some percent
    assert theirs["solid_fraction"] == pytest.approx(ours["solid_fraction"], abs=0.05)
    assert theirs["coordination_backbone"] == pytest.approx(ours["coordination_backbone"], abs=0.4)
    assert theirs["kinetic"] < 1e-8
    assert {row["number"] for row in result["means"]} >= {"solid_fraction", "coordination", "second_moment"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--engines", "pfc"], "--engines 'pfc' is not known; known are: liggghts, yade"),
        (["--parts", "all"], "--parts 'all' is not known; known are: few, packings"),
        (["--seeds", "1,x"], "--seeds 'x' is not allowed"),
        (["--n", "3"], "n = 3 is not allowed"),
        (["--mu", "-1"], "mu = -1"),
        (["--out", "/proc/nowhere"], "give a writable --out DIR"),
    ],
)
def test_misuse_of_crosscheck_is_named(words: list[str], message: str, wf: Wf) -> None:
    done = wf("crosscheck", *words)
    assert done.returncode == 2 and message in done.stderr
