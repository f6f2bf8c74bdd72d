"""The measures of several samples, or of several stages of one run, as a result for programs and as text for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from workflow.archive.read import Archive
from workflow.data.notes import tell
from workflow.errors import InputError
from workflow.measures.alike import differing, in_words, kinds
from workflow.measures.samples import found_at, pool
from workflow.pipeline.collect import measures_of_frames, no_packing
from workflow.pipeline.sources import Run, Source
from workflow.reports.summary import rows, text_of
from workflow.runs.directory import ARCHIVE

Measures = Mapping[str, Any]


def of_samples(sources: Sequence[Source], measures: Sequence[Measures], *, named: bool) -> tuple[Any, str]:
    """Mean and scatter of samples that differ in the seed alone; else what differs, and each kind by itself."""
    parameters = [source.parameters() for source in sources]
    parts = []
    for members in kinds(parameters):
        _same_twice([(sources[k].name, parameters[k]) for k in members if sources[k].run])
        of, first = [measures[number] for number in members], sources[members[0]]
        result = of[0] if len(of) == 1 else _pooled(of, first)
        text = text_of(result, first, named=named) if len(of) == 1 else rows(result)
        parts.append(({"sources": [sources[number].name for number in members], "measures": result}, text))
    if len(parts) == 1:
        return parts[0][0]["measures"], parts[0][1]
    different = differing(parameters)
    head = f"not averaged, the samples differ in more than the seed: {in_words(different)}"
    text = "\n".join([head, *(f"\n{' '.join(part['sources'])}\n{text}" for part, text in parts)])
    return {"differ": different, "kinds": [part for part, _ in parts]}, text


def _pooled(of: Sequence[Measures], first: Source) -> Measures:
    """`pool` of the measures of samples like ``first``, with what is to be said of them."""
    notes = list(dict.fromkeys(note for sample in of for note in sample.get("notes", [])))
    law = first.frame()[1] if "density" in of[0] else None
    return pool(of, law) | ({"notes": notes} if notes else {})


def _same_twice(runs: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Say it if two runs differ in nothing at all: their scatter is none."""
    seen: dict[str, str] = {}
    for name, parameters in runs:
        first = seen.setdefault(repr(parameters), name)
        if first != name:
            tell([f"'{first}' and '{name}' have the same parameters and the same seed: they are one sample, counted twice"])


# columns of the table of stages: heading, path in the measures
COLUMNS = {
    "t": "time", "stress": "stress.pressure", "Phi": "solid_fraction", "z": "coordination",
    "z+": "forces.populations.repulsive.coordination", "z-": "forces.populations.tensile.coordination",
    "z0": "forces.populations.vanishing.coordination", "strong": "forces.populations.strong", "H": "rigidity.hyperstaticity",
    "k": "rigidity.floppy_modes",
}  # fmt: skip


def of_stages(sources: Sequence[Source], groups: Sequence[str] | None) -> tuple[Any, str]:
    """The measures of the last frame of each stage of one run, and a row for each.  Raises InputError for other sources."""
    source, *others = sources
    if others or not isinstance(source, Run):
        raise InputError(f"--stages is not allowed with '{(others[0] if others else source).name}': give one run directory")
    if any(source.run.scene.law_of(stage) is None for stage in source.run.scene.stages.values()):
        raise InputError(no_packing(source.run))
    with Archive(source.run / ARCHIVE) as archive:
        ends = archive.ends
    every = measures_of_frames(source.run, list(ends.values()), groups=groups, **source.options)
    found = dict(zip(ends, every, strict=True))
    width = max(map(len, found))
    text = [" ".join([f"{'stage':{width}s}", *(f"{name:>10s}" for name in COLUMNS)])]
    for stage, measures in found.items():
        values = [found_at(measures, path) for path in COLUMNS.values()]
        shown = (f"{'-' if value is None else format(value, '.4g'):>10s}" for value in values)
        text.append(" ".join([f"{stage:{width}s}", *shown]))
    return found, "\n".join(text)
