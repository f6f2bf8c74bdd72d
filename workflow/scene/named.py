"""The scene that a user names: one of ours, of somebody's file, or in a TOML file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from workflow.errors import InputError, did_you_mean
from workflow.scene.registry import SCENES, Scene, read_toml, scene_from


def scene_named(name: str, given: Mapping[str, Any]) -> Scene:
    """The scene ``name``, or that in the TOML file ``name``, with the parameters ``given`` on top.  Raises InputError."""
    if name in SCENES:
        return scene_from({"scene": name, **given})
    if not (name.endswith(".toml") or os.path.exists(name)):
        known, hint = ", ".join(sorted(SCENES)), did_you_mean(name, SCENES)
        raise InputError(f"'{name}' is neither a scene nor a file; {hint}scenes are: {known}; or give the path of a TOML file")
    stated = read_toml(Path(name))
    if "as_printed" in given:  # a file states the readings that it was run with
        of = SCENES.get(stated.get("scene", ""))
        stated = {key: value for key, value in stated.items() if of is None or key not in of.readings()}
    return scene_from({**stated, **given})
