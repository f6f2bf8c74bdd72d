"""From what the engine wrote to the archive and the measures of a run."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from workflow.archive.dumps import read_frames, read_tracks
from workflow.archive.lammps_contacts import LammpsLaw, with_lammps_contacts
from workflow.archive.write import write_archive
from workflow.data.contact_law import ContactLaw
from workflow.data.files import read_plain
from workflow.data.frame import Frame
from workflow.deck.template import DATA, DECK
from workflow.errors import ArchiveError, InputError
from workflow.measures.registry import Settings, chosen_groups, measure_groups
from workflow.pipeline.kinds import kind_of
from workflow.pipeline.recorded import recorded
from workflow.runs.directory import ARCHIVE, TRACKS, RunDirectory
from workflow.scene.base import Scene

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
        **scene.record(),
    }  # fmt: skip
    _require_space(directory)
    told, contacts = scene.lammps_law, directory / "contacts.dump"
    frames = read_frames(
        directory / "grains.dump", contacts, series=series, stages={0: "start", **scene.stages},
        contacts_of=None if told is None else partial(with_lammps_contacts, told=LammpsLaw(*told), path=contacts),
    )  # fmt: skip
    tracks = read_tracks(directory / TRACKS) if (directory / TRACKS).is_file() else None
    write_archive(directory / ARCHIVE, frames, series, provenance, tracks, scene.units)


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
    with recorded(directory) as run:
        scene, archive = run.scene, run.archive
        unknown = sorted(set(run.series["stage"].tolist()) - set(scene.stages)) if run.series else []
        if unknown:
            raise ArchiveError(f"series.txt in '{directory.path}' has a stage {unknown[0]:g}, which {scene.name} has not; the "
                               "file is damaged, run again")  # fmt: skip
        kind = kind_of(scene)
        whole = kind.of_run(run)

        def measured(chosen: Frame) -> dict[str, Any]:
            law, numbers = scene.law_of(chosen.stage), kind.of_frame(run, chosen) | whole
            if law is not None:
                known = settings_of(scene, law, **options)
                numbers |= measure_groups(chosen, known, chosen_groups(groups, chosen.grains))
            elif groups is not None and list(groups) != ["none"]:
                raise InputError(f"'{directory.path}' is a {scene.name}, which has measures of its own; the groups are of "
                                 "packings: leave --only out")  # fmt: skip
            return numbers | {"time": chosen.time, "step": chosen.step}

        return [measured(archive.frame(frame)) for frame in frames]


def no_packing(directory: RunDirectory) -> str:
    """What is wrong with a run where one is needed that ends in a packing."""
    return f"'{directory.path}' is a {directory.scene.name}, no packing in a periodic cell; give runs that end in a packing"


def settings_of(scene: Scene, law: ContactLaw, **options: Any) -> Settings:
    """What the groups of measures need to know of a scene and of the law of the stage."""
    return Settings(law, force_unit=scene.force_unit, tolerance=scene.tolerance, **options)
