"""Errors a user can meet.

Every message says which name, what value, what is allowed, and what to do next.  The command line prints the message
alone (never a traceback) and exits with ``status``: 1 for work that failed, 2 for misuse.
"""


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
