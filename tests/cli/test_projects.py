"""`wf sweep --export`: the project of another workflow manager computes the same points as `wf sweep` itself.

With the managers themselves: pytest -m managers (pip install '.[managers]').
"""

from __future__ import annotations

import csv
import filecmp
import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest
from wf_process import WF, call

from workflow.campaign.project import MANAGERS, write_project
from workflow.campaign.study import Study
from workflow.campaign.sweep import read_sweep
from workflow.errors import InputError

STUDY = """scene = "method1"
seeds = [1, 2]
[fixed]
cohesion = false
n = 60
kappa = 1e3
hold = 1
"""
Project = Callable[[str], Path]


@pytest.fixture
def project(tmp_path: Path) -> Project:
    """Writes the study as a project, in a path with a blank."""

    def write(manager: str) -> Path:
        (tmp_path / "study.toml").write_text(STUDY)
        folder = tmp_path / f"project of {manager}"
        write_project(tmp_path / "study.toml", folder, manager)
        return folder

    return write


@pytest.fixture
def programs(tmp_path: Path) -> dict[str, str]:
    """Variables with which a shell finds `wf` and the managers of this Python."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/wf").write_text(f'#!/bin/sh\nexec {" ".join(WF)} "$@"\n')
    (tmp_path / "bin/wf").chmod(0o755)
    return {**os.environ, "PATH": f"{tmp_path / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}"}


def done(folder: Path, environment: dict[str, str], *words: str) -> str:
    ended = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def check_results(folder: Path) -> None:
    """Every point is finished, with the bytes of `wf run` on the same scene."""
    assert {Study.open(folder).standing(point).status for point in Study.open(folder).points} == {"done"}
    with open(folder / "results.csv", newline="", encoding="utf-8") as file:
        assert sorted(row["seed"] for row in csv.DictReader(file)) == ["1", "2"]
    point = Study.open(folder).points[0]
    words = ["run", folder / "scenes" / f"{point.name}.toml", "--out", "again"]
    assert call(*words, cwd=folder).returncode == 0
    assert filecmp.cmp(folder / "again/grains.dump", folder / "points" / point.name / "grains.dump", shallow=False)


@pytest.mark.parametrize("manager", sorted(MANAGERS))
def test_scenes_are_the_points_of_the_study(manager: str, project: Project) -> None:
    folder = project(manager)
    points = {point.name: point for point in read_sweep(folder / "study.toml")}
    scenes = {path.stem: tomllib.loads(path.read_text()) for path in (folder / "scenes").iterdir()}
    assert set(scenes) == set(points)
    assert all(scenes[name] == dict(points[name].values) for name in points)
    assert [entry["digest"][:16] for entry in json.loads((folder / "points.json").read_text())] == list(points)


def test_a_folder_with_something_in_it_is_left_alone(project: Project, tmp_path: Path) -> None:
    folder = project("row")
    before = sorted(path.name for path in folder.rglob("*"))
    with pytest.raises(InputError, match="not empty"):
        write_project(tmp_path / "study.toml", folder, "snakemake")
    assert sorted(path.name for path in folder.rglob("*")) == before


def test_command_of_row_computes_and_continues_every_point(project: Project, programs: dict[str, str]) -> None:
    """As row expands it for each directory; row itself comes from conda or cargo and is not run here."""
    folder = project("row")
    declared = tomllib.loads((folder / "workflow.toml").read_text())
    (action,), place = declared["action"], declared["workspace"]["path"]
    names = sorted(path.name for path in (folder / place).iterdir())
    assert len(names) == 2
    for name in names:
        done(folder, programs, "sh", "-c", action["command"].replace("{directory}", name))
        assert all((folder / place / name / product).is_file() for product in action["products"])
    done(folder, programs, "wf", "sweep", "study.toml", "--out", ".")
    check_results(folder)


@pytest.mark.parametrize(("status", "told"), [(0, 0), (1, 1), (2, 2), (3, 0), (130, 130)])
def test_managers_are_told_that_a_run_failed_and_not_that_its_time_was_over(
    status: int, told: int, project: Project, tmp_path: Path
) -> None:
    """A `wf` that only notes its words; 3 is that of a finished run that is not in equilibrium."""
    folder = project("row")
    (tmp_path / "wf").write_text(f'#!/bin/sh\necho "$@" >> said\nexit {status}\n')
    (tmp_path / "wf").chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    words = ["sh", "point.sh", "scenes/a.toml", "points/a b", "--ranks", "2"]
    assert subprocess.run(words, cwd=folder, env=environment, check=False).returncode == told
    (folder / "points/a b").mkdir()
    (folder / "points/a b/run.json").write_text("{}")
    assert subprocess.run(words, cwd=folder, env=environment, check=False).returncode == told
    said = (folder / "said").read_text().splitlines()
    assert said == ["run scenes/a.toml --out points/a b --ranks 2", "resume points/a b --ranks 2"]


@pytest.mark.managers
def test_snakemake_computes_the_study(project: Project, programs: dict[str, str]) -> None:
    if not find_spec("snakemake"):
        pytest.skip("snakemake is not installed: pip install '.[managers]'")
    folder = project("snakemake")
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "1"]
    lint = subprocess.run([*snakemake, "--lint"], cwd=folder, env=programs, capture_output=True, text=True, check=False)
    remarks = {line.strip() for line in (lint.stdout + lint.stderr).splitlines() if line.lstrip().startswith("* ")}
    assert remarks == {"* Specify a conda environment or container for each rule.:"}  # `wf` is the one that wrote the project
    done(folder, programs, *snakemake)
    check_results(folder)
    assert "Nothing to be done" in subprocess.run(snakemake, cwd=folder, env=programs, capture_output=True, text=True,
                                                  check=True).stderr  # fmt: skip


@pytest.mark.managers
def test_signac_computes_the_study(project: Project, programs: dict[str, str]) -> None:
    if not find_spec("flow"):
        pytest.skip("signac-flow is not installed: pip install '.[managers]'")
    folder = project("signac")
    done(folder, programs, sys.executable, "init.py")
    done(folder, programs, sys.executable, "project.py", "run")
    done(folder, programs, "wf", "sweep", "study.toml", "--out", ".", "--adopt", "workspace")
    check_results(folder)
