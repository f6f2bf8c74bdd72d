"""Heaps against B97 (Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997)), claim by claim.

    python validation/heap/heap.py RUNS [CASE ...]      runs what is missing in the folder RUNS, writes the two tables beside
                                                     this file from whatever runs are there

heap.csv: one row per heap.  heap_profile.csv: base force profile of every case, mean and standard error over its heaps.
heap_growth.csv: angle of repose of the cases of 1334 grains while they grow.  heap_profile.png, heap_growth.png: of these.
"""

from __future__ import annotations

import csv
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from workflow.archive.read import Archive
from workflow.errors import InputError
from workflow.measures.heap import angle_of_repose, dip, mean_profile, surface
from workflow.pipeline.heap import ground
from workflow.reports.figures import save, style
from workflow.runs.directory import ARCHIVE, RunDirectory

N = ["--grains", "500"]
SHORT, LONG, HOOKE = ["--index", "144", "--cutoff", "1.047"], ["--index", "144"], ["--hooke", "500"]
CASES: dict[str, tuple[list[str], int]] = {  # options, seeds
    "n 36": ([], 10),
    "Hooke": (HOOKE, 10),
    "n 144 short tail": (SHORT, 10),
    "n 144 long tail": (LONG, 10),
    "n 36, alpha 0.3": (["--alpha", "0.3"], 2),
    "n 36, drop 20": (["--drop-height", "20"], 2),
    "500: n 36": (N, 10),
    "500: Hooke": ([*N, *HOOKE], 10),
    "500: n 144 short tail": ([*N, *SHORT], 10),
    "500: n 144 long tail": ([*N, *LONG], 10),
    "500: mu 0.2": ([*N, "--mu", "0.2"], 10),
    "500: mu 0.6": ([*N, "--mu", "0.6"], 10),
    "500: polydisperse 5 %": ([*N, "--polydispersity", "0.05"], 10),
    "500: polydisperse 10 %": ([*N, "--polydispersity", "0.1"], 10),
    "500: printed damping": ([*N, "--printed-damping"], 4),
    "500: printed rotation": ([*N, "--printed-rotation"], 4),
    "500: spacing 1.0": ([*N, "--spacing", "1.0"], 10),
    "500: spacing 1.4": ([*N, "--spacing", "1.4"], 10),
    "500: drop 20": ([*N, "--drop-height", "20"], 4),
    "500: feed from one place": ([*N, "--feed-half-width", "0.1"], 4),
    "500: wide feed": ([*N, "--feed-half-width", "9"], 4),
    "500: slow feed": ([*N, "--feed-rate", "0.2"], 2),
    "500: half the step": ([*N, "--steps-per-period", "28"], 4),
    "500: scheme of the paper": ([*N, "--scheme", "paper", "--steps-per-period", "20"], 4),
    "flat floor": (["--grains", "200", "--base", "flat"], 1),
    "pyramid": ([*N, "--start", "pyramid", "--spacing", "1.0"], 1),
}


def folder(case: str, seed: int, runs: Path) -> Path:
    """Where a run lives."""
    return runs / f"{case}-{seed}".replace(" ", "_").replace("%", "pc").replace(":", "").replace(",", "")


def make(case: str, seed: int, runs: Path) -> None:
    """The run, if it is not there yet."""
    out = folder(case, seed, runs)
    if not (out / "measures.json").is_file():
        command = ["wf", "run", "heap", *CASES[case][0], "--frame-interval", "0", "--seed", str(seed), "--out", str(out)]
        done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 3):  # 3: not in equilibrium, which the numbers say
            raise SystemExit(done.returncode)


def row(case: str, seed: int, out: Path) -> dict[str, object]:
    """The numbers of one heap."""
    m, state = (json.loads((out / name).read_text()) for name in ("measures.json", "run.json"))
    slides = m["avalanches"] or []
    return {
        "case": case,
        "options": " ".join(CASES[case][0]),
        "seed": seed,
        **{f"angle_{side}": m["angle_of_repose_deg"][side] for side in ("left", "right", "mean", "uncertainty")},
        **{name: m[name] for name in ("height", "half_width", "solid_fraction", "grains_in_heap", "removed", "equilibrated")},
        **m["defects"],
        "sum_over_weight": m["base_force_profile"]["sum_over_weight"],
        "closest_pair": m["closest_pair"],
        "avalanches": len(slides),
        "avalanche_mean_size": statistics.mean(s["size"] for s in slides) if slides else 0,
        "avalanche_mean_depth": statistics.mean(s["depth"] for s in slides) if slides else None,
        "energy_residual": (m["energy_residual"] or {}).get("relative"),
        "time": m["time"],
        "seconds": round(state["seconds"], 1),
        "digest": state["digest"][:12],
        "workflow": state["versions"]["workflow"],
        "lammps": state["versions"]["lammps"],
    }


def profile(case: str, outs: list[Path]) -> list[dict[str, object]]:
    """Mean base force profile of the heaps of a case."""
    heaps = [json.loads((out / "measures.json").read_text())["base_force_profile"] for out in outs]
    mean = mean_profile([(np.array(heap["x"]), np.array(heap["force"])) for heap in heaps])
    columns = zip(mean.x.tolist(), mean.force.tolist(), mean.error.tolist(), strict=True)
    return [
        {"case": case, "heaps": len(outs), "x": round(x, 3), "force": round(f, 4), "error": round(e, 4)}
        for x, f, e in columns
        if f > 0
    ]


def growth(case: str, seeds: list[int], runs: Path) -> list[dict[str, object]]:
    """Angle of repose by number of grains poured, in steps of a hundred: mean over records and heaps, scatter of the heaps."""
    heaps = [_angles(RunDirectory(folder(case, seed, runs))) for seed in seeds]
    rows: list[dict[str, object]] = []
    for low in range(150, 1334, 100):
        means = [m.mean() for n, angle in heaps if len(m := angle[(n >= low) & (n < low + 100)])]
        if means:
            spread = round(float(np.std(means, ddof=1)), 2) if len(means) > 1 else None
            rows.append({"case": case, "grains": low + 50, "heaps": len(means), "angle": round(float(np.mean(means)), 2),
                         "scatter": spread})  # fmt: skip
    return rows


def _angles(run: RunDirectory) -> tuple[np.ndarray, np.ndarray]:
    """Number of grains and mean angle [degrees] in every record of a run; grains that touch nothing do not count."""
    where = ground(run.scene)
    base = run.scene.base_discs()
    with Archive(run / ARCHIVE) as archive:
        tracks = archive.tracks
    found = []
    for place in tracks.position[:, tracks.ids > where.base]:
        there = place[~np.isnan(place[:, 0])]
        if len(there) < 150:
            continue
        near = cKDTree(np.concatenate((there, base))).query(there, k=2)[0][:, 1] < 1.3
        angle = angle_of_repose(surface(there[near], np.ones(near.sum()), where))["mean"]
        if angle is not None:
            found.append((len(there), angle))
    return np.array([n for n, _ in found]), np.array([angle for _, angle in found])


def draw(profiles: list[dict[str, object]], grown: list[dict[str, object]]) -> None:
    """Base force profiles with bands of a standard error, large heaps above, those of 500 below; angles while heaps grow."""
    home = Path(__file__).parent
    with style():
        figure = Figure(figsize=(8.0, 6.4), layout="constrained")
        for axes, small in zip(figure.subplots(2, 1), (False, True), strict=True):
            for case in dict.fromkeys(str(row["case"]) for row in profiles if int(str(row["heaps"])) > 1):
                if case.startswith("500") is small:
                    _band(axes, [row for row in profiles if row["case"] == case], case.removeprefix("500: "))
            axes.set(xlabel=r"$x/\sigma$", ylabel="$F_B/mg$", title="500 grains" if small else "1334 grains", ylim=(0, None))
            axes.legend(frameon=False, fontsize=7)
        save(figure, [home / "heap_profile.png"])
        figure = Figure(figsize=(6.0, 3.4), layout="constrained")
        axes = figure.subplots()
        for case in dict.fromkeys(str(row["case"]) for row in grown):
            n, angle, scatter = (np.array([row[key] or 0.0 for row in grown if row["case"] == case], dtype=float)
                                 for key in ("grains", "angle", "scatter"))  # fmt: skip
            axes.errorbar(n, angle, scatter, marker="o", markersize=3, capsize=2, label=case)
        axes.set(xlabel="grains", ylabel="angle of repose [degrees]")
        axes.legend(frameon=False, fontsize=8)
        save(figure, [home / "heap_growth.png"])


def _band(axes: object, rows: list[dict[str, object]], name: str) -> None:
    x, force, error = (np.array([row[key] for row in rows], dtype=float) for key in ("x", "force", "error"))
    (line,) = axes.plot(x, force, label=f"{name} ({rows[0]['heaps']})", linewidth=1.2)
    axes.fill_between(x, force - error, force + error, color=line.get_color(), alpha=0.2, linewidth=0)


def write(name: str, rows: list[dict[str, object]]) -> None:
    """A table beside this file, whole or not at all."""
    draft = Path(__file__).with_name(f"{name}.part")
    with open(draft, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    os.replace(draft, Path(__file__).with_name(name))


def tables(runs: Path) -> None:
    """Both tables from the runs that are there, and a line per case."""
    rows, profiles, grown = [], [], []
    for case, (_, seeds) in CASES.items():
        there = [seed for seed in range(1, seeds + 1) if (folder(case, seed, runs) / "measures.json").is_file()]
        if not there:
            continue
        of = [row(case, seed, folder(case, seed, runs)) for seed in there]
        rows += of
        part = profile(case, [folder(case, seed, runs) for seed in there])
        profiles += part
        if case.split(":")[0] != "500" and case not in ("flat floor", "pyramid"):
            grown += growth(case, there, runs)
        angles = [float(str(r["angle_mean"])) for r in of if r["angle_mean"] is not None]
        x, force = (np.array([p[key] for p in part], dtype=float) for key in ("x", "force"))
        half = statistics.mean(float(str(r["half_width"])) for r in of)
        spread = statistics.stdev(angles) if len(angles) > 1 else float("nan")
        mean = statistics.mean(angles) if angles else float("nan")
        below = 100.0 * dip(x, force, half)
        print(f"{case:20s} heaps {len(of):2d}  angle {mean:5.1f} +- {spread:4.1f}  centre below maxima {below:5.1f} %")
    if rows:
        write("heap.csv", rows)
        write("heap_profile.csv", profiles)
        write("heap_growth.csv", grown)
        draw(profiles, grown)


def main(runs: Path, chosen: list[str]) -> None:
    """Round by round, so that every case has a heap before one has ten."""
    for name in chosen:
        if name not in CASES:
            raise InputError(f"unknown case '{name}'; known are: {', '.join(CASES)}")
    for seed in range(1, 11):
        for case in chosen:
            if seed <= CASES[case][1]:
                make(case, seed, runs)
    tables(runs)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
