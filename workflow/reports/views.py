"""What a page shows of a run, by the kind of its scene: which grains are marked, the charts, results and error figures.

A kind without an entry in VIEWS is shown by `View`: every column of its time series, every number of its measures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from workflow.data.frame import Bools, Floats, Frame
from workflow.measures.heap import in_heap
from workflow.measures.packing import coordination
from workflow.pipeline.heap import ground
from workflow.reports.network import BAND, kinds_of_fig2
from workflow.reports.numbers import Error, Number, judged, number

if TYPE_CHECKING:
    from workflow.reports.page_data import ReportData


@dataclass(frozen=True)
class Sight:
    """A frame and what a `View` must know of it: ``force_unit`` F1, below ``tolerance`` F1 there is no force; ``cohesive``: an
    attraction acts; ``length`` a; ``scene``: None for the dump of another program."""

    frame: Frame
    force_unit: float
    tolerance: float
    cohesive: bool
    length: float
    scene: Any


KINDS = ("compressive", "tensile", "distant", "no force")  # drawn from the last to the first
Chart = tuple[str, str, Sequence[str], bool]  # title, unit, columns, logarithmic; {l}, {f}: units of length and force
SHOWN = 6  # numbers of the measures among the results


class View:
    """A run of whatever kind.  ``marks``: (look, name) of grains that are marked 1, 2, ...; ``flat``: it is wide and low."""

    marks: Sequence[tuple[str, str]] = ()
    flat = False

    def mark(self, sheet: Sight) -> np.ndarray:
        """The mark of each grain, 0 for none, (N,)."""
        return np.zeros(sheet.frame.grains, dtype=int)

    def kinds(self, sheet: Sight) -> Mapping[str, Bools]:
        """Of KINDS but the last, which interactions are of it, (M,)."""
        normal, least = sheet.frame.interactions.normal_force, sheet.tolerance * sheet.force_unit
        return {"compressive": normal > least, "tensile": normal < -least}

    def shown(self, sheet: Sight) -> Bools:
        """The grains that a picture without periodic sides is to hold, (N,)."""
        return np.ones(sheet.frame.grains, dtype=bool)

    def band(self, sheet: Sight) -> float:
        """Width of the line of one force unit: the largest force is 0.7 wide."""
        return 0.7 / max(float(np.abs(sheet.frame.interactions.normal_force).max(initial=0.0)) / sheet.force_unit, 1.0)

    def charts(self, sheet: ReportData) -> Sequence[Chart]:
        """The charts against time; columns that the series has not are left out."""
        columns = (name for name in sheet.series if name not in ("step", "time", "stage"))
        return [(name.replace("_", " "), "", (name,), False) for name in columns]

    def column(self, sheet: ReportData, name: str) -> Floats:
        """A column of the time series as it is drawn."""
        return sheet.series[name]

    def levels(self, sheet: ReportData) -> Mapping[str, tuple[str, float]]:
        """What the run was to reach: title of a chart -> name and value."""
        return {}

    def results(self, sheet: ReportData) -> list[Number]:
        """What one looks at first."""
        known = {name: value for name, value in sheet.measures.items() if type(value) in (int, float)}
        return [number(name.replace("_", " "), known[name]) for name in list(known)[:SHOWN]]

    def balance(self, sheet: ReportData) -> list[Error]:
        """Equilibrium, in the scene's own criteria."""
        return []


class PackingView(View):
    """A packing in a periodic cell, and the dump of another program."""

    marks = (("grey", "rattler"),)

    def mark(self, sheet: Sight) -> np.ndarray:
        """1: rattlers."""
        return coordination(sheet.frame, threshold=sheet.tolerance * sheet.force_unit).rattlers

    def kinds(self, sheet: Sight) -> Mapping[str, Bools]:
        """As in G07 fig. 2."""
        return {name: kind.rows for name, kind in kinds_of_fig2(sheet.frame, sheet.force_unit, sheet.tolerance).items()}

    def band(self, sheet: Sight) -> float:
        """As in the figures."""
        return (0.3 if sheet.cohesive else BAND) * sheet.length

    def charts(self, sheet: ReportData) -> Sequence[Chart]:
        """PACKING; without attraction there are no aggregates."""
        return [chart for chart in PACKING if sheet.cohesive or chart[0] != "aggregates"]

    def levels(self, sheet: ReportData) -> Mapping[str, tuple[str, float]]:
        """The criteria of equilibrium, and the imposed stress."""
        scene: Any = sheet.scene
        if scene is None:
            return {}
        several = len({scene.pressure_of(stage) for stage in scene.stages.values()} - {None, 0.0}) > 1
        return _tolerances(sheet) | {"stress": ("imposed at the end" if several else "imposed", scene.pressure)}

    def results(self, sheet: ReportData) -> list[Number]:
        """Density, coordination, stress, rigidity."""
        m, (length, force, _) = sheet.measures, sheet.units
        pairs, stress, network = m["interactions"], m["stress"], m.get("rigidity", {})
        imposed = [f"{target:g}" for target in stress["targets"] if target is not None]
        found = [
            number("solid fraction Φ", m["solid_fraction"], ".4f"),
            number("coordination z", m["coordination"], ".3f", note=_backbone(m)),
            number(
                "interactions",
                sum(pairs.values()),
                ".0f",
                note=f"of {m['grains']} grains" + f", {pairs['distant']} distant" * (pairs["distant"] > 0),
            ),
            number("rattlers", None if m["rattler_fraction"] is None else 100 * m["rattler_fraction"], ".1f", " %"),
            number("pressure", stress["pressure"], ".4g", f" {force}/{length}", f"imposed {imposed[0]}" if imposed else ""),
            number("Rumpf ratio", m["rumpf_ratio"], ".3f", note="G07 eq. 18"),
        ]
        if "hyperstaticity" in network:
            note = f"floppy modes k {network['floppy_modes']}"
            found.append(number("hyperstaticity H", network["hyperstaticity"], ".0f", note=note))
        threshold = m.get("forces", {}).get("percolation", {}).get("threshold")
        if threshold is not None:
            found.append(number("force that percolates", threshold / sheet.force_unit, ".3g", f" {force}"))
        return found

    def balance(self, sheet: ReportData) -> list[Error]:
        """Equilibrium, in the criteria of G07 sec. II D."""
        m, (length, *_), scene = sheet.measures, sheet.units, sheet.scene
        unbalanced, unit = m["unbalanced_force"], "F₁"
        tolerance, energy = (None, None) if scene is None else (scene.force_tolerance, scene.energy_tolerance)
        scale = sheet.force_unit
        deviation, kinetic = m["stress"]["deviation"], m["kinetic_energy"]["per_grain"]
        stress = None if deviation is None else deviation / scale
        return [
            judged("largest net force on a grain", unbalanced["force"], tolerance, unit),
            judged("largest net moment on a grain", unbalanced["moment"], tolerance, f"{unit} {length}"),
            judged("stress from the imposed one", stress, tolerance, f"{unit}/{length}"),
            judged("kinetic energy per grain", None if kinetic is None else kinetic / scale, energy, f"{unit} {length}"),
            judged("contact forces from the engine's sums", unbalanced["engine_force_difference"], None, unit),
        ]


class HeapView(View):
    """A heap on its base."""

    marks = (("grey", "not in the heap"), ("edge", "fixed base"))
    flat = True

    def mark(self, sheet: Sight) -> np.ndarray:
        """1: grains that are not in the heap; 2: the base."""
        place = ground(sheet.scene)
        return np.where(sheet.frame.ids <= place.base, 2, ~in_heap(sheet.frame, place))

    def shown(self, sheet: Sight) -> Bools:
        """The heap and the base below it."""
        frame, place = sheet.frame, ground(sheet.scene)
        own = in_heap(frame, place)
        if not own.any():
            return super().shown(sheet)
        across = frame.position[:, 0]
        return own | ((across > across[own].min() - 3) & (across < across[own].max() + 3) & (frame.ids <= place.base))

    def charts(self, sheet: ReportData) -> Sequence[Chart]:
        """POURING."""
        return POURING

    def column(self, sheet: ReportData, name: str) -> Floats:
        """The top is counted from the base."""
        return sheet.series[name] - (ground(sheet.scene).level if name == "top" else 0.0)

    def levels(self, sheet: ReportData) -> Mapping[str, tuple[str, float]]:
        """The criteria of rest."""
        return _tolerances(sheet)

    def results(self, sheet: ReportData) -> list[Number]:
        """Shape, base force and avalanches."""
        m = sheet.measures
        angle, slides = m["angle_of_repose_deg"], m["avalanches"]
        spread = ""
        if angle["uncertainty"] is not None:
            spread = f"± {angle['uncertainty']:.1f}°, left {angle['left']:.1f}°, right {angle['right']:.1f}°"
        low = m["base_force_profile"]["dip"]
        return [
            number("grains in the heap", m["grains_in_heap"], ".0f", note=f"{m['poured']} poured, {m['removed']} gone"),
            number("height", m["height"], ".2f", " σ", f"half width {m['half_width']:.1f} σ"),
            number("angle of repose", angle["mean"], ".1f", "°", spread),
            number("dip of the base force", None if low is None else 100 * low, ".0f", " %", "centre below the maxima"),
            number("solid fraction", m["solid_fraction"], ".3f"),
            number("avalanches", None if slides is None else len(slides), ".0f",
                    note=f"largest {max((s['size'] for s in slides), default=0)} grains" if slides else ""),
        ]  # fmt: skip

    def balance(self, sheet: ReportData) -> list[Error]:
        """Rest, and whether the base carries the weight."""
        m, (length, force, _) = sheet.measures, sheet.units
        carried = m["base_force_profile"]["sum_over_weight"]
        return [
            judged("largest net force on a grain", m["unbalanced_force"], sheet.tolerance, force),
            Error("forces on the base over the weight", "not known" if carried is None else f"{carried:.6f}"),
            Error("closest pair", f"{-m['closest_pair']:.3g} {length} of overlap"),
        ]


def _backbone(m: Mapping[str, Any]) -> str:
    return "" if m["coordination_backbone"] is None else f"z* {m['coordination_backbone']:.3f}"


def _tolerances(sheet: ReportData) -> dict[str, tuple[str, float]]:
    scene, unit = sheet.scene, sheet.force_unit
    return {
        "largest unbalanced force and moment": ("tolerance", scene.force_tolerance * unit),
        "kinetic energy per grain": ("tolerance", scene.energy_tolerance * unit),
    }


PACKING: Sequence[Chart] = (
    ("solid fraction", "Φ", ("solid_fraction",), False),
    ("stress", "{f}/{l}", ("stress_x", "stress_y"), False),
    ("largest unbalanced force and moment", "{f}, {f} {l}", ("net_force", "net_moment"), True),
    ("coordination", "z", ("coordination",), False),
    ("kinetic energy per grain", "{f} {l}", ("kinetic_per_grain", "kinetic_per_grain_raw"), True),
    ("energy", "{f} {l}", ("kinetic", "elastic", "tangential", "rolling", "adhesive"), False),
    ("work and losses", "{f} {l}", ("work", "lost_viscous", "lost_sliding", "lost_rolling", "lost_drag"), False),
    ("energy residual", "{f} {l}", ("residual",), False),
    ("largest overlap", "{l}", ("overlap",), True),
    ("aggregates", "", ("aggregates", "largest_aggregate"), True),
    ("rattlers", "", ("rattlers",), False),
)
POURING: Sequence[Chart] = (
    ("grains", "", ("poured", "removed"), False),
    ("top of the heap", "{l}", ("top",), False),
    ("largest unbalanced force and moment", "{f}, {f} {l}", ("net_force", "net_moment"), True),
    ("kinetic energy per grain", "{f} {l}", ("kinetic_per_grain",), True),
    ("energy", "{f} {l}", ("kinetic", "elastic", "tangential"), False),
    ("losses", "{f} {l}", ("lost_viscous", "lost_sliding"), False),
    ("energy residual", "{f} {l}", ("residual",), False),
    ("largest overlap", "{l}", ("overlap",), True),
)
VIEWS: dict[str, Callable[[], View]] = {"packing": PackingView, "heap": HeapView}  # by the kind of a scene
