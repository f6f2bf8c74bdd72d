"""The stages of method2.in: included by LAMMPS or put into one deck, from the start or from a checkpoint, the same bytes."""

from __future__ import annotations

import filecmp
import shutil
import subprocess
from pathlib import Path

import pytest

from workflow.deck.template import DATA, data_file, render, templates
from workflow.runs.installation import engine
from workflow.scene.method2 import Method2

# all six stages in two seconds: soft contacts that stiffen, one stress, background damping whose account resumes too
SCENE = Method2(n=40, kappa=1e4, soft_kappa=1e3, d0=0.02, stiffening=1.0, quiet=1.0, hold=0.1, pstar=0.05, frame_interval=20.0,
                checkpoint_interval=0.1, drag=0.04)  # fmt: skip


def run(folder: Path, deck: str, *words: str) -> str:
    """Run a deck with plain lmp; its last line RESULT."""
    (folder / DATA).write_text(data_file(SCENE.discs()))
    found = engine()
    command = [found.lmp, "-in", deck, "-screen", "none", *words]
    done = subprocess.run(command, cwd=folder, env=found.variables(), capture_output=True, text=True, check=False)
    log = (folder / "log.lammps").read_text()
    assert done.returncode == 0, log[-500:]
    return [line for line in log.splitlines() if line.startswith("RESULT")][-1]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder and result of the rendered deck."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "deck.in").write_text(render(SCENE))
    return folder, run(folder, "deck.in")


def test_every_stage_runs(whole: tuple[Path, str]) -> None:
    folder, result = whole
    assert result.startswith("RESULT stage 6 ") and "equilibrated 1 stopped 0" in result
    assert sorted(path.name for path in folder.glob("stage.*.in")) == [f"stage.{k}.in" for k in range(1, 7)]


def test_files_included_by_lammps_give_the_bytes_of_the_rendered_deck(whole: tuple[Path, str], tmp_path: Path) -> None:
    inputs = tmp_path / "inputs"
    shutil.copytree(templates(), inputs)
    values = {**SCENE.variables(), "data": DATA}
    words = [
        str(word)
        for name, value in values.items()
        for word in ("-var", name, repr(value) if isinstance(value, float) else value)
    ]
    assert run(inputs, "method2.in", *words) == whole[1]
    for name in ("series.txt", "grains.dump", "contacts.dump"):
        assert filecmp.cmp(inputs / name, whole[0] / name, shallow=False), name


@pytest.mark.parametrize("stage", range(1, 7))
def test_a_stage_that_resumes_ends_where_it_would_have(whole: tuple[Path, str], tmp_path: Path, stage: int) -> None:
    """Grains and contacts to the last digit, and every row of the series from there on."""
    folder, result = whole
    checkpoints = folder.glob(f"checkpoint.{stage}.[ab]")
    oldest = min(checkpoints, key=lambda path: path.stat().st_mtime_ns)  # the other may lie behind the last row
    for path in (*folder.glob("stage.*.in"), folder / "account.in", folder / "deck.in", oldest):
        shutil.copy(path, tmp_path)
    words = {"resume": "yes", "restart": oldest.name, "stage": str(stage)}
    assert run(tmp_path, "deck.in", *(word for name, value in words.items() for word in ("-var", name, value))) == result
    for name in ("grains.dump", "contacts.dump"):
        ends = [(where / name).read_text().rpartition("ITEM: TIME\n")[2] for where in (tmp_path, folder)]
        assert ends[0] == ends[1], name
    rows, expected = ((where / "series.txt").read_text().splitlines() for where in (tmp_path, folder))
    assert set(rows) <= set(expected) and rows[-1] == expected[-1]
