"""Would an adaptive step pay?  The longest step that each row of a run's time series allows, against the one used.

    python validation/adaptive_step/adaptive_step.py RUNS

A row allows what the step rule gives for the state at that time: the stiffest period / 28 while any contact exists, five
steps in the tail at the present approach speed, and without contact and attraction ten times the usual step (nothing acts).
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from workflow.runs.directory import RunDirectory

CASES = {
    "cohesive": ["--cohesion"],
    "cohesionless": ["--no-cohesion"],
    "dilute cohesive": ["--cohesion", "--phi0", "0.1"],
    "D0 = 1e-4": ["--d0", "1e-4"],
    "D0 = 1e-5": ["--d0", "1e-5", "--max-time", "12"],
    "P* = 100": ["--pstar", "100", "--max-time", "3", "--series-interval", "0.002"],
}


def main(runs: Path) -> None:
    """Run what is missing, print one line per case."""
    for case, options in CASES.items():
        out = runs / case.replace(" ", "").replace("*", "").replace("=", "_")
        if not (out / "measures.json").is_file():
            words = [
                "wf",
                "run",
                "method1",
                "--n",
                "150",
                "--series-interval",
                "0.02",
                "--max-time",
                "60",
                *options,
                "--out",
                str(out),
                "--json",
            ]
            done = subprocess.run(words, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            if done.returncode not in (0, 3):  # 3: not in equilibrium, which the numbers say
                raise SystemExit(done.returncode)
        directory = RunDirectory.open(out)
        scene, series = directory.scene, directory.series() or {}
        step, law = scene.step_choice.step, scene.law_in_units
        contact = np.where(series["contacts"] > 0, scene.step_choice.period / scene.steps_per_period, 10.0 * step)
        tail = law.d0 / (5.0 * np.maximum(series["approach"], 1e-300)) if law.f0 else np.inf
        allowed = np.minimum(contact, tail)
        gain = 1.0 / np.mean(step / np.maximum(allowed, step))
        print(f"{case:18s} rows without contact {100 * np.mean(series['contacts'] == 0):5.1f} %  "
              f"rows that allow twice the step {100 * np.mean(allowed > 2 * step):5.1f} %  most that could be saved: "
              f"{gain:.2f} times faster")  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1]))
