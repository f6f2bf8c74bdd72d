"""Every figure by name: what it shows, of what, and the function that draws it, which is imported when it is first called.

A scene declares the groups whose figures show its runs (`Scene.figures`); dumps of other programs have ``network``.  Studies
add groups of their own (`workflow.verification.figures`, `workflow.reproduce.figures`), and so do scenes from outside
(docs/extending.md).  Nothing here imports matplotlib: the help of `wf plot` must not wait for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple

from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.alike import FREE
from workflow.runs.directory import RunDirectory

FRAMES, RUNS, STUDY = "frames", "runs", "study"


class Shown(NamedTuple):
    """A run as its figures name it, and the frame that those of a single frame show."""

    directory: RunDirectory
    name: str
    frame: int = -1


def imported(place: str) -> Callable[..., Any]:
    """The function at ``module:name``, imported when it is called."""
    module, _, name = place.partition(":")

    def call(*given: Any, **options: Any) -> Any:
        return getattr(import_module(module), name)(*given, **options)

    return call


PAGE = "report.html"  # the page of a run, in its directory


@dataclass(frozen=True)
class Figure:
    """``draw`` takes what is shown and the paths to write, one for each format; False: there was nothing to draw.

    ``of``: it shows FRAMES, a sequence of (Frame, Settings); RUNS, a sequence of `Shown`; or the rows of a STUDY.
    ``several``: more than one of them, as a mean over samples that differ in nothing but ``free``, or each by itself where
    ``free`` is None.  ``unasked``: `wf plot` draws it unless told which.  ``needs``: quantities of the frame without which
    there is nothing to draw; ``periodic``: it needs a cell without walls.  ``formats``: the only ones there are.
    """

    meaning: str
    draw: Callable[..., Any]
    of: str = FRAMES
    several: bool = False
    free: tuple[str, ...] | None = FREE
    unasked: bool = False
    needs: tuple[str, ...] = ()
    periodic: bool = False
    formats: tuple[str, ...] = ()

    def check(self, frame: Frame) -> None:
        """Raises InputError if ``frame`` cannot be drawn."""
        frame.need(self.meaning.split(" (")[0], *self.needs)
        if self.periodic and not all(frame.periodic):
            raise InputError(f"{self.meaning}: undefined, it needs a cell that is periodic in x and y; this box has walls")


def _frames(name: str, meaning: str, needs: Sequence[str] = (), **known: Any) -> Figure:
    return Figure(meaning, imported(f"workflow.reports.of_frames:{name}"), needs=tuple(needs), **known)


def _runs(name: str, meaning: str, **known: Any) -> Figure:
    return Figure(meaning, imported(f"workflow.reports.of_runs:{name}"), RUNS, **known)


def _heap(name: str, meaning: str, **known: Any) -> Figure:
    return Figure(meaning, imported(f"workflow.reports.heap:{name}"), RUNS, unasked=True, **known)


FORCES, DISCS, GAPS = ("normal", "tangential"), ("normal", "tangential", "diameter", "gap"), ("diameter", "gap")
FIGURES: dict[str, dict[str, Figure]] = {
    "network": {
        "forces": _frames("forces", "force network: compressive, tensile, distant, rattlers (fig. 2)", DISCS, unasked=True),
        "stressed": _frames("stressed", "force network with the unstressed parts apart (figs. 11, 12, 19-22)", DISCS),
        "distribution": _frames("distribution", "distribution of N (figs. 9, 10)", FORCES, several=True),
        "cloud": _frames("cloud", "N-T plane, Coulomb cone, +-sqrt(3) cross (figs. 14, 17)", FORCES, several=True),
        "angles": _frames("angles", "angle of force and normal (fig. 15)", FORCES, several=True),
        "triangle": _frames("triangle", "a disc held by two touching discs, with its forces (fig. 16)", DISCS),
        "double_triangle": _frames("double_triangle", "two discs held by the same two, with their forces (fig. 18)", DISCS),
        "coordination": _frames("coordination", "share of grains with k neighbours (figs. 3, 6)", FORCES, several=True),
        "self_stress": _frames("self_stress", "hyperstatic clusters", GAPS, periodic=True),
        "floppy": _frames("floppy", "floppy modes", GAPS, periodic=True),
        "vibrations": _frames("vibrations", "vibration spectrum and participation ratios", (*GAPS, "mass"), several=True,
                              periodic=True),
        "scattering": _frames("scattering", "I(k) with the fit of eq. 28 (fig. 23)", ("diameter",), several=True,
                              periodic=True),
        "correlation": _frames("correlation", "C(r) (eq. 24)", ("diameter",), several=True, periodic=True),
        "holes": _frames("holes", "map of the holes (eq. 29)", GAPS, periodic=True),
        "hole_sizes": _frames("hole_sizes", "distribution of hole radii, <R>_w (eq. 30)", GAPS, several=True, periodic=True),
        "pair_correlation": _frames("pair", "g(r)", several=True, periodic=True),
    },
    "history": {
        "history": _runs("history", "density, stresses and unbalanced forces against time", unasked=True),
        "density": _runs("density", "solid fraction against time, logarithmic (fig. 4)", several=True, free=None),
        "pores": _runs("pores", "frames from P* = 0 on side by side (figs. 5, 7)", several=True, free=None),
        "consolidation": _runs("consolidation", "Phi and z against P*", several=True, free=None),
    },
    "aggregation": {
        "agitation": _runs("agitation", "z at P* = 0 against V0 (fig. 8)", several=True, free=(*FREE, "v0")),
    },
    "heap": {
        "heap": _heap("draw_snapshot", "grains with the surface profile (B97 fig. 1)"),
        "vectors": _heap("draw_vectors", "centre-to-centre vectors of near pairs (B97 figs. 2, 5, 6, 8)"),
        "forces": _heap("draw_forces", "normal forces, and the force on the base (B97 fig. 3)"),
        "maps": _heap("draw_maps", "voidage, and lines of the largest stress"),
        "avalanche": _heap("draw_film", "film of the largest avalanche", formats=("gif",)),
    },
}  # fmt: skip


def figures_of(groups: Iterable[str]) -> dict[str, Figure]:
    """The figures of ``groups`` by name.  Raises InputError for a group that nobody has added to FIGURES."""
    found: dict[str, Figure] = {}
    for group in groups:
        if group not in FIGURES:
            raise InputError(f"'{group}' is no group of figures; known are {', '.join(FIGURES)}: add it to "
                             "workflow.reports.registry.FIGURES (docs/extending.md)")  # fmt: skip
        found |= FIGURES[group]
    return found
