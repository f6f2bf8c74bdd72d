"""Reference integration of a few discs: smooth pieces by DOP853, cut where the mode of a pair changes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

from workflow.errors import InputError, WorkflowError
from workflow.reference.cohesive import PairLaw
from workflow.reference.discs import Cell, Discs, Energy, Event, Floats, Trajectory, check_times
from workflow.reference.events import Hit, Search, Solution
from workflow.reference.system import Piece, System, View

SIMULTANEOUS = 1e-12  # events closer than this, in units of the fastest contact's 1/omega, count as one instant
CHATTER = 100  # more events than that at one instant cannot be a sequence of mode changes of 15 pairs
MAX_EVENTS = 10_000
COLUMNS = ("position", "velocity", "omega", "branch", "gap", "xi_t", "xi_r", "normal", "tangential", "moment")


def integrate(
    law: PairLaw,
    discs: Discs,
    t_end: float,
    *,
    t_eval: ArrayLike | None = None,
    cell: Cell | None = None,
    gravity: tuple[float, float] = (0.0, 0.0),
    rtol: float = 1e-12,
) -> Trajectory:
    """Trajectory of ``discs`` under ``law`` from t = 0 to ``t_end``, in open space or in a periodic ``cell``.

    m dv/dt = sum of F, I dw/dt = sum of moments (G07 eqs. 1, 2), dx_a/dt = v_a + (dL_a/dt/L_a) x_a; relative velocities
    at contacts include the affine term (dL_a/dt/L_a) r_a (G07 eq. A2).  ``gravity``: acceleration of discs of finite mass.
    ``t_eval`` (K,) increasing: times of the
    record, default (0, t_end).  ``rtol``: relative tolerance of DOP853; the absolute one is rtol times natural scales.
    Raises InputError for unusable input, WorkflowError when the step size underflows or events pile up.
    """
    times = check_times(t_end, t_eval)
    if not 2.3e-14 <= rtol < 1.0:
        raise InputError(f"integrate: 'rtol' is {rtol!r}; it must be in [2.3e-14, 1); choose e.g. 1e-12")
    if cell is not None:
        cell.require(float(discs.diameter.max()) + law.cutoff_gap, t_end)
    return _Run(System(law, discs, cell, np.asarray(gravity, dtype=np.float64)), times, t_end, rtol).result()


class _Run:
    """What passes from piece to piece: the state, the record and the events so far."""

    def __init__(self, system: System, times: Floats, t_end: float, rtol: float) -> None:
        self.system, self.t_end, self.rtol = system, t_end, rtol
        self.record = Recorder(system, times)
        self.events: list[Event] = []
        self.opening = 0.0
        self.piece, self.y = system.initial()

    def result(self) -> Trajectory:
        while (hit := self._advance()) is not None:
            self._switch(hit)
            self._guard()
        return self.record.trajectory(self.events)

    def _advance(self) -> Hit | None:
        """Integrate the piece to its first event, None if it reaches the end."""
        self.scales = self.system.scales(self.piece.view(0.0, self.y))
        search = Search(self.piece, 1e-13 * self.scales.overlap, SIMULTANEOUS / self.scales.frequency)
        solver = self._solver()
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise WorkflowError(
                    f"reference: the step at t = {self.piece.start + solver.t:g} failed ({message}); loosen 'rtol'"
                )
            self.solution = solver.dense_output()
            hit = search.first(self.solution, solver.t_old, solver.t)
            tau = solver.t if hit is None else hit.tau
            last = hit is None and solver.status == "finished"
            self.record.take(self.piece, self.solution, self.t_end if last else self.piece.start + tau, self.opening)
            if hit is not None:
                return hit
        return None

    def _solver(self) -> DOP853:
        scales, system = self.scales, self.system
        near = self.piece.gap.min() < system.law.cutoff_gap
        # a step must neither jump over a disc nor hide several oscillations of a contact between two samples
        longest = min(0.25 * scales.diameter / scales.speed, 1.0 / scales.frequency if near else np.inf)
        atol = self.rtol * scales.vector(system.count, len(system.pairs))
        duration = max(self.t_end - self.piece.start, 0.0)
        return DOP853(self.piece.derivative, 0.0, self.y, duration, longest, self.rtol, atol)

    def _switch(self, hit: Hit) -> None:
        i, j = self.system.pairs[hit.pair]
        self.piece, self.y, kind, forgotten = self.piece.switched(hit.tau, self.solution(hit.tau), hit.row, hit.pair)
        self.opening += forgotten
        self.events.append(Event(self.piece.start, (int(i), int(j)), kind))

    def _guard(self) -> None:
        count, now = len(self.events), self.piece.start
        stuck = count > CHATTER and now - self.events[-CHATTER].time < SIMULTANEOUS / self.scales.frequency
        if stuck or count > MAX_EVENTS:
            i, j = self.events[-1].pair
            raise WorkflowError(
                f"reference: {count} events up to t = {now:g}, the last '{self.events[-1].kind}' of discs {i} and {j}; "
                f"at most {CHATTER} at one instant and {MAX_EVENTS} in all; change the initial state or shorten the run"
            )


class Recorder:
    """Collects the state at the times asked for."""

    def __init__(self, system: System, times: Floats) -> None:
        self.system, self.times = system, times
        self.rows: list[tuple[Floats, ...]] = []

    def take(self, piece: Piece, solution: Solution, until: float, opening: float) -> None:
        """Record every wanted time up to ``until``."""
        while len(self.rows) < len(self.times) and self.times[len(self.rows)] <= until:
            tau = max(self.times[len(self.rows)] - piece.start, 0.0)
            self.rows.append(self._row(piece, tau, solution(tau), opening))

    def _row(self, piece: Piece, tau: float, y: Floats, opening: float) -> tuple[Floats, ...]:
        system, seen = self.system, piece.view(tau, y)
        response = system.law.response(system.reduced, seen.motion, seen.memory, piece.modes)
        stored = system.law.energies(seen.motion, seen.memory, piece.modes)
        energy = np.array([_kinetic(system.discs, seen), *stored, *seen.accounts[:3], opening, seen.accounts[3],
                           _height(system, piece.positions(y))])  # fmt: skip
        forces = (response.normal, response.tangential, response.moment)
        discs = (piece.positions(y), seen.velocity, seen.omega)
        return (*discs, seen.branch, seen.motion.gap, *seen.memory, *forces, energy)

    def trajectory(self, events: list[Event]) -> Trajectory:
        """The record as arrays."""
        columns = [np.array(column) for column in zip(*self.rows, strict=True)]
        state: dict[str, Any] = dict(zip(COLUMNS, columns[:-1], strict=True))
        energy, system = Energy(*columns[-1].T), self.system
        return Trajectory(time=self.times, pairs=system.pairs, energy=energy, events=tuple(events), start=system.discs, **state)


def _height(system: System, position: Floats) -> float:
    """Energy in the field of gravity, -sum m g.x over the discs of finite mass."""
    free = system.discs.inverse_mass > 0.0
    return -float((system.discs.mass[free] * (position @ system.gravity)[free]).sum())


def _kinetic(discs: Discs, seen: View) -> float:
    """Sum of m v^2/2 + I w^2/2 over the discs of finite mass."""
    free = discs.inverse_mass > 0.0
    translation = ((seen.velocity**2).sum(axis=1)[free] / discs.inverse_mass[free]).sum()
    return float(0.5 * (translation + (seen.omega[free] ** 2 / discs.inverse_inertia[free]).sum()))
