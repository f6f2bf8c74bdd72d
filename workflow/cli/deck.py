"""wf deck: write what `wf run` would run, without running it."""

from __future__ import annotations

import argparse
import shlex
import sys
from functools import partial
from pathlib import Path
from typing import Any

from workflow.campaign.cluster import CLUSTERS, Profile, profile_of
from workflow.campaign.portable import JOB, job_name, job_script, make_portable
from workflow.cli.lists import whole_number
from workflow.cli.options import command
from workflow.cli.scenes import add_scene, scene_of
from workflow.deck.template import DECK, render
from workflow.errors import InputError
from workflow.runs.directory import RunDirectory, default_directory

EXAMPLES = """
wf deck method1 --phi0 0.36 --out packing   then: cd packing && lmp -in deck.in
wf deck method1 --mu 0.15 --dry-run         print the deck, write nothing
wf deck scene.toml --out packing            a scene from a file
wf deck method1 --out packing --scheduler slurm --ranks 4 --time 12:00:00 --account phys
                                            for a cluster without this package: cd packing && sbatch job.sh
wf deck method1 --out packing --profile hunter          the same, from ~/.config/workflow/clusters.toml
"""


def declare(commands: Any) -> None:
    """Options of `wf deck`."""
    parser = command(commands, "deck", "write the deck of a scene, which runs alone with lmp", EXAMPLES, action=action)
    output = add_scene(parser)["output"]
    output.add_argument("--out", type=Path, metavar="DIR", help="directory (default runs/NAME-HASH)")
    output.add_argument("--dry-run", action="store_true", help="print the deck, and of a job its script; write nothing")
    add_cluster(parser)
    parser.add_argument("--ranks", type=whole_number, metavar="R", help="MPI ranks of the job (default 1)")


def add_cluster(parser: argparse.ArgumentParser) -> None:
    """What a job asks for.  ``--account`` is the job's: the energy account of a scene, there by default, has --no-account."""
    group = parser.add_argument_group("job for a cluster (see docs/cluster.md)")
    group.add_argument("--scheduler", choices=list(CLUSTERS), help="kind of the scheduler (default: the profile's, or slurm)")
    group.add_argument("--profile", metavar="NAME", help="cluster in ~/.config/workflow/clusters.toml, or FILE.toml of one")
    group.add_argument("--time", metavar="HH:MM:SS", help="time limit of a job (default 24:00:00); it goes on in another")
    group.add_argument("--account", dest="pays", metavar="NAME", help="account or project that pays")
    group.add_argument("--partition", metavar="NAME", help="partition or queue")


def job_of(arguments: argparse.Namespace, *, local: tuple[str, ...] = ()) -> Profile | None:
    """The job that the command line describes, None if it asks for none; options in ``local`` need none.

    Raises InputError for what is not allowed.
    """
    given = {name: getattr(arguments, name) for name in ("scheduler", "time", "partition", "ranks")} | {
        "account": arguments.pays
    }
    if arguments.scheduler or arguments.profile:
        return profile_of(arguments.profile, **given)
    extra = next((name for name, value in given.items() if value is not None and name not in local), None)
    if extra:
        raise InputError(f"--{extra} is for a job: add --scheduler or --profile")
    return None


def action(arguments: argparse.Namespace) -> int:
    """Write or print the deck."""
    scene, profile = scene_of(arguments), job_of(arguments)
    if arguments.dry_run:
        print(render(scene), end="")
        if profile:
            print(f"\n# {JOB}, {profile.cluster.submit}:\n\n{job_script(profile, job_name(scene))}", end="")
        return 0
    also = None if profile is None else partial(make_portable, profile=profile)
    directory = RunDirectory.create(arguments.out or default_directory(scene), scene, also)
    words = profile.cluster.submit if profile else f"lmp -in {DECK}"
    print(f"run it with: cd {shlex.quote(str(directory.path))} && {words}", file=sys.stderr)
    print(directory / DECK)
    return 0
