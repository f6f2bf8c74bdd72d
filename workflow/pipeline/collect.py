"""From what the engine wrote to the archive and the measures of a run."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from workflow.archive.dumps import read_frames, read_tracks
from workflow.archive.read import Archive
from workflow.archive.write import write_archive
from workflow.data.balance import solid_fraction
from workflow.data.contact_law import ContactLaw
from workflow.data.files import read_plain
from workflow.data.frame import Contacts, Floats, Frame
from workflow.deck.template import DATA, DECK
from workflow.errors import ArchiveError, InputError
from workflow.measures.contacts import measure
from workflow.measures.energy import energies
from workflow.measures.registry import Settings, chosen_groups, measure_groups
from workflow.pipeline.heap import heap_measures
from workflow.pipeline.recorded import recorded
from workflow.runs.directory import ARCHIVE, TRACKS, RunDirectory
from workflow.scene.heap import Heap
from workflow.scene.registry import Packed

MEASURES, CHECKSUM = "measures.json", "checksum"


def collect(directory: RunDirectory) -> dict[str, Any]:
    """Write the archive and the measures of the last frame from what the engine wrote."""
    write(directory)
    return _store(directory, measures_of(directory))


def _store(directory: RunDirectory, measures: dict[str, Any]) -> dict[str, Any]:
    directory.write_text(MEASURES, json.dumps({**measures, CHECKSUM: _checksum(measures)}, indent=1) + "\n")
    return measures


def write(directory: RunDirectory) -> None:
    """Write the archive, one frame in memory at a time."""
    series: dict[str, Any] = directory.series() or {}
    state, scene = directory.state, directory.scene
    provenance = {
        "scene": {"scene": scene.name, **scene.as_mapping()},
        "digest": state["digest"], "versions": state["versions"],
        "hashes": {name: directory.hash(name) for name in (DECK, DATA, *scene.files())}, "ranks": state.get("ranks", 1),
        "result": directory.result(), "accepted": state.get("accepted", []),
        "step": scene.step_choice.step, "step_reason": scene.step_choice.reason, "sizes": dump_sizes(directory),
    }  # fmt: skip
    if not isinstance(scene, Heap):
        provenance["relaxation"] = scene.relaxation
    _require_space(directory)
    frames = read_frames(
        directory / "grains.dump", directory / "contacts.dump", series=series, stages={0: "start", **scene.stages}
    )
    tracks = read_tracks(directory / TRACKS) if (directory / TRACKS).is_file() else None
    write_archive(directory / ARCHIVE, frames, series, provenance, tracks)


def dump_sizes(directory: RunDirectory) -> dict[str, int]:
    """Bytes of what the engine wrote, from which the archive is made."""
    names = ("grains.dump", "contacts.dump", TRACKS, "series.txt")
    return {name: (directory / name).stat().st_size for name in names if (directory / name).is_file()}


def stored_measures(directory: RunDirectory) -> dict[str, Any]:
    """The measures of the last frame: those in measures.json if its checksum is right, else measured anew, and kept if the
    directory can be written."""
    try:
        known = json.loads(read_plain(directory / MEASURES))
        if isinstance(known, dict) and known.pop(CHECKSUM, None) == _checksum(known):
            return known
    except (OSError, ValueError, RecursionError):
        pass
    measures = measures_of(directory)
    with suppress(ArchiveError):
        _store(directory, measures)
    return measures


def _checksum(measures: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(measures).encode()).hexdigest()


def _require_space(directory: RunDirectory) -> None:
    """The archive is smaller than the dumps; HDF5 must not run into a full disk, which it does not survive."""
    needed = sum((directory / name).stat().st_size for name in ("grains.dump", "contacts.dump") if (directory / name).is_file())
    free = shutil.disk_usage(directory.path).free
    if free < needed + 1_000_000:
        raise ArchiveError(
            f"'{directory / ARCHIVE}' is not written: No space left on device "
            f"({free / 1e6:.1f} MB free, {needed / 1e6 + 1:.1f} MB needed); "
            f"make room, then 'wf measure {directory.path}'"
        )


def measures_of(
    directory: RunDirectory, frame: int = -1, *, groups: Sequence[str] | None = None, **options: Any
) -> dict[str, Any]:
    """The measures of a frame of the archive; see `measures_of_frames`."""
    return measures_of_frames(directory, [frame], groups=groups, **options)[0]


def measures_of_frames(
    directory: RunDirectory, frames: Sequence[int], *, groups: Sequence[str] | None = None, **options: Any
) -> list[dict[str, Any]]:
    """The measures of each of ``frames`` of the archive, with the run's own error figures, which are read once for all.

    ``groups`` of measures beside the standard numbers (see `workflow.measures.registry`), None: those that are cheap for so
    many grains; ``options``: fields of its `Settings`.
    """
    scene = directory.scene
    series, result = recorded(directory)
    unknown = sorted(set(series["stage"].tolist()) - set(scene.stages)) if series else []
    if unknown:
        raise ArchiveError(f"series.txt in '{directory.path}' has a stage {unknown[0]:g}, which {scene.name} has not; the file "
                           "is damaged, run again")  # fmt: skip
    if isinstance(scene, Heap):
        if groups is not None and list(groups) != ["none"]:
            raise InputError(f"'{directory.path}' is a heap, which has measures of its own; the groups are of packings: "
                             "leave --only out")  # fmt: skip
        return [heap_measures(directory, scene, frame) for frame in frames]
    with Archive(directory / ARCHIVE) as archive:
        last, ends = archive.frame(-1).step, archive.ends
        relaxed = {
            after: relaxation(archive.frame(ends[before]), archive.frame(ends[after]))
            for before, after in scene.relaxations
            if {before, after} <= set(ends)
        }
        run = {"relaxation": relaxed or None, "numerics": _numerics(scene, series)}

        def measured(chosen: Frame) -> dict[str, Any]:
            reached = bool(result.get("equilibrated")) if chosen.step == last else None
            numbers = _measures(scene, series, chosen, reached) | run
            law = settings_of(scene, scene.law_of(chosen.stage), **options)
            numbers |= measure_groups(chosen, law, chosen_groups(groups, chosen.grains))
            return numbers | {"time": chosen.time, "step": chosen.step}

        return [measured(archive.frame(frame)) for frame in frames]


def _measures(scene: Packed, series: dict[str, Any], chosen: Frame, equilibrated: bool | None) -> dict[str, Any]:
    """The standard numbers of a frame, its energies and the residual of its row of the time series."""
    row = int(abs(series["step"] - chosen.step).argmin()) if series else None
    residual = None
    if row is not None and scene.account and scene.barostat == "inertial":
        value, scale = float(series["residual"][row]), _energy_scale(series, row)
        residual = {"value": value, "relative": value / scale if scale else 0.0}
    pressure, law = scene.pressure_of(chosen.stage), scene.law_of(chosen.stage)
    numbers = measure(
        chosen, force_unit=scene.force_unit, tolerance=scene.force_tolerance, targets=(pressure, pressure),
        equilibrated=equilibrated,
    )  # fmt: skip
    numbers["energy_residual"] = residual
    numbers["energy"] = energies(chosen, law).as_dict()
    return numbers


def _energy_scale(series: dict[str, Any], row: int) -> float:
    """What the residual of a row is compared with: the largest of the work of the cell, each loss, and the energy that grains
    and contacts have held in any row until then, which is all there is where nothing is lost."""
    passed = [abs(float(series[name][row])) for name in ("work", "lost_viscous", "lost_sliding", "lost_rolling", "lost_drag")]
    held = sum(np.abs(series[name][: row + 1]) for name in ("kinetic", "elastic", "tangential", "rolling", "adhesive"))
    return max(*passed, float(np.max(held)))


def settings_of(scene: Packed, law: ContactLaw, **options: Any) -> Settings:
    """What the groups of measures need to know of a scene and of the law of the stage."""
    return Settings(law, force_unit=scene.force_unit, tolerance=scene.force_tolerance, **options)


def _numerics(scene: Packed, series: dict[str, Any]) -> dict[str, Any]:
    """How well the run was resolved: steps per stiffest period, largest overlap, steps in the tail at the fastest approach;
    how fast the cell was strained.

    Overlap and approach are those of every step; of runs of version 0.2, which did not watch them, of the rows of the time
    series, a lower bound (``watched``: "every step" or "rows").  ``largest_strain_rate`` |d ln L/dt| [1/T0] and
    ``largest_wall_speed`` |dL/dt| [a/T0] are means between two rows.
    """
    step, law = scene.step_choice.step, scene.law_in_units
    watched = "every step" if "largest_overlap" in series else "rows"
    overlap = approach = longest = 0.0
    if series and watched == "every step":
        overlap, approach, longest = (float(series[f"largest_{of}"][-1]) for of in ("overlap", "approach", "advance"))
    elif series:
        overlap, approach = float(series["overlap"].max()), float(series["approach"].max())
        steps = {number: scene.step_of(stage).step for number, stage in scene.stages.items()}
        longest = float(max(series["approach"] * [steps[int(number)] for number in series["stage"]]))
    return {
        "step": step,
        "step_reason": scene.step_choice.reason,
        "steps_per_stiffest_period": scene.step_choice.period / step,
        "share_of_stability_limit": step / scene.step_choice.limit,
        "watched": watched,
        "largest_overlap": overlap,
        "largest_overlap_of_smallest_radius": 2.0 * overlap / scene.smallest,
        "fastest_approach": approach,
        "largest_strain_rate": _fastest(series, np.log) if series else 0.0,
        "largest_wall_speed": _fastest(series, np.asarray) if series else 0.0,
        "steps_in_tail": law.d0 / longest if law.f0 > 0 and longest > 0 else None,
    }


def _fastest(series: Mapping[str, Floats], of: Callable[[Any], Floats]) -> float:
    """Largest |d of(L)/dt| of the two lengths of the cell, mean between two rows of the time series."""
    lengths = of(np.array([series["length_x"], series["length_y"]]))
    time = np.diff(series["time"])
    moved = time > 0  # the row of a stage's end may be written twice
    return float(np.abs(np.diff(lengths)[:, moved] / time[moved]).max(initial=0.0))


def relaxation(before: Frame, after: Frame) -> dict[str, Any]:
    """What a settling stage changed, between the last frame before it and its own: contacts that it found or lost."""
    pairs = [_touching(frame) for frame in (before, after)]
    common = len(np.intersect1d(pairs[0], pairs[1], assume_unique=True))
    return {
        "time": after.time - before.time,
        "contacts_opened": len(pairs[0]) - common,
        "contacts_closed": len(pairs[1]) - common,
        "solid_fraction_change": float((before.area / after.area - 1.0) * solid_fraction(before)),
    }


def _touching(frame: Frame) -> np.ndarray:
    """The pairs of ids that touch, each as one complex number: pairs that arrays can be searched for."""
    table: Contacts = frame.contacts.select(frame.contacts.touching)
    return frame.ids[table.i] + 1j * frame.ids[table.j]
