"""Give a run a longer time of each stage: it becomes the run that had that time from its beginning, stopped at a checkpoint."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from workflow.data.files import atomic_write, read_plain
from workflow.deck.template import DECK
from workflow.errors import InputError
from workflow.runs.checkpoint import drop_beyond, reseal
from workflow.runs.directory import FINISHED, INTERRUPTED, SCENE, RunDirectory
from workflow.runs.identity import check_inputs
from workflow.scene.base import Scene
from workflow.scene.registry import to_toml

_END = re.compile(r"^RESULT stage (\d+) step (\d+) equilibrated (\S+)", re.MULTILINE)
_LAST = re.compile(r"(variable last_step equal )(\d+)\n")
_STEPS = re.compile(r"^(variable\s+max_steps\s+index\s+)(\d+)", re.MULTILINE)


def extend(directory: RunDirectory, max_time: float, *, any_deck: bool = False) -> None:
    """Let each stage take up to ``max_time``, and bring the run back into the first stage that its time did not suffice for.

    Scene, deck, what the deck noted, seals and record are changed; `execute` continues from there.  Raises InputError if the
    run is in equilibrium, works, or has as much time already.
    """
    before = directory.scene
    scene = _longer(directory, before, max_time)
    if directory.equilibrium():
        raise InputError(f"the run in '{directory.path}' ended in equilibrium; more time changes nothing (see 'wf measure')")
    with directory.lock():
        check_inputs(directory, executed=True, continued=True, any_deck=any_deck)
        deck = read_plain(directory / DECK)
        old, new = int(_STEPS.search(deck)[2]), scene.variables()["max_steps"]  # type: ignore[index]
        if directory.state["status"] == FINISHED:
            drop_beyond(directory.path, *_short_of_time(directory))
        for number in scene.stages:
            _note(directory.path / f"stage.{number}.in", _added(scene, number, old, new))
        reseal(directory.path, [f"stage.{number}.in" for number in scene.stages])
        deck = _STEPS.sub(rf"\g<1>{new}", deck, count=1)
        directory.write_text(DECK, deck)
        directory.write_text(SCENE, to_toml(scene))
        hashes = {**directory.state.get("hashes", {}), DECK: hashlib.sha256(deck.encode()).hexdigest()}
        why = f"it goes on with max_time = {max_time:g}"
        directory.record(status=INTERRUPTED, digest=scene.digest, hashes=hashes, reason=why)


def _longer(directory: RunDirectory, scene: Scene, max_time: float) -> Scene:
    """The scene with ``max_time``.  Raises InputError where that is not longer."""
    if "max_time" not in scene.as_mapping() and not hasattr(scene, "longest_time"):
        raise InputError(f"scene {scene.name} has no max_time to extend; leave --max-time out")
    longer = replace(scene, max_time=max_time)  # type: ignore[call-arg]
    if longer.variables()["max_steps"] <= scene.variables()["max_steps"]:
        had = getattr(scene, "max_time", None) or scene.longest_time  # type: ignore[attr-defined]
        raise InputError(f"--max-time {max_time:g} is not allowed: the run in '{directory.path}' had {had:g}; give more")
    return longer


def _short_of_time(directory: RunDirectory) -> tuple[int, int]:
    """Number and last step of the first stage that ended because its time was over."""
    for stage, step, calm in _END.findall(read_plain(directory / "log.lammps", errors="replace")):
        note = directory / f"stage.{stage}.in"
        found = _LAST.fullmatch(read_plain(note)) if note.is_file() else None
        if found and int(step) >= int(found[2]) and not float(calm):
            return int(stage), int(step)
    result = directory.result()
    return int(result["stage"]), int(result["step"])


def _added(scene: Scene, number: int, old: int, new: int) -> int:
    """Steps by which a stage may be longer, with the arithmetic of common/run_stage.in."""
    values: dict[str, Any] = scene.variables()
    of_stage = getattr(scene, "step_of", lambda _: scene.step_choice)(scene.stages[number]).step
    ratio, check = values["step"] / of_stage, values["check_every"]
    return int(check * (math.ceil(new / check * ratio) - math.ceil(old / check * ratio)))


def _note(path: Path, added: int) -> None:
    """Write a later last step into what the deck noted for itself."""
    found = _LAST.fullmatch(read_plain(path)) if path.is_file() else None
    if found:
        with atomic_write(path) as draft:
            draft.write_text(f"{found[1]}{int(found[2]) + added}\n", encoding="ascii")
