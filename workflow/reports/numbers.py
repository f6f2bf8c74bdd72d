"""The numbers of a report page: what a run gave, and how far it can be trusted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workflow.reports.page_data import Sheet
from workflow.scene.heap import Heap


@dataclass(frozen=True)
class Number:
    """``value`` for sorting (None: not known), ``text`` for people, ``note`` beside it."""

    name: str
    value: float | None
    text: str
    note: str = ""


@dataclass(frozen=True)
class Error:
    """``limit``: what the run was to keep, if there is such a limit; ``kept``: whether it did."""

    name: str
    text: str
    limit: str = ""
    kept: bool | None = None


def _number(name: str, value: Any, form: str = ".4g", unit: str = "", note: str = "") -> Number:
    known = None if value is None or math.isnan(value) else float(value)
    return Number(name, known, "undefined" if known is None else f"{known:{form}}{unit}", note)


def results(sheet: Sheet) -> list[Number]:
    """What one looks at first."""
    return _of_heap(sheet) if sheet.ground is not None else _of_packing(sheet)


def _of_packing(sheet: Sheet) -> list[Number]:
    m, (length, force, _) = sheet.measures, sheet.units
    pairs, stress, network = m["interactions"], m["stress"], m.get("rigidity", {})
    imposed = [f"{target:g}" for target in stress["targets"] if target is not None]
    found = [
        _number("solid fraction Φ", m["solid_fraction"], ".4f"),
        _number("coordination z", m["coordination"], ".3f", note=_backbone(m)),
        _number(
            "interactions",
            sum(pairs.values()),
            ".0f",
            note=f"of {m['grains']} grains" + f", {pairs['distant']} distant" * (pairs["distant"] > 0),
        ),
        _number("rattlers", None if m["rattler_fraction"] is None else 100 * m["rattler_fraction"], ".1f", " %"),
        _number("pressure", stress["pressure"], ".4g", f" {force}/{length}", note=f"imposed {imposed[0]}" if imposed else ""),
        _number("Rumpf ratio", m["rumpf_ratio"], ".3f", note="G07 eq. 18"),
    ]
    if "hyperstaticity" in network:
        note = f"floppy modes k {network['floppy_modes']}"
        found.append(_number("hyperstaticity H", network["hyperstaticity"], ".0f", note=note))
    threshold = m.get("forces", {}).get("percolation", {}).get("threshold")
    if threshold is not None:
        found.append(_number("force that percolates", threshold / sheet.force_unit, ".3g", f" {force}"))
    return found


def _backbone(m: Mapping[str, Any]) -> str:
    return "" if m["coordination_backbone"] is None else f"z* {m['coordination_backbone']:.3f}"


def _of_heap(sheet: Sheet) -> list[Number]:
    m = sheet.measures
    angle, slides = m["angle_of_repose_deg"], m["avalanches"]
    spread = ""
    if angle["uncertainty"] is not None:
        spread = f"± {angle['uncertainty']:.1f}°, left {angle['left']:.1f}°, right {angle['right']:.1f}°"
    low = m["base_force_profile"]["dip"]
    return [
        _number("grains in the heap", m["grains_in_heap"], ".0f", note=f"{m['poured']} poured, {m['removed']} gone"),
        _number("height", m["height"], ".2f", " σ", f"half width {m['half_width']:.1f} σ"),
        _number("angle of repose", angle["mean"], ".1f", "°", spread),
        _number("dip of the base force", None if low is None else 100 * low, ".0f", " %", "centre below the maxima"),
        _number("solid fraction", m["solid_fraction"], ".3f"),
        _number("avalanches", None if slides is None else len(slides), ".0f",
                note=f"largest {max((s['size'] for s in slides), default=0)} grains" if slides else ""),
    ]  # fmt: skip


def errors(sheet: Sheet) -> list[Error]:
    """The error figures of the run, judged where the scene sets a limit."""
    m, scene = sheet.measures, sheet.scene
    found = _balance(sheet)
    residual = m.get("energy_residual")
    if residual:
        found.append(Error("energy residual", f"{100 * residual['relative']:.2g} % of the energy that went through"))
    elif scene is not None:
        found.append(Error("energy residual", "unknown, no energy account"))
    if "numerics" in m:
        found += _resolution(m["numerics"], sheet.units[0])
    for stage, change in (m.get("relaxation") or {}).items():
        text = f"contacts opened {change['contacts_opened']}, closed {change['contacts_closed']}; solid fraction "
        found.append(Error(f"what changed during {stage}", f"{text}{change['solid_fraction_change']:+.1e}"))
    return found


def _balance(sheet: Sheet) -> list[Error]:
    """Equilibrium, in the scene's own criteria (G07 sec. II D)."""
    m, scene, (length, force, _) = sheet.measures, sheet.scene, sheet.units

    def judged(name: str, value: float | None, limit: float | None, unit: str) -> Error:
        if value is None or limit is None:
            return Error(name, "not known" if value is None else f"{value:.2g} {unit}")
        return Error(name, f"{value:.2g} {unit}", f"{limit:g} {unit}", value <= limit)

    if isinstance(scene, Heap):
        carried = m["base_force_profile"]["sum_over_weight"]
        return [
            judged("largest net force on a grain", m["unbalanced_force"], scene.force_tolerance, force),
            Error("forces on the base over the weight", "not known" if carried is None else f"{carried:.6f}"),
            Error("closest pair", f"{-m['closest_pair']:.3g} {length} of overlap"),
        ]
    unbalanced, unit = m["unbalanced_force"], "F₁"
    tolerance, energy = (None, None) if scene is None else (scene.force_tolerance, scene.energy_tolerance)
    scale = sheet.force_unit
    deviation, kinetic = m["stress"]["deviation"], m["kinetic_energy"]["per_grain"]
    return [
        judged("largest net force on a grain", unbalanced["force"], tolerance, unit),
        judged("largest net moment on a grain", unbalanced["moment"], tolerance, f"{unit} {length}"),
        judged("stress from the imposed one", None if deviation is None else deviation / scale, tolerance, f"{unit}/{length}"),
        judged("kinetic energy per grain", None if kinetic is None else kinetic / scale, energy, f"{unit} {length}"),
        judged("contact forces from the engine's sums", unbalanced["engine_force_difference"], None, unit),
    ]


def _resolution(n: dict[str, Any], length: str) -> list[Error]:
    found = [Error("steps per stiffest period", f"{n['steps_per_stiffest_period']:.4g}")]
    if "share_of_stability_limit" in n:
        share = n["share_of_stability_limit"]
        found.append(Error("step over the largest stable one", f"{share:.2g}", "1", share <= 1.0))
    if n.get("steps_in_tail"):
        found.append(Error("steps in the tail of the force", f"{n['steps_in_tail']:.3g} at the fastest approach"))
    overlap = n["largest_overlap"]
    if overlap is not None:
        part = n.get("largest_overlap_of_smallest_radius")
        text = f"{overlap:.2g} {length}"
        found.append(Error("largest overlap", text if part is None else f"{text}, {100 * part:.2g} % of the smallest radius"))
    return found
