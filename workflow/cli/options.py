"""What commands share: their frame, options of several, and the command line for a published page."""

from __future__ import annotations

import argparse
import shlex
import sys
import textwrap
from pathlib import Path
from typing import Any

from workflow.cli.parser import Parser


def command(commands: Any, name: str, summary: str, examples: str, *, action: Any) -> Parser:
    """A subcommand with its summary, worked examples and the function that does it."""
    parser: Parser = commands.add_parser(
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


def command_line() -> str:
    """The command as it was given, for a published page: of an absolute path the part below this folder, or its name."""

    def public(word: str) -> str:
        option, equals, value = word.rpartition("=") if word.startswith("-") else ("", "", word)
        path = Path(value)
        if not path.is_absolute():
            return word
        return option + equals + str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path.name)

    return shlex.join(["wf", *map(public, sys.argv[1:])])
