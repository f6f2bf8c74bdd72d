"""Force networks, rigidity and density correlations of method-2 samples, beside tables VI and VII of G07.

    python validation/networks/networks.py RUNS        writes networks.csv and networks_fits.csv beside this file

RUNS is a folder of finished runs of `wf run method2`, named SERIES-rr-SEED or SERIES-norr-SEED.  networks.csv has a row for
each run at P* = 0 (the end of the last stage without load) and at its load; networks_fits.csv a row for each fit of eq. 28
to I(k) averaged over the samples of one kind, in several windows of k.
"""

import csv
import re
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from workflow.archive.read import Archive
from workflow.measures.clusters import local_coordination
from workflow.measures.density import scattering
from workflow.measures.packing import measure
from workflow.measures.registry import density_of, measure_groups, shells
from workflow.pipeline.collect import settings_of
from workflow.runs.directory import RunDirectory

GROUPS = ("forces", "clusters", "rigidity", "self_stress", "holes")
UNLOADED = ("free", "stiffen")  # stages that end in equilibrium at P* = 0, the last one counts
WINDOWS = (np.pi, 4.5, 2 * np.pi)  # upper ends of the range of k of the fit [1/a]; the lower end is the smallest k there is


def states(run: Path):
    """Frame, law and imposed pressure of the two states of a run."""
    scene = RunDirectory.open(run).scene
    with Archive(run / "run.h5") as archive:
        ends = {stage: k for k, stage in enumerate(archive.stages)}
        last = max((stage for stage in UNLOADED if stage in ends), key=lambda stage: ends[stage])
        chosen = [archive.frame(ends[last])]
        if scene.pressure:
            chosen.append(archive.frame(-1))
    for frame in chosen:
        yield frame, settings_of(scene, scene.law_of(frame.stage)), scene.pressure_of(frame.stage) or 0.0


def row(run: Path, kind: dict[str, object], frame, law, pressure: float) -> dict[str, object]:
    """The numbers of one state; H is checked against the counting identity as printed, eq. 19 or 21."""
    numbers = measure(frame, force_unit=law.force_unit, targets=(pressure, pressure))
    found = measure_groups(frame, law, GROUPS)
    people, network, holes = found["forces"]["populations"], found["rigidity"], found["holes"]
    bars = 3 if law.law.rolling else 2
    counted = bars * network["contacts"] + network["distant"] + network["floppy_modes"] - 3 * frame.grains - 2
    assert counted == network["hyperstaticity"]
    loose = int((local_coordination(frame, least=2) == 0).sum())  # grains that hang on one contact, or on a chain of such
    signs = {"plus": people["repulsive"], "minus": people["tensile"], "zero": people["vanishing"]}
    return kind | {
        "pstar": pressure, "grains": frame.grains, "solid_fraction": numbers["solid_fraction"], "z": numbers["coordination"],
        "contacts": network["contacts"], "distant": network["distant"],
        **{f"z_{sign}": part["coordination"] for sign, part in signs.items()},
        **{f"n_{sign}_{name}": signs[sign][name] for sign in ("plus", "minus") for name in ("mean", "quadratic")},
        "vanishing_share": people["vanishing"]["share"], "unstressed_share": people["unstressed"],
        "strong_share": people["strong"], "f_perc": found["forces"]["percolation"]["threshold"],
        "stressed_clusters": found["clusters"]["stressed"]["number"],
        "largest_stressed": found["clusters"]["stressed"]["largest"],
        "self_stressed_clusters": found["self_stress"]["number"],
        "largest_self_stressed": max(found["self_stress"]["grains"], default=0),
        "hyperstaticity": network["hyperstaticity"], "floppy_modes": network["floppy_modes"], "hanging_grains": loose,
        "positive_definite": network["positive_definite"], "unstable_modes": network["unstable_modes"],
        "smallest_pivot": network["smallest_pivot"], "largest_residue": network["largest_residue"],
        "rumpf": numbers["rumpf_ratio"], "rumpf_weighted": numbers["rumpf_ratio_weighted"],
        "hole_radius": holes["weighted_radius"], "hole_radius_grid": holes["grid"]["weighted_radius"],
        "net_force": numbers["unbalanced_force"]["force"], **provenance(run),
    }  # fmt: skip


def provenance(run: Path) -> dict[str, object]:
    """What made the run."""
    state = RunDirectory.open(run).state
    return {"digest": state["digest"][:12], "workflow": state["versions"]["workflow"], "lammps": state["versions"]["lammps"]}


def fits(kind: dict[str, object], samples: list):
    """Eq. 28 to the mean I(k) of frames of one kind."""
    largest = max((frame for frame, _ in samples), key=lambda frame: float(frame.cell.max()))
    found = [scattering(frame, shells(largest, law)) for frame, law in samples]
    lowest = 2 * np.pi / float(largest.cell.max())
    for top in WINDOWS:
        fit = density_of(found, replace(samples[0][1], window=(0.999 * lowest, top)))["fit"]
        if "error" in fit:
            fit = {"error": "undetermined"}
        else:
            fit = {"low": fit["window"][0], "high": fit["window"][1], "shells": fit["points"], "d_f": fit["dimension"],
                   "d_f_error": fit["errors"]["dimension"], "xi": fit["xi"], "xi_error": fit["errors"]["xi"],
                   "chi2": fit["reduced_chi2"], "error": ""}  # fmt: skip
        yield kind | {"samples": len(samples), "grains": samples[0][0].grains, "top": top, **fit}


def main(runs: Path) -> None:
    """Measure all finished runs of the folder, write both tables."""
    rows, kinds = [], defaultdict(list)
    for run in sorted(runs.iterdir()):
        named = re.fullmatch(r"(A0|A|B)-(rr|norr)-(\d+)", run.name)
        if not named or not (run / "measures.json").is_file():
            continue
        series, rolling = named[1], named[2] == "rr"
        for frame, law, pressure in states(run):
            rows.append(row(run, {"run": run.name, "series": series, "rolling": rolling}, frame, law, pressure))
            kinds[series, rolling, pressure].append((frame, law))
            print({name: rows[-1][name] for name in ("run", "pstar", "z", "hyperstaticity", "floppy_modes")}, flush=True)
    write(Path(__file__).with_suffix(".csv"), rows)
    names = ("series", "rolling", "pstar")
    table = [one for key, samples in kinds.items() for one in fits(dict(zip(names, key, strict=True)), samples)]
    write(Path(__file__).with_name("networks_fits.csv"), table)


def write(path: Path, rows: list[dict[str, object]]) -> None:
    """Rows as CSV; numbers to six digits."""
    names = list(dict.fromkeys(name for one in rows for name in one))
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        for one in rows:
            writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in one.items()})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
