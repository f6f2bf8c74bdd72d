"""A few discs, many times over: groups of 2 to 6 discs far apart in one cell, each with its reference trajectory.

Every group meets the steps of the integrator at its own phase, so that the root mean square over groups is a smooth
function of the step.  Units: length a, mass of a disc of diameter a, force F0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Discs as Group
from workflow.reference.discs import Trajectory
from workflow.reference.integrate import integrate
from workflow.scene.placement import Floats
from workflow.verification.one_run import Outcome

SPACING = 6.0  # between groups: they never meet
SPEED = 1.0  # largest impact speed
CONTACT = {"kn": 1e5, "kt": 1e5}
TAIL = {"f0": 1.0, "d0": 1e-3}
ROLLING = {"kr": 10.0, "mur": 5e-3}


@dataclass(frozen=True)
class State:
    """Of one group at the end: ``position``, ``velocity`` (n, 2), ``omega`` (n,)."""

    position: Floats
    velocity: Floats
    omega: Floats


Measure = Callable[[Sequence[Group], Sequence[State]], Floats]
Distance = Callable[[Floats, Floats], float]


@dataclass(frozen=True)
class Case:
    """Groups under a law for ``duration``; ``measure`` gives one row of numbers per group, ``distance`` the error of such
    numbers against those of the reference."""

    name: str
    meaning: str
    law: ContactLaw
    groups: list[Group]
    duration: float
    measure: Measure
    distance: Distance

    def discs(self) -> tuple[Discs, Floats, Floats]:
        """All groups in one cell: discs, velocities, spins."""
        across = int(np.ceil(np.sqrt(len(self.groups))))
        centre = SPACING * (np.array([divmod(k, across) for k in range(len(self.groups))]) + 0.5)
        position = np.vstack([group.position + place for group, place in zip(self.groups, centre, strict=True)])
        diameter = np.concatenate([group.diameter for group in self.groups])
        cell = np.full(2, SPACING * across)
        velocity = np.vstack([group.velocity for group in self.groups])
        return Discs(diameter, position, cell), velocity, np.concatenate([group.omega for group in self.groups])

    def reference(self) -> list[State]:
        """The final states by the reference integrator."""
        runs: list[Trajectory] = [integrate(CohesiveLaw(**asdict(self.law)), group, self.duration) for group in self.groups]
        return [State(run.position[-1], run.velocity[-1], run.omega[-1]) for run in runs]

    def states(self, outcome: Outcome) -> list[State]:
        """The final states of an engine run, relative to each group's place as in `reference`."""
        start = self.discs()[0].position
        ends = np.cumsum([len(group.diameter) for group in self.groups])
        rows = [slice(end - len(group.diameter), end) for end, group in zip(ends, self.groups, strict=True)]
        return [
            State(outcome.position[r] - start[r] + group.position, outcome.velocity[r], outcome.omega[r])
            for r, group in zip(rows, self.groups, strict=True)
        ]

    def error(self, outcome: Outcome, exact: Sequence[State]) -> float:
        """Error of an engine run."""
        return self.distance(self.measure(self.groups, self.states(outcome)), self.measure(self.groups, exact))


# ---- what is measured: one row per group -----------------------------------------------------------------------------


def trajectory(groups: Sequence[Group], states: Sequence[State]) -> Floats:
    """Positions in a, velocities and surface velocities in the impact speed, padded with zeros to the largest group."""
    most = max(len(group.diameter) for group in groups)
    table = np.zeros((len(groups), 5 * most))
    for row, group, state in zip(table, groups, states, strict=True):
        values = (state.position.ravel(), state.velocity.ravel() / SPEED, state.omega * group.diameter / 2.0 / SPEED)
        row[: 5 * len(group.diameter)] = np.concatenate(values)
    return table


def restitution(groups: Sequence[Group], states: Sequence[State]) -> Floats:
    """Receding speed over approach speed of each pair."""
    return np.array([[vn(state) / -vn(group)] for group, state in zip(groups, states, strict=True)])


def capture_speed(groups: Sequence[Group], states: Sequence[State]) -> Floats:
    """Approach speed at which nothing is left: the root of v_out^2 as a parabola of v_in^2 over the pairs that escaped."""
    speeds = np.array([[-vn(group), vn(state)] for group, state in zip(groups, states, strict=True)])
    # a captured pair swings within its tail, a free one is far out of it
    free = np.array([gap(group, state.position) > 2.0 * TAIL["d0"] for group, state in zip(groups, states, strict=True)])
    into, out = (speeds[free & (speeds[:, 1] > 0.0)] ** 2).T
    if len(into) < 4:
        return np.array([[np.inf]])
    roots = np.roots(np.polyfit(into, out, 2))
    near = roots[np.isreal(roots)].real
    return np.array([[np.sqrt(near[np.abs(near - into.min()).argmin()]) if len(near) else np.inf]])


def pull_off_work(groups: Sequence[Group], states: Sequence[State]) -> Floats:
    """Kinetic energy of the relative motion spent on separation."""
    work = [
        0.5 / group.inverse_mass.sum() * (vn(group) ** 2 - vn(state) ** 2) for group, state in zip(groups, states, strict=True)
    ]
    return np.array(work)[:, None]


def vn(state: Group | State) -> float:
    """n.(v_j - v_i) of a pair."""
    branch = state.position[1] - state.position[0]
    return float((state.velocity[1] - state.velocity[0]) @ branch / np.hypot(*branch))


def gap(group: Group, position: Floats) -> float:
    """Gap of a pair of ``group`` at ``position``."""
    return float(np.hypot(*(position[1] - position[0])) - group.diameter.mean())


def worst_of_each(found: Floats, exact: Floats) -> float:
    """Root mean square over groups of the largest difference within each."""
    return float(np.sqrt(np.mean(np.abs(found - exact).max(axis=1) ** 2)))


def relative(found: Floats, exact: Floats) -> float:
    """Root mean square of the relative difference."""
    return float(np.sqrt(np.mean((found / exact - 1.0) ** 2)))


# ---- the cases --------------------------------------------------------------------------------------------------------


def cases(count: int, seed: int = 1) -> list[Case]:
    """Every case with ``count`` groups."""
    rng = np.random.default_rng(seed)
    dry = ContactLaw(**CONTACT, zeta=0.3)
    sticky = replace(dry, **TAIL)
    rough = ContactLaw(**CONTACT, zeta=0.8, mu=0.5)
    capture = capture_reference(sticky)
    swing = -TAIL["f0"] / CONTACT["kn"]  # overlap at rest
    escape = np.sqrt(2.0 * (0.5 * TAIL["f0"] * TAIL["d0"] + 0.5 * TAIL["f0"] ** 2 / CONTACT["kn"]) / 0.5)
    near, wide = np.linspace(0.03, 0.3, 3 * count), np.linspace(0.2, 1.0, count)
    return [
        Case("impacts, undamped", "2 to 6 discs, no friction: positions, velocities", ContactLaw(**CONTACT),
             [cluster(rng) for _ in range(count)], 0.08, trajectory, worst_of_each),
        Case("impacts, friction", "2 to 6 discs, undamped, friction", replace(rough, zeta=0.0),
             [cluster(rng) for _ in range(count)], 0.08, trajectory, worst_of_each),
        Case("impacts, damped", "2 to 6 discs, damping and friction", rough,
             [cluster(rng) for _ in range(count)], 0.08, trajectory, worst_of_each),
        Case("impacts, cohesive", "the same with attraction", replace(rough, **TAIL),
             [cluster(rng) for _ in range(count)], 0.08, trajectory, worst_of_each),
        Case("impacts, rolling", "the same with attraction and rolling resistance", replace(rough, **TAIL, **ROLLING),
             [cluster(rng) for _ in range(count)], 0.08, trajectory, worst_of_each),
        Case("restitution", "head-on, zeta = 0.3, e = 0.39", dry, [pair(v, rng.uniform(2e-3, 4e-3)) for v in wide],
             0.06, restitution, relative),
        Case("capture speed", "head-on with attraction, zeta = 0.3", sticky,
             [pair(capture * (1.0 + x), rng.uniform(2e-3, 4e-3)) for x in near], 0.5, capture_speed, relative),
        Case("pull-off work", "undamped pair in equilibrium torn apart", ContactLaw(**CONTACT, **TAIL),
             [pair(-escape * (1.3 + 2.0 * x), swing) for x in wide], 0.2, pull_off_work, relative),
    ]  # fmt: skip


def pair(speed: float, distance: float) -> Group:
    """Two equal discs at a gap ``distance`` that approach with ``speed``."""
    half = (1.0 + distance) / 2.0
    return Group([[-half, 0.0], [half, 0.0]], [[speed / 2.0, 0.0], [-speed / 2.0, 0.0]], [0.0, 0.0], [1.0, 1.0])  # type: ignore[arg-type]


def cluster(rng: np.random.Generator) -> Group:
    """2 to 6 discs at small gaps, thrown at their common centre, spinning."""
    count = int(rng.integers(2, 7))
    diameter = rng.uniform(0.5, 1.0, count)
    position = np.zeros((1, 2))
    while len(position) < count:
        k = len(position)
        angle, host = rng.uniform(0.0, 2.0 * np.pi), int(rng.integers(k))
        reach = (diameter[host] + diameter[k]) / 2.0 + rng.uniform(4e-3, 2e-2)
        place = position[host] + reach * np.array([np.cos(angle), np.sin(angle)])
        if (np.hypot(*(position - place).T) > (diameter[:k] + diameter[k]) / 2.0 + 2e-3).all():
            position = np.vstack((position, place))
    inward = position.mean(axis=0) - position
    velocity = rng.uniform(0.5, 1.0, (count, 1)) * SPEED * inward / np.hypot(*inward.T)[:, None]
    velocity += rng.normal(scale=0.1 * SPEED, size=(count, 2))
    return Group(position, velocity, rng.normal(scale=2.0 * SPEED, size=count), diameter)


@cache
def capture_reference(law: ContactLaw) -> float:
    """Largest approach speed at which two equal discs stay together, by bisection with the reference integrator."""
    low, high, reference = 1e-2, 1.0, CohesiveLaw(**asdict(law))
    while high / low > 1.0 + 1e-3:  # only where to look: the speed itself comes from the pairs near it
        middle = np.sqrt(low * high)
        group = pair(middle, 2e-3)
        end = integrate(reference, group, 4e-3 / middle + 0.1, rtol=1e-8).discs()
        free = gap(group, end.position) > TAIL["d0"]
        low, high = (low, middle) if free else (middle, high)
    return float(high)
