"""`wf run consolidation`: at rest under each stress, denser under a higher one, resumed exactly; its table and its figure."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from test_exact_resume import resume_after_last_checkpoint
from wf_process import Wf, call, record

from workflow.data.series import read_series

# stages 1 to 10: two stresses up, one down, each with load and settle
WORDS = [
    "consolidation", "--n", "60", "--kappa", "1e4", "--soft-kappa", "1e3", "--d0", "0.01", "--stiffening", "3", "--rolling",
    "--quiet", "2", "--hold", "0.2", "--checkpoint-interval", "0.06", "--pstar", "1", "--pstar-first", "0.1",
    "--per-decade", "1", "--unload",
]  # fmt: skip
STRESSES = (0.1, 1.0, 0.1)


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pressed")
    done = call("run", *WORDS, "--out", "whole", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "whole"


def test_comes_to_rest_under_every_stress_in_turn(pressed: Path) -> None:
    series = read_series(pressed / "series.txt")
    assert record(pressed)["status"] == "finished"
    numbers = sorted({int(number) for number in series["stage"] if number > 4})
    assert {(number - 5) // 2 for number in numbers} == set(range(3))
    density = []
    for step, stress in enumerate(STRESSES):
        last = np.flatnonzero((series["stage"] - 5) // 2 == step)[-1]
        for axis in "xy":  # the criterion of equilibrium: 1e-4 F0
            assert series[f"stress_{axis}"][last] == pytest.approx(stress, abs=1e-4)
        assert max(series["net_force"][last], series["net_moment"][last]) < 1e-4
        density.append(series["solid_fraction"][last])
    assert density[0] < density[1], "a higher stress packs more densely"
    assert density[2] > density[0], "and most of it stays when the stress is taken away"


@pytest.mark.parametrize("stage", [6, 9])
def test_a_killed_consolidation_resumes_exactly(stage: int, pressed: Path, tmp_path: Path, wf: Wf) -> None:
    resume_after_last_checkpoint(stage, pressed, tmp_path, wf)


def test_table_of_stages_has_a_row_for_every_stage(pressed: Path) -> None:
    found = json.loads(call("measure", pressed, "--stages", "--only", "none", "--json", cwd=pressed.parent).stdout)
    ends = {name: entry for name, entry in found.items() if name.startswith(("settle", "resettle"))}
    for name, entry in ends.items():
        assert entry["stress"]["pressure"] == pytest.approx(float(name.split()[1]), abs=1e-4)
        assert entry["stress"]["targets"][0] == pytest.approx(float(name.split()[1]), rel=1e-3)
    alone = json.loads(call("measure", pressed, "--frame", "-1", "--only", "none", "--json", cwd=pressed.parent).stdout)
    assert alone == list(found.values())[-1]  # measured together or alone
    rows = call("measure", pressed, "--stages", cwd=pressed.parent).stdout.splitlines()
    assert len(rows) == len(found) + 1
    assert len(rows[0].split()) > 1
    for row in rows:
        assert len(row) == len(rows[0]), row


def test_figure_of_consolidation_is_drawn(pressed: Path, tmp_path: Path) -> None:
    done = call("plot", pressed, "--figure", "consolidation", "--out", tmp_path, "--format", "png", cwd=pressed.parent)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "consolidation.png").stat().st_size > 5000


def test_stages_of_several_sources_are_refused(pressed: Path) -> None:
    done = call("measure", pressed, pressed / "grains.dump", "--stages", cwd=pressed.parent)
    assert done.returncode == 2
    assert "--stages" in done.stderr
