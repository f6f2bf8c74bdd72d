"""wf plot: figures of a run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.analysis.heap import avalanches, in_heap
from workflow.archive.read import Archive
from workflow.cli.measure import archived
from workflow.cli.options import command
from workflow.engine.heap import ground
from workflow.engine.rundir import ARCHIVE, STAGES, RunDirectory
from workflow.errors import InputError
from workflow.scene.heap import Heap

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot runs/heap-4f1c09d2                             a heap: grains, vectors, forces, maps, film of its largest avalanche
"""


def declare(commands: Any) -> None:
    """Options of `wf plot`."""
    parser = command(commands, "plot", "draw the force network and the history of a run", EXAMPLES, action=action)
    parser.add_argument("directory", type=Path, metavar="DIR", help="run directory")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the run directory)")
    parser.add_argument("--frame", type=int, default=-1, metavar="K", help="frame of the force network (default: the last)")
    parser.add_argument("--format", nargs="+", choices=("png", "svg"), default=["png", "svg"], help="file formats")


def action(arguments: argparse.Namespace) -> int:
    """Draw both figures."""
    from workflow.report.figures import force_network, history  # matplotlib is slow to import

    directory = archived(RunDirectory.open(arguments.directory))
    out = arguments.out or directory.path
    out.mkdir(parents=True, exist_ok=True)
    scene = directory.scene
    if isinstance(scene, Heap):
        return heap_figures(directory, scene, arguments, out)
    names = {stem: [out / f"{stem}.{kind}" for kind in arguments.format] for stem in ("forces", "history")}
    with Archive(directory / ARCHIVE) as archive:
        frame, series = archive.frame(arguments.frame), archive.series
    force_network(
        frame, names["forces"], force_unit=scene.force_unit, symbol="F_0" if scene.cohesion else "aP",
        tolerance=scene.force_tolerance,
    )  # fmt: skip
    drawn = list(names["forces"])
    if series:
        history(
            series, names["history"], density="solid_fraction", stresses=("stress_x", "stress_y"),
            unbalanced=("net_force", "net_moment"), targets=(scene.pressure,),
            tolerance=scene.force_tolerance * scene.force_unit, stages=STAGES,
        )  # fmt: skip
        drawn += names["history"]
    print("\n".join(str(path) for path in drawn))
    return 0


def heap_figures(directory: RunDirectory, scene: Heap, arguments: argparse.Namespace, out: Path) -> int:
    """Grains, centre-to-centre vectors, forces with the base profile, voidage and stress lines; a film of an avalanche."""
    from workflow.report import heap  # matplotlib is slow to import

    with Archive(directory / ARCHIVE) as archive:
        frame, tracks = archive.frame(arguments.frame), archive.tracks
    place, drawn = ground(scene), []
    if not in_heap(frame, place).any():
        raise InputError(f"frame {arguments.frame} of '{directory.path}' holds no heap; choose another with --frame")
    for name, draw in (("heap", heap.snapshot), ("vectors", heap.vectors), ("forces", heap.forces), ("maps", heap.maps)):
        paths = [out / f"{name}.{kind}" for kind in arguments.format]
        draw(frame, place, paths)
        drawn += paths
    slides = avalanches(tracks, place) if tracks is not None else []
    if tracks is not None and slides:
        heap.film(tracks, place, max(slides, key=lambda event: event.size), out / "avalanche.gif")
        drawn.append(out / "avalanche.gif")
    print("\n".join(str(path) for path in drawn))
    return 0
