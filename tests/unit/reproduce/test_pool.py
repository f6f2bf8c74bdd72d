"""Samples of several scoreboards together, on hand-made lines."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from workflow.errors import InputError
from workflow.reproduce.papers import Case, Printed
from workflow.reproduce.pool import Earlier, pool, read_earlier
from workflow.reproduce.scoreboard import NO_SAMPLE, Ours, judge

CASE = Case(("4", "row", "column"), {"scene": "method2"}, ((60, 4),), {}, "n", None)
Z = Printed(CASE, "z", "coordination", 3.0, 0.1)
FIT = Printed(CASE, "d_F", "density.fit.dimension", 1.5, 0.1)
WANTED = {"a": 1, "b": 2, "c": 3, "d": 4}


def written(folder: Path, *lines: tuple[Printed, Ours], without: tuple[str, ...] = ()) -> Earlier:
    """A scoreboard with these lines, read from its file; ``without`` columns that an older version did not write."""
    numbers: list[dict[str, Any]] = [asdict(judge(*line)) for line in lines]
    for number in numbers:
        for name in without:
            del number[name]
    path = folder / "scoreboard.json"
    path.write_text(json.dumps({"numbers": numbers, "figures": [], "provenance": {"command": "wf"}}))
    return read_earlier(path)


def test_samples_are_counted_once(tmp_path: Path) -> None:
    """1, 2 here and 2, 3, 6 there, of which 2 is the same sample: mean 3, standard error sqrt(14/3)/2."""
    here = Ours(1.5, 0.5, 2, 4, 2, "1 2", "a b", "1.0 2.0")
    there = Ours(11.0 / 3.0, 1.2, 3, 4, 3, "2 3 4", "b c d", "2.0 3.0 6.0")
    found = pool(here, Z, WANTED, [written(tmp_path, (Z, there))])
    assert found.value == 3.0
    assert found.error == pytest.approx(math.sqrt(14.0 / 3.0) / 2.0, rel=1e-14)
    assert (found.samples, found.wanted, found.at_rest, found.pooled) == (4, 4, 4, 2)
    assert (found.seeds, found.digests, found.values) == ("1 2 3 4", "a b c d", "1.0 2.0 3.0 6.0")


def test_one_sample_of_an_older_version_is_known_by_its_mean(tmp_path: Path) -> None:
    """A0 of the paper: seed 1 on one machine, seed 2 on another."""
    here = Ours(3.1, None, 1, 2, 1, "2", "b", "3.1")
    old = written(tmp_path, (Z, Ours(3.3, None, 1, 2, 1, "1", "a")), without=("pooled", "values"))
    found = pool(here, Z, WANTED, [old])
    assert found.value == pytest.approx(3.2, rel=1e-15)
    assert found.error == pytest.approx(0.1, rel=1e-12)
    assert found.values == "3.3 3.1"


def test_without_single_values_the_line_with_more_samples_stands(tmp_path: Path) -> None:
    old = written(tmp_path, (Z, Ours(3.3, 0.2, 3, 4, 3, "1 2 3", "a b c")), without=("pooled", "values"))
    few = Ours(3.1, 0.1, 2, 4, 2, "3 4", "c d", "3.0 3.2")
    found = pool(few, Z, WANTED, [old])
    assert (found.value, found.error, found.samples, found.pooled, found.digests) == (3.3, 0.2, 3, 3, "a b c")
    as_many = Ours(3.1, 0.1, 3, 4, 3, "2 3 4", "b c d", "3.0 3.1 3.2")
    assert pool(as_many, Z, WANTED, [old]) is as_many


def test_a_fit_is_not_averaged(tmp_path: Path) -> None:
    old = written(tmp_path, (FIT, Ours(1.6, 0.1, 1, 4, 1, "1", "a")))
    here = Ours(1.4, 0.1, 1, 4, 1, "2", "b")
    assert pool(here, FIT, WANTED, [old]) is here
    assert pool(Ours(wanted=4), FIT, WANTED, [old]).value == 1.6


def test_who_is_not_at_rest_is_not_forgotten(tmp_path: Path) -> None:
    """Two of three are at rest, which two is not known: the line is taken as a whole or not at all."""
    there = written(tmp_path, (Z, Ours(2.0, 0.5, 3, 4, 2, "1 2 3", "a b c", "1.0 2.0 3.0")))
    here = Ours(6.0, None, 1, 4, 1, "4", "d", "6.0")
    found = pool(here, Z, WANTED, [there])
    assert (found.samples, found.at_rest, found.digests) == (3, 2, "a b c")


def test_samples_of_other_scenes_are_left(tmp_path: Path) -> None:
    there = written(tmp_path, (Z, Ours(2.0, 0.5, 2, 4, 2, "1 2", "a other", "1.0 3.0")))
    nothing = Ours(wanted=4, trouble="no sample is finished")
    assert pool(nothing, Z, WANTED, [there]) is nothing
    other = Printed(Case(("5", "row", "column"), {}, (), {}, "n", None), "z", "coordination", 3.0)
    assert pool(nothing, other, WANTED, [there]) is nothing


def test_samples_that_do_not_give_the_number(tmp_path: Path) -> None:
    """They are elsewhere and finished: that is the reason, not that none is finished here."""
    there = written(tmp_path, (FIT, Ours(wanted=4, trouble="the samples do not give it")))
    assert pool(Ours(wanted=4, trouble=NO_SAMPLE), FIT, WANTED, [there]).trouble == "the samples do not give it"
    smaller = Ours(wanted=1, trouble=NO_SAMPLE)
    assert pool(smaller, FIT, WANTED, [there]) is smaller
    known = Ours(1.6, 0.1, 1, 4, 1, "1", "a")
    assert pool(known, FIT, WANTED, [there]) is known


def test_lines_that_contradict_themselves(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the samples of 'z' in table 4 are not 3"):
        written(tmp_path, (Z, Ours(2.0, 0.5, 3, 4, 3, "1 2", "a b")))
    with pytest.raises(InputError, match="could not convert"):
        written(tmp_path, (Z, Ours(2.0, None, 1, 4, 1, "1", "a", "much")))
