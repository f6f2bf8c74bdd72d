"""A scene declares by names what the floors above do with it: every name is registered, and nobody asks for its class."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import workflow
from workflow.pipeline.kinds import KINDS
from workflow.reports.registry import figures_of
from workflow.reports.summary import SUMMARIES
from workflow.reports.views import VIEWS
from workflow.scene.base import Scene, Units
from workflow.scene.registry import SCENES

PACKAGE = Path(workflow.__file__).parent
QUESTIONS = ("isinstance", "issubclass", "type")


def classes(cls: type[Scene] = Scene) -> Iterator[str]:
    """Names of the interface and of the package's classes below it."""
    yield cls.__name__
    for below in cls.__subclasses__():
        if below.__module__.startswith("workflow.scene."):
            yield from classes(below)


def asked(text: str, names: set[str]) -> list[int]:
    """Lines of ``text`` that tell scenes apart by their class, or by their name or kind."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in QUESTIONS:
            words = {part.id for argument in node.args[1:] for part in ast.walk(argument) if isinstance(part, ast.Name)}
            found += [node.lineno] if words & names else []
        if isinstance(node, ast.Compare):
            sides = [ast.unparse(side) for side in (node.left, *node.comparators)]
            word = any(isinstance(side, ast.Constant) for side in (node.left, *node.comparators))
            found += [node.lineno] if word and any(side.endswith(("scene.kind", "scene.name")) for side in sides) else []
    return found


def test_nobody_outside_asks_for_the_class_of_a_scene() -> None:
    names = set(classes())
    assert {"Scene", "Packing", "Method2", "Heap"} <= names
    files = [path for path in sorted(PACKAGE.rglob("*.py")) if "scene" not in path.relative_to(PACKAGE).parts[:1]]
    assert len(files) > 100
    broken = [f"{path.relative_to(PACKAGE)}:{line}" for path in files for line in asked(path.read_text("utf-8"), names)]
    assert broken == []


@pytest.mark.parametrize(
    "line",
    ["isinstance(scene, Heap)", "isinstance(scene, (Method1, Heap))", "issubclass(cls, Heap)", "run.scene.kind == 'heap'"],
)
def test_the_check_finds_what_it_looks_for(line: str) -> None:
    assert asked(f"if {line}:\n    pass\n", {"Heap"}) == [1]


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_what_a_scene_declares_is_registered(scene: type[Scene]) -> None:
    assert scene.kind in KINDS and scene.kind in SUMMARIES and scene.kind in VIEWS
    assert figures_of(scene.figures)
    assert scene.name and scene.title and scene.stages


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_defaults_of_every_scene_make_sentences_and_a_deck(scene: type[Scene]) -> None:
    one: Any = scene(n=60) if "n" in scene.__dataclass_fields__ else scene(grains=60)
    assert one.size == 60 and one.sample == "seed 1, N = 60"
    assert isinstance(one.units, Units) and one.force_unit > 0 and 0 < one.tolerance < 1
    clock = "sqrt(sigma/g)" if scene.name == "heap" else "T0"
    assert one.notes()[0] == f"step {one.step_choice.step:.3g} {clock}: {one.step_choice.reason}"
    stages = list(one.stages.values())
    assert all(one.alike(stage, stage) for stage in stages)
    assert (one.law_of(stages[-1]) is None) == (one.kind == "heap")


class Bare(Scene):
    """A scene that gives nothing but what it must."""

    name, stages = "bare", {1: "fly"}

    @property
    def size(self) -> int:
        return 3


def test_a_scene_that_declares_nothing_has_the_defaults() -> None:
    bare = Bare()
    assert bare.sample == "N = 3" and bare.files() == {} and bare.left_out() == [] and bare.record() == {}
    assert bare.law_of("fly") is None and bare.pressure_of("fly") is None and not bare.alike("start", "fly")
    assert bare.progress_line({"stage": [1.0], "time": [2.0]}) == "fly 1/1  t 2.00"  # type: ignore[dict-item]
    one, other = bare.random("places"), bare.random("sizes")
    assert one.integers(1 << 60) != other.integers(1 << 60)


def test_two_stages_of_a_packing_are_alike_if_law_and_load_are() -> None:
    scene = SCENES["method2"](n=60, series="B")
    assert scene.alike("aggregate", "relax")  # a fixed cell and a free one bear the same load: none
    assert not scene.alike("free", "stiffen")  # the stiffness changes
    assert not scene.alike("stiffen", "load")
    assert scene.alike("load", "settle")
