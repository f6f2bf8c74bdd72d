"""First measures of a frame: density, coordination, rattlers, stress, Rumpf relation, balance (G07 sec. III)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workflow.data.balance import balance, solid_fraction
from workflow.data.frame import Bools, Floats, Frame, Interactions, Ints
from workflow.errors import InputError

LARGEST_SHARE = 6  # x_0 ... x_6; the last one counts six neighbours and more


@dataclass(frozen=True)
class Coordination:
    """Who interacts with whom.

    ``z`` = 2 M/N over all M interactions, contacts and distant pairs.  ``rattlers`` (N,) and ``backbone`` (M,), bool:
    see `coordination`.  ``z_backbone`` = z* = z_b/(1 - x_0) with z_b = 2 M_b/N (G07 eq. 13).  ``fractions`` (7,): x_k,
    share of the grains with k backbone interactions, the last one with six or more; x_0 = share of rattlers.
    ``distant_share``: distant pairs over interactions.
    """

    z: float
    z_backbone: float
    rattlers: Bools
    backbone: Bools
    fractions: Floats
    distant_share: float

    @property
    def rattler_fraction(self) -> float:
        """x_0, rattlers over all grains."""
        return float(self.rattlers.mean()) if len(self.rattlers) else 0.0


@dataclass(frozen=True)
class KineticEnergy:
    """Translation and rotation, per grain: ``raw``, and ``relative``: without mean drift and, without cohesion, rattlers."""

    raw: float
    relative: float


def neighbours(i: Ints, j: Ints, grains: int) -> Ints:
    """Number of interactions (i, j) of each grain, (N,) int64."""
    return np.bincount(np.concatenate((i, j)), minlength=grains)


def coordination(frame: Frame, *, threshold: float) -> Coordination:
    """Coordination of the network with and without rattlers (G07 sec. III B, eq. 13).

    Cohesive (any attraction in the frame): every interaction is of the backbone, rattlers are the grains with none.
    Cohesionless: the backbone is what remains of the contacts with |F| > ``threshold`` (a force) when grains with fewer
    than two of them are removed again and again; rattlers are the grains outside.  z_b of eq. 13 counts backbone
    interactions only, so that z* is the mean number of force-carrying contacts of a backbone grain.

    The engine counts something else while it runs: unsupported grains, those with fewer than two contacts whose elastic
    force exceeds the threshold, once and not again and again (column ``rattlers`` of the time series; docs/model.md).
    """
    table, n = frame.interactions, frame.grains
    backbone = np.ones(len(table), dtype=bool)
    if not (table.attraction < 0).any():
        backbone = _peel(table, np.hypot(*table.force.T) > threshold, n)
    degree = neighbours(table.i[backbone], table.j[backbone], n)
    return Coordination(
        z=2 * len(table) / n,
        z_backbone=2 * float(backbone.sum()) / max(int((degree > 0).sum()), 1),
        rattlers=degree == 0,
        backbone=backbone,
        fractions=np.bincount(np.minimum(degree, LARGEST_SHARE), minlength=LARGEST_SHARE + 1) / n,
        distant_share=float((~table.in_contact).mean()) if len(table) else 0.0,
    )


def _peel(table: Interactions, carrying: Bools, grains: int) -> Bools:
    """Interactions left when those of grains with fewer than two are removed until nothing changes."""
    rows = np.flatnonzero(carrying)
    while True:
        i, j = table.i[rows], table.j[rows]
        degree = neighbours(i, j, grains)
        keep = (degree[i] > 1) & (degree[j] > 1)
        if keep.all():
            break
        rows = rows[keep]
    result = np.zeros(len(table), dtype=bool)
    result[rows] = True
    return result


def stress(frame: Frame) -> tuple[Floats, Floats]:
    """Stress tensor, compression positive, as (kinetic part, pair part), (2, 2) each (G07 eq. 3).

    sigma_ab = (1/A) [sum_i m_i v_ia v_ib + sum_pairs F_a r_b], F the force of i on j, r the branch from i to j; v is
    the velocity relative to the affine motion of the cell.
    """
    kinetic = (frame.mass[:, None] * frame.velocity).T @ frame.velocity / frame.area
    return kinetic, frame.interactions.force.T @ frame.interactions.branch / frame.area


def rumpf_ratio(frame: Frame, *, threshold: float) -> float | None:
    """P / [(<d>/<d^2>) z Phi F_N/pi], 1 where force and size are uncorrelated (G07 eqs. 15-18, D = 2).

    P = tr(pair stress)/2, F_N = <N> the mean over all interactions (viscous and attractive parts included), <d>, <d^2>
    over all grains.  T does no work on the branch, so P = z Phi <N r>/(pi <d^2>) holds exactly for any sizes; the
    ratio is thus <N r>/(<N><d>), and eq. 16 sets it to 1.  None if |F_N| <= ``threshold``: P vanishes too (P* = 0).
    """
    table = frame.interactions
    mean_force = float(table.normal_force.mean()) if len(table) else 0.0
    if abs(mean_force) <= threshold:
        return None
    z = 2 * len(table) / frame.grains
    sizes = frame.diameter.mean() / (frame.diameter**2).mean()
    return float(np.trace(stress(frame)[1]) / 2 / (sizes * z * solid_fraction(frame) * mean_force / np.pi))


def weighted_rumpf_ratio(frame: Frame, targets: Sequence[float | None], *, threshold: float) -> float | None:
    """P_imposed / [z Phi <N (R_i + R_j)>/(pi <d^2>)]: G07 eq. 17 without the approximation of eq. 16.

    Contacts sit preferentially on large grains (z_i grows with d_i), so that <N (R_i + R_j)> exceeds F_N <d> by some
    percent and `rumpf_ratio` differs from 1 although the forces balance the imposed pressure.  This ratio leaves the force
    per contact weighted with its branch and compares it with the pressure *imposed*: 1 to the equilibrium criterion.
    None if no stress is imposed on both axes, or if the mean force is within ``threshold``.
    """
    table = frame.interactions
    if any(target is None for target in targets) or not len(table):
        return None
    radius = frame.diameter / 2
    moment = float((table.normal_force * (radius[table.i] + radius[table.j])).mean())
    if abs(moment) <= threshold:
        return None
    imposed = sum(target for target in targets if target is not None) / 2
    z = 2 * len(table) / frame.grains
    return float(imposed * np.pi * (frame.diameter**2).mean() / (z * solid_fraction(frame) * moment))


def kinetic_energy(frame: Frame, rattlers: Bools) -> KineticEnergy:
    """sum(m v^2/2 + I w^2/2)/N with I = m d^2/8; ``relative``: of the grains outside ``rattlers`` (N,) bool only, less
    their centre-of-mass velocity, divided by their number.
    """

    def mean(rows: Bools, drift: Floats) -> float:
        m, v = frame.mass[rows], frame.velocity[rows] - drift
        energy = m * (v**2).sum(axis=1) / 2 + m * (frame.diameter[rows] * frame.omega[rows]) ** 2 / 16
        return float(energy.mean()) if len(energy) else 0.0

    kept = ~rattlers
    drift = np.average(frame.velocity[kept], axis=0, weights=frame.mass[kept]) if kept.any() else np.zeros(2)
    return KineticEnergy(raw=mean(np.ones(frame.grains, dtype=bool), np.zeros(2)), relative=mean(kept, drift))


def measure(
    frame: Frame,
    *,
    force_unit: float,
    tolerance: float = 1e-4,
    targets: Sequence[float | None] = (None, None),
    energy_residual: float | None = None,
    equilibrated: bool | None = None,
) -> dict[str, Any]:
    """The standard numbers of one frame, ready for JSON, in scene units unless said otherwise.

    ``force_unit``: F1 = max(F0, P a).  ``tolerance``: forces below tolerance F1 count as none.  ``targets``: imposed
    stress per axis, None where the length is fixed.  ``energy_residual`` and ``equilibrated`` are the run's, passed
    through.  What needs a quantity that the frame lacks is None.  ``stress``: xx, yy, xy, yx, pressure, targets and
    ``deviation``, the largest |sigma - target| (None
    without target).  ``unbalanced_force``: largest net ``force``/F1 and ``moment``/(F1 a) from the contact table, and
    the largest differences to the engine's sums in the same units.  ``kinetic_energy``: ``per_grain`` without mean
    drift and, without cohesion, rattlers, ``raw`` with both.
    ``rumpf_ratio``: None if the mean force is below tolerance.  Raises InputError.
    """
    if not force_unit > 0:
        raise InputError(f"force_unit is {force_unit}; it must be positive: give max(F0, P a)")
    if not frame.grains:
        raise InputError(f"step {frame.step}: the frame has no grains; choose a frame with at least one")
    threshold = tolerance * force_unit
    carried = not {"normal", "tangential"} & frame.lacks
    network = coordination(frame, threshold=threshold)
    cohesive = bool((frame.interactions.attraction < 0).any())
    energy = kinetic_energy(frame, network.rattlers & (not cohesive))
    in_contact = int(frame.interactions.in_contact.sum()) if "gap" not in frame.lacks else None
    return {
        "grains": frame.grains,
        "interactions": {
            "contacts": in_contact,
            "distant": None if in_contact is None else len(frame.interactions) - in_contact,
        },
        "solid_fraction": _known(solid_fraction(frame)),
        "coordination": network.z,
        "coordination_backbone": network.z_backbone if carried else None,
        "rattler_fraction": network.rattler_fraction if carried else None,
        "neighbour_shares": network.fractions.tolist() if carried else None,
        "distant_share": network.distant_share if in_contact is not None else None,
        "stress": _stress_entry(frame, targets),
        "rumpf_ratio": _known(rumpf_ratio(frame, threshold=threshold)),
        "rumpf_ratio_weighted": _known(weighted_rumpf_ratio(frame, targets, threshold=threshold)),
        "unbalanced_force": {name: _known(value) for name, value in _balance_entry(frame, force_unit).items()},
        "kinetic_energy": {"per_grain": _known(energy.relative) if carried else None, "raw": _known(energy.raw)},
        "energy_residual": energy_residual,
        "equilibrated": equilibrated,
    }


def _known(value: float | None) -> float | None:
    """``value``, None for the NaN that comes of what the source lacks."""
    return None if value is None or np.isnan(value) else value


def _stress_entry(frame: Frame, targets: Sequence[float | None]) -> dict[str, Any]:
    kinetic, pairs = stress(frame)
    sigma = kinetic + pairs
    deviations = [abs(float(sigma[a, a]) - target) for a, target in enumerate(targets) if target is not None]
    (xx, xy), (yx, yy) = sigma.tolist()
    return {
        "xx": _known(xx), "yy": _known(yy), "xy": _known(xy), "yx": _known(yx), "pressure": _known((xx + yy) / 2),
        "targets": list(targets), "deviation": max(deviations, default=None),
    }  # fmt: skip


def stress_parts(frame: Frame) -> dict[str, dict[str, float | None]]:
    """Kinetic and contact part of the stress, each xx, yy, xy, yx, pressure; None where the frame lacks what it takes.

    The contact part of the pressure, sum(N r)/(2 A), needs no tangential forces: these do no work on the branch.
    """
    parts = {}
    for name, ((xx, xy), (yx, yy)) in zip(("kinetic", "contacts"), stress(frame), strict=True):
        parts[name] = {"xx": xx, "yy": yy, "xy": xy, "yx": yx, "pressure": (xx + yy) / 2}
    table = frame.interactions
    parts["contacts"]["pressure"] = float((table.normal_force * table.distance).sum()) / (2 * frame.area)
    return {part: {name: _known(float(value)) for name, value in values.items()} for part, values in parts.items()}


def _balance_entry(frame: Frame, force_unit: float) -> dict[str, float]:
    sums = balance(frame)
    return {
        "force": sums.largest_force / force_unit,
        "moment": sums.largest_moment / force_unit,
        "engine_force_difference": sums.force_difference / force_unit,
        "engine_moment_difference": sums.moment_difference / force_unit,
    }
