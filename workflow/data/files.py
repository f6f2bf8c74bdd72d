"""Files that are read only if they are files, and written as a whole or not at all."""

from __future__ import annotations

import errno
import os
import platform
import re
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from workflow.errors import ArchiveError, InputError

PathLike = str | os.PathLike[str]


def open_plain(path: PathLike) -> BinaryIO:
    """Open a regular file for reading.  Raises OSError for anything else: a FIFO or a device would let its reader wait."""
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(number).st_mode
    if not stat.S_ISREG(mode):
        os.close(number)
        raise OSError(errno.EINVAL, f"it is {'a directory' if stat.S_ISDIR(mode) else 'no regular file'}", os.fspath(path))
    return open(number, "rb")


def read_plain(path: PathLike, *, errors: str = "strict") -> str:
    """The text of a regular file.  Raises OSError for anything else, ValueError if it is no UTF-8."""
    with open_plain(path) as file:
        return file.read().decode("utf-8", errors)


def regular(path: PathLike) -> bool:
    """True for a file that is no link: what is written to it stays where it seems to be."""
    try:
        return stat.S_ISREG(os.lstat(path).st_mode)
    except OSError:
        return False


def writable_folder(path: Path) -> Path:
    """The folder ``path``, made if it is not there.  Raises InputError if it cannot be made."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot create '{path}': {fault.strerror}; give a writable --out DIR") from fault
    return path


@contextmanager
def atomic_write(path: PathLike) -> Iterator[Path]:
    """A temporary name beside ``path`` to write to; synced and renamed on success, removed on failure.

    What a process of this machine left that was killed while it wrote the same file is removed first.  Raises ArchiveError
    when the file cannot be written; an existing file stays as it was.
    """
    target = Path(path)
    draft = target.with_name(f".{target.name}.{platform.node()}-{os.getpid()}.part")
    try:
        _remove_dead(target)
        yield draft
        with open(draft, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(draft, target)
    except OSError as error:
        raise ArchiveError(f"cannot write '{target}': {error}; check directory, rights and free space") from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def _remove_dead(target: Path) -> None:
    """Remove the drafts of ``target`` whose processes, of this machine, are no more."""
    pattern = re.compile(rf"\.{re.escape(target.name)}\.(?:{re.escape(platform.node())}-)?(\d{{1,18}})\.part")
    for name in os.listdir(target.parent):
        match = pattern.fullmatch(name)
        if match and (int(match[1]) == os.getpid() or not alive(int(match[1]))):
            dead = target.with_name(name)
            if dead.is_dir() and not dead.is_symlink():
                shutil.rmtree(dead, ignore_errors=True)
            else:
                dead.unlink(missing_ok=True)


def alive(pid: int | None) -> bool:
    """True while a process of this machine has the id; one that ended but was not waited for has not."""
    try:
        os.kill(pid or 0, 0)
        with open(f"/proc/{pid}/stat", "rb") as file:
            return file.read().rpartition(b")")[2].split()[0] != b"Z"
    except PermissionError:
        return True
    except (OSError, OverflowError, IndexError):
        return False
