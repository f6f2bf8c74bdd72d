"""Files of installed packages, found through their own lists."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

from workflow import DISTRIBUTION


def installed_file(name: str, distribution: str = DISTRIBUTION) -> Path | None:
    """The file ``name`` of an installed package, by default of this one; None if it is not installed or has no such file."""
    try:
        files = metadata.files(distribution) or []
    except metadata.PackageNotFoundError:
        return None
    return next((Path(str(file.locate())) for file in files if file.name == name), None)
