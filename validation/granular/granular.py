"""Method 1 under LAMMPS's granular law and its barostats beside the exact law: a row of granular.csv for each run.

python validation/granular/granular.py RUNS      runs what is missing in the folder RUNS, then writes granular.csv
python validation/granular/granular.py RUNS --finished      runs nothing: the rows of what is finished there
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

FREE, GRANULAR = ["--no-cohesion"], ["--law", "granular"]
CASES = {
    "free_exact": (FREE, 4),
    "free_inertial": ([*FREE, *GRANULAR], 4),
    "free_nph": ([*FREE, *GRANULAR, "--barostat", "nph"], 4),
    "free_berendsen": ([*FREE, *GRANULAR, "--barostat", "berendsen"], 1),
    "coh_exact": ([], 4),
    "coh_inertial": (GRANULAR, 4),
    "coh_nph": ([*GRANULAR, "--barostat", "nph"], 4),
    "coh_exact_nph": (["--barostat", "nph"], 4),
}
GRAINS = "400"


def numbers(run: Path) -> dict[str, object]:
    """What the table has of a finished run."""
    m, state = (json.loads((run / name).read_text()) for name in ("measures.json", "run.json"))
    steps, seconds = int(m["step"]), float(state["seconds"])
    return {
        "solid_fraction": m["solid_fraction"], "coordination": m["coordination"], "equilibrated": m["equilibrated"],
        "unbalanced_force": m["unbalanced_force"]["force"],
        "engine_force_difference": m["unbalanced_force"]["engine_force_difference"],
        "time": m["time"], "steps": steps, "seconds": round(seconds, 1),
        "ns_per_grain_step": round(1e9 * seconds / steps / int(GRAINS)), "digest": state["digest"][:12],
    }  # fmt: skip


def main(runs: Path, compute: bool) -> None:
    """Run what is missing, write the table."""
    rows = []
    for case, (options, seeds) in CASES.items():
        for seed in range(1, seeds + 1):
            out = runs / f"{case}_s{seed}"
            if compute and not (out / "measures.json").is_file():
                words = ["wf", "run", "method1", *options, "--n", GRAINS, "--seed", str(seed), "--out", str(out)]
                subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
            if (out / "measures.json").is_file():
                rows.append({"case": case, "options": " ".join(options), "seed": seed, **numbers(out)})
    with open(Path(__file__).with_suffix(".csv"), "w", encoding="ascii", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]), "--finished" not in sys.argv)
