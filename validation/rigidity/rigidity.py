"""Rumpf's relation, the counts of the rigidity matrix and positive definiteness of every cohesive packing under load.

    python validation/rigidity/rigidity.py RUN ...     writes rigidity.csv beside this file

RUN: run directories of methods 1 and 2; those that are not finished, or without cohesion or load, are left out, and of runs of
one scene the first counts.  `residual`: H - (N (z - 3) + k - 2), eq. 19 in a free cell, with RR H - (3 N z/2 - 3 N + k - 2),
eq. 21, without friction H - (N (z/2 - 2) + k - 2), eq. 22, z counting contacts and distant pairs alike.  What is left is that
a distant pair has one row where a contact has two or three: `residual` is minus once or twice the number of distant pairs.
"""

import csv
import sys
from pathlib import Path

from workflow.archive.read import Archive
from workflow.errors import WorkflowError
from workflow.measures.modes import without_loose
from workflow.measures.packing import measure
from workflow.measures.rigidity import rigidity
from workflow.pipeline.collect import settings_of
from workflow.runs.directory import RunDirectory

KIND = ("method", "series", "n", "phi0", "mu", "rolling", "cell_mass", "rate_cap", "seed")


def row(run):
    """The numbers of one run, None for one that does not count."""
    try:
        directory = RunDirectory.open(run)
        scene, state = directory.scene, directory.state
        if state["status"] != "finished" or not getattr(scene, "cohesion", False) or not scene.pressure:
            return None
        with Archive(run / "run.h5") as archive:
            frame = archive.frame(-1)
    except WorkflowError as fault:
        print(fault, flush=True)
        return None
    law, pressure = settings_of(scene, scene.law_of(frame.stage)), scene.pressure_of(frame.stage)
    numbers = measure(frame, force_unit=law.force_unit, targets=(pressure, pressure))
    found = rigidity(frame, law=law.law, free_cell=True, **law.resists).as_dict()
    grains, pairs = frame.grains, found["contacts"] + found["distant"]
    rows, freedom = (3, 3) if scene.rolling else (2, 3) if scene.mu else (1, 2)  # of a contact, of a grain
    values = vars(scene) | {"method": type(scene).__name__, "rolling": scene.rolling}
    return {name: values.get(name, "") for name in KIND} | {
        "solid_fraction": numbers["solid_fraction"], "z": 2 * pairs / grains,
        "rumpf_ratio": numbers["rumpf_ratio"], "rumpf_ratio_weighted": numbers["rumpf_ratio_weighted"],
        "contacts": found["contacts"], "distant": found["distant"], "hyperstaticity": found["hyperstaticity"],
        "residual": found["hyperstaticity"] - (rows * pairs - freedom * grains + found["floppy_modes"] - 2),
        "floppy_modes": found["floppy_modes"], "loose_grains": grains - without_loose(frame).grains,
        "positive_definite": found["positive_definite"], "unstable_modes": found["unstable_modes"],
        "backbone_grains": found["backbone_grains"], "backbone_mechanisms": found["backbone_mechanisms"],
        "positive_definite_backbone": found["positive_definite_backbone"], "digest": state["digest"][:12],
    }  # fmt: skip


def main(runs):
    rows = {}
    for run in runs:
        one = row(run)
        if one and rows.setdefault(one["digest"], one) is one:
            print(run.name, one["z"], one["floppy_modes"], one["backbone_mechanisms"], flush=True)
    kept = sorted(rows.values(), key=lambda one: tuple(map(str, (one[name] for name in KIND))))
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, kept[0])
        writer.writeheader()
        for one in kept:
            writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in one.items()})


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
