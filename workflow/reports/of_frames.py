"""Figures of frames: from samples, (Frame, Settings) each, to the drawing functions.  Names and meanings: registry.py."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workflow.data.balance import solid_fraction
from workflow.data.frame import Frame
from workflow.errors import InputError, WorkflowError
from workflow.measures import density, elasticity, modes, packing
from workflow.measures import forces as measured
from workflow.measures import holes as measured_holes
from workflow.measures import registry as groups
from workflow.measures.clusters import pair_correlation
from workflow.measures.fractal import FractalFit, fit_fractal
from workflow.measures.registry import LOWEST, NEIGHBOURHOOD, Settings, fit_window, shells
from workflow.reports import charts, maps, triangles
from workflow.reports.figures import PathLike
from workflow.reports.network import BAND, force_network

Sample = tuple[Frame, Settings]
Paths = Sequence[PathLike]
MOST_DRAWN = 600  # floppy modes of which a dense basis is made


def _unit(law: Settings) -> str:
    return "F_0" if law.law.cohesive else "aP"


def _band(law: Settings) -> float:
    """Width of the line of F0 or a P: forces of a cohesive packing are a small part of F0, others a few a P."""
    return (0.3 if law.law.cohesive else BAND) * law.length


def forces(samples: Sequence[Sample], paths: Paths) -> None:
    """Force network."""
    frame, law = samples[0]
    force_network(frame, paths, force_unit=law.force_unit, symbol=_unit(law), tolerance=law.tolerance, band=_band(law))


def stressed(samples: Sequence[Sample], paths: Paths) -> None:
    """Force network with the unstressed parts apart."""
    frame, law = samples[0]
    force_network(frame, paths, force_unit=law.force_unit, symbol=_unit(law), threshold=law.stressed, band=_band(law))


def distribution(samples: Sequence[Sample], paths: Paths) -> None:
    """Distribution of N."""
    law = samples[0][1]
    found = [measured.normal_force_distribution(f, law.force_edges, unit=law.scale(f)) for f, _ in samples]
    charts.force_distribution(found, paths, unit="F_0" if law.law.cohesive else r"\langle N_e\rangle")


def cloud(samples: Sequence[Sample], paths: Paths) -> None:
    """N-T plane."""
    law = samples[0][1]
    if np.isnan(law.law.mu):
        raise InputError("cloud: the Coulomb cone needs the coefficient of friction; give --mu")
    normal = np.concatenate([f.interactions.normal_force for f, _ in samples]) / law.force_unit
    tangential = np.concatenate([f.interactions.tangential for f, _ in samples]) / law.force_unit
    reach = max(float(np.abs(normal).max(initial=0.0)), 1.0)
    edges = np.linspace(-reach, 1.2 * reach, 3)
    lines = measured.nt_scatter(
        samples[0][0], edges, edges, unit=law.force_unit, friction=min(law.law.mu, 1e6), cohesive=law.law.cohesive
    )
    charts.nt_scatter(normal, tangential, lines, paths, unit=_unit(law), cohesive=law.law.cohesive)


def angles(samples: Sequence[Sample], paths: Paths) -> None:
    """Angle of force and normal."""
    edges = np.linspace(0.0, 180.0, 61)
    charts.angles([measured.force_angles(f, edges, tolerance=c.tolerance * c.force_unit) for f, c in samples], paths)


def coordination(samples: Sequence[Sample], paths: Paths) -> None:
    """Shares of grains with k neighbours."""
    found = [packing.coordination(f, threshold=c.tolerance * c.force_unit) for f, c in samples]
    charts.coordination_shares([one.fractions for one in found], paths)


def scattering(samples: Sequence[Sample], paths: Paths) -> None:
    """I(k) with its fit."""
    largest = max((frame for frame, _ in samples), key=lambda frame: float(frame.cell.max()))
    found = [density.scattering(frame, shells(largest, law)) for frame, law in samples]
    charts.scattering_chart(found, _fit(samples, found), paths)


def _fit(samples: Sequence[Sample], found: Sequence) -> FractalFit | str:
    """The fit of eq. 28, or why there is none."""
    mean = density.average(found)
    try:
        return fit_fractal(mean, fit_window(mean, samples[0][1]))
    except WorkflowError as fault:
        return str(fault)


def correlation(samples: Sequence[Sample], paths: Paths) -> None:
    """C(r)."""
    largest = max((frame for frame, _ in samples), key=lambda frame: float(frame.cell.max()))
    fit = _fit(samples, [density.scattering(frame, shells(largest, law)) for frame, law in samples])
    found = [groups.correlation(frame, law) for frame, law in samples]
    shortest = min(len(c["r"]) for c in found)
    phi = float(np.mean([solid_fraction(frame) for frame, _ in samples]))
    charts.correlation_chart(found[0]["r"][:shortest], [c["c"][:shortest] for c in found], phi, fit, paths)


def holes(samples: Sequence[Sample], paths: Paths) -> None:
    """Map of the holes."""
    frame, law = samples[0]
    maps.hole_map(frame, paths, length=law.length)


def hole_sizes(samples: Sequence[Sample], paths: Paths) -> None:
    """Distribution of hole radii."""
    charts.hole_sizes([measured_holes.holes(frame) for frame, _ in samples], paths)


def triangle(samples: Sequence[Sample], paths: Paths) -> None:
    """A disc held by two touching discs."""
    frame, law = samples[0]
    triangles.triangle(frame, paths, tolerance=law.tolerance * law.force_unit)


def double_triangle(samples: Sequence[Sample], paths: Paths) -> None:
    """Two discs held by the same two."""
    frame, law = samples[0]
    triangles.double_triangle(frame, paths, tolerance=law.tolerance * law.force_unit)


def self_stress(samples: Sequence[Sample], paths: Paths) -> None:
    """Hyperstatic clusters."""
    frame, law = samples[0]
    maps.self_stress_map(frame, modes.self_stress(frame, **law.resists), paths)


def floppy(samples: Sequence[Sample], paths: Paths) -> None:
    """Floppy modes."""
    frame, law = samples[0]
    held = modes.without_loose(frame)
    if not held.grains:
        raise InputError("floppy: no grain touches another, every motion is free; choose another frame")
    moving = modes.mobility(held, **law.resists)
    if moving.mechanisms > MOST_DRAWN:
        raise InputError(f"floppy: {moving.mechanisms} mechanisms, at most {MOST_DRAWN} are drawn; take a smaller sample")
    maps.floppy_map(held, moving, modes.floppy_modes(held, **law.resists), frame.grains - held.grains, paths)


def vibrations(samples: Sequence[Sample], paths: Paths) -> None:
    """Vibration spectrum."""
    whole = all(frame.grains * (3 if law.resists["friction"] else 2) <= elasticity.DENSE for frame, law in samples)
    found = [elasticity.vibrations(f, law=c.law, count=None if whole else LOWEST, **c.resists) for f, c in samples]
    charts.vibration_chart(found, paths, whole=whole)


def pair(samples: Sequence[Sample], paths: Paths) -> None:
    """g(r)."""
    far = min(NEIGHBOURHOOD * samples[0][1].length, *(0.5 * float(f.cell.min()) for f, _ in samples))
    edges = np.linspace(0.0, far, 201)
    charts.pair_chart(edges, [pair_correlation(frame, edges).g for frame, _ in samples], paths)
