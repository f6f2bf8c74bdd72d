"""A study as a project of another workflow manager: its files, a scene for each point, and one command that runs a point.

study.toml     the study as it was declared       scenes/NAME.toml   the points, each a file for `wf run`
points.json    the same as data, for `wf status`  point.sh           run a scene, or continue its run
points/NAME/   run directories, as `wf sweep` names them; signac has them in workspace/ID/run
"""

from __future__ import annotations

from pathlib import Path

import tomli_w

from workflow.campaign.study import Study
from workflow.campaign.sweep import read_sweep
from workflow.data.files import atomic_write, read_plain
from workflow.errors import InputError

TEMPLATES = Path(__file__).with_name("exports")
MANAGERS = {
    "row": "row submit",
    "signac": "python init.py && python project.py run",
    "snakemake": "snakemake --cores 1",
}


def write_project(declaration: Path, folder: Path, manager: str) -> str:
    """Write the study that ``declaration`` declares into the new ``folder`` for ``manager``; the command that starts it.

    Raises InputError for a declaration that makes no study, and for a folder that is not empty.
    """
    study = Study(folder, read_sweep(declaration))
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"'{folder}' exists and is not empty; nothing was changed. Give another --out DIR")
    study.save()
    write(folder / "study.toml", read_plain(declaration))
    (folder / "scenes").mkdir()
    for point in study.points:
        values = {name: value for name, value in point.values.items() if value is not None}
        write(folder / "scenes" / f"{point.name}.toml", tomli_w.dumps(values))
        if manager == "row":  # which looks for directories, not for files
            study.directory(point).path.mkdir()
    for path in sorted((TEMPLATES / manager).rglob("*")):
        if path.is_file() and path.suffix != ".pyc":  # an installation compiles what ends in .py
            target = folder / path.relative_to(TEMPLATES / manager)
            target.parent.mkdir(parents=True, exist_ok=True)
            write(target, read_plain(path))
    write(folder / "point.sh", read_plain(TEMPLATES / "point.sh"))
    return MANAGERS[manager]


def write(path: Path, text: str) -> None:
    """Write a file as a whole."""
    with atomic_write(path) as draft:
        draft.write_text(text, encoding="utf-8")
