"""Measures as text for people: the summary of a run by the kind of its scene, and every number in a row of its own."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from workflow.measures.registry import GROUPS
from workflow.pipeline.sources import Source
from workflow.runs.directory import RunDirectory

Measures = Mapping[str, Any]
Summary = tuple[str, list[tuple[str, str]]]  # a headline, and rows of name and text
SHOWN = 6  # entries of a list that people see


def summary(measures: Measures, directory: RunDirectory) -> str:
    """The measures of a run for people: what is known of its kind, else every number."""
    of_kind = SUMMARIES.get(directory.scene.kind)
    if of_kind is None:
        return rows(measures)
    head, found = of_kind(measures)
    found.append(("files", f"{directory.path}  ('wf plot {shlex.quote(str(directory.path))}' draws it)"))
    return "\n".join([head, *(f"{name:22s}{text}" for name, text in found)])


def text_of(measures: Measures, source: Source, *, named: bool) -> str:
    """The summary of a run, with the groups of measures that were asked for by name; every number of other sources."""
    if source.run is None:
        return rows(measures)
    extra = {name: measures[name] for name in GROUPS if name in measures} if named else {}
    return "\n".join([summary(measures, source.run), *(f"{name:44s}{value}" for name, value in lines(extra))])


def of_packing(measures: Measures) -> Summary:
    """The measures of a packing."""
    stress, residual, energy = measures["stress"], measures["energy_residual"], measures["kinetic_energy"]
    unbalanced, relaxation, numerics = measures["unbalanced_force"], measures["relaxation"], measures["numerics"]
    rumpf, state = measures["rumpf_ratio"], {True: "in", False: "NOT in", None: "not judged for"}[measures["equilibrated"]]
    imposed = "none, fixed cell" if stress["targets"][0] is None else f"{stress['targets'][0]:g}"
    shares = "  ".join(f"x{k} {100 * share:.1f}" for k, share in enumerate(measures["neighbour_shares"]))
    rows = [
        ("solid fraction", f"{measures['solid_fraction']:.4f}"),
        (
            "coordination z",
            f"{measures['coordination']:.3f}   z* {measures['coordination_backbone']:.3f}   "
            f"rattlers {100 * measures['rattler_fraction']:.1f} %   distant pairs {measures['interactions']['distant']}",
        ),
        ("neighbours [%]", shares),
        (
            "stress",
            f"xx {stress['xx']:.6g}  yy {stress['yy']:.6g}  xy {stress['xy']:.2g}  (imposed {imposed})",
        ),
        (
            "Rumpf ratio",
            "undefined (no mean force)" if rumpf is None else f"{rumpf:.4f}  (eq. 18; weighted with size {_ratio(measures)})",
        ),
        ("unbalanced [F1]", f"force {unbalanced['force']:.2g}  moment {unbalanced['moment']:.2g}"),
        ("kinetic energy/grain", f"{energy['per_grain']:.2g}  (with drift and every grain {energy['raw']:.2g})"),
    ]
    known = f"{100 * residual['relative']:.2f} % of the energy that went through" if residual else "unknown, no energy account"
    rows.append(("energy residual", known))
    for stage, change in (relaxation or {}).items():
        changes = f"contacts opened {change['contacts_opened']}, closed {change['contacts_closed']}"
        rows.append((f"during {stage}", f"{changes}, solid fraction {change['solid_fraction_change']:+.1e}"))
    if "hyperstaticity" in measures.get("rigidity", {}):
        network = measures["rigidity"]
        counts = f"hyperstaticity H {network['hyperstaticity']}, floppy modes k {network['floppy_modes']}"
        if "backbone_mechanisms" in network:
            held = "rigid" if network["positive_definite_backbone"] else f"with {network['backbone_mechanisms']} mechanisms"
            counts += f", backbone of {network['backbone_grains']} grains {held}"
        rows.append(("rigidity", counts))
    rows.append(("steps", _steps(numerics)))
    if numerics["largest_overlap"] is not None:  # a law of LAMMPS does not tell
        part = 100 * numerics["largest_overlap_of_smallest_radius"]
        text = f"{numerics['largest_overlap']:.1e} a, {part:.2g} % of the smallest radius{_deep(part)}"
        rows.append(("largest overlap", text))
    head = f"{state} equilibrium at t = {measures['time']:.2f} T0 (step {measures['step']})"
    return head, rows


def of_heap(measures: Measures) -> Summary:
    """The measures of a heap."""
    angle, base, order = measures["angle_of_repose_deg"], measures["base_force_profile"], measures["defects"]
    slides, energy = measures["avalanches"] or [], measures["energy_residual"]
    rows = [
        (
            "grains",
            f"{measures['poured']} poured, {measures['grains_in_heap']} in the heap, {measures['removed']} left",
        ),
        ("height, half width", f"{measures['height']:.2f}   {measures['half_width']:.2f}"),
    ]
    if angle["mean"] is not None:
        text = (
            f"{angle['mean']:.1f} +- {angle['uncertainty']:.1f} degrees  (left {angle['left']:.1f}, right {angle['right']:.1f})"
        )
        rows.append(("angle of repose", text))
    if base["dip"] is not None:
        rows.append(
            ("base forces", f"sum/weight {base['sum_over_weight']:.6f}   centre below the maxima by {100 * base['dip']:.0f} %")
        )
    rows += [
        ("avalanches", f"{len(slides)}, the largest of {max((s['size'] for s in slides), default=0)} grains"),
        ("unbalanced [mg]", f"force {measures['unbalanced_force']:.2g}"),
    ]
    if measures["solid_fraction"] is not None:
        text = f"{measures['solid_fraction']:.3f}   six neighbours {100 * order['sixfold']:.0f} % of inner ones"
        rows.append(("solid fraction", text))
    known = f"{100 * energy['relative']:.2f} % of the energy that went through" if energy else "unknown, no energy account"
    rows += [("energy residual", known), ("steps", _steps(measures["numerics"]))]
    deepest, now = measures["numerics"]["largest_overlap"], -measures["closest_pair"]
    rows.append(("largest overlap", f"{now:.3f} sigma now" + ("" if deepest is None else f", {deepest:.3f} in the run")))
    state = "at rest" if measures["equilibrated"] else "NOT at rest"
    head = f"{state} at t = {measures['time']:.2f} (step {measures['step']})"
    return head, rows


DEEP = 10.0  # overlap in percent of the smallest radius beyond which discs with a linear law are no longer stiff


def _deep(percent: float) -> str:
    return ": the contacts are too soft for this energy, raise --kappa" if percent > DEEP else ""


def _steps(numerics: Measures) -> str:
    in_tail = numerics.get("steps_in_tail")
    tail = f", {in_tail:.0f} in the tail at the fastest approach" if in_tail else ""
    return f"{numerics['steps_per_stiffest_period']:.0f} per stiffest period{tail}"


def _ratio(measures: Measures) -> str:
    value = measures["rumpf_ratio_weighted"]
    return "undefined" if value is None else f"{value:.6f}"


SUMMARIES: dict[str, Callable[[Measures], Summary]] = {"packing": of_packing, "heap": of_heap}  # by the kind of a scene


# ---- every number
def rows(result: Mapping[str, Any]) -> str:
    """Every number in a row of its own, then the notes."""
    rows = [f"{name:44s}{text}" for name, text in lines({name: value for name, value in result.items() if name != "notes"})]
    return "\n".join([*rows, *(f"note: {note}" for note in result.get("notes", []))])


def lines(tree: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """One line per number, named by its path."""
    for name, value in tree.items():
        path = f"{above}{name}"
        if isinstance(value, Mapping) and "samples" in value:
            yield path, _moments(value)
        elif isinstance(value, Mapping):
            yield from lines(value, f"{path}.")
        elif isinstance(value, list):
            yield path, " ".join(_short(entry) for entry in value[:SHOWN]) + (" ..." if len(value) > SHOWN else "")
        else:
            yield path, _short(value)


def _moments(value: Mapping[str, Any]) -> str:
    if "true" in value:
        return f"in {value['true']} of {value['samples']}"
    return f"{_short(value['mean'])} +- {_short(value['scatter'])}"


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    return "undefined" if value is None else str(value)
