"""Values of options that are lists, ranges or whole numbers, and the sentences about wrong ones."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from workflow.errors import InputError, did_you_mean
from workflow.scene.method1 import Method1

Item = TypeVar("Item")


def whole_number(text: str) -> int:
    """Whole numbers, also written 1e5."""
    try:
        return int(text)
    except ValueError:
        number = float(text)
        if not number.is_integer():
            raise argparse.ArgumentTypeError(f"{text} is not a whole number") from None
        return int(number)


whole_number.__name__ = "whole number"


def add_list(parser: Any, option: str, metavar: str, text: str) -> None:
    """An option that is a list, [] if it is not given: words with commas, and the option once more for more."""
    parser.add_argument(option, action="append", default=[], metavar=f"{metavar},...", help=text)


def listed(option: str, given: str | Sequence[str], read: Callable[[str, str], Item]) -> list[Item]:
    """The words of an option, between commas or blanks, each once, as ``read`` understands them."""
    words = (given if isinstance(given, str) else ",".join(given)).replace(" ", ",").split(",")
    found = list(dict.fromkeys(read(word, option) for word in words if word))
    if not found:
        raise InputError(f"{option} is empty; give at least one word, or leave it out")
    return found


def positive(word: str, option: str, least: int = 1) -> int:
    """A whole number of at least ``least``; InputError if it is none."""
    if not word.isdigit() or int(word) < least:
        raise InputError(f"{option} '{word}' is not allowed: give whole numbers of at least {least}")
    return int(word)


def grains(least: int) -> Callable[[str, str], int]:
    """A reader of numbers of grains, also written 1e5, as many as a scene can have."""

    def read(word: str, option: str) -> int:
        try:
            count = positive(str(whole_number(word)), option, least)
        except (ValueError, OverflowError, argparse.ArgumentTypeError):
            raise InputError(f"{option} '{word}' is not allowed: give whole numbers of at least {least}") from None
        Method1(n=count)  # says what no scene can have
        return count

    return read


def one_of(names: Sequence[str]) -> Callable[[str, str], str]:
    """A reader of one of ``names``."""

    def read(word: str, option: str) -> str:
        if word not in names:
            raise InputError(f"{option} '{word}' is not known; {did_you_mean(word, names)}known are: {', '.join(names)}")
        return word

    return read


def any_word(word: str, option: str) -> str:
    """A reader of words that are judged elsewhere."""
    return word


def ranged(given: Sequence[str], option: str) -> list[str] | None:
    """The names in 2..5,7: whole numbers of a range, other words as they are; None for none."""
    if not given:
        return None
    names: list[str] = []
    for part in listed(option, given, any_word):
        first, dots, last = part.partition("..")
        if not dots:
            names.append(first)
        elif first.isdigit() and last.isdigit() and int(first) <= int(last) < 1000:
            names += [str(k) for k in range(int(first), int(last) + 1)]
        else:
            raise InputError(f"{option} {part} is not allowed: write a number, a range as 2..5, or several with commas")
    return names
