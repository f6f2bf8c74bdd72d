"""wf plot: figures of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from workflow.archive.read import Archive
from workflow.cli.assembling import TOGETHER
from workflow.cli.options import command
from workflow.cli.sources import Source, add_sources, archived, folder_of, frame_of, packing, parameters_of, sources_of, tell
from workflow.errors import InputError
from workflow.measures.alike import FREE, differing, in_words, kinds
from workflow.measures.heap import avalanches, in_heap
from workflow.pipeline.heap import ground
from workflow.runs.directory import ARCHIVE, RunDirectory
from workflow.scene.heap import Heap

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot packing --figure stressed,cloud,angles         chosen figures; all: every one
wf plot sample1 sample2 sample3 --figure scattering    mean and standard error over samples
wf plot runs/method1-* runs/method2-* --figure density  both methods, solid fraction against time (G07 fig. 4)
wf plot runs/method2-130aae48 --figure pores           frames from P* = 0 to P* side by side (fig. 5)
wf plot runs/method2-* --figure agitation              z at P* = 0 against V0/V* (fig. 8)
wf plot runs/consolidation-* --figure consolidation    Phi and z against P*
wf plot grains.dump --contacts contacts.dump           LAMMPS dumps of another deck
wf plot runs/heap-4f1c09d2                             a heap: grains, vectors, forces, maps, film of its largest avalanche
"""
HISTORY, AGITATION, DEFAULT = "history", "agitation", ("forces", "history")
OF_RUNS = (HISTORY, "density", "pores", AGITATION, "consolidation")  # need the time series or the stages of run directories
# here and not in the gallery, because the help must not wait for matplotlib
FIGURES = ("forces", "stressed", "distribution", "cloud", "angles", "triangle", "double_triangle", "coordination",
           "self_stress", "floppy", "vibrations", "scattering", "correlation", "holes", "hole_sizes", "pair_correlation",
           *OF_RUNS)  # fmt: skip


def declare(commands: Any) -> None:
    """Options of `wf plot`."""
    parser = command(commands, "plot", "draw the force network, the history and other figures", EXAMPLES, action=action)
    add_sources(parser)
    parser.add_argument("--figure", metavar="NAMES",
                        help=f"figures, names with commas, or all (default forces,history): {', '.join(FIGURES)}")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the run directory)")
    parser.add_argument("--format", nargs="+", choices=("png", "svg"), default=["png", "svg"], help="file formats")


def action(arguments: argparse.Namespace) -> int:
    """Draw the chosen figures and say where they are."""
    from workflow.reports.registry import PLOTS  # matplotlib is slow to import

    sources = sources_of(arguments)
    first, several = sources[0], len(sources) > 1
    if isinstance(first, Path) and isinstance(RunDirectory.open(first).scene, Heap):
        return _heap(archived(RunDirectory.open(first)), arguments)
    names = _chosen(first, arguments)
    alone = [name for name in names if name == HISTORY or (name not in OF_RUNS and not PLOTS[name].several)]
    if several and alone:
        raise InputError(f"--figure {alone[0]} shows one sample; give one directory, or figures that show a mean")
    out = arguments.out or folder_of(first)
    samples = [frame_of(source, arguments) for source in sources] if set(names) - set(OF_RUNS) else []
    for frame, law in samples:
        tell(frame.notes)
        for name in set(names) - set(OF_RUNS):
            PLOTS[name].check(frame, law)
    out.mkdir(parents=True, exist_ok=True)
    for name in names:
        for members, label in _parts(name, sources, arguments):
            paths = [out / f"{name}{label}.{kind}" for kind in arguments.format]
            for path in _draw(name, [sources[k] for k in members], [samples[k] for k in members if samples], paths):
                print(path)
    return 0


def _draw(name: str, sources: Sequence[Source], samples: Sequence[Any], paths: list[Path]) -> list[Path]:
    """One figure of sources of one kind."""
    from workflow.reports.registry import PLOTS

    runs = [RunDirectory.open(source) for source in sources if isinstance(source, Path)]
    if name == HISTORY:
        return _history(archived(runs[0]), paths)
    if name in TOGETHER:
        if len(runs) < len(sources):
            raise InputError(f"--figure {name} needs run directories; leave the dumps out")
        TOGETHER[name]([run.path for run in runs], paths)
    else:
        PLOTS[name].draw(samples, paths)
    return paths


def _parts(name: str, sources: Sequence[Source], arguments: argparse.Namespace) -> list[tuple[list[int], str]]:
    """The sources of each figure with the mark in its name: a mean is of samples that differ in the seed alone."""
    every = list(range(len(sources)))
    if len(sources) == 1 or (name in OF_RUNS and name != AGITATION):
        return [(every, "")]
    free = (*FREE, "v0") if name == AGITATION else FREE
    parameters = [parameters_of(source, arguments) for source in sources]
    found = kinds(parameters, free)
    if len(found) == 1:
        return [(every, "")]
    tell([f"{name}: not averaged, the samples differ in more than the seed: {in_words(differing(parameters, free))}"])
    return [(members, f".{number}") for number, members in enumerate(found, 1)]


def _chosen(first: Source, arguments: argparse.Namespace) -> list[str]:
    """Names of the figures; without --figure those that the sources have."""
    known = [name for name in FIGURES if name not in OF_RUNS or isinstance(first, Path)]
    if arguments.figure is None:
        return [name for name in DEFAULT if name in known]
    names = known if arguments.figure == "all" else arguments.figure.split(",")
    for name in names:
        if name not in known:
            raise InputError(f"--figure {name} is not known; choose from {', '.join(known)}, or all")
    return list(names)


def _history(directory: RunDirectory, paths: list[Path]) -> list[Path]:
    """The time series; nothing if the run has none."""
    from workflow.reports.figures import history

    scene = packing(directory)
    with Archive(directory / ARCHIVE) as archive:
        series = archive.series
    if not series:
        return []
    history(
        series, paths, density="solid_fraction", stresses=("stress_x", "stress_y"),
        unbalanced=("net_force", "net_moment"), targets=(scene.pressure,),
        tolerance=scene.force_tolerance * scene.force_unit, stages=scene.stages, force="F_0" if scene.cohesion else "aP",
    )  # fmt: skip
    return paths


def _heap(directory: RunDirectory, arguments: argparse.Namespace) -> int:
    """Grains, centre-to-centre vectors, forces with the base profile, voidage and stress lines; a film of an avalanche."""
    from workflow.reports import heap  # matplotlib is slow to import

    scene, out = directory.scene, arguments.out or directory.path
    assert isinstance(scene, Heap)
    if arguments.figure or len(arguments.source) > 1:
        raise InputError(f"'{directory.path}' is a heap, whose figures are drawn together; give it alone, without --figure")
    with Archive(directory / ARCHIVE) as archive:
        frame, tracks = archive.frame(arguments.frame), archive.tracks
    place, drawn = ground(scene), []
    if not in_heap(frame, place).any():
        raise InputError(f"frame {arguments.frame} of '{directory.path}' holds no heap; choose another with --frame")
    out.mkdir(parents=True, exist_ok=True)
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
