"""Method 1 against tables II and III of G07 (row Phi_I = 0.36), and what the result depends on.

    python validation/method1/method1.py RUNS      runs what is missing in the folder RUNS, writes method1.csv beside this file

Each row of method1.csv is one run of 1400 grains: its options, its numbers, the digest of its scene.
"""

import csv
import json
import statistics
import subprocess
import sys
from pathlib import Path

FREE, COHESIVE = ["--no-cohesion"], ["--cohesion"]
HALF = "5.1e-5"  # half the default step
CASES = {
    "cohesionless": (FREE, 5),
    "cohesive": (COHESIVE, 5),
    "cohesive, M = 14 x sum(m)/L": ([*COHESIVE, "--cell-mass", "14.1"], 5),
    "cohesive, M = 3 x sum(m)/L": ([*COHESIVE, "--cell-mass", "3"], 3),
    "cohesionless, M = 14 x sum(m)/L": ([*FREE, "--cell-mass", "14.1"], 3),
    "cohesionless, half step": ([*FREE, "--step", HALF], 3),
    "cohesive, half step": ([*COHESIVE, "--step", HALF], 3),
    "cohesionless, mu 0.15": ([*FREE, "--mu", "0.15"], 3),
    "cohesive, mu 0.15": ([*COHESIVE, "--mu", "0.15"], 3),
    "cohesionless, rolling": ([*FREE, "--rolling"], 3),
    "cohesive, rolling": ([*COHESIVE, "--rolling"], 3),
    "cohesionless, convention 1": ([*FREE, "--convention", "1"], 3),
    "cohesionless, convention -1": ([*FREE, "--convention", "-1"], 3),
    "cohesive, convention 1": ([*COHESIVE, "--convention", "1"], 3),
    "cohesive, convention -1": ([*COHESIVE, "--convention", "-1"], 3),
    "200 cohesionless, inertial": ([*FREE, "--n", "200"], 3),
    "200 cohesionless, berendsen": ([*FREE, "--n", "200", "--barostat", "berendsen", "--max-time", "5000"], 3),
    "cohesionless, no settling": ([*FREE, "--drag", "0", "--max-time", "150"], 2),
    "cohesive, no settling": ([*COHESIVE, "--drag", "0", "--max-time", "150"], 2),
}


def row(case: str, options: list[str], seed: int, runs: Path) -> dict[str, object]:
    """The numbers of one run, made if it is not there yet."""
    out = runs / f"{case}-{seed}".replace(" ", "_").replace(",", "").replace("(", "").replace(")", "").replace("/", "")
    if not (out / "measures.json").is_file():
        done = subprocess.run(
            ["wf", "run", "method1", *options, "--seed", str(seed), "--out", str(out), "--json"],
            check=False,
            stdout=subprocess.DEVNULL,
        )
        if done.returncode not in (0, 3):  # 3: not in equilibrium, which the numbers say
            raise SystemExit(done.returncode)
    m, state = (json.loads((out / name).read_text()) for name in ("measures.json", "run.json"))
    plain = (
        "solid_fraction",
        "coordination",
        "coordination_backbone",
        "rattler_fraction",
        "rumpf_ratio",
        "rumpf_ratio_weighted",
    )
    return {
        "case": case,
        "options": " ".join(options),
        "seed": seed,
        **{name: m[name] for name in (*plain, "equilibrated", "time")},
        "unbalanced_force": m["unbalanced_force"]["force"],
        "stress_deviation": m["stress"]["deviation"],
        "energy_residual": (m["energy_residual"] or {}).get("relative"),
        "seconds": round(state["seconds"], 1),
        "digest": state["digest"][:12],
        "workflow": state["versions"]["workflow"],
        "lammps": state["versions"]["lammps"],
    }


def main(runs: Path) -> None:
    """Run, write the table, print means."""
    rows = [row(case, options, seed, runs) for case, (options, seeds) in CASES.items() for seed in range(1, seeds + 1)]
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    for case in CASES:
        of = [r for r in rows if r["case"] == case]
        numbers = {name: [float(r[name]) for r in of] for name in ("solid_fraction", "coordination", "time")}
        text = "  ".join(f"{name} {statistics.mean(v):.4f} +- {statistics.stdev(v):.4f}" for name, v in numbers.items())
        print(f"{case:34s} {text}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
