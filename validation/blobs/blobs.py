"""The blob size xi of eqs. 27 and 28 of G07, fitted in several ways to samples of series A, method 2.

    python validation/blobs/blobs.py RUN ...        writes blobs.csv beside this file

RUN: finished runs of `wf run method2 --series A` (others are left out).  Rows: each state of each sample (the end of the
last stage without load, and the load), and the mean I(k) of all samples of a kind (`samples` above 1).  Fits: of I(k) (eq. 28)
from the smallest k to `top`, weighted with the noise of a shell (`noise`, what `wf measure` does) or relative to I, all
shells alike (`relative`); and, for single samples, of C(r) itself (eq. 27) for r from 1 a to 5 a, which knows no k (`real
space`).
"""

import csv
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit

from workflow.archive.read import Archive
from workflow.data.balance import solid_fraction
from workflow.errors import WorkflowError
from workflow.measures.density import autocorrelation, average, scattering
from workflow.measures.fractal import fit_fractal
from workflow.measures.holes import holes
from workflow.measures.registry import shells
from workflow.pipeline.collect import settings_of
from workflow.runs.directory import RunDirectory

TOPS = (np.pi, 4.5, 2 * np.pi)
RINGS = np.append(0.0, np.arange(0.01, 8.0, 0.1))
MESH = 0.02


def fits(data):
    """Of I(k): name, d_F and xi with errors; empty where the data leave them open."""
    alike = replace(data, vectors=np.where(data.vectors > 0, 100.0, 0.0))
    for name, one in (("noise", data), ("relative", alike)):
        for top in TOPS:
            row = {"fit": name, "top": top}
            try:
                found = fit_fractal(one, (float(np.nanmin(data.k)), top))
            except WorkflowError:
                found = None
            if found:
                row |= {"d_F": found.dimension, "d_F_error": found.errors["dimension"]}
                row |= {"xi": found.xi, "xi_error": found.errors["xi"]}
            yield row


def real_space(frame):
    """Of C(r): ln(C(r) - Phi^2) = const + (d_F - 2) ln r - r/xi, least squares."""
    found, phi = autocorrelation(frame, RINGS, spacing=MESH), solid_fraction(frame)
    excess = found.c - phi**2
    rows = (found.r > 1.0) & (found.r < 5.0)
    if not (excess[rows] > 0).all():  # correlations end before 5 a
        return {}

    def law(r, dimension, log_xi, constant):
        return constant + (dimension - 2) * np.log(r) - r / np.exp(log_xi)

    best, covariance = curve_fit(law, found.r[rows], np.log(excess[rows]), [1.7, 0.5, -2.0])
    error, xi = np.sqrt(np.diag(covariance)), np.exp(best[1])
    return {"d_F": best[0], "d_F_error": error[0], "xi": xi, "xi_error": error[1] * xi} if error[1] < 1 else {}


def states(run):
    """The two states of a finished run of series A, with the law's constants."""
    directory = RunDirectory.open(run)
    scene = directory.scene
    if getattr(scene, "series", "") != "A" or directory.state["status"] != "finished" or not scene.pressure:
        return
    with Archive(run / "run.h5") as archive:
        ends = {stage: k for k, stage in enumerate(archive.stages)}
        frames = [archive.frame(ends["free"]), archive.frame(-1)]
    for frame, pressure in zip(frames, (0.0, scene.pressure), strict=True):
        kind = {"digest": directory.state["digest"][:12], "grains": scene.n, "rolling": scene.rolling, "seed": scene.seed,
                "cell_mass": scene.cell_mass, "rate_cap": scene.rate_cap, "pstar": pressure, "samples": 1}  # fmt: skip
        yield kind, frame, settings_of(scene, scene.law_of(frame.stage))


def main(runs):
    rows, alike = [], defaultdict(list)
    for run in runs:
        for kind, frame, law in states(run):
            sample = {"solid_fraction": solid_fraction(frame), "hole_radius": holes(frame).weighted_radius}
            rows += [kind | sample | row for row in fits(scattering(frame, shells(frame, law)))]
            rows.append(kind | sample | {"fit": "real space"} | real_space(frame))
            alike[kind["pstar"], kind["rolling"], kind["rate_cap"]].append((kind, frame, law, sample))
            print(kind | sample, flush=True)
    for members in alike.values():
        largest, law = max(((frame, law) for _, frame, law, _ in members), key=lambda one: float(one[0].cell.max()))
        mean = average([scattering(frame, shells(largest, law)) for _, frame, _, _ in members])
        kind = members[0][0] | {"digest": "", "seed": "", "samples": len(members)}
        kind["grains"] = " ".join(str(one["grains"]) for one, *_ in members)
        kind |= {name: float(np.mean([sample[name] for *_, sample in members])) for name in ("solid_fraction", "hole_radius")}
        rows += [kind | row for row in fits(mean)]
    rows.sort(key=lambda row: (row["pstar"], row["rolling"], row["rate_cap"], str(row["grains"]), str(row["seed"])))
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, [*kind, "fit", "top", "d_F", "d_F_error", "xi", "xi_error", "2_pi_xi"], restval="")
        writer.writeheader()
        for row in rows:
            row |= {"2_pi_xi": 2 * np.pi * row["xi"]} if "xi" in row else {}
            writer.writerow({name: f"{value:.5g}" if isinstance(value, float) else value for name, value in row.items()})


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
