"""A scene that is no packing: grains run out of a silo through a hole in its bottom into the bin below."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from workflow.archive.read import Archive
from workflow.data.discs import Discs
from workflow.pipeline.kinds import KINDS, Kind
from workflow.reports.registry import FIGURES, RUNS, Figure
from workflow.scene.base import Scene, Units
from workflow.scene.parameter import parameter
from workflow.scene.parts import Material, Numerics
from workflow.scene.time_step import choose_step

PITCH, ROOM = 1.1, 1.0  # of the lattice that the grains start on; free height above them [a]


# ---- the scene: parameters, geometry, and the names of what the registries below hold for it
@dataclass(frozen=True, kw_only=True)
class Silo(Scene, Numerics, Material):
    """Units: length a, mass of a disc of diameter a, gravity g.  Walls, bottom and bin are fixed discs of diameter a."""

    name: ClassVar[str] = "silo"
    title: ClassVar[str] = "discs that run out of a silo"
    kind: ClassVar[str] = "silo"
    figures: ClassVar[tuple[str, ...]] = ("silo",)
    template: ClassVar[Path | None] = Path(__file__).with_name("silo.in").resolve()
    stages: ClassVar[dict[int, str]] = {1: "flow"}

    n: int = parameter(200, int, "number of grains", symbol="N", low=1, high=1e6)
    width: int = parameter(12, int, "width between the walls", unit="a", low=4, high=1000)
    opening: int = parameter(5, int, "discs that are left out of the bottom", unit="a", low=1, high=998)
    smallest: float = parameter(0.8, float, "smallest diameter", unit="a", low=0.1, high=1.0)
    cohesion: bool = parameter(False, bool, "attraction of the weight of the largest grain")
    kappa: float = parameter(1e4, float, "stiffness K_N a/(m g)", low=1e2, high=1e8)
    max_time: float = parameter(30.0, float, "longest time", unit="sqrt(a/g)", above=0.0, high=1e6)
    seed: int = parameter(1, int, "seed of sizes and places", low=0, high=2**63 - 1)

    @property
    def size(self):
        return self.n

    @property
    def units(self):
        return Units("a", "mg", "√(a/g)")

    @property
    def force_set_by(self):
        return "gravity"

    @property
    def columns(self):
        """Of the lattice that the grains start on."""
        return int((self.width - 0.2) / PITCH)

    @property
    def bottom(self):
        """Height of the bottom above the floor of the bin, which has room for all grains [a]."""
        return math.ceil(PITCH * math.ceil(self.n / self.columns)) + 2

    @property
    def step_choice(self):
        fall = math.sqrt(4.0 * self.bottom)  # from the top of the grains to the floor of the bin
        return choose_step(self.contact_law(1.0), self.smallest, fall, self)

    def fixed(self):
        """Centres of the fixed discs, (F, 2), spaced by a: walls, floor of the bin, bottom of the silo."""
        left, right, height = 0.5, self.width + 1.5, 2 * self.bottom
        walls = [(x, 0.5 + k) for x in (left, right) for k in range(height)]
        closed = (self.width - self.opening) // 2
        row = [left + 1 + k for k in range(self.width)]
        edges = row[:closed] + row[closed + self.opening :]
        return np.array([*walls, *((x, 0.5) for x in row), *((x, 0.5 + self.bottom) for x in edges)])

    def discs(self):
        rng, fixed = self.random("grains"), self.fixed()
        place = np.array([(k % self.columns, k // self.columns) for k in range(self.n)]) * PITCH
        place += [1.0 + 0.5 * (self.width - PITCH * (self.columns - 1)), self.bottom + 1.6]
        place += rng.uniform(-0.04, 0.04, (self.n, 2))
        size = rng.uniform(self.smallest, 1.0, self.n)
        top = max(place[:, 1].max(), fixed[:, 1].max()) + 0.5 + ROOM
        return Discs(np.append(np.ones(len(fixed)), size), np.vstack((fixed, place)), np.array([self.width + 2.0, top]))

    def variables(self):
        law, step = self.contact_law(1.0), self.step_choice.step
        check = max(1, round(0.02 / step))

        def every(time: float) -> int:
            return check * max(1, math.ceil(time / (check * step)))

        return {
            "kn": law.kn, "kt": law.kt, "zeta": law.zeta, "mu": law.mu, "f0": law.f0, "d0": law.d0, "kr": law.kr,
            "mur": law.mur, "account": "yes" if self.account else "no", "scheme": self.scheme, "step": step,
            "skin": self.skin or 0.3, "fixed": len(self.fixed()), "bottom": 0.5 + self.bottom, "check_every": check,
            "max_steps": every(self.max_time), "series_every": every(self.series_interval),
            "frame_every": every(self.frame_interval or self.max_time),
            "checkpoint_every": every(self.checkpoint_interval),
        }  # fmt: skip

    def state_line(self, series: Mapping[str, Any]) -> str:
        return f"passed {series['passed'][-1]:.0f} of {self.n}"


# ---- its measure, of one frame
def measure(run, frame):
    """Grains that passed the opening and grains still in the silo, the rate [sqrt(g/a)] at which the middle half of those
    that ever pass did so (None: too few), and whether the run came to rest."""
    scene, time, through = run.scene, run.series["time"], run.series["passed"]
    passed = int(np.sum((frame.position[:, 1] < 0.5 + scene.bottom) & (frame.ids > len(scene.fixed()))))
    begin, end = (float(time[np.argmax(through >= share * through.max())]) for share in (0.25, 0.75))
    rate = 0.5 * float(through.max()) / (end - begin) if end > begin else None
    return {"passed": passed, "left": scene.n - passed, "rate": rate, "equilibrated": run.equilibrated(frame)}


# ---- its figure, of a run
def discharge(runs: Sequence[Any], paths: Sequence[Path]) -> None:
    """Grains that passed against time, a curve for each run."""
    from workflow.reports.figures import LOOKS, panel, save, style  # slow to import, and most commands draw nothing

    with style():
        figure, axes = panel()
        for number, run in enumerate(runs):
            colour, dash, _ = LOOKS[number % len(LOOKS)]
            with Archive(run.directory / "run.h5") as archive:
                axes.plot(archive.series["time"], archive.series["passed"], color=colour, linestyle=dash, label=run.name)
        axes.set(xlabel=r"time $t/\sqrt{a/g}$", ylabel="grains that passed")
        if len(runs) > 1:
            axes.legend()
        save(figure, paths)


SCENES = [Silo]
KINDS["silo"] = Kind(measure)
FIGURES["silo"] = {"discharge": Figure("grains that passed the opening against time", discharge, RUNS, several=True,
                                       free=None, unasked=True)}  # fmt: skip
