"""The scenes by name, and their TOML form."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from workflow.errors import InputError
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.quantity import unknown_name

Packed = Method1 | Method2  # the scenes that assemble a packing
Scene = Method1 | Method2 | Heap
SCENES: dict[str, type[Scene]] = {Method1.name: Method1, Method2.name: Method2, Heap.name: Heap}


def scene_from(values: Mapping[str, Any]) -> Scene:
    """The scene that ``values`` describe; key ``scene`` names it, the others are its parameters."""
    rest = dict(values)
    name = rest.pop("scene", None)
    if not isinstance(name, str):
        raise InputError(f'a scene needs the key scene = "NAME" with one of: {", ".join(sorted(SCENES))}')
    if name not in SCENES:
        raise unknown_name(name, SCENES, "scene")
    return SCENES[name].from_mapping(rest)  # type: ignore[return-value]


def read_toml(path: Path, what: str = "scene file", example: str = "'wf run --help'") -> dict[str, Any]:
    """Names and values in a TOML file; InputError if it cannot be read, which says ``what`` it is and where an ``example``."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise InputError(f"{what} '{path}' cannot be read: {fault.strerror}; give the path of a TOML file") from fault
    except (ValueError, RecursionError) as fault:  # TOML, UTF-8, numbers of thousands of digits, nested without end
        raise InputError(f"{what} '{path}' is not TOML: {fault}; see {example} for an example") from fault


def to_toml(scene: Scene) -> str:
    """The TOML text that repeats the scene."""
    return tomli_w.dumps({"scene": scene.name, **scene.as_mapping()})
