"""Time and memory of every group of measures on 5600, 100 000 and 1 000 000 grains, and of reading frames.

    python validation/analysis_speed/analysis_speed.py RUN        adds to analysis_speed.csv beside this file

RUN is the directory of a run of 1400 grains (`wf run method1 --out RUN`); its last frame, repeated 2 x 2, 8 x 9 and
27 x 27 times with its contacts and forces, is the packing that is measured.  A run of more than 100 000 grains is
measured as it is, and so is the reading of it: "read" takes its last frame from the archive, "dumps" streams all frames
from the text dumps, "collect" makes the archive from them, "stream" goes through all frames of the archive with the
standard numbers of each (columns of one process each, all frames).  Each measurement is a process of its own on
one core; memory is its largest resident size, the frame itself included.  "seconds" passed on the clock, which other
work on the machine lengthens; "processor_seconds" were spent.  For repeated packings
"read" measures no group.
"""

import csv
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SIZES = ((2, 2), (8, 9), (27, 27))
DENSE = ("rigidity", "elastic_moduli", "self_stress", "floppy_modes", "vibrations")  # factorise: up to 100 000 grains
READING = ("read", "dumps", "collect", "stream")
LIMIT = 3000  # seconds after which a measurement is given up


def grains_of(run: Path) -> int:
    """Number of grains of the run."""
    from workflow.runs.directory import RunDirectory

    return RunDirectory.open(run).scene.n


def reading(run: Path, name: str) -> int:
    """Read the frames of a run one way; their number."""
    from workflow.archive.dumps import read_frames
    from workflow.archive.read import Archive
    from workflow.archive.write import write_archive
    from workflow.measures.packing import measure

    dumps = run / "grains.dump", run / "contacts.dump"
    if name == "dumps":
        return sum(1 for _ in read_frames(*dumps))
    if name == "collect":
        with tempfile.TemporaryDirectory(dir=run) as folder:
            write_archive(Path(folder) / "run.h5", read_frames(*dumps), {}, {})
        return 0
    with Archive(run / "run.h5") as archive:
        if name == "read":
            return archive.frame(-1).grains and 1
        return sum(1 for frame in archive.frames if measure(frame, force_unit=1.0)["grains"])


def one(run: Path, times: tuple[int, int], name: str) -> dict[str, object]:
    """Measure one group, or one way to read, here."""
    from workflow.archive.read import Archive
    from workflow.data.build import repeat
    from workflow.measures.registry import measure_groups
    from workflow.pipeline.collect import settings_of
    from workflow.runs.directory import RunDirectory

    number, whole = grains_of(run), times == (1, 1)
    if not (whole and name in READING):
        with Archive(run / "run.h5") as archive:
            frame = repeat(archive.frame(-1), times)
        law = settings_of(RunDirectory.open(run).scene, RunDirectory.open(run).scene.law_of(frame.stage))
    start, work = time.perf_counter(), time.process_time()
    if whole and name in READING:
        result: dict = {name: {"frames": reading(run, name)}}
    else:
        result = measure_groups(frame, law, [name] if name != "read" else [])
    seconds, work = time.perf_counter() - start, time.process_time() - work
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2  # kB to GB
    error = result.get(name, {}).get("error", "")
    spent = {"seconds": round(seconds, 2), "processor_seconds": round(work, 2)}
    source = {"source": "simulated" if whole else "repeated"}
    return {"grains": number * times[0] * times[1], "group": name, **spent, "peak_GB": round(peak, 2), "error": error} | source


def measured(run: Path, times: tuple[int, int], name: str) -> dict[str, object]:
    """Measure one group in a process of its own."""
    command = [sys.executable, __file__, str(run), *map(str, times), name]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        grains, source = times[0] * times[1] * grains_of(run), "simulated" if times == (1, 1) else "repeated"
        unknown = {"seconds": "", "processor_seconds": "", "peak_GB": ""}
        return {"grains": grains, "group": name, **unknown, "error": f"> {LIMIT} s", "source": source}
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def main(run: Path) -> None:
    """Every group at every size it is meant for; measurements that the table holds already are kept."""
    from workflow.measures.registry import GROUPS

    table = Path(__file__).with_suffix(".csv")
    with open(table, newline="") if table.exists() else open(os.devnull) as file:
        rows = [{"source": "repeated", **row} for row in csv.DictReader(file)]
    known = {(int(row["grains"]), row["group"], row["source"]) for row in rows}
    machine = {"python": platform.python_version(), "processor": processor(), "date": time.strftime("%Y-%m-%d", time.gmtime())}
    grains = grains_of(run)
    large = grains > 100_000
    for times in ((1, 1),) if large else SIZES:
        for name in (*(READING if large else ("read",)), *GROUPS):
            source = "simulated" if large else "repeated"
            dense = (large or times == SIZES[-1]) and name in DENSE
            if dense or (grains * times[0] * times[1], name, source) in known:
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
