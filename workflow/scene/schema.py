"""The JSON Schema (draft 2020-12) of scene files and study files, from the declarations that check them.

A schema says of one value what its `Quantity` says: type, range, choices, default.  What relates several values, such as
the speeds that two series allow, only a scene itself knows: `wf deck --dry-run` checks a file wholly.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from workflow.scene.base import Scene
from workflow.scene.parameter import Quantity, quantity_of
from workflow.scene.registry import SCENES

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}
Schema = dict[str, Any]


def value_schema(known: Quantity, default: Any = None) -> Schema:
    """Schema of one value; its ``default`` is stated if it is not derived from the rest."""
    unit = f" [{known.unit}]" if known.unit else ""
    said = {"title": known.symbol, "description": f"{known.meaning}{unit}{f'; {known.source}' if known.source else ''}"}
    bounds = {"minimum": known.low, "maximum": known.high, "exclusiveMinimum": known.above}
    return {
        **{name: words for name, words in said.items() if words},
        "type": TYPES[known.kind],
        **{name: known.kind(bound) for name, bound in bounds.items() if math.isfinite(bound)},
        **({"enum": list(known.choices)} if known.choices else {}),
        **({} if default is None or default in (math.inf, -math.inf) else {"default": default}),
    }


def parameters(scene: type[Scene]) -> Schema:
    """Schemas of the parameters of a scene by every name that a file may use."""
    found: Schema = {}
    for item in fields(scene):
        known = quantity_of(item)
        names = (item.name, getattr(known, "option", ""))  # another name, where a parameter declares one
        found |= {name: value_schema(known, item.default) for name in names if name}
    return found


def scene_schema(scene: type[Scene]) -> Schema:
    """Schema of the files of one scene."""
    return _table({"scene": {"const": scene.name}, **parameters(scene)}, required=["scene"], title=scene.title)


def study_schema(scene: type[Scene]) -> Schema:
    """Schema of the studies of one scene (docs/sweep.md): a grid has lists of what its scene has once."""
    one = parameters(scene)
    grid = _table({name: {"type": "array", "items": value, "minItems": 1} for name, value in one.items()})
    seed = one.get("seed", {"type": "integer"})
    seeds = {"anyOf": [{"type": "integer", "minimum": 1}, {"type": "array", "items": seed, "minItems": 1}]}
    known = {"scene": {"const": scene.name}, "seeds": seeds, "fixed": _table(one),
             "grid": {"anyOf": [grid, {"type": "array", "items": grid, "minItems": 1}]}}  # fmt: skip
    return _table(known, required=["scene"], title=f"study of {scene.name}")


def of_any(schemas: Mapping[str, Schema]) -> Schema:
    """Schema of a file of whichever scene it names: an editor then shows the parameters of this one."""
    chosen = [
        {"if": {"properties": {"scene": {"const": name}}, "required": ["scene"]}, "then": {"$ref": f"#/$defs/{name}"}}
        for name in schemas
    ]
    named = {"scene": {"enum": sorted(schemas), "description": "name of the scene"}}
    return {"$schema": DIALECT, "type": "object", "properties": named, "required": ["scene"], "allOf": chosen,
            "$defs": dict(schemas)}  # fmt: skip


def schema(name: str | None = None, *, study: bool = False) -> Schema:
    """Schema of the files of the scene ``name``, of every known scene if None; of their studies if ``study``."""
    of = study_schema if study else scene_schema
    if name is not None:
        return {"$schema": DIALECT, **of(SCENES[name])}
    return of_any({name: of(scene) for name, scene in sorted(SCENES.items())})


def _table(properties: Schema, **more: Any) -> Schema:
    return {**more, "type": "object", "properties": properties, "additionalProperties": False}
