"""Discrete-element simulation of cohesive powders and granular heaps on LAMMPS.

One way through, each step with one door::

    Scene -> Deck -> Run -> Archive -> Measures -> Report

The public names: the scenes `Method1`, `Method2`, `Consolidation`, `Heap`; the functions `run`, `open`, `measure`, `plot`,
`report`, `sweep`; and what they take and give, `Run`, `Frame`, `ContactLaw`.  Everything else is internal.  The command
``wf`` is a thin layer over the same functions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from workflow.api import (
        Consolidation,
        ContactLaw,
        Frame,
        Heap,
        Method1,
        Method2,
        Run,
        measure,
        open,
        plot,
        report,
        run,
        sweep,
    )

__version__ = "0.3.0"  # the one statement: packaging reads it here
DISTRIBUTION = "cohesive-dem"  # what `pip install` calls this package
__all__ = [
    "Consolidation", "ContactLaw", "Frame", "Heap", "Method1", "Method2", "Run", "measure", "open", "plot", "report", "run",
    "sweep",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """The public names, loaded when one is first used: a command does not load what it does not run."""
    if name not in __all__:
        raise AttributeError(f"module 'workflow' has no attribute '{name}'")
    from workflow import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
