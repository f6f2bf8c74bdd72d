"""The figures by name: what each shows in G07, and how it is drawn from frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from workflow.data.balance import solid_fraction
from workflow.data.frame import Frame
from workflow.errors import InputError, WorkflowError
from workflow.measures import forces
from workflow.measures.clusters import pair_correlation
from workflow.measures.contacts import coordination
from workflow.measures.density import average, scattering
from workflow.measures.elasticity import DENSE, vibrations
from workflow.measures.fractal import FEW, FractalFit, fit_fractal
from workflow.measures.holes import holes
from workflow.measures.modes import floppy_modes, mobility, self_stress, without_loose
from workflow.measures.registry import LOWEST, NEIGHBOURHOOD, Settings, correlation, fit_window, shells
from workflow.reports import charts, maps, triangles
from workflow.reports.figures import BAND, PathLike, force_network

Sample = tuple[Frame, Settings]
Paths = Sequence[PathLike]
MOST_DRAWN = 600  # floppy modes of which a dense basis is made


@dataclass(frozen=True)
class Plot:
    """``draw`` takes samples and the paths to write; ``several``: it can show the mean of more than one sample; ``needs``:
    quantities without which there is nothing to draw; ``periodic``: it needs a cell without walls."""

    meaning: str
    several: bool
    draw: Callable[[Sequence[Sample], Paths], None]
    needs: tuple[str, ...] = ()
    periodic: bool = False

    def check(self, frame: Frame, law: Settings) -> None:
        """Raises InputError if ``frame`` cannot be drawn."""
        frame.need(self.meaning.split(" (")[0], *self.needs)
        if self.periodic and not all(frame.periodic):
            raise InputError(f"{self.meaning}: undefined, it needs a cell that is periodic in x and y; this box has walls")


def _unit(law: Settings) -> str:
    return "F_0" if law.law.cohesive else "aP"


def _band(law: Settings) -> float:
    """Width of the line of F0 or a P: forces of a cohesive packing are a small part of F0, others a few a P."""
    return (0.3 if law.law.cohesive else BAND) * law.length


def _forces(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    force_network(frame, paths, force_unit=law.force_unit, symbol=_unit(law), tolerance=law.tolerance, band=_band(law))


def _stressed(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    force_network(frame, paths, force_unit=law.force_unit, symbol=_unit(law), threshold=law.stressed, band=_band(law))


def _distribution(samples: Sequence[Sample], paths: Paths) -> None:
    law = samples[0][1]
    found = [forces.normal_force_distribution(f, law.force_edges, unit=law.scale(f)) for f, _ in samples]
    charts.force_distribution(found, paths, unit="F_0" if law.law.cohesive else r"\langle N_e\rangle")


def _cloud(samples: Sequence[Sample], paths: Paths) -> None:
    law = samples[0][1]
    if np.isnan(law.law.mu):
        raise InputError("cloud: the Coulomb cone needs the coefficient of friction; give --mu")
    normal = np.concatenate([f.contacts.normal_force for f, _ in samples]) / law.force_unit
    tangential = np.concatenate([f.contacts.tangential for f, _ in samples]) / law.force_unit
    reach = max(float(np.abs(normal).max(initial=0.0)), 1.0)
    edges = np.linspace(-reach, 1.2 * reach, 3)
    lines = forces.force_cloud(
        samples[0][0], edges, edges, unit=law.force_unit, friction=min(law.law.mu, 1e6), cohesive=law.law.cohesive
    )
    charts.force_cloud(normal, tangential, lines, paths, unit=_unit(law), cohesive=law.law.cohesive)


def _angles(samples: Sequence[Sample], paths: Paths) -> None:
    edges = np.linspace(0.0, 180.0, 61)
    charts.angles([forces.force_angles(f, edges, tolerance=c.tolerance * c.force_unit) for f, c in samples], paths)


def _coordination(samples: Sequence[Sample], paths: Paths) -> None:
    charts.coordination_shares([coordination(f, threshold=c.tolerance * c.force_unit).shares for f, c in samples], paths)


def _scattering(samples: Sequence[Sample], paths: Paths) -> None:
    largest = max((frame for frame, _ in samples), key=lambda frame: float(frame.cell.max()))
    found = [scattering(frame, shells(largest, law)) for frame, law in samples]
    charts.scattering_chart(found, _fit(samples, found), paths)


def _fit(samples: Sequence[Sample], found: Sequence) -> FractalFit | None:
    """The fit of eq. 28, None where it finds nothing."""
    mean = average(found)
    try:
        return fit_fractal(mean, fit_window(mean, samples[0][1]), weighted=len(found) >= FEW)
    except WorkflowError:
        return None


def _correlation(samples: Sequence[Sample], paths: Paths) -> None:
    largest = max((frame for frame, _ in samples), key=lambda frame: float(frame.cell.max()))
    fit = _fit(samples, [scattering(frame, shells(largest, law)) for frame, law in samples])
    found = [correlation(frame, law) for frame, law in samples]
    shortest = min(len(c["r"]) for c in found)
    phi = float(np.mean([solid_fraction(frame) for frame, _ in samples]))
    charts.correlation_chart(found[0]["r"][:shortest], [c["c"][:shortest] for c in found], phi, fit, paths)


def _holes(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    maps.hole_map(frame, paths, length=law.length)


def _hole_sizes(samples: Sequence[Sample], paths: Paths) -> None:
    charts.hole_sizes([holes(frame) for frame, _ in samples], paths)


def _triangle(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    triangles.triangle(frame, paths, tolerance=law.tolerance * law.force_unit)


def _double_triangle(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    triangles.double_triangle(frame, paths, tolerance=law.tolerance * law.force_unit)


def _self_stress(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    maps.self_stress_map(frame, self_stress(frame, **law.resists), paths)


def _floppy(samples: Sequence[Sample], paths: Paths) -> None:
    frame, law = samples[0]
    held = without_loose(frame)
    if not held.grains:
        raise InputError("floppy: no grain touches another, every motion is free; choose another frame")
    moving = mobility(held, **law.resists)
    if moving.mechanisms > MOST_DRAWN:
        raise InputError(f"floppy: {moving.mechanisms} mechanisms, at most {MOST_DRAWN} are drawn; take a smaller sample")
    maps.floppy_map(held, moving, floppy_modes(held, **law.resists), frame.grains - held.grains, paths)


def _vibrations(samples: Sequence[Sample], paths: Paths) -> None:
    whole = all(frame.grains * (3 if law.resists["friction"] else 2) <= DENSE for frame, law in samples)
    found = [vibrations(f, law=c.law, count=None if whole else LOWEST, **c.resists) for f, c in samples]
    charts.vibration_chart(found, paths, whole=whole)


def _pair(samples: Sequence[Sample], paths: Paths) -> None:
    far = min(NEIGHBOURHOOD * samples[0][1].length, *(0.5 * float(f.cell.min()) for f, _ in samples))
    edges = np.linspace(0.0, far, 201)
    charts.pair_chart(edges, [pair_correlation(frame, edges).g for frame, _ in samples], paths)


FORCES = ("normal", "tangential")
DISCS = (*FORCES, "diameter", "gap")
PLOTS: dict[str, Plot] = {
    "forces": Plot("force network: compressive, tensile, distant, rattlers (fig. 2)", False, _forces, DISCS),
    "stressed": Plot("force network with the unstressed parts apart (figs. 11, 12, 19-22)", False, _stressed, DISCS),
    "distribution": Plot("distribution of N (figs. 9, 10)", True, _distribution, FORCES),
    "cloud": Plot("N-T plane, Coulomb cone, +-sqrt(3) cross (figs. 14, 17)", True, _cloud, FORCES),
    "angles": Plot("angle of force and normal (fig. 15)", True, _angles, FORCES),
    "triangle": Plot("a disc held by two touching discs, with its forces (fig. 16)", False, _triangle, DISCS),
    "double_triangle": Plot("two discs held by the same two, with their forces (fig. 18)", False, _double_triangle, DISCS),
    "coordination": Plot("share of grains with k neighbours (figs. 3, 6)", True, _coordination, FORCES),
    "self_stress": Plot("hyperstatic clusters", False, _self_stress, ("diameter", "gap"), True),
    "floppy": Plot("floppy modes", False, _floppy, ("diameter", "gap"), True),
    "vibrations": Plot("vibration spectrum and participation ratios", True, _vibrations, ("diameter", "gap", "mass"), True),
    "scattering": Plot("I(k) with the fit of eq. 28 (fig. 23)", True, _scattering, ("diameter",), True),
    "correlation": Plot("C(r) (eq. 24)", True, _correlation, ("diameter",), True),
    "holes": Plot("map of the holes (eq. 29)", False, _holes, ("diameter", "gap"), True),
    "hole_sizes": Plot("distribution of hole radii, <R>_w (eq. 30)", True, _hole_sizes, ("diameter", "gap"), True),
    "pair_correlation": Plot("g(r)", True, _pair, (), True),
}
