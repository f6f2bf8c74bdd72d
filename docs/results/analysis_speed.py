"""Time and memory of every group of measures on 5600, 100 000 and 1 000 000 grains.

    python docs/results/analysis_speed.py RUN        writes analysis_speed.csv beside this file

RUN is the directory of a run of 1400 grains (`wf run method1 --out RUN`); its last frame, repeated 2 x 2, 8 x 9 and
27 x 27 times with its contacts and forces, is the packing that is measured.  Each measurement is a process of its own on
one core; memory is its largest resident size, the frame itself included.  "seconds" passed on the clock, which other
work on the machine lengthens; "processor_seconds" were spent.  "read" measures no group.
"""

import csv
import json
import os
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

SIZES = ((2, 2), (8, 9), (27, 27))
DENSE = ("rigidity", "elastic_moduli", "self_stress", "floppy_modes", "vibrations")  # factorise: up to 100 000 grains
LIMIT = 1200  # seconds after which a measurement is given up


def one(run: Path, times: tuple[int, int], name: str) -> dict[str, object]:
    """Measure one group here."""
    from workflow.analysis.build import repeat
    from workflow.analysis.groups import measure_groups
    from workflow.archive.read import Archive
    from workflow.engine.collect import constants_of
    from workflow.engine.rundir import RunDirectory

    with Archive(run / "run.h5") as archive:
        frame = repeat(archive.frame(-1), times)
    law = constants_of(RunDirectory.open(run).scene)
    start, work = time.perf_counter(), time.process_time()
    result = measure_groups(frame, law, [name] if name != "read" else [])
    seconds, work = time.perf_counter() - start, time.process_time() - work
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2  # kB to GB
    error = result.get(name, {}).get("error", "")
    times = {"seconds": round(seconds, 2), "processor_seconds": round(work, 2)}
    return {"grains": frame.grains, "group": name, **times, "peak_GB": round(peak, 2), "error": error}


def measured(run: Path, times: tuple[int, int], name: str) -> dict[str, object]:
    """Measure one group in a process of its own."""
    command = [sys.executable, __file__, str(run), *map(str, times), name]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        grains = times[0] * times[1] * 1400
        return {"grains": grains, "group": name, "seconds": "", "processor_seconds": "", "peak_GB": "", "error": f"> {LIMIT} s"}
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def main(run: Path) -> None:
    """Every group at every size it is meant for; measurements that the table holds already are kept."""
    from workflow.analysis.groups import GROUPS

    table = Path(__file__).with_suffix(".csv")
    with open(table, newline="") if table.exists() else open(os.devnull) as file:
        rows = list(csv.DictReader(file))
    known = {(int(row["grains"]), row["group"]) for row in rows}
    machine = {"python": platform.python_version(), "processor": processor(), "date": time.strftime("%Y-%m-%d", time.gmtime())}
    for times in SIZES:
        for name in ("read", *GROUPS):
            if (1400 * times[0] * times[1], name) in known or (times == SIZES[-1] and name in DENSE):
                continue
            rows.append({**measured(run, times, name), **machine})
            print(rows[-1], flush=True)
            with open(table, "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0])
                writer.writeheader()
                writer.writerows(sorted(rows, key=lambda row: int(row["grains"])))


def processor() -> str:
    """Model name of the processor, as the kernel gives it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    if len(sys.argv) == 2:
        main(Path(sys.argv[1]))
    else:
        print(json.dumps(one(Path(sys.argv[1]), (int(sys.argv[2]), int(sys.argv[3])), sys.argv[4])))
