"""No file of a run directory, and none of the folder where `wf` is started, is ever executed."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from kills import SCENES, environment

from workflow.archive.export import write_csv
from workflow.archive.read import Archive
from workflow.campaign import slurm
from workflow.campaign.cluster import Profile
from workflow.cli.main import main
from workflow.cli.terminal import Escaping
from workflow.data.cells import cell
from workflow.data.frame import Frame
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import engine, python_child

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]
SHADOWS = ("workflow/__init__.py", "json.py", "random.py", "signal.py", "numpy.py", "lammps.py", "sitecustomize.py")
PWNED = "import pathlib; pathlib.Path(__file__).with_suffix('.pwned').touch()\nraise SystemExit('shadowed')\n"


def plant(folder: Path) -> None:
    for name in SHADOWS:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(PWNED)


def test_modules_in_the_run_directory_and_in_the_current_folder_change_nothing(tmp_path: Path) -> None:
    """A folder workflow/ as in every Snakemake project, and a random.py, beside the runs and in one of them."""
    plant(tmp_path)
    wf = [*python_child("workflow.cli.main")]

    def call(*words: str) -> None:
        done = subprocess.run(
            [*wf, *words], cwd=tmp_path, env=environment(), capture_output=True, text=True, check=False, timeout=200
        )
        assert done.returncode == 0, done.stderr

    call("deck", *SCENES["method1"], "--out", "run")
    plant(tmp_path / "run")
    call("resume", "run")
    (tmp_path / "study.toml").write_text(
        'scene = "method1"\nseeds = 1\n[fixed]\nn = 20\ncohesion = false\nkappa = 1e3\nhold = 0.5\n'
    )
    call("sweep", "study.toml", "--out", "study")
    assert not list(tmp_path.rglob("*.pwned"))


def test_children_find_no_code_where_they_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries of search paths that are empty or relative mean the folder of the child, which holds data."""
    monkeypatch.setenv("PYTHONPATH", ":.:/somewhere:")
    monkeypatch.setenv("LD_LIBRARY_PATH", "::lib")
    variables = engine().variables()
    assert variables["PYTHONPATH"] == f"{os.getcwd()}:/somewhere"
    assert variables["LD_LIBRARY_PATH"].split(":")[1:] == [f"{os.getcwd()}/lib"]
    assert variables["PYTHONSAFEPATH"] == "1"
    assert python_child()[1:3] == ["-P", "-m"]


def test_tasks_of_job_arrays_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", ":rel")
    script = slurm.array_script(Profile(), tmp_path / "study" / "jobs" / "0001", "0-1")
    assert f"{sys.executable} -P -m workflow.campaign.array_task" in script
    assert f"export PYTHONPATH={os.getcwd()}/rel\n" in script


def test_the_engine_is_no_task_of_the_surroundings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Inside `srun`, `mpiexec` and containers."""
    for name in ("SLURM_JOB_ID", "SLURM_NODELIST", "PMI_RANK", "PMI_FD", "PMIX_RANK", "HYDI_CONTROL_FD", "HYDRA_HOST_FILE"):
        monkeypatch.setenv(name, "7")
    variables = engine().variables()
    assert not [name for name in variables if name.startswith(("SLURM_", "PMI_", "PMIX_", "HYDI_"))]
    assert {name: value for name, value in variables.items() if name.startswith("HYDRA_")} == {
        "HYDRA_LAUNCHER": "fork", "HYDRA_RMK": "user",
    }  # fmt: skip


@pytest.mark.parametrize("ranks", ["1", "2"])
def test_it_runs_where_a_launcher_left_its_variables(ranks: str, tmp_path: Path) -> None:
    left = {"PMI_RANK": "0", "PMI_SIZE": "1", "PMI_FD": "7", "SLURM_JOB_ID": "7", "SLURM_JOBID": "7", "SLURM_NNODES": "1",
            "SLURM_NODELIST": "elsewhere", "SLURM_JOB_NODELIST": "elsewhere", "SLURM_TASKS_PER_NODE": "1"}  # fmt: skip
    words = [
        "run",
        "method1",
        "--no-cohesion",
        "--n",
        "20",
        "--kappa",
        "1e3",
        "--max-time",
        "1",
        "--ranks",
        ranks,
        "--oversubscribe",
    ]
    done = subprocess.run(
        [*python_child("workflow.cli.main"), *words, "--out", "run"], cwd=tmp_path, env={**environment(), **left},
        capture_output=True, text=True, check=False, timeout=200,
    )  # fmt: skip
    assert done.returncode == 3, done.stderr  # it ran, for a time that is too short for equilibrium


@pytest.mark.parametrize("text", ["=cmd|'/C calc'!A0", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"])
def test_cells_are_no_formulas(text: str, packing: Path, tmp_path: Path) -> None:
    assert cell(text) == f"'{text}"
    assert cell(-1.5) == -1.5
    with Archive(packing / "run.h5") as archive:
        frame: Frame = archive.frame(-1)
    object.__setattr__(frame, "stage", text)
    path = next(path for path in write_csv([frame], tmp_path) if path.name == "frames.csv")
    with open(path, newline="") as file:
        assert next(csv.DictReader(file))["stage"] == f"'{text}"


def test_a_terminal_is_not_steered(packing: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, {})
    RunDirectory(run).record(status="failed", reason="\x1b[2J\x9b5n\u202eevil")
    for words in (["status", run], ["status", run, "--json"], ["report", run]):
        _, out, err = wf(*words)
        assert not set("\x1b\x9b\u202e") & set(out + err)
    assert "\\x1b[2J\\x9b5n\\u202eevil" in wf("status", run)[1]


def test_text_that_the_terminal_has_not_is_escaped(tmp_path: Path) -> None:
    with open(tmp_path / "out", "w", encoding="ascii") as stream:
        Escaping(stream).write("\u00e9\udcff\n")
    assert (tmp_path / "out").read_text() == "\\xe9\\udcff\n"


def test_a_directory_whose_name_is_no_text(packing: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    import shutil

    run = os.fsencode(tmp_path) + b"/\xff\xfe"
    shutil.copytree(os.fsencode(packing), run)
    for command in ("measure", "status", "export", "report", "verify"):
        if command != "verify":
            assert main([command, os.fsdecode(run)]) in (0, 1)
    assert "Traceback" not in capfd.readouterr().err
    assert signal.getsignal(signal.SIGALRM) is not None
