"""Make a job of the signac project for every scene: python init.py, then python project.py run."""

import tomllib
from pathlib import Path

import signac

project = signac.init_project()
for path in sorted(Path("scenes").glob("*.toml")):
    job = project.open_job(tomllib.loads(path.read_text(encoding="utf-8"))).init()
    job.document["scene"] = str(path)
