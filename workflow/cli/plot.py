"""wf plot: figures of a run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.archive.read import Archive
from workflow.cli.assembling import density, pores
from workflow.cli.measure import archived
from workflow.cli.options import command
from workflow.engine.collect import ARCHIVE
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError

EXAMPLES = """
wf plot runs/method1-130aae48                          forces.png/.svg and history.png/.svg in that directory
wf plot runs/method1-130aae48 --out figures            elsewhere
wf plot runs/method1-130aae48 --frame 0 --format png   the first frame, PNG only
wf plot runs/method1-* runs/method2-* --figure density   both methods, solid fraction against time (G07 fig. 4)
wf plot runs/method2-130aae48 --figure pores             frames from P* = 0 to P* side by side (fig. 5)
"""


def declare(commands: Any) -> None:
    """Options of `wf plot`."""
    parser = command(commands, "plot", "draw the force network and the history of a run", EXAMPLES, action=action)
    parser.add_argument(
        "directories", type=Path, nargs="+", metavar="DIR", help="run directories; several for density and pores"
    )
    parser.add_argument("--figure", choices=("run", "density", "pores"), default="run",
                        help="force network and history; solid fraction against log time; the closing of pores")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the run directory)")
    parser.add_argument("--frame", type=int, default=-1, metavar="K", help="frame of the force network (default: the last)")
    parser.add_argument("--format", nargs="+", choices=("png", "svg"), default=["png", "svg"], help="file formats")


def action(arguments: argparse.Namespace) -> int:
    """Draw both figures."""
    from workflow.report.figures import force_network, history  # matplotlib is slow to import

    if arguments.figure == "run" and len(arguments.directories) > 1:
        raise InputError("several directories are drawn together by --figure density or --figure pores; give one, or choose")
    out = arguments.out or arguments.directories[0]
    if arguments.figure != "run":
        paths = [out / f"{arguments.figure}.{kind}" for kind in arguments.format]
        draw = {"density": density, "pores": pores}[arguments.figure]
        directories = [RunDirectory.open(path).path for path in arguments.directories]
        out.mkdir(parents=True, exist_ok=True)
        draw(directories, paths)
        print("\n".join(map(str, paths)))
        return 0
    directory = archived(RunDirectory.open(arguments.directories[0]))
    out.mkdir(parents=True, exist_ok=True)
    scene = directory.scene
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
            tolerance=scene.force_tolerance * scene.force_unit, stages=scene.stages,
        )  # fmt: skip
        drawn += names["history"]
    print("\n".join(str(path) for path in drawn))
    return 0
