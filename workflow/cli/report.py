"""wf report: one HTML page of a run, of several, or of another program's dump."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.cli.options import command, command_line
from workflow.cli.sources import add_sources, sources_of
from workflow.cli.units import add_powder, powder_of, refuse_powder
from workflow.reports.registry import PAGE

EXAMPLES = """
wf report packing                          packing/report.html: results, force network, time series, errors, provenance
wf report packing --frame 0                of the first frame
wf report runs                             runs/report.html: a table of all runs below, and the page of each
wf report runs/method1-* --out study.html  some of them
wf report packing --si --diameter 10um --density 1200 --force 30nN   also in SI, for a powder
wf report grains.dump --contacts contacts.dump   LAMMPS dumps of another deck
"""


def declare(commands: Any) -> None:
    """Options of `wf report`."""
    parser = command(commands, "report", "write an HTML page of a run or of several, to look at in a browser", EXAMPLES,
                     action=action)  # fmt: skip
    add_sources(parser)
    group = parser.add_argument_group("SI (see 'wf units --help')")
    group.add_argument("--si", action="store_true", help="add a section in SI, for the powder that the next options name")
    add_powder(group, needed=False)
    parser.add_argument("--out", type=Path, metavar="FILE", help=f"the page (default: {PAGE} in the directory, or here)")


def action(arguments: argparse.Namespace) -> int:
    """Write the page and say where it is."""
    powder = powder_of(arguments) if arguments.si else None
    if not powder:
        refuse_powder(arguments)
    sources = sources_of(arguments)
    out = arguments.out or (Path(PAGE) if len(sources) > 1 else sources[0].folder / PAGE)
    from workflow.reports.sheets import write_page_of  # matplotlib is slow to import

    write_page_of(sources, out, command_line(), powder)
    print(out)
    return 0
