"""wf plot: figures of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.cli.assembling import density, pores
from workflow.cli.options import command
from workflow.cli.sources import add_sources, archived, frame_of
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot packing --figure stressed,cloud,angles         chosen figures; all: every one
wf plot sample1 sample2 sample3 --figure scattering    mean and standard error over samples
wf plot runs/method1-* runs/method2-* --figure density both methods, solid fraction against time (G07 fig. 4)
wf plot runs/method2-130aae48 --figure pores           frames from P* = 0 to P* side by side (fig. 5)
wf plot grains.dump --contacts contacts.dump           LAMMPS dumps of another deck
"""
HISTORY, DEFAULT = "history", ("forces", "history")
OF_RUNS = (HISTORY, "density", "pores")  # need the time series or the stages of run directories
# here and not in the gallery, because the help must not wait for matplotlib
FIGURES = ("forces", "stressed", "distribution", "cloud", "angles", "coordination", "self_stress", "floppy", "vibrations",
           "scattering", "correlation", "holes", "hole_sizes", "pair_correlation", *OF_RUNS)  # fmt: skip


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
    from workflow.report.gallery import PLOTS  # matplotlib is slow to import

    names = _chosen(arguments)
    first, several = arguments.source[0], len(arguments.source) > 1
    alone = [name for name in names if name == HISTORY or (name not in OF_RUNS and not PLOTS[name].several)]
    if several and alone:
        raise InputError(f"--figure {alone[0]} shows one sample; give one directory, or figures that show a mean")
    out = arguments.out or (first.parent if first.is_file() else first)
    samples = [frame_of(source, arguments) for source in arguments.source] if set(names) - set(OF_RUNS) else []
    together = {"density": density, "pores": pores}
    out.mkdir(parents=True, exist_ok=True)
    for name in names:
        paths = [out / f"{name}.{kind}" for kind in arguments.format]
        if name == HISTORY:
            paths = _history(archived(RunDirectory.open(first)), paths)
        elif name in together:
            together[name]([RunDirectory.open(source).path for source in arguments.source], paths)
        else:
            PLOTS[name].draw(samples, paths)
        for path in paths:
            print(path)
    return 0


def _chosen(arguments: argparse.Namespace) -> list[str]:
    """Names of the figures; without --figure those that the sources have."""
    known = [name for name in FIGURES if name not in OF_RUNS or not arguments.source[0].is_file()]
    if arguments.figure is None:
        return [name for name in DEFAULT if name in known]
    names = known if arguments.figure == "all" else arguments.figure.split(",")
    for name in names:
        if name not in known:
            raise InputError(f"--figure {name} is not known; choose from {', '.join(known)}, or all")
    return list(names)


def _history(directory: RunDirectory, paths: list[Path]) -> list[Path]:
    """The time series; nothing if the run has none."""
    from workflow.archive.read import Archive
    from workflow.engine.collect import ARCHIVE
    from workflow.report.figures import history

    scene = directory.scene
    with Archive(directory / ARCHIVE) as archive:
        series = archive.series
    if not series:
        return []
    history(
        series, paths, density="solid_fraction", stresses=("stress_x", "stress_y"),
        unbalanced=("net_force", "net_moment"), targets=(scene.pressure,),
        tolerance=scene.force_tolerance * scene.force_unit, stages=scene.stages,
    )  # fmt: skip
    return paths
