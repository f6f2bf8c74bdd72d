"""Give a run a longer time of each stage: it becomes the run that had that time from its beginning, stopped at a checkpoint."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import replace
from typing import Any

from workflow.data.files import read_plain
from workflow.deck.template import DECK
from workflow.errors import InputError
from workflow.runs.checkpoint import drop_beyond, reseal
from workflow.runs.directory import FINISHED, INTERRUPTED, SCENE, RunDirectory
from workflow.runs.identity import check_inputs
from workflow.scene.base import Scene
from workflow.scene.registry import to_toml

# end of a stage in the log; of stages before a resume it is no result any more
_END = re.compile(r"^(?:RESULT|interrupted:) stage (\d+) step (\d+) equilibrated (\S+)", re.MULTILINE)
_LAST = re.compile(r"variable last_step equal (\d+)\n")
_STEPS = re.compile(r"^(variable\s+max_steps\s+index\s+)(\d+)", re.MULTILINE)


def extend(directory: RunDirectory, max_time: float | None, *, any_deck: bool = False) -> None:
    """Let each stage take up to ``max_time``, and bring the run back into the first stage that its time did not suffice for.

    Scene, deck, what the deck noted, seals and record are changed; `execute` continues from there.  What is to be done is
    recorded first: where a kill comes between, the next call does it, also without a ``max_time``.  Raises InputError if
    the run is in equilibrium, works, or has as much time already.
    """
    plan = directory.state.get("extension")
    if max_time is None and not plan:
        return
    with directory.lock():
        if not plan:
            scene = _longer(directory, max_time or 0.0)
            check_inputs(directory, executed=True, continued=True, any_deck=any_deck)
            plan = _plan(directory, scene)
            directory.record(extension=plan)
        _carry_out(directory, plan)


def _plan(directory: RunDirectory, scene: Scene) -> dict[str, Any]:
    """What is to be changed: the time and steps of a stage, where the run goes back to, and last steps of stages."""
    found = _STEPS.search(read_plain(directory / DECK))
    steps = scene.variables()["max_steps"]
    back = _short_of_time(directory) if directory.state["status"] == FINISHED else None
    lasts = {}
    for number in scene.stages:
        note = directory / f"stage.{number}.in"
        noted = _LAST.fullmatch(read_plain(note)) if note.is_file() else None
        if noted and found:
            lasts[str(number)] = int(noted[1]) + _added(scene, number, int(found[2]), steps)
    return {"max_time": scene.as_mapping()["max_time"], "max_steps": steps, "back": back, "lasts": lasts}


def _carry_out(directory: RunDirectory, plan: dict[str, Any]) -> None:
    """Change what a plan says; a second time changes nothing more."""
    scene = replace(directory.scene, max_time=float(plan["max_time"]))  # type: ignore[call-arg]
    if plan["back"]:
        drop_beyond(directory.path, *map(int, plan["back"]))
    notes = {f"stage.{int(number)}.in": int(step) for number, step in plan["lasts"].items()}
    for name, step in notes.items():
        directory.write_text(name, f"variable last_step equal {step}\n")
    reseal(directory.path, list(notes))
    deck = _STEPS.sub(rf"\g<1>{int(plan['max_steps'])}", read_plain(directory / DECK), count=1)
    directory.write_text(DECK, deck)
    directory.write_text(SCENE, to_toml(scene))
    hashes = {**directory.state.get("hashes", {}), DECK: hashlib.sha256(deck.encode()).hexdigest()}
    why = f"it goes on with max_time = {plan['max_time']:g}"
    directory.record(status=INTERRUPTED, digest=scene.digest, hashes=hashes, reason=why, extension=None)


def _longer(directory: RunDirectory, max_time: float) -> Scene:
    """The scene with ``max_time``.  Raises InputError where that is not longer, or changes nothing."""
    scene = directory.scene
    if "max_time" not in scene.as_mapping() and not hasattr(scene, "longest_time"):
        raise InputError(f"scene {scene.name} has no max_time to extend; leave --max-time out")
    longer = replace(scene, max_time=max_time)  # type: ignore[call-arg]
    if longer.variables()["max_steps"] <= scene.variables()["max_steps"]:
        had = getattr(scene, "max_time", None) or scene.longest_time  # type: ignore[attr-defined]
        raise InputError(f"--max-time {max_time:g} is not allowed: the run in '{directory.path}' had {had:g}; give more")
    if directory.equilibrium():
        raise InputError(f"the run in '{directory.path}' ended in equilibrium; more time changes nothing (see 'wf measure')")
    return longer


def _short_of_time(directory: RunDirectory) -> tuple[int, int]:
    """Number and last step of the first stage that ended because its time was over."""
    for stage, step, equilibrated in _END.findall(read_plain(directory / "log.lammps", errors="replace")):
        note = directory / f"stage.{stage}.in"
        found = _LAST.fullmatch(read_plain(note)) if note.is_file() else None
        if found and int(step) >= int(found[1]) and not float(equilibrated):
            return int(stage), int(step)
    result = directory.result()
    return int(result["stage"]), int(result["step"])


def _added(scene: Scene, number: int, old: int, new: int) -> int:
    """Steps by which a stage may be longer, with the arithmetic of common/run_stage.in."""
    values: dict[str, Any] = scene.variables()
    of_stage = getattr(scene, "step_of", lambda _: scene.step_choice)(scene.stages[number]).step
    ratio, check = values["step"] / of_stage, values["check_every"]
    return int(check * (math.ceil(new / check * ratio) - math.ceil(old / check * ratio)))
