"""The lock of a run directory: a file that is locked as long as a `wf`, or the engine it started, is at work."""

from __future__ import annotations

import fcntl
import os
import shlex
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from workflow.data.files import open_plain
from workflow.errors import WorkflowError
from workflow.runs.child_process import kill_stopped_holders

LOCK_PATIENCE = 3.0  # seconds for the engine of a killed wf to end


@contextmanager
def locked_file(path: Path, orphaned: Callable[[], bool]) -> Iterator[TextIO]:
    """The file ``path``, made if it is absent, open and locked.

    ``orphaned``: says whether the `wf` that had the lock was killed; then an engine of it that is stopped is ended.  Raises
    WorkflowError if another process has the lock, or the disk has no locks.
    """
    deadline = time.monotonic() + LOCK_PATIENCE
    while True:
        with open(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666), "w") as file:
            _lock(file, path, deadline, orphaned)
            if os.fstat(file.fileno()).st_nlink:  # else it was removed meanwhile
                yield file
                return


def _lock(file: TextIO, path: Path, deadline: float, orphaned: Callable[[], bool]) -> None:
    while True:
        try:
            return fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline and not (orphaned() and kill_stopped_holders(path)):
                raise WorkflowError(f"'{path.parent}' is in use by another wf; wait for it, or look with 'wf status "
                                    f"{shlex.quote(str(path.parent))}'") from None  # fmt: skip
            time.sleep(0.05)
        except OSError as fault:
            raise WorkflowError(f"'{path.parent}' cannot be locked ({fault.strerror}); use a disk with locks") from None


def is_locked(path: Path) -> bool:
    """True while another process has the lock, on whatever machine."""
    try:
        with open_plain(path) as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False
