"""Run a deck in a child process and watch it."""

from __future__ import annotations

import os
import platform
import re
import reprlib
import shlex
import shutil
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, TextIO

from workflow.data.files import read_plain, regular
from workflow.data.notebook import progress_output
from workflow.deck.template import DECK
from workflow.errors import ArchiveError, EngineError, InputError, WorkflowError
from workflow.runs.checkpoint import ACCOUNT, CheckpointChecksums
from workflow.runs.child_process import Child
from workflow.runs.directory import FAILED, FINISHED, INTERRUPTED, RUNNING, RunDirectory, timestamp
from workflow.runs.identity import check_inputs
from workflow.runs.installation import engine
from workflow.runs.interrupts import deferred_interrupts
from workflow.runs.launch import start_deck
from workflow.runs.outputs import Parts
from workflow.runs.progress import Progress
from workflow.runs.resume_point import Start, start_of

SPARE = 1_000_000  # bytes, besides three checkpoints, that must stay free on the disk
RESERVED = ".reserve"  # kept aside while the engine runs: what it fills to the last byte has room for the last seal and state
RESERVE = 65_536  # bytes of it
# what is written in a run directory under its own name, through a link that somebody put there
WRITTEN = ("*.dump", "*.txt", "*.in", "*.lammps", "*.err", "checkpoint.*", "stop", ".*")


def execute(
    directory: RunDirectory, then: Callable[[RunDirectory], object], *, ranks: int = 1, resume: bool = False,
    any_deck: bool = False, anew: bool = False, out: TextIO | None = None,
) -> str:  # fmt: skip
    """Run (or continue) the deck of ``directory`` on ``ranks`` MPI ranks, ``then`` collect what it wrote; returns its status.

    Progress goes to ``out``, by default standard error, or the cell of a notebook.  A KeyboardInterrupt asks the engine to
    stop: it writes a checkpoint and the last frame, and the status is INTERRUPTED; a second one, or a signal that reaches
    the engine itself, ends it at once, with the newest checkpoint to go on from.  Raises EngineError with the engine's own
    words if it fails; what it wrote stays.  InputError if version or deck are not those of the run, or of its scene
    (``any_deck`` accepts that); ArchiveError if what a checkpoint needs is lost (``anew`` begins again then).
    """
    engine()  # before anything is changed: is everything there?
    out = out or progress_output()
    with directory.lock() as lock:
        _require_files(directory)
        check_inputs(directory, executed=True, continued=resume, any_deck=any_deck)
        variables = _start(directory, resume, out, anew=anew)
        before = float(directory.state.get("seconds") or 0.0)  # of the parts before this one
        state = directory.state
        begun_on, earlier = state.get("ranks", ranks), state.get("earlier_ranks", [])
        if resume and begun_on != ranks and state.get("starts", 0):
            earlier = [*earlier, begun_on]
        directory.record(
            status=RUNNING, ranks=ranks, earlier_ranks=earlier, started=timestamp(), pid=os.getpid(), host=platform.node(),
            reason=None, starts=state.get("starts", 0) + 1,
        )  # fmt: skip
        with suppress(OSError):
            (directory / RESERVED).write_bytes(bytes(RESERVE))
        begun, seals = time.monotonic(), CheckpointChecksums(directory.path)
        progress = Progress(directory, out)

        def ended(status: str, reason: str | None = None, **entries: Any) -> str:
            seconds = before + time.monotonic() - begun
            directory.record(status=status, finished=timestamp(), seconds=seconds, reason=reason, **entries)
            return status

        with open(directory / "engine.err", "w+", encoding="utf-8", errors="replace") as errors:
            child = start_deck(directory.path, DECK, variables, ranks, errors, lock.fileno())
            try:
                interrupted, full = _watch(child, directory, progress.show, seals)
            except EngineError as fault:
                ended(FAILED, str(fault))
                raise
            errors.seek(0)
            words = errors.read().strip()
        progress.end()
        result = directory.result()
        broken = full or child.status != 0 or not result
        if broken and interrupted and not full and "ERROR" not in words:
            # the signal reached the engine too, or a second one ended it: what is left is the newest checkpoint
            return ended(INTERRUPTED, "it was ended at once")
        if broken:
            reason = full or _full(directory, seals) or _reason(child.status, words)
            ended(FAILED, reason)
            raise EngineError(f"the engine stopped in '{directory.path}': {reason}")
        (directory / "stop").unlink(missing_ok=True)
        try:
            parts = seals.parts.finished(int(result.get("step", -1)))
            seals.parts.series.cut()
            then(directory)
        except WorkflowError as fault:
            ended(FAILED, str(fault))
            raise
        return ended(INTERRUPTED if interrupted or result.get("stopped") else FINISHED, result=result, parts=parts)


def _require_files(directory: RunDirectory) -> None:
    """Raise InputError if what will be written is a link, which would lead elsewhere, or no file."""
    for path in directory.path.iterdir():
        if not regular(path) and any(fnmatch(path.name, pattern) for pattern in WRITTEN):
            what = "a symbolic link" if path.is_symlink() else "no regular file"
            raise InputError(f"'{path}' is {what}, and the engine writes there; put the file itself in its place")


def _start(directory: RunDirectory, resume: bool, out: TextIO, *, anew: bool = False) -> dict[str, object]:
    """Variables that say where the deck starts, after the directory was brought back to that point."""
    if not resume:
        (directory / "stop").unlink(missing_ok=True)
        return {}
    if directory.state["status"] == FINISHED:
        if directory.equilibrium() is False:
            raise InputError(f"the run in '{directory.path}' is finished, not in equilibrium; extend it with "
                             f"'wf resume {shlex.quote(str(directory.path))} --max-time T'")  # fmt: skip
        raise InputError(f"the run in '{directory.path}' is finished; there is nothing to resume (see 'wf measure')")
    try:
        start = start_of(directory.path)
        _require_notes(directory.path)
    except ArchiveError as fault:
        if not anew:
            raise
        start = Start(None, Parts(directory.path), [str(fault)])
    (directory / "stop").unlink(missing_ok=True)
    for words in start.words:
        print(words, file=out)
    checkpoint = start.checkpoint
    where = f"{checkpoint.path.name}, step {checkpoint.step}" if checkpoint else "the beginning: no whole checkpoint is there"
    print(f"continuing from {where}", file=out)
    _forget_result(directory)
    start.cut_back()
    if checkpoint is None:  # interrupted before the first checkpoint: start over
        return {}
    return {"resume": "yes", "restart": checkpoint.path.name, "stage": checkpoint.stage}


def _require_notes(folder: Path) -> None:
    """Raise ArchiveError if what the deck wrote down for itself, which it executes, is more than the value of a variable."""
    for path in (*folder.glob("stage.*.in"), *folder.glob(ACCOUNT)):
        text = read_plain(path, errors="replace")
        if not re.fullmatch(r"variable \w+ equal [-+.\w]+\n", text):
            raise ArchiveError(f"'{path}' holds {reprlib.repr(text)}, expected 'variable NAME equal VALUE'; restore it or run "
                               "the scene again")  # fmt: skip


def _forget_result(directory: RunDirectory) -> None:
    """Keep the log of the interrupted part, without its result line."""
    log = directory / "log.lammps"
    if log.is_file():
        text = read_plain(log, errors="replace")
        directory.write_text("log.lammps", re.sub(r"(?m)^RESULT ", "interrupted: ", text))


def _watch(
    child: Child, directory: RunDirectory, show: Callable[[], None], seals: CheckpointChecksums
) -> tuple[bool, str | None]:
    """Wait for the child, seal its checkpoints; whether the user interrupted it, and why the disk did."""
    interrupted, full, going = False, None, True
    while going:
        try:
            going = child.running()
            show()
            if not full:
                full = _full(directory, seals)
                if full:
                    child.ask()
        except KeyboardInterrupt:
            if interrupted:
                child.end()
            interrupted = True
            child.ask()
    (directory / RESERVED).unlink(missing_ok=True)
    with suppress(ArchiveError), deferred_interrupts():  # what came since the last look
        seals.look()
    return interrupted, full


def _full(directory: RunDirectory, seals: CheckpointChecksums) -> str | None:
    """Seal new checkpoints; in words what is wrong if the disk has no room to go on, or something was not written."""
    try:
        needed = SPARE + 3 * max((file.stat().st_size for file in directory.path.glob("checkpoint.*")), default=0)
        free = shutil.disk_usage(directory.path).free
        with deferred_interrupts():
            seals.look()
        fault = None
    except ArchiveError as words:
        fault = str(words)
    except OSError as words:  # the directory was removed, or its disk is gone
        return f"'{directory.path}' cannot be read any more: {words.strerror}"
    if free > needed:
        return fault
    return (
        f"No space left on device: {free / 1e6:.1f} MB are free, {needed / 1e6:.1f} MB are needed to go on; make room, then "
        f"'wf resume {shlex.quote(str(directory.path))}' continues from the last good checkpoint"
    )


def _reason(status: int, words: str) -> str:
    """Why the child failed, in one line."""
    lines = [line for line in words.splitlines() if line.strip()]
    if status == -signal.SIGXFSZ:
        return "a file of the run reached the largest size that is allowed here (ulimit -f); raise it, then 'wf resume'"
    if status < 0 and not lines:
        return f"it was killed by signal {-status}; continue with 'wf resume'"
    errors = words.split("ERROR")  # every rank says it, perhaps on one line
    if len(errors) > 1:
        return "ERROR" + errors[1].splitlines()[0].rstrip()
    return lines[-1].strip() if lines else "it left no message"
