"""Options of the command line made from the quantities of a scene, and the frame every command runs in."""

from __future__ import annotations

import argparse
import shlex
import sys
import textwrap
from collections.abc import Mapping
from dataclasses import Field, fields
from pathlib import Path
from typing import Any

from workflow.cli.lists import whole_number
from workflow.scene.base import Scene
from workflow.scene.named import scene_named
from workflow.scene.parameter import Quantity, quantity_of
from workflow.scene.registry import SCENES


def command(commands: Any, name: str, summary: str, examples: str, *, action: Any) -> argparse.ArgumentParser:
    """A subcommand with its summary, worked examples and the function that does it."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=summary[0].upper() + summary[1:] + ".",
        epilog="examples:\n" + textwrap.indent(textwrap.dedent(examples).strip(), "  "),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.set_defaults(action=action)
    return parser


def add_any_deck(parser: argparse.ArgumentParser) -> None:
    """What commands that compare a run with its record share."""
    parser.add_argument("--any-deck", action="store_true",
                        help="accept what is not as the record of the run says, and note it in run.json")  # fmt: skip


def add_scene(parser: argparse.ArgumentParser) -> None:
    """The scene: a name with options, or a TOML file, or a file with options on top."""
    parser.usage = f"{parser.prog} SCENE [--out DIR] [options]"
    parser.add_argument("scene", metavar="SCENE", help=f"{', '.join(sorted(SCENES))}, or a TOML file")
    group = parser.add_argument_group("scene parameters (defaults are those of the paper)")
    of: dict[str, dict[str, Field[Any]]] = {}
    for scene in SCENES.values():
        for item in fields(scene):
            of.setdefault(item.name, {})[scene.name] = item
    for name, items in of.items():
        _add(group, name, quantity_of(next(iter(items.values()))), {scene: item.default for scene, item in items.items()})


def _add(group: Any, name: str, known: Quantity, defaults: Mapping[str, Any]) -> None:
    """The option of a parameter, with the default of each scene where they differ."""
    flag = "--" + name.replace("_", "-")
    notes = [known.meaning]
    if known.choices:
        notes.append(f"({known.allowed})")
    if known.unit:
        notes.append(f"[{known.unit}]")
    of: dict[str, list[str]] = {}
    for scene, value in defaults.items():
        of.setdefault("chosen" if value is None else _word(known, value), []).append(scene)
    if len(of) > 1:
        notes.append("(default " + ", ".join(f"{word} in {' and '.join(scenes)}" for word, scenes in of.items()) + ")")
    elif "chosen" not in of:
        notes.append(f"(default {next(iter(of))})")
    text = " ".join(notes).replace("%", "%%")
    if known.kind is bool:
        group.add_argument(flag, action=argparse.BooleanOptionalAction, default=argparse.SUPPRESS, help=text)
        return
    kind = {int: whole_number, float: float, str: str}[known.kind]
    group.add_argument(
        flag, type=kind, default=argparse.SUPPRESS, help=text, metavar=known.symbol or name.upper(),
        choices=known.choices or None,
    )  # fmt: skip


def _word(known: Quantity, value: Any) -> str:
    return str(value) if known.kind is not bool else "yes" if value else "no"


def command_line() -> str:
    """The command as it was given, for a published page: of an absolute path the part below this folder, or its name."""

    def public(word: str) -> str:
        option, equals, value = word.rpartition("=") if word.startswith("-") else ("", "", word)
        path = Path(value)
        if not path.is_absolute():
            return word
        return option + equals + str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path.name)

    return shlex.join(["wf", *map(public, sys.argv[1:])])


def scene_of(arguments: argparse.Namespace) -> Scene:
    """The scene that the command line describes."""
    given = {
        item.name: getattr(arguments, item.name)
        for scene in SCENES.values()
        for item in fields(scene)
        if hasattr(arguments, item.name)
    }
    return scene_named(arguments.scene, given)
