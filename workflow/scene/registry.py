"""The scenes by name, those of other people's files among them, and their TOML form."""

from __future__ import annotations

import math
import os
import re
import sys
import tomllib
from collections.abc import Mapping
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import tomli_w

from workflow.data.files import read_plain
from workflow.errors import InputError
from workflow.scene.base import Scene
from workflow.scene.consolidation import Consolidation
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.packing import Packing
from workflow.scene.parameter import unknown_name

SCENES: dict[str, type[Scene]] = {cls.name: cls for cls in (Method1, Method2, Consolidation, Heap)}
LONGEST, DEEPEST = 1_000_000, 50  # characters of a file, parts of a name a.b.c: more is no file of ours, and slow to read
DEEP = re.compile(r"""(?:(?:[^\s.="']{1,99}|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*)""" + f"{{{DEEPEST}}}")
SCENES_VARIABLE = "WORKFLOW_SCENES"  # Python files with further scenes, separated as in PATH


def load_scenes() -> None:
    """Add the scenes of the files in WORKFLOW_SCENES: the classes in their list SCENES (docs/extending.md).

    Raises InputError for a file that cannot be read, fails, or has no such list.
    """
    for path in filter(None, os.environ.get(SCENES_VARIABLE, "").split(os.pathsep)):
        try:
            spec = spec_from_file_location(f"{SCENES_VARIABLE}.{Path(path).stem}", path)
            assert spec and spec.loader, "no file of Python"
            module = sys.modules[spec.name] = module_from_spec(spec)
            spec.loader.exec_module(module)
            found = list(module.SCENES)
        except Exception as fault:  # whatever somebody's file may do
            words = f"{type(fault).__name__}: {fault}"
            raise InputError(f"{SCENES_VARIABLE}: '{path}' gives no scenes ({words}); it must have a list SCENES") from fault
        for scene in found:
            if not (isinstance(scene, type) and issubclass(scene, Scene) and scene.name and scene.template and scene.kind):
                raise InputError(f"{SCENES_VARIABLE}: {scene!r} in '{path}' is no Scene with name, template and kind")
            SCENES[scene.name] = scene


def scene_from(values: Mapping[str, Any]) -> Scene:
    """The scene that ``values`` describe; key ``scene`` names it, the others are its parameters."""
    rest = dict(values)
    name = rest.pop("scene", None)
    if not isinstance(name, str):
        raise InputError(f'a scene needs the key scene = "NAME" with one of: {", ".join(sorted(SCENES))}')
    if name not in SCENES:
        raise unknown_name(name, SCENES, "scene")
    return SCENES[name].from_mapping(_of_version_2(name, rest))  # type: ignore[return-value]


# parameters of every scene that files of version 0.2 state; somebody's own file has no reason to state them all
STATED = {
    "seed", "mu", "force_tolerance", "energy_tolerance", "steps_per_period", "scheme", "account", "frame_interval",
    "series_interval", "checkpoint_interval",
}  # fmt: skip


def _of_version_2(name: str, values: dict[str, Any]) -> dict[str, Any]:
    """The scene of a run of version 0.2 as it was run: its files state every parameter that the version knew, automatic ones
    left out, and those of later versions stand for what it did.

    Not repeated: series B of method2 had another drag before it was stiffened, sqrt(soft_kappa/1e5).
    """
    if "as_printed" in values or not set(values) >= STATED:
        return values
    then: dict[str, Any] = {"as_printed": True}
    if issubclass(SCENES[name], Packing):
        kappa = values.get("kappa") if issubclass(SCENES[name], Method2) else None
        drag = math.sqrt(kappa / 1e5) if isinstance(kappa, float | int) and kappa > 0 else 1.0
        then |= {"dashpots": 0.0, "drag": drag, "initial": "addition_by_size"}
    return then | values


def read_toml(path: Path, what: str = "scene file", example: str = "'wf run --help'") -> dict[str, Any]:
    """Names and values in a TOML file; InputError if it cannot be read, which says ``what`` it is and where an ``example``."""
    try:
        text = read_plain(path)
        if len(text) > LONGEST or DEEP.search(text):
            raise ValueError(f"more than {LONGEST} characters, or names of more than {DEEPEST} parts")
        return tomllib.loads(text)
    except OSError as fault:
        raise InputError(f"{what} '{path}' cannot be read: {fault.strerror}; give the path of a TOML file") from fault
    except (ValueError, RecursionError) as fault:  # TOML, UTF-8, numbers of thousands of digits, nested without end
        raise InputError(f"{what} '{path}' is not TOML: {fault}; see {example} for an example") from fault


def to_toml(scene: Scene) -> str:
    """The TOML text that repeats the scene."""
    return tomli_w.dumps({"scene": scene.name, **scene.as_mapping()})
