"""wf measure: the numbers of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from workflow.archive.inspect import columns_of
from workflow.archive.read import Archive
from workflow.campaign.measured import found_at
from workflow.cli.dumps import options_of, reading_of
from workflow.cli.options import add_any_deck, command
from workflow.cli.run import summary
from workflow.cli.sources import (
    Source,
    add_sources,
    archived,
    frame_of,
    measures_from,
    name_of,
    packing,
    parameters_of,
    sources_of,
    tell,
)
from workflow.errors import InputError
from workflow.measures.alike import differing, in_words, kinds
from workflow.measures.registry import GROUPS, chosen_groups
from workflow.measures.samples import pool
from workflow.pipeline.collect import measures_of_frames
from workflow.runs.directory import ARCHIVE, RunDirectory

EXAMPLES = """
wf measure runs/method1-130aae48                         for people
wf measure runs/method1-130aae48 --json                  for programs
wf measure runs/method1-130aae48 --only forces,holes     chosen groups beside the standard numbers
wf measure runs/consolidation-130aae48 --stages          the end of every stage, one row each
wf measure sample1 sample2 sample3 --only all            mean and scatter over samples
wf measure grains.dump --contacts contacts.dump          LAMMPS dumps of another deck
wf measure 'post/g*.dump' --contacts 'post/c*.dump' --liggghts pos,id,force   LIGGGHTS, one file per step
wf measure --columns-of contacts.dump                    what a file holds, and as what it is read
"""
SHOWN = 6  # entries of a list that people see


def declare(commands: Any) -> None:
    """Options of `wf measure`."""
    parser = command(
        commands, "measure", "measure a run: density, coordination, forces, rigidity, structure, energy", EXAMPLES + _table(),
        action=action,
    )  # fmt: skip
    add_sources(parser)
    parser.add_argument("--only", metavar="GROUPS", help="groups beside the standard numbers: names with commas, all, or none")
    parser.add_argument("--stages", action="store_true", help="the last frame of every stage of one run, one row each")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--columns-of", type=Path, metavar="FILE", help="show what a dump holds and how it is read; measure nothing"
    )
    add_any_deck(parser)


def _table() -> str:
    """The groups with their cost, under the examples of the help."""
    rows = [f"  {name:17s} {group.cost:16s} {group.meaning}{'' if group.unasked else ' *'}" for name, group in GROUPS.items()]
    title = "groups (processor seconds for 5600 grains, for 1 000 000; * only when named):"
    return "\n".join(["", title, *rows]) + "\n"


def action(arguments: argparse.Namespace) -> int:
    """Measure and print; 1 if a group that was asked for could not be had."""
    if arguments.columns_of is not None:
        print(columns_of(arguments.columns_of, reading_of(arguments)))
        return 0
    named = arguments.only.split(",") if arguments.only is not None else None
    chosen_groups(named, 0)  # a misspelt name is said before anything is computed
    if arguments.any_deck:
        for source in arguments.source:
            if source.is_dir():
                archived(RunDirectory.open(source), any_deck=True)
    sources = sources_of(arguments)
    if arguments.stages:
        return _stages(sources, arguments, named)
    measures = [measures_from(source, arguments, named) for source in sources]
    if len(sources) == 1:
        _show(measures[0], _text(measures[0], sources[0], named=named is not None), arguments)
    else:
        _several(sources, measures, arguments, named)
    asked = chosen_groups(named, 0) if named else []
    faults = {name: sample[name]["error"] for sample in measures for name in asked if "error" in sample[name]}
    for name, fault in faults.items():
        print(f"wf: {name}: {fault}", file=sys.stderr)
    return int(bool(faults))


def _show(result: Any, text: str, arguments: argparse.Namespace) -> None:
    print(json.dumps(result, indent=1) if arguments.json else text)


def _several(
    sources: Sequence[Source], measures: Sequence[dict[str, Any]], arguments: argparse.Namespace, named: list[str] | None
) -> None:
    """Mean and scatter of samples that differ in the seed alone; else what differs, and each kind by itself."""
    parameters = [parameters_of(source, arguments) for source in sources]
    parts = []
    for members in kinds(parameters):
        of = [measures[number] for number in members]
        _same_twice([(name_of(sources[k]), parameters[k]) for k in members if isinstance(sources[k], Path)])
        result = of[0]
        if len(of) > 1:
            notes = list(dict.fromkeys(note for sample in of for note in sample.get("notes", [])))
            law = frame_of(sources[members[0]], arguments)[1] if "density" in of[0] else None
            result = pool(of, law) | ({"notes": notes} if notes else {})
        text = _text(result, sources[members[0]], named=named is not None) if len(of) == 1 else _rows(result)
        parts.append(({"sources": [name_of(sources[number]) for number in members], "measures": result}, text))
    if len(parts) == 1:
        _show(parts[0][0]["measures"], parts[0][1], arguments)
        return
    different = differing(parameters)
    head = f"not averaged, the samples differ in more than the seed: {in_words(different)}"
    text = "\n".join([head, *(f"\n{' '.join(part['sources'])}\n{text}" for part, text in parts)])
    _show({"differ": different, "kinds": [part for part, _ in parts]}, text, arguments)


def _same_twice(runs: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Say it if two runs differ in nothing at all: their scatter is none."""
    seen: dict[str, str] = {}
    for name, parameters in runs:
        first = seen.setdefault(repr(parameters), name)
        if first != name:
            tell([f"'{first}' and '{name}' have the same parameters and the same seed: they are one sample, counted twice"])


# columns of --stages: heading, path in the measures
COLUMNS = {
    "t": "time", "stress": "stress.pressure", "Phi": "solid_fraction", "z": "coordination",
    "z+": "forces.populations.repulsive.coordination", "z-": "forces.populations.tensile.coordination",
    "z0": "forces.populations.vanishing.coordination", "strong": "forces.populations.strong", "H": "rigidity.hyperstaticity",
    "k": "rigidity.floppy_modes",
}  # fmt: skip


def _stages(sources: Sequence[Source], arguments: argparse.Namespace, named: list[str] | None) -> int:
    """One row, or with --json one entry, for the last frame of each stage."""
    source, *others = sources
    if others or not isinstance(source, Path):
        raise InputError(f"--stages is not allowed with '{name_of(others[0] if others else source)}': give one run directory")
    directory = archived(RunDirectory.open(source))
    packing(directory)
    with Archive(directory / ARCHIVE) as archive:
        ends = archive.ends
    every = measures_of_frames(directory, list(ends.values()), groups=named, **options_of(arguments))
    found = dict(zip(ends, every, strict=True))
    if arguments.json:
        print(json.dumps(found, indent=1))
        return 0
    width = max(map(len, found))
    print(" ".join([f"{'stage':{width}s}", *(f"{name:>10s}" for name in COLUMNS)]))
    for stage, measures in found.items():
        values = [found_at(measures, path) for path in COLUMNS.values()]
        print(" ".join([f"{stage:{width}s}", *(f"{'-' if value is None else format(value, '.4g'):>10s}" for value in values)]))
    return 0


def _text(result: dict[str, Any], source: Source, *, named: bool) -> str:
    """For people: the summary of a run, and the groups that were asked for; everything for other sources."""
    if not isinstance(source, Path):
        return _rows(result)
    text = summary(result, RunDirectory.open(source))
    extra = {name: result[name] for name in GROUPS if name in result} if named else {}
    return "\n".join([text, *(f"{name:44s}{value}" for name, value in lines(extra))])


def _rows(result: Mapping[str, Any]) -> str:
    """Every number in a row of its own, then the notes."""
    rows = [f"{name:44s}{text}" for name, text in lines({name: value for name, value in result.items() if name != "notes"})]
    return "\n".join([*rows, *(f"note: {note}" for note in result.get("notes", []))])


def lines(tree: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """One line per number, named by its path."""
    for name, value in tree.items():
        path = f"{above}{name}"
        if isinstance(value, Mapping) and "samples" in value:
            yield path, _moments(value)
        elif isinstance(value, Mapping):
            yield from lines(value, f"{path}.")
        elif isinstance(value, list):
            yield path, " ".join(_short(entry) for entry in value[:SHOWN]) + (" ..." if len(value) > SHOWN else "")
        else:
            yield path, _short(value)


def _moments(value: Mapping[str, Any]) -> str:
    if "true" in value:
        return f"in {value['true']} of {value['samples']}"
    return f"{_short(value['mean'])} +- {_short(value['scatter'])}"


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    return "undefined" if value is None else str(value)
