"""The finished points of a study as one table: what was varied, and what came out."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from typing import Any

from workflow.campaign.study import DONE, Study
from workflow.data.cells import named_cells
from workflow.data.files import atomic_write
from workflow.measures.registry import GROUPS
from workflow.pipeline.collect import stored_measures
from workflow.runs.directory import ARCHIVE

RESULTS = "results.csv"


def write_results(study: Study) -> int:
    """results.csv in the folder of the study: name, varied values, seconds and standard measures of every finished point.

    Nested measures are named by their path (unbalanced_force.force); lists and groups of measures are left to `wf measure`.
    Returns the number of rows; without any, nothing is written.
    """
    rows = []
    for point in study.points:
        now, directory = study.standing(point), study.directory(point)
        if now.status == DONE and (directory / ARCHIVE).is_file():
            measures = stored_measures(directory)
            standard = {name: value for name, value in measures.items() if name not in GROUPS}
            varied = {name: point.values.get(name) for name in study.varied}
            # a varied `step` is that of time, the measure of this name the number of the last step
            numbers = {name: value for name, value in _numbers(standard) if name not in varied}
            rows.append({"name": point.name, **varied, "seconds": round(now.seconds, 1), **numbers})
    if rows:
        names = {name: None for row in rows for name in row}
        with atomic_write(study.folder / RESULTS) as draft, open(draft, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(named_cells(names)))
            writer.writeheader()
            writer.writerows(map(named_cells, rows))
    return len(rows)


def _numbers(tree: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{above}{name}.")
        elif isinstance(value, int | float):
            yield above + name, value
