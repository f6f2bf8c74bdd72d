"""Rendering: the template verbatim but for the values of its index variables."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workflow.deck import template as render_module
from workflow.deck.template import data_file, data_parts, fill, render, templates, whole
from workflow.errors import InputError
from workflow.scene.consolidation import Consolidation
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.registry import Scene

TEMPLATE = """# variable kn index 7 is only a comment
variable kn    index 1.0e5
variable   data index data/discs.data
variable restart index none
variable stage index 1
variable phi equal ${kn}*2
print "variable kn index 3"
run ${kn}
"""
REFERENCE = Path(__file__).with_name("method1_variables.txt")


def declared(deck: str) -> dict[str, str]:
    """Index variables of a deck with their first values (a later one does not count, as for `lmp`)."""
    words = [line.split() for line in deck.splitlines() if line.startswith("variable ")]
    return {word[1]: word[3] for word in reversed(words) if word[2] == "index" and len(word) == 4}


def test_fill_replaces_exactly_the_index_variables() -> None:
    text = fill(TEMPLATE, {"kn": 0.1, "data": "grains.data"})
    expected = TEMPLATE.replace("index 1.0e5", "index 0.1").replace("data/discs.data", "grains.data")
    assert text == expected


def test_value_equal_to_the_default_changes_nothing() -> None:
    assert fill(TEMPLATE, {"kn": "1.0e5", "data": "data/discs.data"}) == TEMPLATE


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kn": 1.0}, ["no value for ['data']"]),
        ({"kn": 1.0, "data": "x", "mu": 0.5}, ["no variable for ['mu']"]),
        ({"phi": 1.0, "kn": 1.0, "data": "x"}, ["no variable for ['phi']"]),
    ],
)
def test_template_and_scene_must_agree(values: dict[str, str | float], words: list[str]) -> None:
    with pytest.raises(InputError) as fault:
        fill(TEMPLATE, values)
    for word in words:
        assert word in str(fault.value)


@pytest.mark.parametrize(
    "value", ["two words", "it's", 'say "x"', "", "$x", "${kn}", "a;b", "a&", "a#b", "a\nrun 5", "tab\tx", "*", "é é"]
)
def test_values_that_the_input_language_would_take_apart_are_refused(value: str) -> None:
    with pytest.raises(InputError, match="'data'"):
        fill(TEMPLATE, {"kn": 1.0, "data": value})


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers())
def test_numbers_keep_their_last_bit(number: float, whole: int) -> None:
    assert float(declared(fill(TEMPLATE, {"kn": number, "data": "x"}))["kn"]) == number
    assert int(declared(fill(TEMPLATE, {"kn": whole, "data": "x"}))["kn"]) == whole


def test_every_variable_of_the_scene_appears_with_its_value() -> None:
    scene = Method1(mu=0.123456789012345678, kappa=12345.678, d0=1 / 300, seed=7)
    shown = declared(render(scene))
    for name, value in scene.variables().items():
        assert shown[name] == value if isinstance(value, str) else float(shown[name]) == value, name
    assert shown["data"] == "grains.data"
    assert (shown["restart"], shown["stage"]) == ("none", "1")
    assert set(shown) == {*scene.variables(), "data", "resume", "restart", "stage"}


@pytest.mark.parametrize("scene", [Method1(), Method2(n=50)], ids=lambda scene: scene.name)
def test_rest_of_the_deck_is_the_template(scene: Scene) -> None:
    template = whole(templates() / f"{scene.name}.in").splitlines()
    deck = render(scene).splitlines()
    assert not [line for line in deck if line.startswith("include ")]
    assert len(deck) == len(template)
    changed = [old for old, new in zip(template, deck, strict=True) if old != new]
    for line in changed:
        assert re.match(r"variable\s+\w+\s+index\s", line)


def test_values_are_those_of_the_stored_reference() -> None:
    """What runs today runs tomorrow: a scene's numbers change only on purpose (then store the new ones)."""
    shown = declared(render(Method1(n=60, cohesion=False, mu=0.15, kappa=1e3)))
    stored = dict(line.split() for line in REFERENCE.read_text().splitlines())
    assert set(shown) == set(stored)
    for name, value in stored.items():
        try:
            # derived numbers pass through sqrt and pi of the platform's libm
            assert float(shown[name]) == pytest.approx(float(value), rel=1e-14), name
        except ValueError:
            assert shown[name] == value


def test_rendering_is_a_pure_function(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert render(Method1(seed=3)) == render(Method1(seed=3))
    assert not list(tmp_path.iterdir())


def test_data_file_holds_every_disc_to_the_last_bit() -> None:
    discs = Method1(n=50).discs()
    head, rows = data_file(discs).split("Atoms # sphere\n\n")
    table = np.array([line.split() for line in rows.splitlines()], dtype=float)
    assert table[:, 0].tolist() == list(range(1, 51))
    assert np.array_equal(table[:, 2], discs.diameter)
    assert np.array_equal(table[:, 4:6], discs.position)
    assert "50 atoms" in head
    bounds = {line.split()[2]: [float(word) for word in line.split()[:2]] for line in head.splitlines() if line.endswith("hi")}
    assert bounds["xlo"] == [0.0, discs.cell[0]]
    assert bounds["ylo"] == [0.0, discs.cell[1]]
    assert bounds["zlo"][0] < 0.0 < bounds["zlo"][1]


def test_data_file_holds_every_velocity_to_the_last_bit() -> None:
    discs = Method2(n=50).discs()
    _, rows = data_file(discs).split("Velocities\n\n")
    table = np.array([line.split() for line in rows.splitlines()], dtype=float)
    assert table[:, 0].tolist() == list(range(1, 51))
    assert discs.velocity is not None
    assert np.array_equal(table[:, 1:3], discs.velocity)
    assert not table[:, 3:].any()


def test_included_text_stands_where_it_was_asked_for(tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "common" / "part.in").write_text("run 1\nrun 2\n")
    (tmp_path / "deck.in").write_text("units lj\ninclude common/part.in\n# include common/part.in\ninclude other.in\n")
    assert whole(tmp_path / "deck.in") == "units lj\nrun 1\nrun 2\n# include common/part.in\ninclude other.in\n"


LAW = "common/law_cohesive.in"


def test_the_law_is_the_file_that_its_variable_names(tmp_path: Path) -> None:
    """A value of the scene, else the default; beside the template, else in the package; a path as it is."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "law.in").write_text("pair_style mine\n")
    (tmp_path / "deck.in").write_text("variable law index mine/law.in\ninclude ${law}\nrun 1\n")
    packaged = (templates() / LAW).read_text()
    for values, text in (
        ({}, "pair_style mine\n"),
        ({"law": LAW}, packaged),
        ({"law": tmp_path / "mine" / "law.in"}, "pair_style mine\n"),
    ):
        assert whole(tmp_path / "deck.in", values) == f"variable law index mine/law.in\n{text}run 1\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("include ${law}\n", "includes \\$\\{law\\} and has no such variable; declare it in its head"),
        ("variable law index common/law_typo.in\ninclude ${law}\n", "law_typo.in' cannot be read"),
        ("include method3/load.in\n", "method3/load.in' cannot be read"),
    ],
)
def test_an_include_that_names_no_file_is_an_error(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "deck.in").write_text(text)
    with pytest.raises(InputError, match=words):
        whole(tmp_path / "deck.in")


@pytest.mark.parametrize(
    "scene", [Method1(), Method2(n=50), Consolidation(n=50), Heap(grains=20)], ids=lambda scene: scene.name
)
def test_labels_of_a_deck_are_there_once_and_every_jump_finds_its_own(scene: Scene) -> None:
    """The stages are put into one file, in which LAMMPS jumps to the first label of a name."""
    deck = render(scene)
    labels = re.findall(r"^label (\w+)", deck, re.MULTILINE)
    assert len(labels) == len(set(labels))
    assert set(re.findall(r"jump SELF (\w+)", deck)) == set(labels)


def test_parts_of_a_data_file_are_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the size of the parts, the text is one and the same."""
    scene = Method2(n=50)
    whole_text = data_file(scene.discs())
    for rows in (1, 7, 50, 51):
        monkeypatch.setattr(render_module, "ROWS", rows)
        parts = list(data_parts(scene.discs()))
        assert "".join(parts) == whole_text
        assert len(parts) == 2 + 2 * -(-50 // rows)
