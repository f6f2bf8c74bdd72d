"""wf measure: the numbers of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from typing import Any

from workflow.analysis.groups import GROUPS, chosen_groups
from workflow.analysis.samples import pool
from workflow.archive.read import Archive
from workflow.cli.options import add_any_deck, command
from workflow.cli.run import summary
from workflow.cli.sources import add_sources, archived, frame_of, measures_from, options_of, packing
from workflow.engine.collect import measures_of_frames
from workflow.engine.rundir import ARCHIVE, RunDirectory
from workflow.errors import InputError
from workflow.study.evaluate import found_at

EXAMPLES = """
wf measure runs/method1-130aae48                         for people
wf measure runs/method1-130aae48 --json                  for programs
wf measure runs/method1-130aae48 --only forces,holes     chosen groups beside the standard numbers
wf measure runs/consolidation-130aae48 --stages          the end of every stage, one row each
wf measure sample1 sample2 sample3 --only all            mean and scatter over samples
wf measure grains.dump --contacts contacts.dump          LAMMPS dumps of another deck
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
    add_any_deck(parser)


def _table() -> str:
    """The groups with their cost, under the examples of the help."""
    rows = [f"  {name:17s} {group.cost:16s} {group.meaning}{'' if group.unasked else ' *'}" for name, group in GROUPS.items()]
    title = "groups (processor seconds for 5600 grains, for 1 000 000; * only when named):"
    return "\n".join(["", title, *rows]) + "\n"


def action(arguments: argparse.Namespace) -> int:
    """Measure and print; 1 if a group that was asked for could not be had."""
    named = arguments.only.split(",") if arguments.only is not None else None
    chosen_groups(named, 0)  # a misspelt name is said before anything is computed
    if len(arguments.source) > 1 and len(set(arguments.source)) < len(arguments.source):
        raise InputError("a source is named twice; samples must be different runs")
    if arguments.any_deck:
        for source in arguments.source:
            if source.is_dir():
                archived(RunDirectory.open(source), any_deck=True)
    if arguments.stages:
        return _stages(arguments, named)
    measures = [measures_from(source, arguments, named) for source in arguments.source]
    pooled = len(measures) > 1
    result = pool(measures, frame_of(arguments.source[0], arguments)[1]) if pooled else measures[0]
    if arguments.json:
        print(json.dumps(result, indent=1))
    else:
        print(_text(result, arguments, pooled=pooled, named=named is not None))
    asked = chosen_groups(named, 0) if named else []
    return int(any("error" in sample[name] for sample in measures for name in asked))


# columns of --stages: heading, path in the measures
COLUMNS = {
    "t": "time", "stress": "stress.pressure", "Phi": "solid_fraction", "z": "coordination",
    "z+": "forces.populations.repulsive.coordination", "z-": "forces.populations.tensile.coordination",
    "z0": "forces.populations.vanishing.coordination", "strong": "forces.populations.strong", "H": "rigidity.hyperstaticity",
    "k": "rigidity.floppy_modes",
}  # fmt: skip


def _stages(arguments: argparse.Namespace, named: list[str] | None) -> int:
    """One row, or with --json one entry, for the last frame of each stage."""
    source, *others = arguments.source
    if others or source.is_file():
        raise InputError(f"--stages is not allowed with '{others[0] if others else source}': give one run directory")
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


def _text(result: dict[str, Any], arguments: argparse.Namespace, *, pooled: bool, named: bool) -> str:
    """For people: the summary of a run, and the groups that were asked for; everything for other sources."""
    source = arguments.source[0]
    if pooled or source.is_file():
        return "\n".join(f"{name:44s}{text}" for name, text in lines(result))
    text = summary(result, RunDirectory.open(source))
    extra = {name: result[name] for name in GROUPS if name in result} if named else {}
    return "\n".join([text, *(f"{name:44s}{value}" for name, value in lines(extra))])


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
