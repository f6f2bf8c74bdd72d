"""The paper that figures are drawn for: how wide they are, how fine, and nothing of matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from workflow.errors import InputError

COLUMN, PAGE = 86.0, 178.0  # mm: one column and both of a journal's page
NARROW = 120.0  # mm; below, panels stand above each other
DPI = 300
FORMATS = ("png", "svg", "pdf")
WIDTHS, DOTS = (40.0, 400.0), (50, 1200)  # mm and dots per inch that can be asked for
WIDEST = 12000  # pixels; a picture of twice as many takes gigabytes


@dataclass(frozen=True)
class Paper:
    """``width`` of a figure [mm], None: as wide as each is meant to be; ``dpi`` of what has pixels, None: DPI."""

    width: float | None = None
    dpi: int | None = None

    def __post_init__(self) -> None:
        for option, value, (least, most) in (("--size", self.width, WIDTHS), ("--dpi", self.dpi, DOTS)):
            if value is not None and not least <= value <= most:
                raise InputError(f"{option} {value:g} is not allowed; give a number from {least:g} to {most:g}")
        if (wide := (self.width or PAGE) / 25.4 * (self.dpi or DPI)) > WIDEST:
            raise InputError(f"--dpi {self.dpi} makes {wide:.0f} pixels of a line, at most {WIDEST} are drawn; give less")


PLAIN = Paper()
PAPER: ContextVar[Paper] = ContextVar("PAPER", default=PLAIN)


@contextmanager
def on(paper: Paper) -> Iterator[None]:
    """Draw for ``paper`` inside the block."""
    token = PAPER.set(paper)
    try:
        yield
    finally:
        PAPER.reset(token)
