"""The parser of every command: whole option names only, a suggestion for a misspelt one, one sentence for what is wrong."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from workflow.errors import InputError, did_you_mean

REWORDED = (  # what argparse says, and what is said here
    (r"argument ([^:]+): invalid (.+) value: '(.*)'", r"\1 '\3' is not allowed: it must be a \2"),
    (r"argument ([^:]+): expected (?:one argument|at least one argument)", r"\1 needs a value"),
    (r"argument ([^:]+): expected (\d+) arguments", r"\1 needs \2 values"),
    (r"argument ([^:]+): ignored explicit argument '(.*)'", r"\1 takes no value, found '\2'"),
    (r"the following arguments are required: (.*)", r"\1 is missing"),
    (r"argument ([^:]+): (\S.* is not a whole number)", r"\1: \2"),
)


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are InputError.

    ``prepare`` is called once with the words of the command line before they are parsed, to add options that depend on them;
    ``subject``: words of the command line that its help needs, such as a scene; ``elsewhere``: options that it has not, and
    who has them.
    """

    prepare: Callable[[Sequence[str]], None] | None = None
    subject: str = ""
    elsewhere: dict[str, str]

    def __init__(self, *args: Any, **known: Any) -> None:
        super().__init__(*args, **known | {"allow_abbrev": False})
        self.elsewhere = {}
        self.words: list[str] = []

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse; words that no option and no argument takes are an error here, where the options are known."""
        self.words = words = list(args or [])
        if self.prepare:
            prepare, self.prepare = self.prepare, None
            prepare(words)
        found, rest = super().parse_known_args(words, namespace)
        if rest:
            option = self._misspelt(rest)
            self.error(self._unknown(option) if option else f"'{rest[0]}' is one word too many")
        return found, []

    def _misspelt(self, words: Sequence[str]) -> str | None:
        """The first of ``words`` that looks like an option and is none."""
        known = {flag for action in self._actions for flag in action.option_strings}
        options = (word.partition("=")[0] for word in words if word.startswith("--") and word != "--")
        return next((option for option in options if option not in known), None)

    def arguments(self) -> list[argparse.Action]:
        """The options and arguments so far."""
        return list(self._actions)

    def commands(self) -> list[Parser]:
        """The parsers of its commands."""
        return [one for action in self._actions if isinstance(action.choices, dict) for one in action.choices.values()]

    def switches(self) -> set[str]:
        """The options that take no value."""
        return {flag for action in self._actions if action.nargs == 0 for flag in action.option_strings}

    def error(self, message: str) -> NoReturn:
        """Raise InputError with a sentence that ends in where the way out is shown."""
        option = self._misspelt(self.words) if "arguments are required" in message else None
        message = self._unknown(option) if option else message
        for theirs, ours in REWORDED:
            message = re.sub(f"^{theirs}$", ours, message)
        choice = re.fullmatch(r"argument ([^:]+): invalid choice: '?(.*?)'? \(choose from (.*)\)", message)
        if choice:
            known = choice[3].replace("'", "").split(", ")
            message = f"{choice[1]} '{choice[2]}' is not known; {did_you_mean(choice[2], known)}known are: {', '.join(known)}"
        raise InputError(f"{message}; '{' '.join(filter(None, (self.prog, self.subject)))} --help' shows what is allowed")

    def _unknown(self, option: str) -> str:
        """Words on an option that this command has not, with the nearest that it has."""
        if option in self.elsewhere:
            return f"{option} {self.elsewhere[option]}"
        known = [flag for action in self._actions for flag in action.option_strings]
        return f"unknown option {option}: {did_you_mean(option.replace('_', '-'), known, 2)}".rstrip(": ")


def number(text: str) -> float:
    """A number of an option."""
    return float(text)


number.__name__ = "number"
