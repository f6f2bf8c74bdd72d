"""Equations of motion of a few discs on one smooth piece of their trajectory.

The gap is advanced as h(0) + (2 r(0) + delta).delta/(|r| + |r(0)|), delta = r - r(0): subtracting radii from distances
at every step would leave rounding errors of 1e-16 a in overlaps that may be 1e-8 a.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workflow.reference.cohesive import Motion, PairLaw, Response
from workflow.reference.discs import Cell, Discs, Floats, Ints, pair_list


class View(NamedTuple):
    """A state vector seen from the pairs and the discs."""

    branch: Floats
    normal: Floats
    motion: Motion
    memory: Floats
    lever: Floats
    gradient: Floats
    velocity: Floats
    omega: Floats
    accounts: Floats


class Scales(NamedTuple):
    """Natural scales of the motion: they set tolerances and the longest step."""

    speed: float
    frequency: float
    mass: float
    diameter: float

    @property
    def overlap(self) -> float:
        """speed/frequency."""
        return self.speed / self.frequency

    def vector(self, discs: int, pairs: int) -> Floats:
        """One scale per entry of the state: displacement, velocity, spin, du, dtheta, three heats and a work."""
        sizes = (2 * discs, 2 * discs, discs, pairs, pairs, 4)
        turn, omega, energy = self.overlap / self.diameter, self.speed / self.diameter, self.mass * self.speed**2
        return np.repeat((self.overlap, self.speed, omega, self.overlap, turn, energy), sizes)


class System:
    """Constants of a run: masses, pairs, incidence matrices and the natural scales."""

    def __init__(self, law: PairLaw, discs: Discs, cell: Cell | None, gravity: Floats) -> None:
        self.law, self.discs, self.cell, self.gravity = law, discs, cell, gravity
        self.count = len(discs.diameter)
        self.pairs = pair_list(self.count)
        i, j = self.pairs.T
        rows = np.arange(len(self.pairs))
        self.difference = np.zeros((len(rows), self.count))
        self.difference[rows, i], self.difference[rows, j] = -1.0, 1.0
        self.arms = np.abs(self.difference) * discs.diameter / 2.0
        self.radsum = self.arms.sum(axis=1)
        free = discs.inverse_mass > 0.0
        self.weight = np.where(free, 1.0, 0.0)[:, None] * gravity
        inverse = discs.inverse_mass[i] + discs.inverse_mass[j]
        # two fixed discs: any reduced mass does, 0 keeps their (irrelevant) damping finite
        self.reduced = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0.0)

    def initial(self) -> tuple[Piece, Floats]:
        """The first piece and its state vector."""
        discs = self.discs
        piece = Piece(self, 0.0, discs.position, None, np.zeros((3, len(self.pairs)), dtype=np.int64))
        given = np.stack((discs.xi_t, discs.xi_r))
        moving = np.concatenate((np.zeros(2 * self.count), discs.velocity.ravel(), discs.omega))
        seen = piece.view(0.0, np.concatenate((moving, given.ravel(), np.zeros(4))))
        memory, piece.modes = self.law.start(seen.motion, given)
        return piece, np.concatenate((moving, memory.ravel(), np.zeros(4)))

    def acceleration(self, response: Response, normal: Floats, lever: Floats) -> tuple[Floats, Floats, Floats]:
        """dv/dt (N, 2), dw/dt (N,) and the pair forces F of i on j (P, 2)."""
        tangent = np.column_stack((-normal[:, 1], normal[:, 0]))
        force = response.normal[:, None] * normal + response.tangential[:, None] * tangent
        torque = -self.arms.T @ (lever * response.tangential) + self.difference.T @ response.moment
        pushed = self.difference.T @ force
        return pushed * self.discs.inverse_mass[:, None] + self.weight, torque * self.discs.inverse_inertia, force

    def scales(self, seen: View) -> Scales:
        """Natural scales at an instant."""
        lightest = 1.0 / self.discs.inverse_mass.max() if self.discs.inverse_mass.any() else 1.0
        frequency = self.law.frequency(lightest)
        speeds = (
            np.abs(self.difference @ seen.velocity).max(),
            np.abs(seen.omega * self.discs.diameter).max(),
            np.abs(seen.gradient).max() * np.abs(seen.branch).max(),
            max(-seen.motion.gap.min(), 0.0) * frequency,
            self.law.speed(lightest),
        )
        return Scales(float(max(speeds)) or 1.0, frequency, lightest, float(self.discs.diameter.min()))


class Piece:
    """One smooth piece: displacements, memory and accounts since its start at ``start`` (local time 0)."""

    def __init__(self, system: System, start: float, position: Floats, gap: Floats | None, modes: Ints) -> None:
        self.system, self.start, self.position, self.modes = system, start, position, modes
        branch = system.difference @ position
        self.images = np.zeros_like(branch)
        self.lengths = np.zeros(2)
        if system.cell is not None:
            self.lengths, _ = system.cell.at(start)
            self.images = np.round(branch / self.lengths)
            branch = branch - self.images * self.lengths
        self.branch, self.distance = branch, np.hypot(*branch.T)
        self.gap = self.distance - system.radsum if gap is None else gap

    def view(self, tau: float, y: Floats) -> View:
        """Everything the law needs to know at local time ``tau``."""
        system, n = self.system, self.system.count
        moved, velocity = y[: 2 * n].reshape(n, 2), y[2 * n : 4 * n].reshape(n, 2)
        omega, memory = y[4 * n : 5 * n], y[5 * n : -4].reshape(2, -1)
        delta, gradient = system.difference @ moved, np.zeros(2)
        if system.cell is not None:
            lengths, gradient = system.cell.at(self.start + tau)
            delta = delta - self.images * (lengths - self.lengths)
            delta = delta - lengths * np.round((self.branch + delta) / lengths)
        branch = self.branch + delta
        distance = np.hypot(branch[:, 0], branch[:, 1])
        gap = self.gap + ((2.0 * self.branch + delta) * delta).sum(axis=1) / (distance + self.distance)
        normal = branch / distance[:, None]
        relative = system.difference @ velocity + gradient * branch
        vn = (normal * relative).sum(axis=1)
        vt = normal[:, 0] * relative[:, 1] - normal[:, 1] * relative[:, 0]
        lever = system.law.lever(distance, system.radsum)
        surface = vt - lever * (system.arms @ omega)
        motion = Motion(gap, vn, np.stack((surface, system.difference @ omega)), vt)
        held = system.law.held(motion, memory, self.modes)
        return View(branch, normal, motion, held, lever, gradient, velocity, omega, y[-4:])

    def positions(self, y: Floats) -> Floats:
        """Centres (N, 2), not wrapped."""
        return self.position + y[: 2 * self.system.count].reshape(-1, 2)

    def derivative(self, tau: float, y: Floats) -> Floats:
        """dy/dt; y = displacements, velocities, spins, memory, heat (3), work of the cell (1)."""
        seen = self.view(tau, y)
        response = self.system.law.response(self.system.reduced, seen.motion, seen.memory, self.modes)
        push, turn, force = self.system.acceleration(response, seen.normal, seen.lever)
        affine = seen.gradient * self.positions(y)
        work = -float((force * seen.branch * seen.gradient).sum())
        drift = (seen.velocity + affine).ravel()
        return np.concatenate((drift, push.ravel(), turn, response.memory_rate.ravel(), response.dissipated_power, [work]))

    def switched(self, tau: float, y: Floats, row: int, pair: int) -> tuple[Piece, Floats, str, float]:
        """Next piece after a trigger fired, its state vector, the kind of event and the spring energy forgotten."""
        system, seen = self.system, self.view(tau, y)
        memory, modes, kind = system.law.switch(row, pair, seen.motion, seen.memory, self.modes)
        piece = Piece(system, self.start + tau, self.positions(y), seen.motion.gap, modes)
        moving = y[2 * system.count : 5 * system.count]
        y = np.concatenate((np.zeros(2 * system.count), moving, memory.ravel(), seen.accounts))
        before = system.law.energies(seen.motion, seen.memory, self.modes)[1:3].sum()
        after = system.law.energies(seen.motion, memory, modes)[1:3].sum()
        return piece, y, kind, float(before - after)

    def triggers(self, tau: float, y: Floats) -> tuple[Floats, Floats]:
        """The law's triggers and their slopes."""
        seen = self.view(tau, y)
        return self.system.law.triggers(seen.motion, seen.memory, self.modes)
