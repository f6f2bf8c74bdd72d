"""The engine as a child process: started so that it cannot outlive its `wf`, watched, and ended whatever state it is in."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO

from workflow.errors import EngineError

POLL = 0.25  # seconds between looks at a running child
PATIENCE = 60.0  # seconds a child may take to write its checkpoint after it was asked to stop
GRACE = 10.0  # seconds it may take to end after SIGTERM, and its processes after SIGKILL


class Child:
    """A running command in ``folder`` that is asked to stop by the file ``stop``."""

    def __init__(self, command: list[str], folder: Path, variables: dict[str, str], errors: IO[str], keep: int) -> None:
        """``keep``: a file that stays open, and so locked, as long as the child or one of its own lives."""
        self.folder, self.deadline, self.told = folder, float("inf"), 0
        self.process = subprocess.Popen(
            command, cwd=folder, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors,
            start_new_session=True, preexec_fn=with_parent(), pass_fds=[keep],
        )  # fmt: skip

    @property
    def status(self) -> int:
        """Exit status."""
        return self.process.returncode

    def running(self) -> bool:
        """Wait a moment; True while the child runs.  One that was asked to stop and does not is ended, at last by SIGKILL,
        which a stopped process obeys too.  Raises EngineError if even that does not end it."""
        if self.process.poll() is not None:
            return False
        time.sleep(POLL)
        if self.process.poll() is None and time.monotonic() > self.deadline:
            self.end()
        return self.process.poll() is None

    def ask(self) -> None:
        """Ask the deck to stop at its next check."""
        self.deadline = min(self.deadline, time.monotonic() + PATIENCE)
        try:
            (self.folder / "stop").touch()
        except OSError:  # no room even for that
            self.end()

    def end(self) -> None:
        """End the child: SIGTERM first, SIGKILL for all its processes when that was not enough."""
        self.deadline = time.monotonic() + GRACE
        self.told += 1
        if self.told == 1:
            self.process.terminate()
        elif self.told == 2:
            for pid in [*descendants(self.process.pid), self.process.pid]:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        else:
            raise EngineError(f"process {self.process.pid} of the engine does not end, it waits for a disk or a network; "
                              f"'{self.folder}' stays locked until it does")  # fmt: skip


def with_parent(number: int = signal.SIGTERM) -> Callable[[], None]:
    """What a child does before it becomes another program: end when wf is killed, so that no engine runs on unwatched."""
    parent, library = os.getpid(), ctypes.CDLL(None)

    def die_with_parent() -> None:
        library.prctl(1, number)  # PR_SET_PDEATHSIG
        if os.getppid() != parent:  # killed before the line above
            os._exit(1)

    return die_with_parent


def descendants(pid: int) -> list[int]:
    """Ids of the children of a process, of theirs, and so on."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError, ValueError):
            for child in map(int, task.read_text().split()):
                found += [child, *descendants(child)]
    return found


def kill_stopped_holders(path: Path) -> bool:
    """Kill the processes that hold the file ``path`` open if all of them are stopped: an engine whose wf was killed while it
    could not end.  True if there were some."""
    target, holders = path.stat(), []
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError):
            same = any(_is(file, target) for file in (entry / "fd").iterdir())
            if same and int(entry.name) != os.getpid():
                holders.append((int(entry.name), (entry / "stat").read_text().rpartition(")")[2].split()[0]))
    if not holders or any(state not in "Tt" for _, state in holders):
        return False
    for pid, _ in holders:
        with suppress(OSError):
            os.kill(pid, signal.SIGKILL)
    return True


def _is(file: Path, target: os.stat_result) -> bool:
    with suppress(OSError):
        state = file.stat()
        return (state.st_dev, state.st_ino) == (target.st_dev, target.st_ino)
    return False
