"""Heaps of B97 (Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997)): grains poured on a row of fixed discs.

Units: largest diameter sigma, mass m of such a disc, gravity g; time sqrt(sigma/g), force m g.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.data.frame import Floats
from workflow.errors import InputError
from workflow.scene.base import Scene, Units
from workflow.scene.parameter import parameter
from workflow.scene.parts import idle
from workflow.scene.progress import heap_left, of_heap
from workflow.scene.routes import LARGEST_FRICTION
from workflow.scene.time_step import Step

CLOCK = "sqrt(sigma/g)"  # unit of time
FLOOR = 4.0  # height of the base above the lower face of the box; grains 3 below the base have left
LAWS = {None: "common/law_continuous.in", "hooke/history": "common/law_heap_hooke_history.in"}  # of lammps_inputs/
MARGIN = 12.0  # free width beyond each end of the base
HEADROOM = 6.0  # above the height of the drop
# steps per period at which an impact with the damping of B97 is at the limit of stability; more damping shortens the step
STEPS_TO_LIMIT = {"paper": 6.1, "second": 10.0}
FASTEST_APPROACH = 2.0  # times the impact speed: of two grains within reach of the feed


@dataclass(frozen=True, kw_only=True, repr=False)
class Heap(Scene):
    """Scene `heap`; every parameter is a field, every derived number a property."""

    name: ClassVar[str] = "heap"
    title: ClassVar[str] = "two-dimensional heap poured from a height (B97)"
    kind: ClassVar[str] = "heap"
    stages: ClassVar[dict[int, str]] = {1: "pour"}
    figures: ClassVar[tuple[str, ...]] = ("heap",)
    ends_in_equilibrium: ClassVar[bool] = True
    READINGS: ClassVar[Mapping[str, tuple[Any, Any]]] = {"spacing": (1.0, 1.1)}

    grains: int = parameter(
        1334, int, "number of grains poured", symbol="N", low=1, high=1e6, source="B97 fig. 1", group="grains", option="n",
    )  # fmt: skip
    law: str = parameter(
        None, str, "contact law: exact (default, B97), or LAMMPS's hooke/history, near to Hooke's (hooke > 0)",
        choices=("exact", "hooke/history"), automatic=True, group="contact law",
    )  # fmt: skip
    index: float = parameter(
        36.0, float, "index n of the force (sigma/r)^(n+1)", symbol="n", low=4.0, high=1000.0, source="B97 sec. II",
        group="contact law",
    )  # fmt: skip
    cutoff: float = parameter(
        1.2, float, "range r0 of the force", symbol="r0", unit="sigma", low=1.0, high=2.0, source="B97: 1.047 for n = 144",
        group="contact law",
    )  # fmt: skip
    hooke: float = parameter(
        0.0, float, "stiffness k of Hooke's law in place of the continuous one, 0: none", symbol="k", unit="mg/sigma",
        low=0.0, high=1e8, source="B97 eq. 14: 500", group="contact law",
    )  # fmt: skip
    mu: float = parameter(
        0.5, float, "friction coefficient", symbol="mu", low=0.0, source="B97: 0.4 to 0.6", group="contact law",
    )  # fmt: skip
    alpha: float = parameter(
        1.214, float, "dmax = alpha mu (r0 - r)", symbol="alpha", above=0.0, high=100.0, source="B97", group="contact law",
    )  # fmt: skip
    damping: float = parameter(
        0.5, float, "fraction of critical damping", low=0.0, high=2.0, source="B97 eqs. 3, 8", group="contact law",
    )  # fmt: skip
    printed_rotation: bool = parameter(
        False, bool, "lever arms r_ij of eqs. 6 and 13 as printed, not r_ij/2", source="B97 eqs. 6, 13", group="contact law",
    )  # fmt: skip
    printed_damping: bool = parameter(
        False, bool, "tangential damping of the centres' motion alone, as eq. 4 is printed", source="B97 eq. 4",
        group="contact law",
    )  # fmt: skip
    polydispersity: float = parameter(
        0.0, float, "delta: diameters uniform in [1 - delta, 1]", unit="sigma", low=0.0, high=0.5, source="B97: 0, 0.05, 0.1",
        group="grains",
    )  # fmt: skip
    base: str = parameter("rough", str, "a row of fixed discs, or a smooth flat floor", choices=("rough", "flat"))
    spacing: float = parameter(
        None, float, "spacing of the base discs, default 1.0, as printed 1.1", symbol="S", unit="sigma", low=0.5, high=3.0,
        automatic=True, source="B97 sec. III",
    )  # fmt: skip
    base_half_width: float | None = parameter(
        None, float, "half the width of the base, default 1.6 sqrt(N) + 5", unit="sigma", above=1.0, high=1e5, automatic=True
    )
    start: str = parameter("pour", str, "pour, or a pyramid on the lattice of the base", choices=("pour", "pyramid"))
    feed_rate: float = parameter(0.62, float, "grains per time unit", above=0.0, high=10.0, source="B97 fig. 2")
    feed_half_width: float = parameter(3.0, float, "grains start this near the middle", unit="sigma", low=0.0, high=1e3)
    drop_height: float = parameter(100.0, float, "height of the feed above the base", unit="sigma", low=3.0, high=1e4)
    seed: int = parameter(1, int, "seed of places and sizes", low=0, high=2**63 - 1, group="grains")
    force_tolerance: float = parameter(1e-4, float, "largest net force and moment at rest", unit="mg", above=0.0, high=1.0)
    energy_tolerance: float = parameter(5e-8, float, "kinetic energy per grain at rest", unit="mg sigma", above=0.0, high=1.0)
    hold: float = parameter(2.0, float, "time that rest must last", unit=CLOCK, low=0.0, high=1e6)
    max_time: float | None = parameter(
        None, float, "longest time, default that of the feed and 500 more", unit=CLOCK, above=0.0, high=1e9, automatic=True,
    )  # fmt: skip
    step: float | None = parameter(
        None, float, "time step, default from the hardest impact", unit=CLOCK, low=1e-9, high=1.0, automatic=True,
        group="numerics",
    )  # fmt: skip
    steps_per_period: float = parameter(14.0, float, "steps per stiffest period", low=4.0, high=1e4, group="numerics")
    skin: float | None = parameter(
        None, float, "neighbour skin, default r0 - sigma + 0.3", unit="sigma", above=0.0, high=2.0, automatic=True,
        group="numerics",
    )  # fmt: skip
    scheme: str = parameter(
        "second", str, "time integration: second order in the step, or that of the paper (dampers see half-step velocities)",
        choices=("second", "paper"), source="B97 eqs. 9-12", group="numerics",
    )  # fmt: skip
    account: bool = parameter(True, bool, "energy account (what viscosity and sliding dissipate)", group="numerics")
    frame_interval: float = parameter(
        50.0, float, "time between frames, 0: first and last only", unit=CLOCK, low=0.0, high=1e9, group="output",
    )  # fmt: skip
    track_interval: float = parameter(
        2.0, float, "time between records of all positions", unit=CLOCK, above=0.0, high=1e9, group="output",
    )  # fmt: skip
    series_interval: float = parameter(
        1.0, float, "time between rows of the time series", unit=CLOCK, above=0.0, high=1e9, group="output",
    )  # fmt: skip
    checkpoint_interval: float = parameter(
        100.0, float, "time between checkpoints", unit=CLOCK, above=0.0, high=1e9, group="output",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.law == "exact":
            object.__setattr__(self, "law", None)  # the default, which is not written down: names of runs stay
        elif self.law:
            self._check_hooke_history()
            object.__setattr__(self, "scheme", "paper")  # the only one that it has
        apart = 0.5 / self.feed_rate**2
        if self.start == "pour" and apart < self.reach:
            raise InputError(
                f"feed_rate = {self.feed_rate:g} is not allowed: a grain has fallen {apart:.2f} sigma when the next starts, "
                f"less than the range r0 = {self.reach:g} of the force; use at most {math.sqrt(0.5 / self.reach):.3g}"
            )
        if self.feed_half_width > self.half_width:
            raise InputError(
                f"feed_half_width = {self.feed_half_width:g} is not allowed: the base ends at {self.half_width:g}; "
                "narrow the feed or widen --base-half-width"
            )
        if self.neighbour_skin <= self.reach - 1.0:
            raise InputError(
                f"skin = {self.skin:g} is not allowed: it must exceed r0 - sigma = {self.reach - 1.0:g}, or pairs would be "
                "missed; leave it out"
            )
        choice = self.step_choice
        if choice.step > choice.limit:
            raise InputError(
                f"step = {choice.step:g} is not allowed: the stiffest period is {choice.period:.3g}; use at most "
                f"{0.8 * choice.limit:.2g}, or leave it out"
            )

    def _check_hooke_history(self) -> None:
        """Raise InputError for what LAMMPS's hooke/history cannot do."""
        rules = (
            (self.hooke == 0.0, "is Hooke's law: give hooke, its stiffness, for example 500, or leave law out"),
            (self.base == "flat", "has no smooth floor: use base = rough, or leave law out"),
            (
                self.printed_rotation or self.printed_damping,
                "has no printed forms of eqs. 4, 6 and 13: leave them, or law, out",
            ),
            (self.mu > LARGEST_FRICTION, f"takes friction up to mu = {LARGEST_FRICTION:g}, not {self.mu:g}: leave law out"),
        )
        for wrong, words in rules:
            if wrong:
                raise InputError(f"law = {self.law} {words}")

    @property
    def lammps_law(self) -> tuple[ContactLaw, float] | None:
        """Of LAMMPS's hooke/history, what it stands for: k, and the stiffness of eq. 7 before it yields."""
        if self.law is None:
            return None
        return ContactLaw(kn=self.hooke, kt=1.5 * self.hooke / self.alpha, zeta=self.damping, mu=self.mu), 0.25

    def record(self) -> dict[str, Any]:
        """What a law of LAMMPS does not tell of a contact."""
        return {"lacks": ["xi_r", "xi_t"]} if self.law else {}

    @property
    def size(self) -> int:
        """Number of grains."""
        return self.grains

    @property
    def units(self) -> Units:
        """Length sigma, force m g."""
        return Units("σ", "mg", "√(σ/g)")

    @property
    def tolerance(self) -> float:
        """Forces below ``tolerance`` m g count as none."""
        return self.force_tolerance

    @property
    def force_set_by(self) -> str:
        """Forces are in units of m g."""
        return "gravity"

    @property
    def reach(self) -> float:
        """r0/sigma."""
        return 1.0 if self.hooke else self.cutoff

    @property
    def half_width(self) -> float:
        """Half the width of the base."""
        return self.base_half_width if self.base_half_width is not None else 1.6 * math.sqrt(self.grains) + 5.0

    @property
    def middle(self) -> float:
        """x of the middle of the base in the box."""
        return self.half_width + MARGIN

    @property
    def neighbour_skin(self) -> float:
        """Skin of the neighbour list [sigma]."""
        return self.skin if self.skin is not None else self.reach - 1.0 + 0.3

    @property
    def impact_speed(self) -> float:
        """Of a grain that falls on the base."""
        return math.sqrt(2.0 * self.drop_height)

    def elastic(self, distance: float) -> float:
        """F_N(r) of two largest grains."""
        return self.hooke * (1.0 - distance) if self.hooke else distance ** -(self.index + 1.0)

    def stiffness(self, distance: float) -> float:
        """k(r) = -dF_N/dr."""
        return self.hooke or (self.index + 1.0) * distance ** -(self.index + 2.0)

    @cached_property
    def closest(self) -> float:
        """Smallest distance in the hardest impact: a grain at impact speed hits one that cannot give way."""

        def motion(_: float, state: np.ndarray) -> list[float]:
            r, v = state
            return [v, self.elastic(r) - 2.0 * self.damping * math.sqrt(self.stiffness(r)) * v]

        def turned(_: float, state: np.ndarray) -> float:
            return float(state[1])

        turned.terminal, turned.direction = True, 1.0  # type: ignore[attr-defined]
        speed = self.impact_speed if self.start == "pour" else math.sqrt(2.0)
        from scipy.integrate import solve_ivp  # a quarter of a second that most commands need not pay

        found = solve_ivp(
            motion, (0.0, 10.0), [self.reach, -speed], events=turned, rtol=1e-8, atol=1e-10, max_step=0.01 / speed
        )
        return float(found.y[0].min())

    def tangential_stiffness(self, distance: float) -> float:
        """k_T(r) of a displacement d = 0 (eq. 7): 1.5 F_N/(alpha (r0 - r)), 0 without friction."""
        return 1.5 * self.elastic(distance) / (self.alpha * (self.reach - distance)) if self.mu else 0.0

    @cached_property
    def step_choice(self) -> Step:
        """The time step with its reason: the stiffest of the hardest impact (a pair: 2 k; its sliding: 6 k_T), and of a grain
        between six neighbours that carry the heap (3 (k + k_T), or the rate 12 C_T at which they stop its rotation)."""
        r = self.closest
        impact = max(2.0 * self.stiffness(r), 6.0 * self.tangential_stiffness(r))
        load = 1.5 * (math.sqrt(self.grains) + 1.0)
        r = max(1.0 - load / self.hooke, 0.1) if self.hooke else load ** (-1.0 / (self.index + 1.0))
        along = self.tangential_stiffness(r)
        pressed = max(3.0 * (self.stiffness(r) + along), (24.0 * self.damping) ** 2 * along)
        omega = math.sqrt(max(impact, pressed))
        # two grains in an impact: z = sqrt(2) damping; limit for dampers with a late or extrapolated velocity as `damped_limit`
        b = math.sqrt(2.0) * self.damping * (2.0 if self.scheme == "second" else 1.0)
        limit = min(0.5 * math.pi, 2.0 * (math.sqrt(1.0 + b * b) - b)) / omega
        period = min(2.0 * math.pi / omega, STEPS_TO_LIMIT[self.scheme] * limit)
        what = (
            f"an impact at {self.impact_speed:.3g} (closest distance {self.closest:.3f})"
            if impact > pressed
            else "a loaded grain"
        )
        if self.step is not None:
            return Step(
                self.step, period, limit, f"given; {period / self.step:.1f} steps per stiffest period {period:.3g}, of {what}"
            )
        reason = f"stiffest period {period:.3g}, of {what}, / {self.steps_per_period:g}"
        return Step(period / self.steps_per_period, period, limit, reason)

    @property
    def longest_time(self) -> float:
        """Time at which the run ends in any case."""
        fed = self.grains / self.feed_rate + self.impact_speed if self.start == "pour" else 0.0
        return self.max_time if self.max_time is not None else fed + 500.0

    def base_discs(self) -> np.ndarray:
        """Centres of the fixed discs, (B, 2), symmetric about the middle; a flat floor has one, out of reach, for its size."""
        if self.base == "flat":
            return np.array([[0.5, 0.5]])
        each_side = int(self.half_width / self.spacing)
        x = self.middle + self.spacing * np.arange(-each_side, each_side + 1)
        return np.column_stack((x, np.full(len(x), FLOOR)))

    def pyramid(self) -> np.ndarray:
        """Centres of a pyramid whose rows rest in the hollows of the row below, (N', 2), N' <= grains."""
        rows = int((math.sqrt(8.0 * self.grains + 1.0) - 1.0) / 2.0)
        rise = math.sqrt(max(1.0 - 0.25 * self.spacing**2, 0.1))
        places = []
        for k in range(rows):
            width = rows - k
            # the base has a disc in the middle: the first row lies half a spacing beside one
            x = self.middle + self.spacing * (np.arange(width) - 0.5 * (width - 1) + 0.5 * (rows % 2))
            places.append(np.column_stack((x, np.full(width, FLOOR + rise * (k + 1)))))
        return np.concatenate(places)

    def sizes(self, count: int) -> np.ndarray:
        """Diameters, (count,): uniform in [1 - delta, 1]."""
        return 1.0 - self.polydispersity * self.random("sizes").uniform(0.0, 1.0, count)

    def discs(self) -> Discs:
        """The base, then the pyramid if there is one."""
        base = self.base_discs()
        cell = np.array([2.0 * self.middle, FLOOR + self.drop_height + HEADROOM])
        if self.start == "pour":
            return Discs(np.ones(len(base)), base, cell)
        placed = self.pyramid()
        return Discs(np.concatenate((np.ones(len(base)), self.sizes(len(placed)))), np.concatenate((base, placed)), cell)

    def files(self) -> dict[str, str]:
        """The feed: tag, time of release, x, diameter of every grain that is poured."""
        count = self.grains if self.start == "pour" else 0
        x = self.middle + self.random("places").uniform(-self.feed_half_width, self.feed_half_width, count)
        first = len(self.base_discs()) + 1
        rows = zip(range(count), x.tolist(), self.sizes(count).tolist(), strict=True)
        return {"feed.txt": "".join(f"{first + k} {k / self.feed_rate!r} {place!r} {size!r}\n" for k, place, size in rows)}

    def variables(self) -> dict[str, Any]:
        """Values of the variables of the deck heap.in."""
        step = self.step_choice.step
        # a look for falling grains every so many steps; in between no pair closes in by more than `ahead`
        look, ahead = max(1, round(0.05 / step)), 0.05 * FASTEST_APPROACH * self.impact_speed + 0.5
        check = 5 * look

        def every(time: float) -> int:
            """Steps in ``time``, a multiple of the interval between checks."""
            return check * max(1, math.ceil(time / (check * step)))

        return {
            "law": LAWS[self.law],
            "index": self.index, "cutoff": self.reach, "hooke": self.hooke, "mu": self.mu, "alpha": self.alpha,
            "damping": self.damping, "printed_rotation": int(self.printed_rotation),
            "printed_damping": int(self.printed_damping), "base": len(self.base_discs()), "floor": self.base,
            "floor_y": FLOOR, "middle": self.middle, "half_width": self.half_width, "feed": "feed.txt",
            "height": FLOOR + self.drop_height, "ahead": ahead,
            "force_tolerance": self.force_tolerance, "energy_tolerance": self.energy_tolerance, "hold": self.hold,
            "step": step, "scheme": self.scheme, "skin": self.neighbour_skin, "energy_balance": "yes" if self.account else "no",
            "max_steps": every(self.longest_time), "feed_every": look, "check_every": check,
            "series_every": every(self.series_interval),
            "frame_every": every(self.frame_interval) if self.frame_interval else 0,
            "track_every": every(self.track_interval), "checkpoint_every": every(self.checkpoint_interval),
        }  # fmt: skip

    def state_line(self, series: Mapping[str, Floats]) -> str:
        """Grains poured and gone, height, unbalanced force."""
        return of_heap(series, self.grains, FLOOR)

    def time_left(self, rows: Mapping[str, Floats], stage: str) -> float | None:
        """Until the feed ends and the heap is at rest; None: unknown."""
        return heap_left(rows, self)

    def cost_left(self, rows: Mapping[str, Floats]) -> float:
        """A step costs what its grains cost, and they become more while they are poured."""
        return 0.5 * (1.0 + self.grains / max(float(rows["poured"][-1]), 1.0))

    def left_out(self) -> list[str]:
        """What this scene does not use and therefore does not pay for."""
        return [what for what, out in {"friction": self.mu == 0, "energy account": not self.account}.items() if out]

    def without_effect(self) -> dict[str, str]:
        """Parameters that change nothing in this scene, as its other ones stand: name -> why."""
        return idle(
            ("Hooke's law takes the place of the continuous one", self.hooke > 0.0, "index cutoff"),
            ("mu is 0", self.mu == 0.0, "alpha"),
            ("the heap starts as a pyramid", self.start == "pyramid", "feed_rate feed_half_width"),
            ("a flat base has no discs", self.base == "flat" and self.start == "pour", "spacing"),
            ("the step is given", self.step is not None, "steps_per_period"),
        )
