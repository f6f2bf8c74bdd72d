"""Run a deck in a child process and watch it."""

from __future__ import annotations

import ctypes
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

from workflow import __version__
from workflow.deck.render import DECK
from workflow.engine.checkpoint import Seals, cut_back, damaged, drop_later, drop_repeats, newest
from workflow.engine.collect import collect
from workflow.engine.environment import engine, python_child
from workflow.engine.rundir import FAILED, FINISHED, INTERRUPTED, RUNNING, RunDirectory, timestamp
from workflow.engine.watch import Progress
from workflow.errors import ArchiveError, EngineError, InputError, WorkflowError

POLL = 0.25  # seconds between looks at a running child
SPARE = 1_000_000  # bytes, besides three checkpoints, that must stay free on the disk
RESERVED = ".reserve"  # kept aside while the engine runs: what it fills to the last byte has room for the last seal and state
RESERVE = 65_536  # bytes of it
PATIENCE = 60.0  # seconds a child may take to write its checkpoint after it was asked to stop


def run(directory: RunDirectory, *, ranks: int = 1, resume: bool = False, out: TextIO | None = None) -> str:
    """Run (or continue) the deck of ``directory`` on ``ranks`` MPI ranks; returns its status.

    Progress goes to ``out``, by default standard error.  A KeyboardInterrupt asks the engine to stop: it writes a
    checkpoint and the last frame, and the status is INTERRUPTED; a second one, or a signal that reaches the engine
    itself, ends it at once, with the newest checkpoint to go on from.  Raises EngineError with the engine's own words
    if it fails; what it wrote stays.  Raises InputError for a directory of another version: its deck and its checkpoints
    mean something else to this one's plugin.
    """
    _require_version(directory)
    environment, out = engine(), out or sys.stderr
    with directory.lock() as lock:
        variables = _start(directory, resume, out)
        before = float(directory.state.get("seconds") or 0.0)  # of the parts before this one
        command = [*python_child(), DECK, *variables]
        if ranks > 1:
            command = [str(environment.mpiexec), "-n", str(ranks), *command]
        directory.record(status=RUNNING, ranks=ranks, started=timestamp(), pid=os.getpid(), host=platform.node(), reason=None)
        with suppress(OSError):
            (directory / RESERVED).write_bytes(bytes(RESERVE))
        begun = time.monotonic()
        progress, seals = Progress(directory, out), Seals(directory.path)
        with open(directory / "engine.err", "w+", encoding="utf-8") as errors:
            child = subprocess.Popen(
                command, cwd=directory.path, env=environment.variables(), stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=errors, start_new_session=True, preexec_fn=with_parent(),
                pass_fds=[lock.fileno()],  # the directory stays locked as long as an engine works in it
            )  # fmt: skip
            interrupted, full = _watch(child, directory, progress.show, seals)
            errors.seek(0)
            words = errors.read().strip()
        progress.end()
        seconds = before + time.monotonic() - begun
        result = directory.result()
        broken = full or child.returncode != 0 or not result
        if broken and interrupted and not full and "ERROR" not in words:
            # the signal reached the engine too, or a second one ended it: what is left is the newest checkpoint
            directory.record(status=INTERRUPTED, finished=timestamp(), seconds=seconds, reason="it was ended at once")
            return INTERRUPTED
        if broken:
            reason = full or _full(directory, seals) or _reason(child.returncode, words)
            directory.record(status=FAILED, finished=timestamp(), seconds=seconds, reason=reason)
            raise EngineError(f"the engine stopped in '{directory.path}': {reason}")
        status = INTERRUPTED if interrupted or result["stopped"] else FINISHED
        (directory / "stop").unlink(missing_ok=True)
        drop_repeats(directory.path)
        try:
            collect(directory)
        except WorkflowError as fault:
            directory.record(status=FAILED, finished=timestamp(), seconds=seconds, reason=str(fault))
            raise
        directory.record(status=status, finished=timestamp(), seconds=seconds, result=result)
    return status


def _require_version(directory: RunDirectory) -> None:
    """Versions that differ in the last number alone run each other's directories."""
    made = directory.state["versions"].get("workflow", __version__)
    if made.split(".")[:2] != __version__.split(".")[:2]:
        again = f"wf run {shlex.quote(str(directory / 'scene.toml'))} --out DIR"
        raise InputError(
            f"'{directory.path}' was written by version {made} of workflow, whose decks and checkpoints version {__version__} "
            f"does not run: go on with 'pip install workflow=={made}', or run the scene anew with '{again}'"
        )


def _start(directory: RunDirectory, resume: bool, out: TextIO) -> list[str]:
    """Variables that say where the deck starts, after the directory was brought back to that point."""
    (directory / "stop").unlink(missing_ok=True)
    if not resume:
        return []
    if directory.state["status"] == FINISHED:
        raise InputError(f"the run in '{directory.path}' is finished; there is nothing to resume (see 'wf measure')")
    checkpoint = newest(directory.path)
    for path in damaged(directory.path):
        print(f"{path.name} is damaged (its checksum or its end is wrong) and not used", file=out)
    where = f"{checkpoint.path.name}, step {checkpoint.step}" if checkpoint else "the beginning: no whole checkpoint is there"
    print(f"continuing from {where}", file=out)
    _forget_result(directory)
    drop_later(directory.path, checkpoint)
    if checkpoint is None:  # interrupted before the first checkpoint: start over
        cut_back(directory.path, -1)
        return []
    cut_back(directory.path, checkpoint.step)
    return ["resume", "yes", "restart", checkpoint.path.name, "stage", str(checkpoint.stage)]


def _forget_result(directory: RunDirectory) -> None:
    """Keep the log of the interrupted part, without its result line."""
    log = directory / "log.lammps"
    if log.is_file():
        text = log.read_text(encoding="utf-8", errors="replace")
        directory.write_text("log.lammps", text.replace("\nRESULT ", "\ninterrupted: "))


def _watch(
    child: subprocess.Popen[bytes], directory: RunDirectory, show: Callable[[], None], seals: Seals
) -> tuple[bool, str | None]:
    """Wait for the child, seal its checkpoints; whether the user interrupted it, and why the disk did."""
    interrupted, full, deadline = False, None, float("inf")

    def ask_to_stop() -> None:
        nonlocal deadline
        deadline = time.monotonic() + PATIENCE
        try:
            (directory / "stop").touch()
        except OSError:  # no room even for that
            child.terminate()

    while child.poll() is None:
        try:
            time.sleep(POLL)
            show()
            if not full:
                full = _full(directory, seals)
                if full:
                    ask_to_stop()
        except KeyboardInterrupt:
            if interrupted:
                child.terminate()
            interrupted = True
            ask_to_stop()
        if time.monotonic() > deadline:
            child.terminate()
            deadline = float("inf")
    (directory / RESERVED).unlink(missing_ok=True)
    with suppress(ArchiveError):  # what came since the last look
        seals.look()
    return interrupted, full


def _full(directory: RunDirectory, seals: Seals) -> str | None:
    """Seal new checkpoints; in words what is wrong if the disk has no room to go on."""
    needed = SPARE + 3 * max((file.stat().st_size for file in directory.path.glob("checkpoint.*")), default=0)
    free = shutil.disk_usage(directory.path).free
    fault = None
    try:
        seals.look()
    except ArchiveError as words:
        fault = str(words)
    if free > needed:
        return fault
    return (
        f"No space left on device: {free / 1e6:.1f} MB are free, {needed / 1e6:.1f} MB are needed to go on; make room, then "
        f"'wf resume {shlex.quote(str(directory.path))}' continues from the last good checkpoint"
    )


def with_parent() -> Callable[[], None]:
    """What a child does before it becomes another program: end when wf is killed, so that no engine runs on unwatched."""
    parent, library = os.getpid(), ctypes.CDLL(None)

    def die_with_parent() -> None:
        library.prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
        if os.getppid() != parent:  # killed before the line above
            os._exit(1)

    return die_with_parent


def _reason(status: int, words: str) -> str:
    """Why the child failed, in one line."""
    lines = [line for line in words.splitlines() if line.strip()]
    if status < 0 and not lines:
        return f"it was killed by signal {-status}; continue with 'wf resume'"
    errors = words.split("ERROR")  # every rank says it, perhaps on one line
    if len(errors) > 1:
        return "ERROR" + errors[1].splitlines()[0].rstrip()
    return lines[-1].strip() if lines else "it left no message"
