"""The run directory, its checkpoints and its progress line, without running anything."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from workflow.data.series import read_last_row, read_series
from workflow.errors import ArchiveError, InputError, WorkflowError
from workflow.runs import progress as watch
from workflow.runs.checkpoint import CheckpointChecksums, confirmed, damaged, newest, step_of
from workflow.runs.directory import RunDirectory, default_directory
from workflow.runs.outputs import Parts
from workflow.runs.resume_point import Start
from workflow.scene.method1 import Method1
from workflow.scene.progress import words

SCENE = Method1(n=20, cohesion=False, hold=1.0)
COLUMNS = ["step", "time", "stage", "solid_fraction", "stress_x", "stress_y", "net_force", "coordination"]
# Start of a restart file of LAMMPS 22 Jul 2025: magic, byte order, revision, then records (number of the record, value;
# texts with their length): version, sizes of four integer types, units; record 5 is the step.
HEAD = (
    b"LammpS RestartT\0" + struct.pack("<iii", 1, 3, 0) + struct.pack("<i", 12) + b"22 Jul 2025\0"
    + struct.pack("<8i", 1, 4, 48, 4, 2, 4, 3, 8) + struct.pack("<ii", 4, 3) + b"lj\0" + struct.pack("<i", 5)
)  # fmt: skip


@pytest.fixture
def run(tmp_path: Path) -> RunDirectory:
    return RunDirectory.create(tmp_path / "run", SCENE)


def write_series(run: RunDirectory, force: np.ndarray, interval: float = 0.5) -> None:
    rows = [f"{10 * k} {interval * k} 1 0.5 1.0 3.0 {value!r} 2.5" for k, value in enumerate(force.tolist())]
    run.write_text("series.txt", "\n".join(["# " + " ".join(COLUMNS), *rows, ""]))


def test_create_writes_what_repeats_the_run(run: RunDirectory) -> None:
    assert sorted(path.name for path in run.path.iterdir()) == ["deck.in", "grains.data", "run.json", "scene.toml"]
    assert run.scene == SCENE
    assert run.state["status"] == "prepared"
    assert run.state["digest"] == SCENE.digest
    assert run.series() is None
    assert run.result() == {}


def test_create_keeps_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "note").write_text("mine")
    with pytest.raises(InputError, match="not empty"):
        RunDirectory.create(tmp_path, SCENE)
    assert [path.name for path in tmp_path.iterdir()] == ["note"]


def test_create_accepts_an_empty_directory_and_makes_parents(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    RunDirectory.create(tmp_path / "empty", SCENE)
    RunDirectory.create(tmp_path / "a" / "b c" / "é", SCENE)
    assert RunDirectory.open(tmp_path / "a" / "b c" / "é").scene == SCENE


def test_failed_creation_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: RunDirectory, name: str, text: Iterable[str]) -> None:
        if name == "scene.toml":
            raise ArchiveError("no space")
        (self / name).write_text("".join(text))

    monkeypatch.setattr(RunDirectory, "write_text", full)
    with pytest.raises(ArchiveError):
        RunDirectory.create(tmp_path / "run", SCENE)
    assert not (tmp_path / "run").exists()


def test_default_directory_depends_on_the_scene_alone() -> None:
    assert default_directory(Method1()) == default_directory(Method1(n=1400))
    assert default_directory(Method1()) != default_directory(Method1(seed=2))


def test_record_adds_and_replaces(run: RunDirectory) -> None:
    run.record(status="running", pid=7)
    run.record(status="failed")
    assert (run.state["status"], run.state["pid"], run.state["digest"]) == ("failed", 7, SCENE.digest)
    assert json.loads((run / "run.json").read_text()) == run.state


def test_lock_is_for_one(run: RunDirectory) -> None:
    with run.lock(), pytest.raises(WorkflowError, match="in use"), run.lock():
        pass
    with run.lock():
        pass


def test_result_is_the_last_one(run: RunDirectory) -> None:
    lines = [
        "RESULT stage 1 step 10 equilibrated 0 stopped 1",
        "x",
        'print "RESULT stage"',
        "RESULT stage 2 step 30 equilibrated 1 stopped 0",
    ]
    run.write_text("log.lammps", "\n".join(lines))
    assert run.result() == {"stage": 2.0, "step": 30.0, "equilibrated": 1.0, "stopped": 0.0}


def test_cut_off_result_is_none(run: RunDirectory) -> None:
    """Killed in the middle of the last line."""
    run.write_text("log.lammps", "RESULT stage 2 step 30 equili")
    assert run.result() == {}


def test_the_step_in_a_restart_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.1.a"
    file.write_bytes(HEAD + struct.pack("<q", 123_456_789_012) + bytes(100))
    assert step_of(file) == 123_456_789_012


@pytest.mark.parametrize("content", [b"", b"LammpS", b"text " * 100, HEAD[:40], HEAD, bytes(600)])
def test_a_file_that_is_no_restart_file_is_no_checkpoint(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "checkpoint.1.a").write_bytes(content)
    assert step_of(tmp_path / "checkpoint.1.a") is None
    assert newest(tmp_path) is None


def checkpoint(folder: Path, name: str, step: int, content: bytes = bytes(100)) -> Path:
    """A whole restart file as far as head and end mark go, beside a series that has begun."""
    (folder / "series.txt").write_text("# step time stage x\n0 0 1 0.5\n")
    file = folder / f"checkpoint.{name}"
    file.write_bytes(HEAD + struct.pack("<q", step) + content + b"LammpS RestartT\0")
    return file


def test_the_newest_whole_checkpoint_is_chosen(tmp_path: Path) -> None:
    for name, step in {"1.a": 100, "1.b": 300, "2.a": 300}.items():
        checkpoint(tmp_path, name, step)
    checkpoint(tmp_path, "2.end", 900)  # written because the run was asked to stop: not part of its course
    (tmp_path / "checkpoint.2.b").write_bytes(b"cut off")
    found = newest(tmp_path)
    assert found is not None
    assert (found.path.name, found.stage, found.step) == ("checkpoint.2.a", 2, 300)
    assert [path.name for path in damaged(tmp_path)] == ["checkpoint.2.b"]


def test_a_sealed_checkpoint_comes_before_a_newer_one_without_seal(tmp_path: Path) -> None:
    checkpoint(tmp_path, "1.a", 100)
    CheckpointChecksums(tmp_path).look()
    checkpoint(tmp_path, "1.b", 200)
    assert newest(tmp_path).path.name == "checkpoint.1.a"  # type: ignore[union-attr]
    CheckpointChecksums(tmp_path).look()
    assert newest(tmp_path).path.name == "checkpoint.1.b"  # type: ignore[union-attr]


@pytest.mark.parametrize("position", [20, 80, -1])
def test_one_changed_bit_is_noticed(position: int, tmp_path: Path) -> None:
    checkpoint(tmp_path, "3.a", 100)
    file = checkpoint(tmp_path, "3.b", 200)
    CheckpointChecksums(tmp_path).look()
    content = bytearray(file.read_bytes())
    content[position] ^= 1
    file.write_bytes(bytes(content))
    assert damaged(tmp_path) == [file]
    assert newest(tmp_path).path.name == "checkpoint.3.a"  # type: ignore[union-attr]


def test_unfinished_and_overwritten_checkpoints_have_no_valid_seal(tmp_path: Path) -> None:
    file = checkpoint(tmp_path, "1.a", 100)
    seals = CheckpointChecksums(tmp_path)
    seals.look()
    assert confirmed(file)
    file.write_bytes(HEAD + struct.pack("<q", 300) + bytes(50))  # the engine is writing the next one
    seals.look()
    assert not confirmed(file)
    assert newest(tmp_path) is None
    checkpoint(tmp_path, "1.a", 300)
    seals.look()
    assert confirmed(file)
    assert json.loads((tmp_path / "checkpoint.1.a.json").read_text())["step"] == 300


def test_a_series_is_cut_back_to_its_checkpoint(run: RunDirectory) -> None:
    write_series(run, np.ones(10))
    with open(run / "series.txt", "a") as file:
        file.write("# " + " ".join(COLUMNS) + "\n100 5 1")
    parts = Parts(run.path)
    parts.extents(45)
    parts.cut()
    series = run.series()
    assert series is not None
    assert series["step"].tolist() == [0, 10, 20, 30, 40]


def test_a_series_cut_back_to_nothing_is_empty(run: RunDirectory) -> None:
    write_series(run, np.ones(3))
    Start(None, Parts(run.path), []).cut_back()
    assert run.series() is None


def settling(force: np.ndarray) -> dict[str, np.ndarray]:
    """Rows of a settling stage, one per half time unit, whose net force is ``force``; nothing else is left to wait for."""
    none = np.zeros(len(force))
    return {"time": 0.5 * np.arange(len(force)), "step": np.arange(len(force)), "net_force": force, "net_moment": none,
            "kinetic_per_grain": none, "held": none}  # fmt: skip


def test_time_left_of_an_exponential_decay() -> None:
    """force = exp(-t): at t = 15 it takes 5 more to the tolerance exp(-20) F1, and the time that it must hold."""
    scene = Method1(n=20, cohesion=False, hold=0.1, force_tolerance=float(np.exp(-20.0)))
    rows = settling(np.exp(-0.5 * np.arange(31)))
    assert scene.time_left(rows, "settle") == pytest.approx(5.1)
    assert [words(seconds) for seconds in (100.0, 1000.0, 36_000.0, None)] == ["~100 s", "~17 min", "~10.0 h", "unknown"]


@pytest.mark.parametrize("slope, rows", [(0.1, 31), (-0.5, 3), (-0.01, 31)], ids=["it grows", "few rows", "beyond the past"])
def test_no_guess_without_grounds(slope: float, rows: int) -> None:
    assert SCENE.time_left(settling(np.exp(slope * np.arange(rows))), "settle") is None


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_progress_shows_state_and_time_left(
    kind: type[io.StringIO], run: RunDirectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, "LINE_INTERVAL", 0.0)
    monkeypatch.setattr(watch, "PLAIN_INTERVAL", 0.0)
    out = kind()
    progress = watch.Progress(run, out)
    progress.show()
    assert out.getvalue() == ""  # nothing to say before the first row
    write_series(run, np.ones(3))
    progress.show()
    run.write_text("series.txt", "# step time stage\nhalf a")  # caught in the middle of a write
    progress.show()
    write_series(run, np.ones(9))
    progress.show()
    progress.end()
    text = out.getvalue()
    assert "t 1.00" in text
    assert "t 4.00" in text
    assert "P         2" in text  # mean of 1 and 3
    if kind is Terminal:
        assert (text.count("\r"), text.count("\n")) == (2, 1)
        assert text.endswith("\n")
    else:
        assert (text.count("\r"), text.count("\n")) == (0, 2)


def test_progress_waits_between_lines(run: RunDirectory) -> None:
    write_series(run, np.ones(3))
    out = io.StringIO()
    progress = watch.Progress(run, out)
    for _ in range(5):
        progress.show()
    assert out.getvalue() == ""


def test_a_lock_is_seen_from_outside(run: RunDirectory) -> None:
    assert not run.locked()
    with run.lock():
        assert run.locked()
    assert not run.locked()


def test_the_last_row_is_that_of_the_whole_series(run: RunDirectory) -> None:
    """Also of a long file, and while a row is written."""
    write_series(run, np.linspace(1.0, 2.0, 3000))
    whole = {name: values[-1] for name, values in read_series(run / "series.txt").items()}
    for torn in ("", "30000 1500.5 1 0.5", "# step time"):
        with open(run / "series.txt", "a") as file:
            file.write(torn)
        assert {name: values[-1] for name, values in read_last_row(run / "series.txt").items()} == whole
    run.write_text("series.txt", "# step time stage\n")
    assert read_last_row(run / "series.txt") == {}


def test_the_line_fits_a_narrow_terminal(run: RunDirectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "LINE_INTERVAL", 0.0)
    monkeypatch.setenv("COLUMNS", "40")
    out = Terminal()
    progress = watch.Progress(run, out)
    write_series(run, np.ones(9))
    progress.show()
    lines = out.getvalue().split("\r")
    assert "left unknown" in lines[-1] and max(map(len, lines)) < 40


@pytest.mark.parametrize("plan", [
    {}, {"max_time": 3.0}, {"max_time": 3.0, "max_steps": 5, "back": None, "lasts": {"../x": 3}},
    {"max_time": 3.0, "max_steps": 5, "back": [1], "lasts": {}}, {"max_time": "3", "max_steps": 5, "back": None, "lasts": {}},
    {"max_time": 3.0, "max_steps": True, "back": None, "lasts": {}}, {"max_time": 3.0, "max_steps": 5, "back": 3, "lasts": []},
])  # fmt: skip
def test_an_extension_that_nobody_here_wrote_is_damage(plan: dict[str, object], run: RunDirectory) -> None:
    run.record(extension=plan)
    with pytest.raises(ArchiveError, match="extension"):
        _ = run.state
