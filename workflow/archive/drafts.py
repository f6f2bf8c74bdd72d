"""Files written as a whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from workflow.errors import ArchiveError

PathLike = str | os.PathLike[str]


@contextmanager
def replacing(path: PathLike) -> Iterator[Path]:
    """A temporary name beside ``path`` to write to; synced and renamed on success, removed on failure.

    Raises ArchiveError when the file cannot be written; an existing file stays as it was.
    """
    target = Path(path)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield draft
        with open(draft, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(draft, target)
    except OSError as error:
        raise ArchiveError(f"cannot write '{target}': {error}; check directory, rights and free space") from None
    finally:
        draft.unlink(missing_ok=True)
