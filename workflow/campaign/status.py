"""Where a study stands: counts, core hours, what runs and what failed, for programs and for people."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from workflow.campaign import slurm, study
from workflow.campaign.study import Study, remaining
from workflow.runs.standing import progress

MOST = 20  # of those that run, and of those that failed, that people see


def study_standing(path: Path) -> dict[str, Any]:
    """Counts, core hours spent and left, and every point; the progress of those at work."""
    whole = Study.open(path)
    standings, _, error = slurm.standings(whole)
    counts = Counter(now.status for now in standings)
    left = remaining(whole.points, standings)
    return {
        "directory": str(path),
        "counts": {status: counts[status] for status in study.STATUSES},
        "scheduler": error,
        "core_hours_spent": sum(now.core_seconds for now in standings) / 3600.0,
        "core_hours_left": None if left is None else left / 3600.0,
        "points": [
            {
                "name": point.name, "label": whole.label(point), "status": now.status, "reason": now.reason,
                "seconds": now.seconds,
                "line": progress(whole.directory(point), point.scene) if now.status == study.RUNNING else None,
            }
            for point, now in zip(whole.points, standings, strict=True)
        ],
    }  # fmt: skip


def in_words(row: dict[str, Any]) -> str:
    """A study for people."""
    left = row["core_hours_left"]
    cost = f"core hours: {row['core_hours_spent']:.2f} spent, {'unknown' if left is None else f'about {left:.2f}'} left"
    counts = ", ".join(f"{count} {status}" for status, count in row["counts"].items() if count or status == study.DONE)
    kinds = {kind: [one for one in row["points"] if one["status"] == kind] for kind in (study.RUNNING, study.FAILED)}
    shown = [one for some in kinds.values() for one in some[:MOST]]
    width = max((len(one["label"]) for one in shown), default=0)
    lines = []
    for one in shown:
        words = one["line"] or one["reason"] or ""
        lines.append(f"  {one['status']:8s} {one['name']}  {one['label']:{width}s}  {words}")
    lines += [f"  and {len(some) - MOST} more {kind}: see --json" for kind, some in kinds.items() if len(some) > MOST]
    short = sum(one["status"] == study.DONE and one["reason"] == study.OUT_OF_TIME for one in row["points"])
    lines += [f"  {short} of those done {study.OUT_OF_TIME}"] if short else []
    waits = Counter(one["reason"] for one in row["points"] if one["status"] == study.WAITING and one["reason"])
    lines += [f"  {count} waiting {reason}" for reason, count in waits.most_common()]
    lines += [f"  the scheduler was not asked: {row['scheduler']}"] if row["scheduler"] else []
    return "\n".join([f"{row['directory']}  {len(row['points'])} points: {counts or 'none'}; {cost}", *lines])
