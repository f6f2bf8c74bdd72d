"""Reference pages made from the code: Python, commands, scenes, decks, styles of the plugin, sources of the examples."""

from __future__ import annotations

import argparse
import inspect
import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from repository import ROOT

import workflow
from workflow import errors
from workflow.cli.main import parser
from workflow.data.frame import Interactions
from workflow.scene.parameter import Quantity, quantity_of
from workflow.scene.registry import SCENES

LANGUAGES = {".py": "python", ".sh": "sh", ".toml": "toml", ".cpp": "cpp", ".h": "cpp", ".in": "text"}


def generated_pages() -> dict[str, str]:
    """Path on the site -> Markdown."""
    pages = {
        "reference/python.md": python(),
        "reference/cli.md": cli(),
        "reference/scenes.md": scenes(),
        "reference/decks.md": decks(),
        "reference/styles.md": styles(),
    }
    for folder in sorted((ROOT / "examples").glob("[0-9][0-9]_*")):
        pages[f"examples/{folder.name}/README.md"] = sources(folder)
    return pages


def _cell(text: Any) -> str:
    """Text in a cell of a table: of the marks of Markdown only those of code act."""
    parts = re.split(r"(`[^`]*`)", " ".join(str(text).split()))
    return "".join(re.sub(r"([|])" if k % 2 else r"([|*_<>\[\]`])", r"\\\1", part) for k, part in enumerate(parts))


def _table(head: str, rows: Iterator[str]) -> str:
    return "\n".join([head, "|---" * (head.count("|") - 1) + "|", *rows])


# ---- Python
MEMBERS: dict[type, tuple[str, ...]] = {
    workflow.Run: ("scene", "status", "archive", "frames", "series", "measures", "plot", "report"),
    workflow.Frame: ("grains", "area", "to_pandas", "select"),
    Interactions: ("normal_force", "distance", "normal", "force", "in_contact", "to_pandas", "select"),
    workflow.ContactLaw: (),
}


def python() -> str:
    """Every public name with its signature and docstring."""
    functions = [name for name in workflow.__all__ if inspect.isfunction(getattr(workflow, name))]
    parts = ["# Python, every name", "Made from the docstrings of the package. What is not here is internal and changes "
             "without notice. The parameters of scenes are listed under [scenes](scenes.md).", "## Functions"]  # fmt: skip
    parts += [_documented(f"workflow.{name}", getattr(workflow, name), 3) for name in functions]
    parts.append("## What they give and take")
    for kind, members in MEMBERS.items():
        parts.append(_documented(kind.__name__, kind, 3))
        parts += [_documented(f"{kind.__name__}.{name}", inspect.getattr_static(kind, name), 4) for name in members]
    parts.append("## Errors")
    parts += [_documented(name, kind, 3) for name, kind in vars(errors).items() if inspect.isclass(kind)]
    return "\n\n".join(parts) + "\n"


def _documented(name: str, thing: Any, level: int) -> str:
    """Heading, signature and docstring; the docstring is Markdown but for its stars."""
    text = re.sub(r"(?<!^)(?<!\n)\*", r"\\*", inspect.getdoc(thing) or "").replace("``", "`")
    if isinstance(thing, property):
        call = f"{name}: {inspect.signature(thing.fget).return_annotation}"  # type: ignore[arg-type]
    else:
        call = f"{name}{_call(thing)}" if inspect.isfunction(thing) else f"class {name}"
    return f"{'#' * level} {name}\n\n```python\n{call}\n```\n\n{text}"


def _call(function: Any) -> str:
    """The parameters with annotations and defaults, a line each where they do not fit one."""
    found = inspect.signature(function)
    parts, positional = [], True
    for one in found.parameters.values():
        if one.kind is one.KEYWORD_ONLY and positional:
            parts, positional = [*parts, "*"], False
        annotation = "" if one.annotation is one.empty else f": {one.annotation}"
        default = "" if one.default is one.empty else f" = {one.default!r}"
        if one.name != "self":
            parts.append(f"{'**' if one.kind is one.VAR_KEYWORD else ''}{one.name}{annotation}{default}")
    line = ", ".join(parts)
    if len(line) > 80:
        line = "".join(f"\n    {part}," for part in parts) + "\n"
    return f"({line}) -> {found.return_annotation}"


# ---- commands
def cli() -> str:
    """Every command with its options, from the parsers that read them."""
    top = parser()
    commands = next(action for action in top._actions if isinstance(action, argparse._SubParsersAction))
    parts = [
        "# Commands",
        "Made from the parsers of `wf`. `wf COMMAND --help` prints the same. The parameters of scenes, which are options of "
        "`wf run` and `wf deck`, are listed under [scenes](scenes.md).",
        _table(
            "| command | what it does |",
            (f"| [`wf {listed.dest}`](#wf-{listed.dest}) | {_cell(listed.help)} |" for listed in commands._choices_actions),
        ),
    ]
    parts += [_command(listed.dest, commands.choices[listed.dest]) for listed in commands._choices_actions]
    return "\n\n".join(parts) + "\n"


def _command(name: str, command: argparse.ArgumentParser) -> str:
    usage = command.format_usage().removeprefix("usage: ").strip()
    parts = [f"## wf {name}", (command.description or "").replace("%%", "%"), f"```text\n{usage}\n```"]
    for group in command._action_groups:
        rows = [
            f"| {_flags(action)} | {_cell(_help(action))} |"
            for action in group._group_actions
            if action.help != argparse.SUPPRESS and not isinstance(action, argparse._HelpAction)
        ]
        if rows:
            parts += [f"**{(group.title or 'options').capitalize()}**", _table("| option | meaning |", iter(rows))]
    if command.epilog:
        parts += [
            "**Examples**",
            "```text\n" + re.sub(r"^  ", "", command.epilog.removeprefix("examples:\n"), flags=re.MULTILINE) + "\n```",
        ]
    return "\n\n".join(part for part in parts if part)


def _flags(action: argparse.Action) -> str:
    value = action.metavar or (action.dest.upper() if action.nargs != 0 and action.option_strings else action.dest)
    value = " ".join(value) if isinstance(value, tuple) else value
    if not action.option_strings:
        return f"`{value}`"
    return ", ".join(f"`{flag}`" if action.nargs == 0 else f"`{flag} {value}`" for flag in action.option_strings)


def _help(action: argparse.Action) -> str:
    text = (action.help or "").replace("%%", "%")
    return text.replace("%(default)s", str(action.default))


# ---- scenes
def scenes() -> str:
    """Every parameter of every scene, from the classes that check them."""
    parts = [
        "# Scenes and their parameters",
        "A parameter is a field of the scene in Python, `wf.Method1(mu=0.3)`, a name in a scene file, `mu = 0.3`, and "
        "an option of `wf run`, `--mu 0.3`. *auto* stands for a value that follows from the others.",
    ]
    for scene in SCENES.values():
        rows = (
            f"| `{item.name}` | {_default(quantity_of(item), item.default)} | {_cell(quantity_of(item).unit)} | "
            f"{_cell(quantity_of(item).meaning)} | {_cell(quantity_of(item).allowed)} | {_cell(quantity_of(item).source)} |"
            for item in fields(scene)
        )
        parts += [
            f"## {scene.name}",
            f"{scene.title[0].upper()}{scene.title[1:]}. Stages: {', '.join(scene().stages.values())}.",
            _table("| parameter | default | unit | meaning | allowed | source |", rows),
        ]
    return "\n\n".join(parts) + "\n"


def _default(known: Quantity, value: Any) -> str:
    return "*auto*" if value is None else f"`{str(value).lower() if known.kind is bool else value}`"


# ---- decks
def decks() -> str:
    """Head, variables and text of every deck, from the files."""
    parts = [
        "# Decks, as they are",
        "The files of `lammps_inputs/`. Meanings and units of their variables: [decks](../lammps_inputs/README.md).",
    ]
    for path in sorted((ROOT / "lammps_inputs").rglob("*.in")):
        text = path.read_text(encoding="utf-8")
        values = re.findall(r"^variable\s+(\w+)\s+index\s+(\S+)", text, re.MULTILINE)
        head = " ".join(line.lstrip("# ") for line in re.match(r"(?:#.*\n)*", text)[0].splitlines())  # type: ignore[index]
        parts += [f"## {path.relative_to(ROOT / 'lammps_inputs').as_posix()}", _cell(head)]
        if values:
            parts.append(_table("| variable | default |", (f"| `{name}` | `{value}` |" for name, value in values)))
        parts.append(f"<details><summary>the file</summary>\n\n```text\n{text.rstrip()}\n```\n\n</details>")
    return "\n\n".join(part for part in parts if part) + "\n"


# ---- plugin
USAGE = re.compile(r"/\* ((?:pair_style|fix|run_style) (?:ID \S+ )?(disc/\w+|verlet/disc).*?)\*/", re.DOTALL)


def styles() -> str:
    """The comment above the class of every style, from the headers."""
    parts = ["# Styles, as their headers state them", "Syntax in full, with examples and restrictions: [plugin](../plugin.md)."]
    for header in sorted((ROOT / "plugins").glob("*.h")):
        for text, name in USAGE.findall(header.read_text(encoding="utf-8")):
            parts += [
                f"## {name}",
                f"`plugins/{header.name}`",
                f"```text\n{re.sub(r'^   ', '', text.rstrip(), flags=re.MULTILINE)}\n```",
            ]
    return "\n\n".join(parts) + "\n"


# ---- examples
def sources(folder: Path) -> str:
    """The files of an example."""
    parts = [f"# {folder.name}"]
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in LANGUAGES:
            text = path.read_text(encoding="utf-8").rstrip()
            parts.append(f"## {path.relative_to(folder).as_posix()}\n\n```{LANGUAGES[path.suffix]}\n{text}\n```")
    return "\n\n".join(parts) + "\n"
