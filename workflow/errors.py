"""Errors a user can meet.

Every message says which name, what value, what is allowed, and what to do next.  The command line prints the message
alone (never a traceback) and exits with ``status``: 1 for work that failed, 2 for misuse.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class WorkflowError(Exception):
    """Base of all errors of this package that are the user's to read."""

    status = 1


class InputError(WorkflowError, ValueError):
    """A value, a keyword or a file given by the user is not usable."""

    status = 2


class EnvironmentFault(WorkflowError, RuntimeError):
    """The machine lacks something: engine, plugin, MPI, compiler, or they do not fit together."""


class EngineError(WorkflowError, RuntimeError):
    """LAMMPS stopped with an error, was killed, or did not produce what it should."""


class ArchiveError(WorkflowError, ValueError):
    """A dump, log or archive cannot be read as what it claims to be."""


def did_you_mean(word: str, known: Iterable[str], most: int = 1) -> str:
    """A question with the nearest of ``known`` words and a blank behind it, "" if none is near."""
    near = difflib.get_close_matches(word, sorted(known), n=most, cutoff=0.5)
    return f"did you mean {' or '.join(near)}? " if near else ""
