"""wf export: frames of a run for the tools that people already use."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from workflow.archive.export import FORMATS
from workflow.cli.lists import listed, one_of
from workflow.cli.options import command
from workflow.cli.sources import add_sources, one_source
from workflow.data.files import writable_folder
from workflow.data.frame import Frame
from workflow.data.notes import tell
from workflow.errors import InputError
from workflow.pipeline.sources import Source

EXAMPLES = """
wf export runs/method1-130aae48                        grains and contacts of the last frame as CSV, in its folder export
wf export runs/method1-130aae48 --to vtk --all         every frame for ParaView: open the three .pvd files
wf export runs/method1-130aae48 --to gsd --all         every frame for OVITO: open run.gsd
wf export packing --to parquet,graphml --frame 0       the first frame; elsewhere with --out DIR
wf export grains.dump --contacts contacts.dump         LAMMPS dumps of another deck
"""


def declare(commands: Any) -> None:
    """Options of `wf export`."""
    rows = [f"  {name:9s}{form.meaning}{f' (needs {form.needs})' if form.needs else ''}" for name, form in FORMATS.items()]
    parser = command(
        commands, "export", "write grains and contacts for other tools", EXAMPLES + "\n".join(["", "formats:", *rows]) + "\n",
        action=action,
    )  # fmt: skip
    add_sources(parser, measured=False)
    parser.add_argument(
        "--to", action="append", default=[], metavar="FORMATS", help=f"names with commas: {', '.join(FORMATS)} (default csv)"
    )
    parser.add_argument("--all", action="store_true", help="every frame instead of one")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: export in the run directory)")


def action(arguments: argparse.Namespace) -> int:
    """Write the files and say where they are."""
    names = listed("--to", arguments.to or ["csv"], one_of(list(FORMATS)))
    source = one_source(arguments)
    out = arguments.out or source.folder / "export"
    if arguments.out is None and out.is_symlink():
        raise InputError(f"'{out}' is a symbolic link, which leads out of the run directory; name the place with --out DIR")
    writable_folder(out)
    for number, name in enumerate(names):
        for path in FORMATS[name].write(_frames(source, every=arguments.all, notes=number == 0), out):
            print(path)
    return 0


def _frames(source: Source, *, every: bool, notes: bool) -> Iterator[Frame]:
    """The frame that is wanted or every one, read one at a time; ``notes``: say what is to be said of the first."""
    for number, frame in enumerate(source.frames() if every else [source.one_frame()]):
        tell(frame.notes if notes and not number else ())
        yield frame
