"""What runs are measured by, under the name that a scene declares as its ``kind``; others add theirs (docs/extending.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.pipeline import heap, packing
from workflow.pipeline.recorded import Recorded
from workflow.scene.base import Scene


def _nothing(run: Recorded) -> dict[str, Any]:
    return {}


@dataclass(frozen=True)
class Kind:
    """Numbers ready for JSON: ``of_frame``, of one frame of a run; ``of_run``, of the whole run, beside those of every
    frame.

    Beside them stand the groups of measures, if the scene has a law that they know (`Scene.law_of`), and time and step.
    """

    of_frame: Callable[[Recorded, Frame], dict[str, Any]]
    of_run: Callable[[Recorded], dict[str, Any]] = _nothing


KINDS: dict[str, Kind] = {"packing": Kind(packing.of_frame, packing.of_run), "heap": Kind(heap.of_frame)}


def kind_of(scene: Scene) -> Kind:
    """The entry of KINDS for ``scene``.  Raises InputError if there is none."""
    if scene.kind not in KINDS:
        raise InputError(f"scene {scene.name} is of kind '{scene.kind}', which has no measures; known are "
                         f"{', '.join(KINDS)}: add it to workflow.pipeline.kinds.KINDS (docs/extending.md)")  # fmt: skip
    return KINDS[scene.kind]
