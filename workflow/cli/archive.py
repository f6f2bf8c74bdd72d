"""wf archive: RO-Crate metadata of runs and studies, for a repository."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from workflow.campaign.crate import Attribution, write_crate
from workflow.cli.options import command

EXAMPLES = """
wf archive packing                         ro-crate-metadata.json in the directory of a run
wf archive runs/study                      of a study: one action for each of its runs, failed ones too
wf archive runs/gilabert2007 --author Lovelace --license https://spdx.org/licenses/CC-BY-4.0
                                           of a reproduction, with who made it and who may use it

the folder is then a Process Run Crate 0.5 that Zenodo, WorkflowHub and their tools read: pack it and upload it
"""


def declare(commands: Any) -> None:
    """Options of `wf archive`."""
    parser = command(commands, "archive", "write RO-Crate metadata for runs and studies", EXAMPLES, action=action)
    parser.add_argument("directories", type=Path, nargs="+", metavar="DIR", help="run directories, studies, reproductions")
    parser.add_argument("--author", metavar="NAME", help="who made the data")
    parser.add_argument("--orcid", metavar="URI", help="ORCID of the author")
    parser.add_argument("--license", metavar="URI", help="licence of the data (default: none is stated)")


def action(arguments: argparse.Namespace) -> int:
    """Write them and say where they are."""
    attribution = Attribution(arguments.author, arguments.orcid, arguments.license)
    for folder in arguments.directories:
        print(write_crate(folder, attribution))
    return 0
