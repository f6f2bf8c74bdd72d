"""wf bench: nanoseconds per grain and step on a packing of one's own."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workflow.archive.read import Archive
from workflow.cli.options import command
from workflow.cli.sources import archived
from workflow.engine.collect import ARCHIVE
from workflow.engine.rundir import RunDirectory
from workflow.errors import InputError
from workflow.scene.heap import Heap
from workflow.study.bench import REFERENCE, bench

EXAMPLES = """
wf run method1 --no-cohesion --out dense     a packing to time on, then:
wf bench dense                               every case, five rounds
wf bench dense --rounds 9 --json             more rounds, for programs
"""


def declare(commands: Any) -> None:
    """Options of `wf bench`."""
    parser = command(
        commands,
        "bench",
        "time the kernels on the last frame of a run, beside LAMMPS's own contact styles",
        EXAMPLES,
        action=action,
    )
    parser.add_argument("directory", type=Path, metavar="DIR", help="run directory")
    parser.add_argument("--steps", type=int, default=20_000, metavar="K", help="timed steps per case and round (default 20000)")
    parser.add_argument("--rounds", type=int, default=5, metavar="R", help="rounds (default 5)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def action(arguments: argparse.Namespace) -> int:
    """Time and print."""
    directory = RunDirectory.open(arguments.directory)
    scene = directory.scene
    if isinstance(scene, Heap) or scene.cohesion:
        raise InputError(
            f"'{directory.path}' is no packing without cohesion, what LAMMPS's own styles can hold together; "
            "give a run made with --no-cohesion"
        )
    archived(directory)
    with Archive(directory / ARCHIVE) as archive:
        frame = archive.frame(-1)
    step = directory.scene.step_choice.step
    timings = bench(frame, step=step, steps=max(1, arguments.steps), rounds=max(1, arguments.rounds))
    if arguments.json:
        print(json.dumps([asdict(timing) for timing in timings], indent=1))
        return 0
    print(f"{frame.grains} grains, ns per grain and step: median [least .. most], ratio to {REFERENCE} in the same round")
    for t in timings:
        print(f"{t.case:45s} {t.median:6.1f} [{t.least:6.1f} .. {t.most:6.1f}]  {t.ratio:5.2f}")
    return 0
