"""The cohesive contact law of G07 as a hybrid system: smooth forces within a mode, triggers that end the mode.

All pairs are handled at once; arrays have one column per pair (P,).  A pair is apart, in the attractive tail or in
contact, and each of its two springs (row 0: tangential du, row 1: rolling dtheta) sticks or slips.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CONTACT, TAIL, APART = 0, 1, 2


class Motion(NamedTuple):
    """Relative motion of pairs: ``gap`` h (P,), ``vn`` v_n (P,), ``rate`` (2, P) = v_t and w_j - w_i;
    ``vt`` (P,) = t.(v_j - v_i) of the centres alone."""

    gap: Floats
    vn: Floats
    rate: Floats
    vt: Floats


class Response(NamedTuple):
    """Forces of i on j: ``normal`` N, ``tangential`` T, ``moment`` -K_r dtheta (P,); ``memory_rate`` (2, P);
    ``dissipated_power`` (3,): power lost by viscosity, sliding and rolling, summed over the pairs."""

    normal: Floats
    tangential: Floats
    moment: Floats
    memory_rate: Floats
    dissipated_power: Floats


class PairLaw(Protocol):
    """What the integrator asks of a law.

    ``memory`` (2, P) holds du and dtheta; ``modes`` (3, P) int64 is the discrete state, its meaning known to the law
    alone.  ``triggers`` are positive as long as the mode of the pair holds.
    """

    @property
    def cutoff_gap(self) -> float:
        """Largest gap at which a pair interacts."""

    def frequency(self, mass: float) -> float:
        """Fastest angular frequency of a contact of grains of this mass."""

    def speed(self, mass: float) -> float:
        """Speed that the interaction itself gives to a grain of this mass (0 if there is none)."""

    def lever(self, distance: Floats, radsum: Floats) -> Floats:
        """Lever arms of the tangential force in units of the radii, (P,), for pairs at ``distance``; ``radsum`` R_i + R_j."""

    def start(self, motion: Motion, memory: Floats) -> tuple[Floats, Ints]:
        """Memory and modes of a state that is given from outside; InputError if the law forbids it."""

    def held(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """Memory with its slaved entries replaced by their present value, (2, P)."""

    def response(self, reduced: Floats, motion: Motion, memory: Floats, modes: Ints) -> Response:
        """Forces and rates for held ``memory`` and reduced masses m* (P,)."""

    def triggers(self, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Floats]:
        """Values and time derivatives (0 where unknown) of the triggers, (E, P) each, for held ``memory``."""

    def switch(self, row: int, pair: int, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Ints, str]:
        """New memory, new modes and the kind of event when trigger ``row`` of ``pair`` has fired."""

    def energies(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """Energy of the normal, tangential and rolling springs and of the attraction, (4,)."""


class CohesiveLaw(ContactLaw):
    """`ContactLaw` with its forces: n from i to j, h gap, v_n receding positive, force of i on j N n + T t, repulsion positive.

    * 0 <= h <= D0: N = -F0 (1 - h/D0) (eq. 4);  h < 0: N = -K_N h - eta v_n - F0 (eqs. 5, 6),
      eta = zeta sqrt(4 K_N m*), m* = m_i m_j/(m_i + m_j)
    * T = -K_T du, d du/dt = v_t, K_T |du| <= mu K_N (-h) (eq. 8); du is forgotten when the contact opens
    * moment of i on j -R_j T - K_r dtheta, of j on i -R_i T + K_r dtheta, d dtheta/dt = w_j - w_i,
      K_r |dtheta| <= mu_r K_N (-h) (eqs. 9, 10)
    * adhesive potential -F0 (D0 - h)^2/(2 D0) in the tail, -F0 D0/2 + F0 h in contact

    Raises InputError for a constant out of range or not known.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if math.isnan(self.mu):
            raise InputError("law: 'mu' is nan; it must be >= 0; correct this value")

    def frequency(self, mass: float) -> float:
        """sqrt(max(2 K_N, 6 K_T)/m): two equal discs, 3 K_T/m* being the tangential spring with the spins."""
        return math.sqrt(max(2.0 * self.kn, 6.0 * self.kt) / mass)

    def speed(self, mass: float) -> float:
        """max(sqrt(F0 D0/m), F0/sqrt(K_N m)): escape from the tail, swing about the equilibrium overlap."""
        return max(math.sqrt(self.f0 * self.d0 / mass), self.f0 / math.sqrt(self.kn * mass))

    def lever(self, distance: Floats, radsum: Floats) -> Floats:
        """The radii themselves."""
        return np.ones_like(distance)

    @cached_property
    def _stiffness(self) -> Floats:
        """K_T and K_r (2, 1), 0 for a spring whose limit is 0: it never stores anything."""
        return np.array([[k if limit > 0.0 else 0.0] for k, limit in ((self.kt, self.mu), (self.kr, self.mur))])

    @cached_property
    def _limited(self) -> NDArray[np.bool_]:
        return (self._stiffness > 0.0) & np.isfinite([[self.mu], [self.mur]])

    @cached_property
    def _slope(self) -> Floats:
        """Largest elastic displacement per overlap, mu K_N/K_T and mu_r K_N/K_r (2, 1); 0 where nothing slips."""
        pairs = zip(self._limited.flat, (self.mu, self.mur), self._stiffness.flat, strict=True)
        return np.array([[limit * self.kn / k if limited else 0.0] for limited, limit, k in pairs])

    def start(self, motion: Motion, memory: Floats) -> tuple[Floats, Ints]:
        """Zone from the gap; a spring at its limit that would be loaded further slips."""
        zone = np.where(motion.gap < 0.0, CONTACT, np.where(motion.gap < self.cutoff_gap, TAIL, APART))
        memory = np.where((zone == CONTACT) & (self._stiffness > 0.0), memory, 0.0)
        excess = self._limited & (np.abs(memory) > np.maximum(-self._slope * motion.gap, 0.0) * (1.0 + 1e-9))
        if np.any(excess):
            row, pair = np.argwhere(excess)[0]
            raise InputError(
                f"discs: '{('xi_t', 'xi_r')[row]}' of pair {pair} is {memory[row, pair]:g}; the law allows at "
                f"most {-self._slope[row, 0] * motion.gap[pair]:g} at its overlap; reduce it"
            )
        return memory, np.vstack((zone, np.where(zone == CONTACT, self._slip_sign(motion, memory), 0)))

    def _slip_sign(self, motion: Motion, memory: Floats) -> Ints:
        """+-1 where a spring at its limit is loaded faster than the limit -slope h grows, else 0; (2, P)."""
        sign = np.sign(np.where(memory == 0.0, motion.rate, memory))
        # the limit is met only up to rounding when a state is handed on from a run that was slipping
        full = np.abs(memory) >= -self._slope * motion.gap * (1.0 - 1e-12)
        loaded = sign * motion.rate + self._slope * motion.vn > 0.0
        return np.where(full & loaded & self._limited, sign, 0.0).astype(np.int64)

    def held(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """A slipping spring is at its limit: du = +-mu K_N (-h)/K_T."""
        slip = modes[1:]
        return np.where(slip != 0, -slip * self._slope * motion.gap, memory)

    def response(self, reduced: Floats, motion: Motion, memory: Floats, modes: Ints) -> Response:
        """See the class; a slipping spring loses (limit force) * (rate of the displacement it cannot follow)."""
        gap, vn, rate, _ = motion
        zone, slip = modes[0], modes[1:]
        in_contact = zone == CONTACT
        viscous = np.where(in_contact, self.zeta * np.sqrt(4.0 * self.kn * reduced) * vn, 0.0)
        normal = np.where(in_contact, -self.kn * gap, 0.0) - viscous + self._attraction(gap, zone)
        spring = -self._stiffness * memory
        memory_rate = np.where(in_contact & (slip == 0) & (self._stiffness > 0.0), rate, 0.0)
        lost = -spring * np.where(slip != 0, rate + slip * self._slope * vn, 0.0)
        dissipated_power = np.array([viscous @ vn, lost[0].sum(), lost[1].sum()])
        return Response(normal, spring[0], spring[1], memory_rate, dissipated_power)

    def _attraction(self, gap: Floats, zone: Ints) -> Floats:
        if self.cutoff_gap == 0.0:
            return np.where(zone == CONTACT, -self.f0, 0.0)
        return -self.f0 * np.where(zone == CONTACT, 1.0, np.where(zone == TAIL, 1.0 - gap / self.d0, 0.0))

    def triggers(self, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Floats]:
        """Rows: gap above the zone's lower end, gap below its upper end, tangential spring, rolling spring.

        Springs: distance to the limit while sticking, rate of the inelastic displacement while slipping.
        """
        gap, vn, rate, _ = motion
        zone, slip = modes[0], modes[1:]
        lower = np.array([-math.inf, 0.0, self.cutoff_gap])[zone]
        upper = np.array([0.0, self.cutoff_gap, math.inf])[zone]
        sign = np.where(slip != 0, slip, np.sign(memory))
        inelastic = sign * rate + self._slope * vn
        springs = np.where(slip != 0, inelastic, -self._slope * gap - np.abs(memory))
        springs = np.where(self._limited & (zone == CONTACT), springs, math.inf)
        values = np.vstack((gap - lower, upper - gap, springs))
        return values, np.vstack((vn, -vn, np.where(slip != 0, 0.0, -inelastic)))

    def switch(self, row: int, pair: int, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Ints, str]:
        """Kinds: enter, close, open, leave (gap); slip, stick (tangential); roll, lock (rolling)."""
        memory, modes = memory.copy(), modes.copy()
        if row < 2:
            return memory, modes, self._change_zone(row, pair, motion, memory, modes)
        spring = row - 2
        if modes[row - 1, pair] == 0:
            toward = memory[spring, pair] or motion.rate[spring, pair]
            modes[row - 1, pair] = 1 if toward >= 0.0 else -1
            return memory, modes, ("slip", "roll")[spring]
        modes[row - 1, pair] = 0
        return memory, modes, ("stick", "lock")[spring]

    def _change_zone(self, row: int, pair: int, motion: Motion, memory: Floats, modes: Ints) -> str:
        step = 1 if self.cutoff_gap > 0.0 else 2
        old = int(modes[0, pair])
        new = old - step if row == 0 else old + step
        memory[:, pair] = 0.0
        modes[:, pair] = (new, 0, 0)
        if new == CONTACT:
            modes[1:, pair] = self._slip_sign(motion._replace(gap=np.zeros_like(motion.gap)), memory)[:, pair]
        return {CONTACT: "close", APART: "leave" if old == TAIL else "open", TAIL: "enter" if row == 0 else "open"}[new]

    def energies(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """K_N h^2/2, K_T du^2/2, K_r dtheta^2/2 and the adhesive potential."""
        gap, zone = motion.gap, modes[0]
        normal = 0.5 * self.kn * np.sum(gap[zone == CONTACT] ** 2)
        springs = 0.5 * self._stiffness[:, 0] * np.sum(memory**2, axis=1)
        adhesive = np.sum(self.f0 * (gap[zone == CONTACT] - 0.5 * self.d0))
        if self.cutoff_gap > 0.0:
            adhesive -= self.f0 * np.sum((self.d0 - gap[zone == TAIL]) ** 2) / (2.0 * self.d0)
        return np.array([normal, *springs, adhesive])
