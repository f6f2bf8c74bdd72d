"""wf deck: write what `wf run` would run, without running it."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import Any

from workflow.cli.options import add_scene, command, scene_of
from workflow.deck.render import DECK, render
from workflow.engine.rundir import RunDirectory, default_directory

EXAMPLES = """
wf deck method1 --phi0 0.36 --out packing   then: cd packing && lmp -in deck.in
wf deck method1 --mu 0.15 --dry-run         print the deck, write nothing
wf deck scene.toml --out packing            a scene from a file
"""


def declare(commands: Any) -> None:
    """Options of `wf deck`."""
    parser = command(commands, "deck", "write the deck of a scene, which runs alone with lmp", EXAMPLES, action=action)
    add_scene(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="directory (default runs/NAME-HASH)")
    parser.add_argument("--dry-run", action="store_true", help="print the deck, write nothing")


def action(arguments: argparse.Namespace) -> int:
    """Write or print the deck."""
    scene = scene_of(arguments)
    if arguments.dry_run:
        print(render(scene), end="")
        return 0
    directory = RunDirectory.create(arguments.out or default_directory(scene), scene)
    print(f"run it with: cd {shlex.quote(str(directory.path))} && lmp -in {DECK}", file=sys.stderr)
    print(directory / DECK)
    return 0
