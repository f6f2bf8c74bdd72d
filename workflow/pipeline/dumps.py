"""Measures of dumps of other programs, with what the user knows of their law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workflow.archive.columns import Reading
from workflow.archive.samples import Files
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Frame
from workflow.measures.packing import measure, stress_parts
from workflow.measures.registry import Settings, attempt, measure_groups, slipping


def frame_of_files(files: Files, reading: Reading, number: int) -> Frame:
    """Frame ``number`` of a sample, negative from the end, with a note of its place among several."""
    sample = files.sample(reading)
    frame = sample.frame(number)
    if len(sample.steps) == 1:
        return frame
    place = f"frame {number % len(sample.steps) + 1} of {len(sample.steps)}, step {frame.step}"
    return replace(frame, notes=(place, *frame.notes))


def settings_of_dump(frame: Frame, law: ContactLaw, *, force_unit: float | None = None, **options: Any) -> Settings:
    """What the groups of measures need to know of a dump whose contacts obey ``law``, mu NaN if it is not known.

    ``force_unit``: F1, None for F0 or, without cohesion, the mean |N|; ``options``: other fields of `Settings`.
    """
    normal = abs(frame.interactions.normal_force) if "normal" not in frame.lacks else np.empty(0)
    unit = force_unit or (law.f0 if law.cohesive else float(normal.mean() if len(normal) else 0.0)) or 1.0
    length = 1.0 if "diameter" in frame.lacks else float(frame.diameter.max())
    return Settings(law, shows_friction=_shows_friction(frame), force_unit=unit, length=length, **options)


def _shows_friction(frame: Frame) -> bool:
    """The file itself shows that there is friction, by tangential forces and flags of sliding."""
    return not {"tangential", "sliding"} & frame.lacks and bool(frame.interactions.tangential.any())


def measures_of_dump(frame: Frame, settings: Settings, groups: Sequence[str]) -> dict[str, Any]:
    """The standard numbers with the two parts of the stress, the groups, and the notes."""
    numbers = measure(frame, force_unit=settings.force_unit, tolerance=settings.tolerance)
    numbers["stress"] |= stress_parts(frame)
    sliding = None if "sliding" in frame.lacks else int(frame.interactions.sliding.sum())
    time = None if "time" in frame.lacks else frame.time
    found = numbers | {"sliding_contacts": sliding} | measure_groups(frame, settings, groups)
    if sliding and "error" not in found.get("rigidity", {"error": "not asked"}):
        found["rigidity"]["slipping"] = attempt(lambda: slipping(frame, settings))
    return found | {"time": time, "step": frame.step, "notes": list(frame.notes)}
