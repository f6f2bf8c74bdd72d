"""wf run: scene -> run directory -> engine -> archive and measures."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from pathlib import Path
from typing import Any

from workflow.cli.options import add_scene, command, scene_of
from workflow.pipeline.collect import stored_measures
from workflow.pipeline.run import run
from workflow.runs.directory import INTERRUPTED, RunDirectory, default_directory
from workflow.runs.installation import check_room, engine
from workflow.scene.heap import Heap
from workflow.scene.method2 import Method2

EXAMPLES = """
wf run method1 --phi0 0.36                            the cohesive packing of G07 table III
wf run method1 --no-cohesion --mu 0.15 --out dense    without cohesion, into directory dense
wf run consolidation --rolling --unload                an aggregate from P* = 0.001 to 10 and back
wf run scene.toml --seed 2 --ranks 2                  a scene from a file, another seed, two MPI ranks

a scene file holds the options as names and values; every run writes the one that repeats it:
  scene = "method1"
  phi0 = 0.36
  cohesion = false
"""


def declare(commands: Any) -> None:
    """Options of `wf run`."""
    parser = command(commands, "run", "run a scene and measure the result", EXAMPLES, action=action)
    add_scene(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="run directory (default runs/NAME-HASH)")
    add_run_options(parser)


def add_run_options(parser: argparse.ArgumentParser, ranks: int | None = 1) -> None:
    """What run and resume share; ``ranks``: default, None for those of the run."""
    text = "MPI ranks (default 1)" if ranks else "MPI ranks (default: those of the run)"
    parser.add_argument("--ranks", type=int, default=ranks, metavar="R", help=text)
    add_oversubscribe(parser)
    parser.add_argument("--json", action="store_true", help="print the measures as JSON")


def action(arguments: argparse.Namespace) -> int:
    """Create the directory and run it."""
    check_ranks(arguments)
    scene = scene_of(arguments)
    engine()  # a missing plugin or engine is said before anything is written
    directory = RunDirectory.create(arguments.out or default_directory(scene), scene, ranks=arguments.ranks)
    choice = scene.step_choice
    print(f"{scene.title}\nseed {scene.seed}, N = {scene.n}, directory {directory.path}", file=sys.stderr)
    print(f"step {choice.step:.3g} T0: {choice.reason}", file=sys.stderr)
    if isinstance(scene, Method2):
        for stage in ("aggregate", "relax"):
            if (other := scene.step_of(stage)).step != choice.step:
                print(f"step in {stage} {other.step:.3g} T0: {other.reason}", file=sys.stderr)
    if not isinstance(scene, Heap) and scene.compression_time > scene.max_time:
        print(f"the compression alone takes about {scene.compression_time:.0f} T0: raise --max-time", file=sys.stderr)
    left_out = scene.left_out()
    if left_out:
        print(f"left out, not paid for: {', '.join(left_out)}", file=sys.stderr)
    return finish(directory, arguments, resume=False)


def add_oversubscribe(parser: argparse.ArgumentParser) -> None:
    """What commands that start ranks on this machine share."""
    parser.add_argument("--oversubscribe", action="store_true", help="allow more ranks than this machine has cores")


def check_ranks(arguments: argparse.Namespace) -> None:
    """Before anything is written."""
    check_room(arguments.ranks, oversubscribe=arguments.oversubscribe)


def finish(
    directory: RunDirectory, arguments: argparse.Namespace, *, resume: bool, any_deck: bool = False, anew: bool = False
) -> int:
    """Run or continue, then show the result."""
    status = run(directory, ranks=arguments.ranks, resume=resume, any_deck=any_deck, anew=anew)
    if status == INTERRUPTED:
        print(f"wf: interrupted; continue with 'wf resume {shlex.quote(str(directory.path))}'", file=sys.stderr)
        return 130
    show(directory, as_json=arguments.json)
    return 0


def show(directory: RunDirectory, *, as_json: bool) -> None:
    """Print the measures of the run."""
    measures = stored_measures(directory)
    print(json.dumps(measures, indent=1) if as_json else summary(measures, directory))


def summary(measures: dict[str, Any], directory: RunDirectory) -> str:
    """The measures for people."""
    if measures.get("scene") == Heap.name:
        return heap_summary(measures, directory)
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
    part = 100 * numerics["largest_overlap_of_smallest_radius"]
    rows.append(("largest overlap", f"{numerics['largest_overlap']:.1e} a, {part:.2g} % of the smallest radius{_deep(part)}"))
    rows.append(("files", f"{directory.path}  ('wf plot {shlex.quote(str(directory.path))}' draws it)"))
    head = f"{state} equilibrium at t = {measures['time']:.2f} T0 (step {measures['step']})"
    return "\n".join([head, *(f"{name:22s}{text}" for name, text in rows)])


def heap_summary(measures: dict[str, Any], directory: RunDirectory) -> str:
    """The measures of a heap for people."""
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
    rows.append(("files", f"{directory.path}  ('wf plot {shlex.quote(str(directory.path))}' draws it)"))
    state = "at rest" if measures["equilibrated"] else "NOT at rest"
    head = f"{state} at t = {measures['time']:.2f} (step {measures['step']})"
    return "\n".join([head, *(f"{name:22s}{text}" for name, text in rows)])


DEEP = 10.0  # overlap in percent of the smallest radius beyond which discs with a linear law are no longer stiff


def _deep(percent: float) -> str:
    return ": the contacts are too soft for this energy, raise --kappa" if percent > DEEP else ""


def _steps(numerics: dict[str, Any]) -> str:
    in_tail = numerics.get("steps_in_tail")
    tail = f", {in_tail:.0f} in the tail at the fastest approach" if in_tail else ""
    return f"{numerics['steps_per_stiffest_period']:.0f} per stiffest period{tail}"


def _ratio(measures: dict[str, Any]) -> str:
    value = measures["rumpf_ratio_weighted"]
    return "undefined" if value is None else f"{value:.6f}"
