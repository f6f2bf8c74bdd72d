"""The measures by name: groups of numbers of one frame, ready for JSON, with what each costs.

A group is a plain function of a frame and the law's constants.  `measure_groups` runs the named ones; a group that
cannot be had on a frame says why under "error" and leaves the others alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass, replace
from typing import Any

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Floats, Frame, Ints
from workflow.errors import InputError, WorkflowError, did_you_mean
from workflow.measures.clusters import aggregates, local_coordination, pair_correlation
from workflow.measures.density import Scattering, autocorrelation, average, mesh_spacing, scattering
from workflow.measures.elasticity import DENSE, elastic_moduli, vibrations
from workflow.measures.forces import (
    fabric,
    force_angles,
    force_populations,
    normal_force_distribution,
    triangles,
)
from workflow.measures.fractal import fit_fractal
from workflow.measures.holes import Holes, grid_holes, holes
from workflow.measures.modes import hyperstatic_clusters, mobility, without_loose
from workflow.measures.pebble import rigid_clusters
from workflow.measures.percolation import Clusters, percolation, stressed_clusters
from workflow.measures.rigidity import rigidity

LOWEST = 40  # vibration modes of a frame too large for all of them
NEIGHBOURHOOD = 10.0  # reach of g(r), in lengths a
PER_DECADE = 16  # shells of |k|


@dataclass(frozen=True)
class Settings:
    """What the groups need to know beside the frame: the law of its contacts, units, and resolution.

    ``law``: constants of the contact law; ``shows_friction``: where its mu is not known, the data show that there is friction.
    ``force_unit`` F1 = max(F0, P a) and ``tolerance``: forces below tolerance F1 count as none.  ``length`` a.
    ``window``: range of k of the fractal fit (None: from the smallest k of the cell to pi/a).  ``spacing`` of the mesh of
    C(r) and of the paper's holes (None: a/100, coarser where that makes too many nodes).
    """

    law: ContactLaw
    shows_friction: bool = False
    force_unit: float = 1.0
    tolerance: float = 1e-4
    length: float = 1.0
    window: tuple[float, float] | None = None
    spacing: float | None = None

    @property
    def resists(self) -> dict[str, Any]:
        """Arguments of the rigidity functions.  Raises InputError if nobody says whether there is friction."""
        if np.isnan(self.law.mu) and not self.shows_friction:
            raise InputError("undefined without the coefficient of friction: give --mu (0: no friction)")
        return {"friction": self.law.mu != 0, "rolling": self.law.rolling}

    @property
    def stressed(self) -> float:
        """Force above which a contact counts as stressed: F1 tolerance, or F1/100 with rolling resistance (G07 fig. 19)."""
        return self.force_unit * (1e-2 if self.law.rolling else self.tolerance)

    def scale(self, frame: Frame) -> float | None:
        """Unit of the distribution of N: F0; None (the mean) without cohesion, unless nothing presses on anything."""
        return self.force_unit if self.law.cohesive or not frame.interactions.elastic.any() else None

    @property
    def force_edges(self) -> Floats:
        """Bins of N/F0, or of N/<N> without cohesion."""
        return np.linspace(-1.5 if self.law.cohesive else 0.0, 6.0, 151 if self.law.cohesive else 121)


@dataclass(frozen=True)
class Group:
    """``unasked``: number of grains up to which the group is measured unasked (0: only when named).  ``needs``: quantities
    without which it is undefined; ``periodic``: it needs a cell without walls."""

    meaning: str
    cost: str
    unasked: int
    measure: Callable[[Frame, Settings], dict[str, Any]]
    needs: tuple[str, ...] = ()
    periodic: bool = False

    def of(self, frame: Frame, settings: Settings) -> dict[str, Any]:
        """The numbers.  Raises InputError where they are undefined."""
        frame.need(self.meaning.split(",")[0], *self.needs)
        if self.periodic and not all(frame.periodic):
            raise InputError("undefined: it needs a cell that is periodic in x and y, this box has walls")
        return self.measure(frame, settings)


def forces_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Statistics of the interaction forces (G07 sec. IV)."""
    found, corners = percolation(frame), triangles(frame)
    normals = normal_force_distribution(frame, settings.force_edges, unit=settings.scale(frame))
    return {
        "populations": asdict(force_populations(frame, unit=settings.force_unit, tolerance=settings.tolerance)),
        "percolation": {"threshold": found.any, "axis": list(found.axis)},
        "fabric": fabric(frame),
        "triangles": {
            "number": len(corners.grains), "per_grain": len(corners.grains) / frame.grains,
            "mean_ratio": float(corners.ratio.mean()) if len(corners.grains) else None,
        },
        "distribution": {"unit": "F0" if settings.law.cohesive else "mean", **asdict(normals)},
        "angles": asdict(force_angles(frame, np.linspace(0.0, 180.0, 91), tolerance=settings.tolerance * settings.force_unit)),
    }  # fmt: skip


def clusters_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Aggregates, clusters of stressed contacts, and the coordination of large and small grains."""
    whole = aggregates(frame)
    found: dict[str, Any] = {
        "aggregates": _census(whole.clusters)
        | {"largest_gyration": float(whole.gyration[0]), "loops": int(whole.clusters.loops.sum())},
        "stressed": None, "coordination_by_size": None,
    }  # fmt: skip
    if {"normal", "tangential"} & frame.lacks:
        return found
    stressed = stressed_clusters(frame, settings.stressed)
    found["stressed"] = _census(stressed) | {"threshold": settings.stressed, "loops": int(stressed.loops.sum())}
    if "diameter" not in frame.lacks:
        number = local_coordination(
            frame,
            least=1 if settings.law.cohesive else 2,
            tolerance=None if settings.law.cohesive else settings.tolerance * settings.force_unit,
        )
        found["coordination_by_size"] = _by_size(frame.diameter, number)
    return found


def _census(found: Clusters) -> dict[str, Any]:
    """How many clusters of how many grains; ``largest`` of them in grains, and whether it winds around the cell."""
    size, number = np.unique(found.grains, return_counts=True)
    return {
        "number": len(found.grains),
        "largest": int(found.grains[0]) if len(found.grains) else 0,
        "winds": found.wraps[0].tolist() if len(found.grains) else [False, False],
        "sizes": {"grains": size, "number": number},
    }


def _by_size(diameter: Floats, number: Ints) -> dict[str, Any]:
    """Mean number of neighbours in five classes of equally many grains, small to large."""
    classes = np.array_split(np.argsort(diameter, kind="stable"), min(5, len(diameter)))
    return {
        "diameter": [float(diameter[rows].mean()) for rows in classes],
        "neighbours": [float(number[rows].mean()) for rows in classes],
    }


def rigidity_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Counts H and k of the network in a free cell."""
    return dict(rigidity(frame, law=settings.law, free_cell=True, **settings.resists).as_dict())


def slipping(frame: Frame, settings: Settings) -> dict[str, Any]:
    """H and k where the contacts that slide resist along their normal alone, as pairs at a distance do.

    In `rigidity_group` they count as sticking (G07 appendix A).  Raises InputError where nobody says which contacts slide.
    """
    frame.need("H and k with sliding contacts", "sliding", "gap")
    if settings.law.rolling:
        raise InputError("H and k with sliding contacts are not counted where contacts resist rolling")
    apart = np.where(frame.interactions.sliding & frame.interactions.in_contact, 0.0, frame.interactions.gap)
    loose = replace(frame, interactions=replace(frame.interactions, gap=apart))
    found = rigidity(loose, law=settings.law, free_cell=True, **settings.resists)
    return {
        "contacts": int(frame.interactions.sliding.sum()),
        "hyperstaticity": found.hyperstaticity,
        "floppy_modes": found.floppy_modes,
    }


def moduli_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Elastic moduli, [force/length]."""
    moduli = elastic_moduli(frame, law=settings.law, **settings.resists)
    return asdict(moduli) | {"bulk": moduli.bulk, "shear": moduli.shear}


def self_stress_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Hyperstatic clusters of the network in its fixed cell: parts that could hold self-balanced forces."""
    clusters, states = hyperstatic_clusters(frame, **settings.resists)
    inside = clusters >= 0
    table = frame.interactions.select(inside)
    held = np.unique(np.column_stack((np.tile(clusters[inside], 2), np.concatenate((table.i, table.j)))), axis=0)
    return {
        "states": int(states.sum()), "number": len(states), "hyperstaticity": states,
        "grains": np.bincount(held[:, 0], minlength=len(states)),
        "interactions": np.bincount(clusters[inside], minlength=len(states)),
    }  # fmt: skip


def floppy_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Mechanisms of the network in its fixed cell, beside the translations and the free motions of loose grains (those that
    touch none), and how many grains take part in them."""
    held = without_loose(frame)
    loose = frame.grains - held.grains
    if not held.grains:
        return {"mechanisms": 0, "loose_grains": loose, "participating_grains": 0.0}
    found = mobility(held, **settings.resists)
    return {
        "mechanisms": found.mechanisms, "loose_grains": loose, "participating_grains": _participating(found.grains),
    }  # fmt: skip


def _participating(mobility: Floats) -> float:
    """(sum m)^2 / sum m^2: the number of grains that share the motion."""
    square = float((mobility**2).sum())
    return float(mobility.sum()) ** 2 / square if square > 0 else 0.0


def rigid_clusters_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Rigid clusters by counting (pebble game, with friction; sliding contacts count once)."""
    if not settings.resists["friction"]:
        raise InputError("rigid clusters: the pebble game counts discs with friction; take the group rigidity")
    found = rigid_clusters(frame, rolling=settings.law.rolling)
    size, number = np.unique(found.sizes, return_counts=True)
    return {
        "number": len(found.redundant), "largest": int(found.sizes[0]), "largest_share": float(found.sizes[0] / frame.grains),
        "hinges": int((found.contacts < 0).sum()), "redundant": int(found.redundant.sum()),
        "independent": found.independent, "sizes": {"grains": size, "number": number},
    }  # fmt: skip


def vibrations_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Vibration spectrum in the fixed cell: all modes of a small frame, the lowest ones of a large one."""
    whole = frame.grains * (3 if settings.resists["friction"] else 2) <= DENSE
    found = vibrations(frame, law=settings.law, count=None if whole else LOWEST, **settings.resists)
    return {"all": whole, "frequency": found.frequency, "participation": found.participation}


def pair_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Pair correlation function g(r) up to ten lengths a."""
    far = min(NEIGHBOURHOOD * settings.length, 0.5 * float(frame.cell.min()))
    return asdict(pair_correlation(frame, np.linspace(0.0, far, 201)))


def density_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """I(k) without a grid, its fit by eq. 28, and C(r)."""
    found = density_of([scattering(frame, shells(frame, settings))], settings)
    return found | {"autocorrelation": correlation(frame, settings)}


def shells(frame: Frame, settings: Settings) -> Floats:
    """Shells of |k|: fixed places on a logarithmic scale, so that samples of any size share them; up to 4 pi/a."""
    lowest = np.log10(settings.length / float(frame.cell.max()))  # 2 pi/L in units of 2 pi/a
    first = int(np.floor(lowest * PER_DECADE))
    top = int(np.ceil(np.log10(2.0) * PER_DECADE))
    return 2 * np.pi / settings.length * 10.0 ** (np.arange(first, top + 1) / PER_DECADE)


def density_of(samples: Sequence[Scattering], settings: Settings) -> dict[str, Any]:
    """Mean I(k) over samples with standard errors, and the fit to it."""
    mean = average(samples)
    return {"averaged": len(samples), "shells": asdict(mean), "fit": attempt(lambda: _fit(mean, fit_window(mean, settings)))}


def fit_window(mean: Scattering, settings: Settings) -> tuple[float, float]:
    """Range of k of the fit: the one that was asked for, else from the smallest k there is to pi/a."""
    return settings.window or (float(np.nanmin(mean.k)), np.pi / settings.length)


def _fit(mean: Scattering, window: tuple[float, float]) -> dict[str, Any]:
    fit = fit_fractal(mean, window)
    return asdict(fit) | {"errors": fit.errors, "ell": fit.ell, "wavelength": fit.wavelength}


def correlation(frame: Frame, settings: Settings) -> dict[str, Any]:
    """C(r) on rings of a fifth of a length."""
    spacing = settings.spacing or mesh_spacing(frame, settings.length)
    far = min(4.0 * NEIGHBOURHOOD * settings.length, 0.5 * float(frame.cell.min()))
    edges = np.append(0.0, np.arange(0.5 * spacing, far, max(0.2 * settings.length, 2.0 * spacing)))
    found = autocorrelation(frame, edges, spacing=spacing)
    return {"spacing": spacing, "r": found.r, "c": found.c}


def holes_group(frame: Frame, settings: Settings) -> dict[str, Any]:
    """Holes exactly, and on the mesh of the paper."""
    spacing = settings.spacing or mesh_spacing(frame, settings.length)
    meshed = _holes(grid_holes(frame, spacing=spacing), settings)
    return _holes(holes(frame), settings) | {"grid": {"spacing": spacing} | meshed}


def _holes(found: Holes, settings: Settings) -> dict[str, Any]:
    edges = settings.length * np.geomspace(1e-2, 1e2, 41)
    sized = found.radius[~np.isnan(found.radius)]
    return {
        "number": len(found.area), "weighted_radius": found.weighted_radius,
        "percolates": bool(found.wraps.any()), "largest_radius": float(sized.max()) if len(sized) else None,
        "area_share_of_largest": float(found.area[0] / found.area.sum()) if len(found.area) else None,
        "distribution": {"edges": edges, "density": found.distribution(edges)},
    }  # fmt: skip


NETWORK = ("diameter", "gap")  # what a rigidity matrix is made of
GROUPS: dict[str, Group] = {
    "forces": Group("force populations, percolation threshold, distributions of N and angle", "0.1, 12", 10_000, forces_group,
                    ("normal", "tangential")),
    "clusters": Group("aggregates, stressed clusters, loops, coordination by grain size", "0.1, 3", 10_000, clusters_group),
    "rigidity": Group("hyperstaticity H, floppy modes k, stability", "1.2, 1e5: 43", 10_000, rigidity_group, NETWORK, True),
    "elastic_moduli": Group("C11, C22, C12, bulk and shear modulus", "0.2, 1e5: 14", 10_000, moduli_group, NETWORK, True),
    "self_stress": Group("hyperstatic clusters and their sizes", "0.8, 1e5: 22", 0, self_stress_group, NETWORK, True),
    "floppy_modes": Group("mechanisms and the grains that move in them", "0.7, 1e5: 19", 0, floppy_group, NETWORK, True),
    "rigid_clusters": Group("rigid clusters by a (3,3) pebble game", "0.2, 27", 0, rigid_clusters_group,
                            ("gap", "sliding", "rolling")),
    "vibrations": Group("vibration spectrum and participation ratios", "1.7, -", 0, vibrations_group, (*NETWORK, "mass"), True),
    "pair_correlation": Group("g(r)", "0.3, 63", 0, pair_group, (), True),
    "density": Group("I(k), fit of d_F and xi (G07 eq. 28), C(r)", "2.9, 49", 0, density_group, ("diameter",), True),
    "holes": Group("holes exactly and on a mesh, <R>_w", "0.8, 30", 0, holes_group, ("diameter", "gap"), True),
}  # fmt: skip


def chosen_groups(names: Sequence[str] | None, grains: int) -> list[str]:
    """The groups to measure: ``names`` (or all, or none), by default those that are cheap for so many grains."""
    if names is None:
        return [name for name, group in GROUPS.items() if grains <= group.unasked]
    if list(names) in (["all"], ["none"]):
        return list(GROUPS) if names[0] == "all" else []
    for name in names:
        if name not in GROUPS:
            hint = did_you_mean(name, GROUPS)
            raise InputError(f"'{name}' is no group of measures; {hint}choose from {', '.join(GROUPS)}, or all, or none")
    return list(names)


def measure_groups(frame: Frame, settings: Settings, names: Sequence[str]) -> dict[str, Any]:
    """Group name -> numbers, ready for JSON (numbers that are not defined are None)."""
    return {name: plain(attempt(lambda name=name: GROUPS[name].of(frame, settings))) for name in names}  # type: ignore[misc]


def attempt(part: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """The numbers, or why they cannot be had."""
    try:
        return part()
    except WorkflowError as fault:
        return {"error": str(fault)}


def plain(value: Any) -> Any:
    """``value`` as JSON knows it: arrays become lists, NaN and infinity None."""
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
