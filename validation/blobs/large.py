"""Fractal dimension and blob size (eqs. 27, 28 of G07) of single large samples, fitted in several ways.

    python validation/blobs/large.py RUN ...        writes large.csv beside this file; rows of other runs in it stay

RUN: directories of runs of method 2; of each the last frame, also of a run that was interrupted.  The fits are those of
blobs.py: of I(k) from the smallest k to `top`, weighted with the noise of a shell or relative to I, and of C(r) itself.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from blobs import fits, real_space

from workflow.archive.read import Archive
from workflow.data.balance import solid_fraction
from workflow.measures.density import scattering
from workflow.measures.packing import coordination
from workflow.measures.registry import shells
from workflow.pipeline.collect import settings_of
from workflow.runs.directory import RunDirectory

NAMES = (
    "digest", "version", "grains", "series", "rolling", "seed", "status", "stage", "time", "aggregates", "largest",
    "solid_fraction", "z", "fit", "top", "d_F", "d_F_error", "xi", "xi_error", "2_pi_xi",
)  # fmt: skip


def main(runs):
    table = Path(__file__).with_suffix(".csv")
    found = [row for run in runs for row in measured(run)]
    here = {row["digest"] for row in found}
    with open(table, newline="") as file:
        others = [row for row in csv.DictReader(file) if row["digest"] not in here]
    with open(table, "w", newline="") as file:
        writer = csv.DictWriter(file, NAMES, restval="")
        writer.writeheader()
        writer.writerows(others + found)


def measured(run):
    """The rows of one run, a fit each."""
    directory = RunDirectory.open(run)
    scene, state = directory.scene, directory.state
    with Archive(run / "run.h5") as archive:
        frame = archive.frame(-1)
        last = {name: archive.series[name][-1] for name in ("time", "aggregates", "largest_aggregate")}
    kind = {
        "digest": state["digest"][:16], "version": state["versions"]["workflow"], "grains": scene.n,
        "series": scene.series, "rolling": scene.rolling, "seed": scene.seed, "status": state["status"],
        "stage": frame.stage, "time": last["time"], "aggregates": int(last["aggregates"]),
        "largest": int(last["largest_aggregate"]),
        "solid_fraction": solid_fraction(frame), "z": coordination(frame, threshold=0.0).z,
    }  # fmt: skip
    law = settings_of(scene, scene.law_of(frame.stage))
    for row in (*fits(scattering(frame, shells(frame, law))), {"fit": "real space"} | real_space(frame)):
        row |= {"2_pi_xi": 2 * np.pi * row["xi"]} if "xi" in row else {}
        yield {name: f"{value:.5g}" if isinstance(value, float) else value for name, value in (kind | row).items()}


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
