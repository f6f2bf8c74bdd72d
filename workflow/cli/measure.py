"""wf measure: the numbers of a run, of several samples, or of another program's dump."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from workflow.archive.inspect import columns_of
from workflow.cli.dumps import reading_of
from workflow.cli.lists import add_list, any_word, listed
from workflow.cli.options import add_any_deck, command
from workflow.cli.sources import add_sources, sources_of
from workflow.measures.registry import GROUPS, chosen_groups
from workflow.pipeline.archived import archived
from workflow.reports.several import of_samples, of_stages
from workflow.reports.summary import text_of
from workflow.runs.directory import RunDirectory

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


def declare(commands: Any) -> None:
    """Options of `wf measure`."""
    parser = command(
        commands, "measure", "measure a run: density, coordination, forces, rigidity, structure, energy", EXAMPLES + _table(),
        action=action,
    )  # fmt: skip
    add_sources(parser)
    add_list(parser, "--only", "GROUPS", "groups beside the standard numbers: names with commas, all, or none")
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
    named = listed("--only", arguments.only, any_word) if arguments.only else None
    asked = chosen_groups(named, 0) if named else []  # a misspelt name is said before anything is computed
    if arguments.any_deck:
        for path in filter(Path.is_dir, arguments.source):
            archived(RunDirectory.open(path), any_deck=True)
    sources = sources_of(arguments)
    if arguments.stages:
        result, text = of_stages(sources, named)
        print(json.dumps(result, indent=1) if arguments.json else text)
        return 0
    measures = [source.measures(named) for source in sources]
    if len(sources) > 1:
        result, text = of_samples(sources, measures, named=named is not None)
    else:
        result, text = measures[0], text_of(measures[0], sources[0], named=named is not None)
    print(json.dumps(result, indent=1) if arguments.json else text)
    faults = {name: sample[name]["error"] for sample in measures for name in asked if "error" in sample.get(name, ())}
    for name, error in faults.items():
        print(f"wf: {name}: {error}", file=sys.stderr)
    return int(bool(faults))
