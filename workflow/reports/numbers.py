"""The numbers of a report page: what a run gave, and how far it can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workflow.reports.page_data import ReportData


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


def number(name: str, value: Any, form: str = ".4g", unit: str = "", note: str = "") -> Number:
    """A result as it is shown."""
    known = None if value is None or math.isnan(value) else float(value)
    return Number(name, known, "undefined" if known is None else f"{known:{form}}{unit}", note)


def judged(name: str, value: float | None, limit: float | None, unit: str) -> Error:
    """An error figure against its limit, None: without one."""
    if value is None or limit is None:
        return Error(name, "not known" if value is None else f"{value:.2g} {unit}")
    return Error(name, f"{value:.2g} {unit}", f"{limit:g} {unit}", value <= limit)


def errors(sheet: ReportData) -> list[Error]:
    """The error figures of the run, judged where the scene sets a limit."""
    m, scene = sheet.measures, sheet.scene
    found = sheet.view.balance(sheet)
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
