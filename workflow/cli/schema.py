"""wf schema: the JSON Schema of scene files and study files."""

from __future__ import annotations

import argparse
import json
from typing import Any

from workflow.cli.options import command
from workflow.scene.registry import SCENES
from workflow.scene.schema import schema

EXAMPLES = """
wf schema                   of every scene: what a file may hold depends on the scene that it names
wf schema method1           of one scene
wf schema --study           of the files of wf sweep

written to scene.json, and with a first line '#:schema ./scene.json' in a scene file, editors with Taplo (VS Code,
Helix, Neovim) complete, explain and check the file; 'taplo lint scene.toml' does so in a shell
"""


def declare(commands: Any) -> None:
    """Options of `wf schema`."""
    parser = command(commands, "schema", "print the JSON Schema of scene files", EXAMPLES, action=action)
    parser.add_argument("scene", nargs="?", choices=sorted(SCENES), metavar="SCENE", help="one of these: "
                        f"{', '.join(sorted(SCENES))} (default: whichever a file names)")  # fmt: skip
    parser.add_argument("--study", action="store_true", help="of the files of wf sweep instead")


def action(arguments: argparse.Namespace) -> int:
    """Print it."""
    print(json.dumps(schema(arguments.scene, study=arguments.study), indent=1, ensure_ascii=False))
    return 0
