"""The JSON Schema says of a value what the declaration of the parameter says, for every scene."""

from __future__ import annotations

import json
import math
from dataclasses import fields
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from workflow.errors import InputError
from workflow.scene.parameter import Quantity, quantity_of
from workflow.scene.registry import SCENES, scene_from
from workflow.scene.schema import schema, value_schema

QUANTITIES = [(scene.name, item.name, quantity_of(item)) for scene in SCENES.values() for item in fields(scene)]
# what TOML can hold; NaN is no value of JSON, and infinity is only of numbers without an upper bound
VALUES = st.one_of(st.booleans(), st.integers(-(10**7), 10**7), st.floats(allow_nan=False), st.text(max_size=5),
                   st.lists(st.integers(), max_size=2))  # fmt: skip


def allowed(known: Quantity, value: Any) -> bool:
    try:
        known.check("it", value)
    except InputError:
        return False
    return True


def near(known: Quantity) -> st.SearchStrategy[Any]:
    """Values at the bounds and beside them, choices, and anything else."""
    edges = [bound for bound in (known.low, known.high, known.above) if math.isfinite(bound)]
    beside = [value for edge in edges for value in (edge, math.nextafter(edge, math.inf), math.nextafter(edge, -math.inf))]
    return st.one_of(st.sampled_from([*beside, *map(int, edges), *known.choices, 0, 1.5]), VALUES)


@pytest.mark.parametrize("whole", [schema(), schema(study=True), *map(schema, sorted(SCENES))])
def test_a_schema_is_one_of_draft_2020_12(whole: dict[str, Any]) -> None:
    Draft202012Validator.check_schema(whole)
    json.dumps(whole, allow_nan=False)  # JSON knows no infinity


@given(st.data())
def test_a_value_is_valid_exactly_where_its_declaration_allows_it(data: st.DataObject) -> None:
    scene, name, known = data.draw(st.sampled_from(QUANTITIES))
    value = data.draw(near(known))
    assert Draft202012Validator(value_schema(known)).is_valid(value) == allowed(known, value), (scene, name, value)


@pytest.mark.parametrize("name", sorted(SCENES))
def test_a_file_of_a_scene_is_valid_and_its_defaults_are_those_of_the_scene(name: str) -> None:
    values = scene_from({"scene": name}).as_mapping()
    for whole in (schema(), schema(name)):
        Draft202012Validator(whole).validate({"scene": name, **values})
    known = schema(name)["properties"]
    stated = {key: known[key]["default"] for key in values if "default" in known[key]}
    assert stated == {key: values[key] for key in stated}


@pytest.mark.parametrize(("file", "wrong"), [
    ({"scene": "method1", "phi": 0.3}, "phi"), ({"scene": "method3"}, "method3"), ({"phi0": 0.3}, "scene"),
    ({"scene": "method1", "phi0": 0.7}, "0.7"), ({"scene": "heap", "phi0": 0.3}, "phi0"),
])  # fmt: skip
def test_a_wrong_file_is_refused_and_the_fault_named(file: dict[str, Any], wrong: str) -> None:
    assert [wrong in fault.message for fault in Draft202012Validator(schema()).iter_errors(file)] == [True]


STUDY = {"scene": "method1", "seeds": 4, "fixed": {"cohesion": False}, "grid": {"mu": [0.15, 0.5]}}


def test_a_study_is_valid_and_its_faults_are_found() -> None:
    validator = Draft202012Validator(schema(study=True))
    validator.validate(STUDY)
    validator.validate({**STUDY, "seeds": [1, 7], "grid": [{"mu": [0.1]}, {"phi0": [0.3, 0.4]}]})
    for wrong in ({"seeds": 0}, {"fixed": {"mu": -1.0}}, {"grid": {"mu": 0.5}}, {"grid": {"mu": [-1.0]}}, {"grids": {}}):
        assert not validator.is_valid({**STUDY, **wrong}), wrong
