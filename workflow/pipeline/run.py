"""A run from its directory to its measures: engine, archive, measures."""

from __future__ import annotations

from typing import TextIO

from workflow.pipeline.collect import collect
from workflow.pipeline.kinds import kind_of
from workflow.runs.directory import RunDirectory
from workflow.runs.execute import execute


def run(
    directory: RunDirectory, *, ranks: int = 1, resume: bool = False, any_deck: bool = False, anew: bool = False,
    out: TextIO | None = None,
) -> str:  # fmt: skip
    """Run (or continue) the deck of ``directory``, then write its archive and measures; returns its status (see `execute`).

    Raises InputError, before anything runs, for a scene whose kind has no measures.
    """
    kind_of(directory.scene)
    return execute(directory, collect, ranks=ranks, resume=resume, any_deck=any_deck, anew=anew, out=out)
