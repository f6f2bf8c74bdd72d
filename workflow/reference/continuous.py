"""The continuous law of B97 (Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997)) as a law for the reference integrator.

All pairs are handled at once; arrays have one column per pair (P,).  A pair interacts below r0; its tangential spring
sticks or is held at its largest displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workflow.errors import InputError
from workflow.reference.cohesive import APART, CONTACT, Floats, Ints, Motion, Response


@dataclass(frozen=True)
class ContinuousLaw:
    """B97 sec. II with n from i to j, force of i on j N n + T t, repulsion positive, s = sigma_ij, r0 = cutoff s.

    * N_e = force (s/r)^(index + 1) for r < r0, or with ``stiffness`` k > 0 (Hooke's law) N_e = k (s - r) for r < s
    * N = N_e - C_N v_n, C_N = sqrt(m k(r)), k(r) = -dN_e/dr (eq. 3)
    * T = -sign(d) mu N_e [1 - (1 - |d|/dmax)^(3/2)] - C_T v_t, dmax = alpha mu (r0 - r) (eqs. 4, 5); d d/dt = v_t from
      r = r0 on (eq. 6), |d| held at dmax where it would exceed it; C_T = sqrt(m k_T), k_T of eq. 7 (eq. 8)
    * v_t = t.(v_j - v_i) - (R_i w_i + R_j w_j) r/s, and T acts with the arms R r/s.  ``printed_rotation``: twice these
      arms, which are those of eqs. 6 and 13 as printed; ``printed_damping``: C_T acts on t.(v_j - v_i) alone (eq. 4)

    ``sigma``, ``mass``: s and m of every pair, a number or (P,).  Raises InputError for values out of range.
    """

    index: int = 36
    cutoff: float = 1.2
    mu: float = 0.5
    alpha: float = 1.214
    force: float = 1.0
    stiffness: float = 0.0
    sigma: ArrayLike = 1.0
    mass: ArrayLike = 1.0
    printed_rotation: bool = False
    printed_damping: bool = False

    def __post_init__(self) -> None:
        for name, low in (("index", 1), ("cutoff", 1.0), ("mu", 0.0), ("alpha", 0.0), ("force", 0.0), ("stiffness", 0.0)):
            value = getattr(self, name)
            if not low <= value < math.inf:
                raise InputError(f"law: '{name}' is {value}; it must be finite and at least {low}; correct this value")
        if self.mu > 0.0 and self.alpha == 0.0:
            raise InputError("law: 'alpha' is 0; friction (mu > 0) needs a finite displacement; give 1.214 as in B97")

    @property
    def _range(self) -> Floats:
        """r0 - s, (P,) or a number."""
        return ((1.0 if self.stiffness else self.cutoff) - 1.0) * np.asarray(self.sigma)

    @property
    def cutoff_gap(self) -> float:
        """Largest r0 - s of a pair."""
        return float(np.max(self._range))

    def frequency(self, mass: float) -> float:
        """Of a grain of this mass between springs of the stiffness at r = s."""
        return math.sqrt(6.0 * (self.stiffness or (self.index + 1.0) * self.force / float(np.min(self.sigma))) / mass)

    def speed(self, mass: float) -> float:
        """sqrt(force s/m): a fall through a diameter under the force at r = s."""
        return math.sqrt(self.force * float(np.max(self.sigma)) / mass)

    def lever(self, distance: Floats, radsum: Floats) -> Floats:
        """r/s, or twice that."""
        return (2.0 if self.printed_rotation else 1.0) * distance / radsum

    def _elastic(self, gap: Floats) -> tuple[Floats, Floats]:
        """N_e and k = -dN_e/dr, (P,)."""
        sigma = np.asarray(self.sigma)
        if self.stiffness:
            return self.stiffness * np.maximum(-gap, 0.0), np.full_like(gap, self.stiffness)
        force = self.force * (sigma / (sigma + gap)) ** (self.index + 1)
        return force, (self.index + 1) * force / (sigma + gap)

    @property
    def _slope(self) -> float:
        """Largest displacement per depth r0 - r."""
        return self.alpha * self.mu

    def _depth(self, gap: Floats) -> Floats:
        return self._range - gap

    def start(self, motion: Motion, memory: Floats) -> tuple[Floats, Ints]:
        """Zone from the gap; a spring at its limit that would be loaded further slips."""
        zone = np.where(motion.gap < self._range, CONTACT, APART)
        memory = np.where((zone == CONTACT) & (self.mu > 0.0), memory * [[1.0], [0.0]], 0.0)
        excess = np.abs(memory[0]) > np.maximum(self._slope * self._depth(motion.gap), 0.0) * (1.0 + 1e-9)
        if np.any(excess):
            raise InputError(f"discs: 'xi_t' of pair {int(np.argmax(excess))} is above alpha mu (r0 - r); reduce it")
        return memory, np.stack((zone, np.where(zone == CONTACT, self._slip_sign(motion, memory), 0), np.zeros_like(zone)))

    def _slip_sign(self, motion: Motion, memory: Floats) -> Ints:
        if not self.mu:
            return np.zeros(len(motion.gap), dtype=np.int64)
        xi_t, rate = memory[0], motion.rate[0]
        sign = np.sign(np.where(xi_t == 0.0, rate, xi_t))
        full = np.abs(xi_t) >= self._slope * self._depth(motion.gap) * (1.0 - 1e-12)
        loaded = sign * rate + self._slope * motion.vn > 0.0
        return np.where(full & loaded, sign, 0.0).astype(np.int64)

    def held(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """A slipping spring is at +-alpha mu (r0 - r)."""
        limit = self._slope * self._depth(motion.gap)
        return np.where(modes[1] != 0, np.stack((modes[1] * limit, memory[1])), memory)

    def response(self, reduced: Floats, motion: Motion, memory: Floats, modes: Ints) -> Response:
        """See the class.  The heat of the spring is the work it takes beyond what it stores (`energies`): it may be
        negative while the normal force changes, because T depends on r without a potential of its own."""
        gap, vn, rate, vt = motion
        on, zero = modes[0] == CONTACT, np.zeros_like(gap)
        gap = np.where(on, gap, 0.5 * self._range if not self.stiffness else -1e-3)  # any point where the formulas are finite
        elastic, stiffness = self._elastic(gap)
        viscous = np.sqrt(np.asarray(self.mass) * stiffness) * vn
        spring, damping, stretch_rate, slid = zero, zero, zero, zero
        if self.mu:
            moving = vt if self.printed_damping else rate[0]
            spring, tangential_stiffness = self._spring(gap, memory[0], elastic, modes[1])
            damping = np.sqrt(np.asarray(self.mass) * tangential_stiffness) * moving
            stretch_rate = np.where(modes[1] == 0, rate[0], 0.0)
            slid = -spring * rate[0] - self._stored_rate(gap, memory[0], elastic, stiffness, vn, rate[0], modes[1])
        dissipated_power = [np.where(on, viscous * vn + damping * rate[0], 0.0).sum(), np.where(on, slid, 0.0).sum(), 0.0]
        normal, tangential = np.where(on, elastic - viscous, 0.0), np.where(on, spring - damping, 0.0)
        return Response(normal, tangential, zero, np.stack((np.where(on, stretch_rate, 0.0), zero)), np.array(dissipated_power))

    def _load(self, gap: Floats, xi_t: Floats, slip: Ints | int = 0) -> tuple[Floats, Floats]:
        """dmax and 1 - |d|/dmax, which is 0 while slipping; finite also where a trial step went beyond r0."""
        largest = self._slope * np.abs(self._depth(gap)) + 1e-300
        return largest, np.where(slip != 0, 0.0, np.clip(1.0 - np.abs(xi_t) / largest, 0.0, 1.0))

    def _spring(self, gap: Floats, xi_t: Floats, elastic: Floats, slip: Ints) -> tuple[Floats, Floats]:
        """Elastic part of T (eq. 5) and k_T (eq. 7)."""
        largest, rest = self._load(gap, xi_t, slip)
        return -np.sign(xi_t) * self.mu * elastic * (1.0 - rest**1.5), 1.5 * self.mu * elastic / largest * np.sqrt(rest)

    def _stored(self, gap: Floats, xi_t: Floats, elastic: Floats) -> Floats:
        """Integral of eq. 5 over d at fixed r: mu N_e dmax [x - 2/5 (1 - (1 - x)^(5/2))], x = |d|/dmax."""
        largest, rest = self._load(gap, xi_t)
        return self.mu * elastic * largest * (1.0 - rest - 0.4 * (1.0 - rest**2.5))

    def _stored_rate(
        self, gap: Floats, xi_t: Floats, elastic: Floats, stiffness: Floats, vn: Floats, rate: Floats, slip: Ints
    ) -> Floats:
        """Time derivative of `_stored`."""
        largest, rest = self._load(gap, xi_t, slip)
        part = 1.0 - rest - 0.4 * (1.0 - rest**2.5)
        along_r = -self.mu * (stiffness * largest + elastic * self._slope) * part
        along_r += self.mu * elastic * (1.0 - rest**1.5) * (1.0 - rest) * self._slope
        moved = np.where(slip == 0, rate, -slip * self._slope * vn)
        return along_r * vn + np.sign(xi_t) * self.mu * elastic * (1.0 - rest**1.5) * moved

    def triggers(self, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Floats]:
        """Rows: beyond r0 (apart), within r0 (contact), tangential spring (distance to its limit, or inelastic rate)."""
        gap, vn, rate, _ = motion
        zone, slip = modes[0], modes[1]
        depth = self._depth(gap)
        apart, contact = np.where(zone == APART, -depth, np.inf), np.where(zone == CONTACT, depth, np.inf)
        sign = np.where(slip != 0, slip, np.sign(memory[0]))
        inelastic = sign * rate[0] + self._slope * vn
        spring = np.where(slip != 0, inelastic, self._slope * depth - np.abs(memory[0]))
        spring = np.where((zone == CONTACT) & (self.mu > 0.0), spring, np.inf)
        return np.stack((apart, contact, spring)), np.stack((vn, -vn, np.where(slip != 0, 0.0, -inelastic)))

    def switch(self, row: int, pair: int, motion: Motion, memory: Floats, modes: Ints) -> tuple[Floats, Ints, str]:
        """Kinds: close, open; slip, stick."""
        memory, modes = memory.copy(), modes.copy()
        if row < 2:
            memory[:, pair] = 0.0
            modes[:, pair] = (CONTACT if row == 0 else APART, 0, 0)
            if row == 0:
                at_edge = motion._replace(gap=np.zeros_like(motion.gap) + self._range)
                modes[1, pair] = self._slip_sign(at_edge, memory)[pair]
            return memory, modes, "close" if row == 0 else "open"
        if modes[1, pair] == 0:
            modes[1, pair] = 1 if (memory[0, pair] or motion.rate[0, pair]) >= 0.0 else -1
            return memory, modes, "slip"
        modes[1, pair] = 0
        return memory, modes, "stick"

    def energies(self, motion: Motion, memory: Floats, modes: Ints) -> Floats:
        """Potential of N_e, zero at r0; energy of the tangential springs (`_stored`)."""
        on, sigma = modes[0] == CONTACT, np.broadcast_to(np.asarray(self.sigma, dtype=np.float64), motion.gap.shape)
        gap = motion.gap[on]
        part = ContinuousLaw(**{**self.__dict__, "sigma": sigma[on]})
        if self.stiffness:
            normal = 0.5 * self.stiffness * gap**2
        else:
            scale, power = self.force * sigma[on] / self.index, self.index
            normal = scale * ((sigma[on] / (sigma[on] + gap)) ** power - self.cutoff**-power)
        stored = part._stored(gap, memory[0][on], part._elastic(gap)[0]) if self.mu else np.zeros(1)
        return np.array([normal.sum(), stored.sum(), 0.0, 0.0])
