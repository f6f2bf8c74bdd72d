"""Directories are made by one process alone, and nothing waits for ever."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from kills import environment, start
from mutations import deadline

from workflow.data.files import alive, atomic_write, open_plain
from workflow.errors import EngineError, InputError, WorkflowError
from workflow.runs import child_process as process
from workflow.runs import installation as engine_environment
from workflow.runs.child_process import Child, descendants
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import check_room, python_child
from workflow.scene.method1 import Method1

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]
ENDLESS = ["method1", "--n", "200", "--max-time", "500"]


def test_one_of_two_processes_makes_a_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The other says so; deck, data and digest are of one scene."""
    first, second = Method1(n=20, cohesion=False), Method1(n=20, cohesion=False, mu=0.1)
    begun, go_on = threading.Event(), threading.Event()
    plain = RunDirectory._fill

    def slow(self: RunDirectory, scene: Method1, *more: object) -> None:
        begun.set()
        go_on.wait(20.0)
        plain(self, scene, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(RunDirectory, "_fill", slow)
    monkeypatch.setattr("workflow.runs.lock.LOCK_PATIENCE", 0.2)
    thread = threading.Thread(target=RunDirectory.create, args=(tmp_path / "run", first))
    thread.start()
    assert begun.wait(20.0)
    with pytest.raises(WorkflowError, match="in use by another wf"):
        RunDirectory.create(tmp_path / "run", second)
    go_on.set()
    thread.join()
    with pytest.raises(InputError, match="exists and is not empty"):
        RunDirectory.create(tmp_path / "run", second)
    run = RunDirectory.open(tmp_path / "run")
    assert run.scene == first and run.state["digest"] == first.digest
    assert run.hash("deck.in") == run.state["hashes"]["deck.in"]


@pytest.mark.parametrize(
    "written", [[], ["grains.data"], ["grains.data", "deck.in", "scene.toml", ".scene.toml.vm-99999999.part"]]
)
def test_what_a_killed_process_began_is_made_anew(written: list[str], tmp_path: Path) -> None:
    run = tmp_path / "run"
    run.mkdir()
    for name in [".lock", *written]:
        (run / name).write_text("half")
    made = RunDirectory.create(run, Method1(n=20, cohesion=False))
    assert made.scene == Method1(n=20, cohesion=False)
    assert sorted(path.name for path in run.iterdir()) == ["deck.in", "grains.data", "run.json", "scene.toml"]


@pytest.mark.parametrize("name", ["deck.in", "note.txt", "run.json"])
def test_a_directory_that_wf_did_not_begin_is_left_alone(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match="not empty"):
        RunDirectory.create(tmp_path, Method1(n=20, cohesion=False))
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_dead_drafts_are_removed_and_living_ones_are_not(tmp_path: Path) -> None:
    with subprocess.Popen(["sleep", "100"]) as other:
        drafts = {
            k: tmp_path / f".run.h5.{os.uname().nodename}-{pid}.part" for k, pid in (("dead", 1 << 22), ("living", other.pid))
        }
        older, elsewhere = tmp_path / ".run.h5.4194304.part", tmp_path / ".run.h5.another-4194304.part"
        for path in (*drafts.values(), older, elsewhere):
            path.write_text("half")
        with atomic_write(tmp_path / "run.h5") as draft:
            draft.write_text("whole")
        other.kill()
    assert not drafts["dead"].exists() and not older.exists()
    assert drafts["living"].exists() and elsewhere.exists()
    assert (tmp_path / "run.h5").read_text() == "whole"


def child(tmp_path: Path, text: str) -> Child:
    """A Python in the place of the engine."""
    with open(tmp_path / "err", "w") as errors, open(tmp_path / ".lock", "w") as lock:
        command = [*python_child("x")[:1], "-c", text]
        return Child(command, tmp_path, dict(os.environ), errors, lock.fileno())


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, seconds in (("POLL", 0.1), ("PATIENCE", 0.3), ("GRACE", 4.0)):  # a busy machine takes a while to end a process
        monkeypatch.setattr(process, name, seconds)


DEAF = "import signal, time, subprocess, sys; signal.signal(signal.SIGTERM, signal.SIG_IGN); "


@pytest.mark.parametrize("state", ["deaf", "stopped", "with children"])
def test_an_engine_that_does_not_end_is_killed(state: str, tmp_path: Path, impatient: None) -> None:
    """SIGTERM, then SIGKILL, for all its processes."""
    more = "subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(100)'], start_new_session=True); "
    one = child(tmp_path, DEAF + (more if state == "with children" else "") + "time.sleep(100)")
    time.sleep(2.0)
    if state == "stopped":
        os.kill(one.process.pid, signal.SIGSTOP)
    below = descendants(one.process.pid)
    assert len(below) == (state == "with children")
    with deadline():
        one.ask()
        while one.running():
            pass
    assert one.status == -signal.SIGKILL
    assert not any(map(alive, below))


def test_an_engine_that_nothing_ends_is_reported(tmp_path: Path, impatient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """As one that waits for a disk: here SIGKILL is kept from it."""
    one = child(tmp_path, DEAF + "time.sleep(100)")
    time.sleep(1.0)
    kill = os.kill
    monkeypatch.setattr(os, "kill", lambda pid, number: None)
    try:
        with deadline(), pytest.raises(EngineError, match="does not end, it waits for a disk"):
            one.ask()
            while one.running():
                pass
    finally:
        kill(one.process.pid, signal.SIGKILL)
        one.process.wait()


def ended(run: subprocess.Popen[bytes]) -> None:
    """Kill a `wf` of the test with all that it started."""
    for pid in [*descendants(run.pid), run.pid]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    run.wait()


def wait_until(true: Callable[[], bool], run: subprocess.Popen[bytes], folder: Path) -> None:
    until = time.monotonic() + 100.0
    while not true():
        assert run.poll() is None and time.monotonic() < until, (folder / "said").read_text()
        time.sleep(0.05)


@pytest.mark.parametrize("ranks", ["1", "2"])
def test_a_stopped_engine_keeps_nobody_out(ranks: str, tmp_path: Path) -> None:
    """SIGSTOP for the engine, kill -9 for its wf: the next `wf resume` goes on."""
    run = start(tmp_path, "run", *ENDLESS, "--ranks", ranks, "--oversubscribe", "--out", "run")
    try:
        wait_until((tmp_path / "run" / "series.txt").is_file, run, tmp_path)
        engines = descendants(run.pid)
        for pid in engines:
            os.kill(pid, signal.SIGSTOP)
    finally:
        run.kill()
        run.wait()
    again = start(tmp_path, "resume", "run", "--oversubscribe")
    try:
        wait_until(lambda: "continuing from" in (tmp_path / "said").read_text(), again, tmp_path)
        assert not any(map(alive, engines))
    finally:
        ended(again)


@pytest.mark.parametrize(
    "name", ["run.json", "scene.toml", "deck.in", "series.txt", "run.h5", "grains.dump", ".lock", "measures.json"]
)
@pytest.mark.parametrize("command", ["measure", "status", "resume"])
def test_a_fifo_in_place_of_a_file_is_no_wait(name: str, command: str, packing: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, {})
    if command == "resume":
        RunDirectory(run).record(status="interrupted")
    (run / name).unlink(missing_ok=True)
    os.mkfifo(run / name)
    if command == "resume" and name in ("run.h5", "measures.json"):
        return  # it would run
    wf(command, run)


def test_a_fifo_is_no_regular_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    with deadline(), pytest.raises(OSError, match="no regular file"):
        open_plain(tmp_path / "fifo")


@pytest.mark.parametrize(
    "text",
    ["a." * 20_000 + "a = 1\n", '"a b".' * 8000 + "a = 1\n", "[" + "a." * 20_000 + "a]\n", "x = [" * 9000, "#" * 2_000_000],
)
def test_toml_that_takes_for_ever_is_refused(text: str, tmp_path: Path, wf: Wf) -> None:
    (tmp_path / "scene.toml").write_text(text)
    begun = time.process_time()
    status, _, err = wf("deck", "scene.toml", "--dry-run")
    assert status == 2 and "scene.toml" in err
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("command", ["run", "resume", "verify"])
def test_more_ranks_than_cores_are_refused(command: str, packing: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, {})
    if command == "resume":
        RunDirectory(run).record(status="interrupted")
    words = ["run", "method1", "--n", "60", "--out", "new"] if command == "run" else [command, run]
    status, _, err = wf(*words, "--ranks", "999")
    assert status == 2 and "--ranks 999 is not allowed" in err and "--oversubscribe" in err
    status, _, err = wf(*words, "--ranks", "1000000", "--oversubscribe")
    assert status == 2 and "GB of memory" in err
    assert not Path("new").exists()


def test_as_many_ranks_as_cores_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(4)))
    monkeypatch.setattr(engine_environment, "_free_memory", lambda: 1e10)
    check_room(4)
    check_room(8, oversubscribe=True)
    with pytest.raises(InputError, match="4 cores can be used here"):
        check_room(5)


@pytest.mark.parametrize("command", [["status", "run"], ["run", "method1", "--n", "60", "--out", "new"], ["doctor"]])
@pytest.mark.parametrize("megabytes", [60, 150, 220, 300])
def test_little_memory_is_a_sentence(command: list[str], megabytes: int, tmp_path: Path) -> None:
    """ulimit -v: OpenBLAS would wait for threads that cannot be started."""
    limit = megabytes * 1_000_000
    done = subprocess.run(
        [*python_child("workflow.cli.main"), *command], cwd=tmp_path, env=environment(), capture_output=True, text=True,
        check=False, timeout=60, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )  # fmt: skip
    assert done.returncode == 1
    assert "'ulimit -v' allows" in done.stderr and "Traceback" not in done.stderr


def test_a_run_directory_that_is_removed_is_a_sentence(tmp_path: Path) -> None:
    run = start(tmp_path, "run", *ENDLESS, "--out", "run")
    try:
        wait_until((tmp_path / "run" / "series.txt").is_file, run, tmp_path)
        while (tmp_path / "run").exists():
            shutil.rmtree(tmp_path / "run", ignore_errors=True)
        assert run.wait(timeout=100) == 1
    finally:
        ended(run)
    said = (tmp_path / "said").read_text()
    assert "Traceback" not in said and said.splitlines()[-1].startswith("wf: ")
