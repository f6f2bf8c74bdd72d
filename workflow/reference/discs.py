"""What goes into the reference integrator and what comes out of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workflow.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def pair_list(count: int) -> Ints:
    """All pairs i < j of ``count`` discs in row order (0,1), (0,2), ..., (1,2), ...; (P, 2)."""
    return np.column_stack(np.triu_indices(count, 1)).astype(np.int64)


@dataclass(frozen=True)
class Discs:
    """State of 2 to 6 discs.

    ``position``, ``velocity`` (N, 2); ``omega`` (N,), counter-clockwise positive; ``diameter`` (N,).  ``mass`` (N,):
    d^2 if not given, ``inf`` for a disc that keeps its velocity and spin.  Moment of inertia m d^2/8.
    ``xi_t``, ``xi_r`` (P,): du and dtheta of the pairs of ``pair_list(N)``, 0 if not given and without effect
    for pairs that do not touch.  In a cell velocities are relative to its affine motion.
    Raises InputError for wrong shapes, values that are not finite, or centres that coincide.
    """

    position: Floats
    velocity: Floats
    omega: Floats
    diameter: Floats
    mass: Floats = field(default_factory=lambda: np.empty(0))
    xi_t: Floats = field(default_factory=lambda: np.empty(0))
    xi_r: Floats = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.diameter))
        if not 2 <= count <= 6:
            raise InputError(f"discs: 'diameter' has {count} values; the reference takes 2 to 6 discs; use the engine")
        pairs = count * (count - 1) // 2
        shapes = {"position": (count, 2), "velocity": (count, 2), "xi_t": (pairs,), "xi_r": (pairs,)}
        defaults = {"mass": np.square(self.diameter), "xi_t": np.zeros(pairs), "xi_r": np.zeros(pairs)}
        for name in (f.name for f in fields(self)):
            value = getattr(self, name)
            value = defaults[name] if name in defaults and np.size(value) == 0 else value
            array = _checked(f"discs: '{name}'", value, shapes.get(name, (count,)), infinite=name == "mass")
            object.__setattr__(self, name, array)
        for name in ("diameter", "mass"):
            if np.any(getattr(self, name) <= 0.0):
                raise InputError(f"discs: '{name}' is {getattr(self, name)}; it must be > 0; correct this value")
        if len(np.unique(self.position, axis=0)) < count:
            raise InputError(f"discs: 'position' {self.position.tolist()} has coinciding centres; move them apart")

    @property
    def inverse_mass(self) -> Floats:
        """1/m, (N,), 0 for fixed discs."""
        return 1.0 / self.mass

    @property
    def inverse_inertia(self) -> Floats:
        """8/(m d^2), (N,)."""
        return 8.0 * self.inverse_mass / self.diameter**2


def _checked(what: str, value: ArrayLike, shape: tuple[int, ...], infinite: bool = False) -> Floats:
    array = np.array(value, dtype=np.float64)
    if array.shape != shape:
        raise InputError(f"{what} has shape {array.shape}; it must be {shape}; give one value per disc or pair")
    if np.any(np.isnan(array)) or not (infinite or np.all(np.isfinite(array))):
        raise InputError(f"{what} is {array.tolist()}; all values must be finite; correct them")
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Cell:
    """Periodic rectangle with L_a(t) = L_a(0) (1 - rate_a t), compression positive (G07 sec. II A).

    ``lengths``, ``rate`` (2,).  Centres move as dx_a/dt = v_a + (dL_a/dt/L_a) x_a; positions are not wrapped.
    """

    lengths: Floats
    rate: Floats | tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "lengths", _checked("cell: 'lengths'", self.lengths, (2,)))
        object.__setattr__(self, "rate", _checked("cell: 'rate'", self.rate, (2,)))

    def at(self, time: float) -> tuple[Floats, Floats]:
        """Lengths L (2,) and velocity gradient dL/dt/L (2,) at ``time``."""
        strain = 1.0 - np.asarray(self.rate) * time
        return self.lengths * strain, -np.asarray(self.rate) / strain

    def require(self, cutoff_gap: float, t_end: float) -> None:
        """Raise InputError unless at most one image of a disc can interact with another (L > 2 ``cutoff_gap``)."""
        smallest = np.minimum(self.lengths, self.lengths * (1.0 - np.asarray(self.rate) * t_end))
        if np.any(smallest <= 2.0 * cutoff_gap):
            raise InputError(
                f"cell: 'lengths' shrink to {smallest.tolist()}; each must stay above twice the range {cutoff_gap:g} of a "
                "pair; enlarge the cell, lower the rate or shorten the run"
            )


class Event(NamedTuple):
    """``kind``: enter, close, open, leave; slip, stick (tangential); roll, lock (rolling).  ``pair``: (i, j)."""

    time: float
    pair: tuple[int, int]
    kind: str


@dataclass(frozen=True)
class Energy:
    """Energy account, (K,) each.

    Stored: ``kinetic`` (discs of finite mass), springs ``normal``, ``tangential``, ``rolling``, and ``adhesive`` <= 0.
    Lost since t = 0: ``viscous``, ``sliding``, ``rolling_friction``, and ``opening``, what tangential and rolling
    springs still hold when they are forgotten at opening (only with infinite mu or mu_r).
    ``cell_work`` done by the cell on the discs, -integral of sum over pairs F_a r_a (dL_a/dt)/L_a.
    ``gravity`` -sum m g.x, stored too.
    """

    kinetic: Floats
    normal: Floats
    tangential: Floats
    rolling: Floats
    adhesive: Floats
    viscous: Floats
    sliding: Floats
    rolling_friction: Floats
    opening: Floats
    cell_work: Floats
    gravity: Floats

    @property
    def stored(self) -> Floats:
        """Kinetic, elastic, adhesive and gravitational energy."""
        return self.kinetic + self.normal + self.tangential + self.rolling + self.adhesive + self.gravity

    @property
    def lost(self) -> Floats:
        """All dissipation since t = 0."""
        return self.viscous + self.sliding + self.rolling_friction + self.opening

    @property
    def residual(self) -> Floats:
        """stored + lost - cell_work minus its first value: 0 but for the integration error."""
        account = self.stored + self.lost - self.cell_work
        return account - account[0]


@dataclass(frozen=True)
class Trajectory:
    """Result at the K times ``time``.

    Per disc: ``position``, ``velocity`` (K, N, 2), ``omega`` (K, N).  Per pair of ``pairs`` (P, 2): ``branch`` (K, P, 2)
    from i to the nearest image of j, ``gap``, ``xi_t`` du, ``xi_r`` dtheta, ``normal`` N, ``tangential`` T and
    ``moment`` -K_r dtheta (K, P), forces of i on j.  At the time of an event the state before it is given.
    """

    time: Floats
    position: Floats
    velocity: Floats
    omega: Floats
    pairs: Ints
    branch: Floats
    gap: Floats
    xi_t: Floats
    xi_r: Floats
    normal: Floats
    tangential: Floats
    moment: Floats
    energy: Energy
    events: tuple[Event, ...]
    start: Discs

    def discs(self, k: int = -1) -> Discs:
        """State at ``time[k]``, to start another run from."""
        state = (self.position[k], self.velocity[k], self.omega[k], self.start.diameter, self.start.mass)
        return Discs(*state, self.xi_t[k], self.xi_r[k])

    def times_of(self, kind: str) -> list[float]:
        """Times of the events of one kind."""
        return [event.time for event in self.events if event.kind == kind]


def check_times(t_end: float, t_eval: ArrayLike | None) -> Floats:
    """``t_eval`` as increasing float64 in [0, t_end], (0, t_end) if not given."""
    if not (t_end > 0.0 and math.isfinite(t_end)):
        raise InputError(f"integrate: 't_end' is {t_end!r}; it must be > 0 and finite; correct this value")
    times = np.array([0.0, t_end] if t_eval is None else t_eval, dtype=np.float64)
    if times.ndim != 1 or not len(times) or times[0] < 0.0 or times[-1] > t_end or np.any(np.diff(times) <= 0.0):
        raise InputError(f"integrate: 't_eval' must increase within [0, {t_end:g}]; sort it and drop what lies outside")
    return times
