"""Phi(P*) and the contact network along it, from the runs of consolidation.toml: a table, and a figure beside this file.

wf sweep validation/consolidation/consolidation.toml --jobs 2
python validation/consolidation/consolidation.py runs/consolidation > validation/consolidation/consolidation.csv
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from workflow.archive.read import Archive
from workflow.campaign.measured import found_at
from workflow.campaign.study import DONE, Study
from workflow.pipeline.collect import measures_of
from workflow.reports.of_runs import consolidation
from workflow.reports.registry import Shown
from workflow.runs.directory import ARCHIVE

PATHS = {
    "t": "time", "Phi": "solid_fraction", "z": "coordination", "rattlers": "rattler_fraction",
    "z+": "forces.populations.repulsive.coordination", "z-": "forces.populations.tensile.coordination",
    "z0": "forces.populations.vanishing.coordination", "strong": "forces.populations.strong",
    "N+": "forces.populations.repulsive.mean", "F_perc": "forces.percolation.threshold", "H": "rigidity.hyperstaticity",
    "k": "rigidity.floppy_modes", "bulk": "elastic_moduli.bulk", "shear": "elastic_moduli.shear",
}  # fmt: skip


def main(folder: Path) -> None:
    """One row for each stress of each run, at its end."""
    study = Study.open(folder)
    writer = csv.writer(sys.stdout)
    writer.writerow(["rolling", "seed", "n", "direction", "P*", *PATHS, "digest"])
    done = [point for point in study.points if study.standing(point).status == DONE]
    names = [f"{'' if point.values['rolling'] else 'no '}RR, seed {point.values['seed']}" for point in done]
    shown = [Shown(study.directory(point), name) for point, name in zip(done, names, strict=True)]
    consolidation(shown, [Path(__file__).with_suffix(".png")])
    for point in done:
        directory = study.directory(point)
        scene = directory.scene
        with Archive(directory / ARCHIVE) as archive:
            ends = archive.ends
        loads: dict[tuple[str, float], int] = {}
        for stage, frame in ends.items():
            stress = scene.pressure_of(stage)
            if stress is not None and not stage.startswith(("free", "stiffen")):
                loads["down" if stage.startswith(("unload", "resettle")) else "up", stress] = frame
        start = {("up", 0.0): ends["stiffen"]} if "stiffen" in ends else {}
        for (direction, stress), frame in (start | loads).items():
            measures = measures_of(directory, frame)
            values = [found_at(measures, path) for path in PATHS.values()]
            row = ["" if value is None else f"{value:.6g}" for value in values]
            writer.writerow([scene.rolling, scene.seed, scene.n, direction, f"{stress:.6g}", *row, point.name])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
