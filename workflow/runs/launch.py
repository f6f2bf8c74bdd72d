"""Start programs: the one place that says how a deck becomes a process, for runs that are watched and runs that are awaited."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from workflow.deck.template import copy_template
from workflow.errors import EngineError
from workflow.runs.child_process import Child
from workflow.runs.installation import Engine, engine, python_child

Values = Mapping[str, object]  # index variables of a deck


@dataclass(frozen=True)
class Completed:
    """A program that ended: its ``command``, exit ``status``, what it ``printed``, its ``log``.lammps, its ``errors``."""

    command: list[str]
    status: int
    printed: str
    log: str
    errors: str

    @property
    def words(self) -> str:
        """The last thing that it said of itself."""
        said = re.search(r"ERROR.*", self.errors + self.printed + self.log)
        last = self.errors.strip() or (self.printed + self.log).strip() or f"exit status {self.status}, no message"
        return said[0] if said else last.splitlines()[-1].strip()

    def output(self) -> str:
        """What it printed and its log.  Raises EngineError with its words if it failed."""
        if self.status:
            raise EngineError(f"the run {' '.join(self.command[-40:])!r:.200} stopped: {self.words}")
        return self.printed + self.log


def run_program(
    command: list[str], folder: Path | None = None, *, environment: Mapping[str, str] | None = None,
    patience: float | None = None,
) -> Completed:  # fmt: skip
    """Run ``command`` in ``folder`` (None: the present one) to its end.

    Raises EngineError if it takes longer than ``patience`` [s].
    """
    log = (folder or Path()) / "log.lammps"
    if folder:
        log.unlink(missing_ok=True)
    try:
        child = subprocess.run(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
            check=False, timeout=patience,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise EngineError(f"the run did not end within {patience:.0f} s") from None
    text = log.read_text(encoding="utf-8", errors="replace") if folder and log.is_file() else ""
    return Completed(command, child.returncode, child.stdout, text, child.stderr)


def run_deck(
    folder: Path, deck: str, values: Values | None = None, *, ranks: int = 1, patience: float | None = None
) -> Completed:
    """Run the file ``deck`` of ``folder`` there to its end on ``ranks`` MPI ranks, ``values`` its index variables.

    Raises EnvironmentFault without an engine, EngineError if it takes longer than ``patience`` [s].
    """
    found = engine()
    command = deck_command(found, deck, values or {}, ranks)
    return run_program(command, folder, environment=found.variables(), patience=patience)


def run_template(
    folder: Path, deck: str, values: Values | None = None, *, ranks: int = 1, patience: float | None = None
) -> Completed:
    """`run_deck` with a copy of one of this package's decks."""
    copy_template(deck, folder)
    return run_deck(folder, deck, values, ranks=ranks, patience=patience)


def start_deck(folder: Path, deck: str, values: Values, ranks: int, errors: IO[str], keep: int) -> Child:
    """Start the file ``deck`` of ``folder`` there and return at once: a run that is watched while it goes on.

    ``errors``: where its standard error goes; ``keep``: a file that stays open as long as it or a process of its own lives.
    """
    found = engine()
    return Child(deck_command(found, deck, values, ranks), folder, found.variables(), errors, keep)


def deck_command(found: Engine, deck: str, values: Values, ranks: int) -> list[str]:
    """The command that runs ``deck`` on ``ranks`` MPI ranks."""
    command = [*python_child(), deck, *(str(word) for pair in values.items() for word in pair)]
    return [str(found.mpiexec), "-n", str(ranks), *command] if ranks > 1 else command
