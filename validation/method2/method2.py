"""Method 2 against tables IV to VI of G07, and what the relaxation does.

    python validation/method2/method2.py RUNS      runs what is missing in the folder RUNS, writes method2.csv beside this file

Each row of method2.csv is the end of a stage of one run: its options, its numbers, the digest of its scene.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path

from workflow.archive.read import Archive

RR, PLAIN = ["--rolling"], ["--no-rolling"]
UNLOADED = ["--pstar", "0"]
SMALL = ["--n", "400", "--max-time", "1500", *UNLOADED]
RUNS = {
    "A-rr-1": ["--series", "A", *RR, "--seed", "1", "--frame-interval", "10"],
    "A-norr-1": ["--series", "A", *PLAIN, "--seed", "1", "--frame-interval", "10"],
    "A-norr-2": ["--series", "A", *PLAIN, "--seed", "2"],
    "B-rr-1": ["--series", "B", *RR, "--seed", "1"],
    "B-norr-1": ["--series", "B", *PLAIN, "--seed", "1"],
    "large-rolling-slow-1": ["--n", "400", "--kappa", "1e4", *RR, "--mur", "0.5", "--v0", "0.95", *UNLOADED, "--seed", "1"],
    **{
        f"r-{rr[0][2:]}-{drag}": [*SMALL, *rr, "--drag", drag]
        for rr in (RR, PLAIN)
        for drag in ("3", "1", "0.3", "0.1", "0.03")
    },
    "r-rolling-0": [*SMALL, *RR, "--drag", "0"],
}


def rows(name: str, options: list[str], runs: Path) -> list[dict[str, object]]:
    """A row for the end of each stage of a run, made if it is not there yet."""
    out = runs / name
    if not (out / "measures.json").is_file():
        done = subprocess.run(["wf", "run", "method2", *options, "--out", str(out)], check=False, stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 3):  # 3: not in equilibrium, which the numbers say
            raise SystemExit(done.returncode)
    measures, state = (json.loads((out / file).read_text()) for file in ("measures.json", "run.json"))
    with Archive(out / "run.h5") as archive:
        stages, series = archive.stages, archive.series
        ends = {stage: archive.frame(k) for k, stage in enumerate(stages)}
    relaxation, table, begun = measures["relaxation"] or {}, [], 0.0
    for stage, frame in ends.items():
        row = int(series["step"].searchsorted(frame.step, "right")) - 1
        change = relaxation.get(stage, {})
        in_contact = int(frame.interactions.in_contact.sum())
        table.append({
            "run": name, "options": " ".join(options), "stage": stage, "time": frame.time, "duration": frame.time - begun,
            "solid_fraction": float((frame.diameter**2).sum() * 0.7853981633974483 / frame.area),
            "coordination": 2 * len(frame.interactions) / frame.grains,
            "contacts": in_contact, "distant": len(frame.interactions) - in_contact,
            "aggregates": int(series["aggregates"][row]), "net_force": float(series["net_force"][row]),
            "kinetic_per_grain": float(series["kinetic_per_grain"][row]),
            "contacts_opened": change.get("contacts_opened"), "contacts_closed": change.get("contacts_closed"),
            "equilibrated": measures["equilibrated"] if stage == stages[-1] else None,
            "energy_residual": (measures["energy_residual"] or {}).get("relative") if stage == stages[-1] else None,
            "seconds": round(state["seconds"], 1), "digest": state["digest"][:12],
            "workflow": state["versions"]["workflow"], "lammps": state["versions"]["lammps"],
        })  # fmt: skip
        begun = frame.time
    return table


def main(runs: Path) -> None:
    """Run, write the table."""
    table = [row for name, options in RUNS.items() for row in rows(name, options, runs)]
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, table[0])
        writer.writeheader()
        writer.writerows(table)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
