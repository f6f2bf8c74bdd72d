"""A run directory that a cluster computes without this package: with job script, README and, where needed, plugin source."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

from workflow.campaign.cluster import Profile
from workflow.errors import InputError
from workflow.runs.directory import RunDirectory
from workflow.scene.base import Scene

JOB = "job.sh"
README = """\
{title}

Submit the job from this directory:

    {submit}

{needs}

{margin} s before its time of {time} s is over the job stops the deck and submits itself again. It goes on from the newest whole
checkpoint (checkpoint.STAGE.a and .b) and drops what was written beyond it; so it does after a kill, a failed node or a
cancelled job, when it is submitted again by hand. `touch stop` stops the deck cleanly. A finished run is left as it is.

deck.in        the LAMMPS input; `lmp -in deck.in` runs it{where}
grains.data    initial grains            series.txt      time series
job.sh         the job                   log.lammps      LAMMPS's log; its last line RESULT says how it ended
scene.toml     the parameters            *.dump          frames: grains, contacts

Where the Python package is installed, on any machine, `wf measure DIR` makes archive and measures from this directory, and
`wf status DIR` shows how far it is.
"""


NEEDS_PLUGIN = """\
It needs LAMMPS {lammps} with its package PLUGIN and nothing else of ours. The job builds the plugin in plugin/ when it
starts first; where compute nodes have no compiler, build it before, with the modules of LAMMPS loaded:

    sh plugin/build.sh"""
NEEDS_GRANULAR = "It needs LAMMPS with its package GRANULAR and nothing of ours; written for {lammps}."


def sources() -> Path:
    """The folder of the plugin's source: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "plugin_source", package.parent / "plugins"):
        if (folder / "build.sh").is_file():
            return folder
    raise InputError(f"plugin source not found beside {package}; install the package again: pip install .")


def tested_release() -> str:
    """The release of LAMMPS that the plugin is tested with, as build.sh reads it from its source."""
    text = (sources() / "engine_verlet.h").read_text(encoding="utf-8")
    stated = re.search(r'\(DISC_LAMMPS_VERSION\) == "(.+)"', text)
    assert stated  # or build.sh would know no release either
    return stated[1]


def make_portable(directory: RunDirectory, profile: Profile) -> None:
    """Add job script, README and, where the deck needs it, the source of the plugin to a run directory."""
    scene = directory.scene
    if scene.needs_plugin:
        ignored = shutil.ignore_patterns("*.so", "CMakeLists.txt", "where.py")
        shutil.copytree(sources(), directory / "plugin", ignore=ignored)
    directory.write_text(JOB, job_script(profile, job_name(scene)))
    text = README.format(
        title=scene.title, submit=profile.cluster.submit, time=profile.time, margin=profile.margin,
        needs=(NEEDS_PLUGIN if scene.needs_plugin else NEEDS_GRANULAR).format(lammps=tested_release()),
        where=" where LAMMPS_PLUGIN_PATH names plugin/" if scene.needs_plugin else "",
    )  # fmt: skip
    directory.write_text("README.txt", text)


def job_name(scene: Scene) -> str:
    """What the scheduler calls the job of a scene."""
    return f"{scene.name}-{scene.digest[:8]}"


def job_script(profile: Profile, name: str) -> str:
    """The job of a deck: directives and settings of ``profile``, then job.sh of this folder as it is."""
    more = [f"--ntasks={profile.ranks}"] if profile.scheduler == "slurm" else []
    output = {"slurm": "job-%j.out", "lsf": "job-%J.out"}.get(profile.scheduler, "")
    settings = [
        f"launch=({shlex.join(profile.launch)})",
        f"lmp={shlex.quote(profile.lmp)}",
        f"include={shlex.quote(profile.lammps_include)}",
        f"compiler={shlex.quote(profile.compiler)}",
        f"limit={profile.time - profile.margin}",
        f"folder=${profile.cluster.folder}",
        f"again() {{ {profile.cluster.submit}; }}",
    ]
    body = Path(__file__).with_name(JOB).read_text(encoding="utf-8")
    return "\n".join(["#!/bin/bash", *profile.head(name, output, *more), "", *profile.loading(), *settings, "", body])
