"""A scene on the command line: its name or file, and its parameters as options, in the groups of the scene."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from workflow.cli.lists import whole_number
from workflow.cli.parser import Parser, number
from workflow.errors import InputError
from workflow.scene.base import Scene
from workflow.scene.named import scene_named
from workflow.scene.parameter import GROUPS, Quantity, quantity_of
from workflow.scene.registry import SCENES, read_toml

Groups = Mapping[str, Any]
KINDS = {int: whole_number, float: number, str: str}


def add_scene(parser: Parser) -> Groups:
    """The scene: a name with options, or a TOML file, or a file with options on top; the groups of its options by title.

    Options are those of the scene that the words name; of every scene where they name none.
    """
    parser.usage = f"{parser.prog} SCENE [--out DIR] [options]"
    names = ", ".join(sorted(SCENES))
    parser.add_argument("scene", metavar="SCENE", help=f"{names}, or a TOML file; '{parser.prog} SCENE --help' shows its "
                        "parameters, whose defaults are those of the paper")  # fmt: skip
    groups = {title: parser.add_argument_group(title) for title in GROUPS}
    parser.prepare = partial(add_parameters, parser, groups)
    return groups


def add_parameters(parser: Parser, groups: Groups, words: Sequence[str]) -> None:
    """The parameters of the scene that ``words`` name; of every scene if they name none, unless only help is wanted."""
    name, scene = _scene_in(parser, words)
    if scene:
        parser.subject = name
        parser.usage = f"{parser.prog} {name} [--out DIR] [options]"
        for flag, owners in _owners().items():
            parser.elsewhere[flag] = f"is an option of {' and '.join(owners)}, not of {scene.name}"
    elif {"-h", "--help"} & set(words):
        return
    taken = set[str]()
    for one in [scene] if scene else SCENES.values():
        for item in fields(one):
            flags = [flag for flag in _flags(item.name, quantity_of(item)) if flag not in taken]
            if flags:
                _add(groups[one.group_of(item.name)], flags, item.name, quantity_of(item), item.default)
                taken.update(flags)


def _scene_in(parser: Parser, words: Sequence[str]) -> tuple[str, type[Scene] | None]:
    """The first word that is no option and no value of one, and the scene that it names."""
    names = (item.name for scene in SCENES.values() for item in fields(scene) if quantity_of(item).kind is bool)
    switches = {flag for name in names for flag in (_flag(name), _flag(f"no-{name}"))} | parser.switches()
    for before, word in zip(["", *words], words, strict=False):
        if word.startswith("-") or (before.startswith("--") and "=" not in before and before not in switches):
            continue
        if word in SCENES or not word.endswith(".toml"):
            return word, SCENES.get(word)
        try:
            return word, SCENES.get(read_toml(Path(word)).get("scene", ""))
        except (InputError, TypeError):  # what is wrong with the file is said when it is read
            return word, None
    return "", None


def _owners() -> dict[str, list[str]]:
    """The scenes that have an option."""
    found: dict[str, list[str]] = {}
    for scene in SCENES.values():
        for item in fields(scene):
            for flag in _flags(item.name, quantity_of(item)):
                found.setdefault(flag, []).append(scene.name)
    return found


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _flags(name: str, known: Quantity) -> list[str]:
    """The names of a parameter on the command line, the first for people."""
    return [_flag(one) for one in (known.option, name) if one]


def _add(group: Any, flags: Sequence[str], name: str, known: Quantity, default: Any) -> None:
    """The option of a parameter, with unit and default."""
    word = (
        ("yes" if default else "no") if known.kind is bool else f"{default:g}" if isinstance(default, float) else str(default)
    )
    notes = [known.meaning, f"({known.allowed})" if known.choices else "", f"[{known.unit}]" if known.unit else "",
             "" if default is None else f"(default {word})"]  # fmt: skip
    common: dict[str, Any] = {"default": argparse.SUPPRESS, "help": " ".join(filter(None, notes)).replace("%", "%%")}
    if known.kind is not bool:
        group.add_argument(*flags, dest=name, type=KINDS[known.kind], metavar=known.symbol or name.upper(),
                           choices=known.choices or None, **common)  # fmt: skip
        return
    try:
        group.add_argument(*flags, dest=name, action=argparse.BooleanOptionalAction, **common)
    except argparse.ArgumentError:  # the command has an option of this name: a switch that is on can be put off
        group.add_argument(_flag(f"no-{name}"), dest=name, action="store_false", **common)


def scene_of(arguments: argparse.Namespace) -> Scene:
    """The scene that the command line describes; what has no effect in it is said."""
    names = {item.name for scene in SCENES.values() for item in fields(scene)}
    given = {name: getattr(arguments, name) for name in names if hasattr(arguments, name)}
    scene = scene_named(arguments.scene, given)
    for name, reason in scene.without_effect().items():
        if name in given:
            print(f"note: {_flag(name)} has no effect: {reason}", file=sys.stderr)
    return scene
