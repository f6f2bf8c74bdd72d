"""wf completion: a script by which a shell completes commands, options, names and files."""

from __future__ import annotations

import argparse
from typing import Any

import shtab

from workflow.cli.options import command
from workflow.scene.registry import SCENES

EXAMPLES = """
wf completion bash        the script; in ~/.bashrc: eval "$(wf completion bash)"
wf completion zsh         to be written to a file _wf in a folder of fpath
wf completion fish        to be written to ~/.config/fish/completions/wf.fish
"""
SHELLS = shtab.SUPPORTED_SHELLS
SCENE = {"bash": "_wf_scene", "zsh": f"_alternative 'scenes:scene:({' '.join(SCENES)})' 'files:file:_files -g \"*.toml\"'"}
PREAMBLE = {"bash": f"""_wf_scene() {{ compgen -W "{" ".join(SCENES)}" -- "$1"; compgen -f -X '!*.toml' -- "$1"; }}"""}


def declare(commands: Any) -> None:
    """Arguments of `wf completion`."""
    parser = command(commands, "completion", "print a script for the completion of a shell", EXAMPLES, action=action)
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def action(arguments: argparse.Namespace) -> int:
    """Print the script."""
    from workflow.cli.main import parser

    top = parser()
    for one in top.commands():
        if one.prepare:
            one.prepare(())  # the options of every scene
        for argument in one.arguments():
            if argument.dest == "scene":
                argument.complete = SCENE  # type: ignore[attr-defined]
            elif argument.type is not None and argument.type.__name__ == "Path":  # type: ignore[union-attr]
                argument.complete = shtab.FILE  # type: ignore[attr-defined]
    script = shtab.complete(top, arguments.shell, preamble=PREAMBLE)  # type: ignore[arg-type]
    print(script)
    return 0
