"""Mean and scatter of measures over samples."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from workflow.errors import InputError
from workflow.measures.density import Scattering
from workflow.measures.registry import Settings, density_of, plain

CLOCK = ("step", "time")  # of a frame; their mean over samples means nothing


def pool(samples: Sequence[Mapping[str, Any]], settings: Settings | None) -> dict[str, Any]:
    """Every number of ``samples`` (the measures of one sample each) as {"mean", "scatter", "samples"}.

    ``scatter``: standard deviation over the samples that have the number (None for one).  Lists of equal length are
    pooled entry by entry, to "mean" and "scatter" lists; truth values become the number of samples in which they hold;
    what the samples do not share, step and time are left out.  I(k) is averaged over the samples on
    shells of equal k, and eq. 28 is
    fitted to the average (G07 fig. 23).
    """
    if not samples:
        raise InputError("there are no samples to pool; give at least one")
    shared = [name for name in samples[0] if name not in CLOCK and all(name in sample for sample in samples)]
    pooled = {name: _pool([sample[name] for sample in samples]) for name in shared}
    if "density" in pooled and settings is not None:
        parts = [sample["density"] for sample in samples]
        pooled["density"] = plain(density_of(_common([_scattering(p["shells"]) for p in parts if "shells" in p]), settings))
    return {name: part for name, part in pooled.items() if part is not None}


def _pool(values: Sequence[Any]) -> Any:
    """The pooled form of one entry; None for what cannot be pooled (texts, lists of different lengths)."""
    if all(isinstance(value, Mapping) for value in values):
        shared = {name: _pool([v[name] for v in values]) for name in values[0] if all(name in v for v in values)}
        return {name: part for name, part in shared.items() if part is not None} or None
    if all(isinstance(value, list) for value in values):
        return _pool_lists(values)
    if all(isinstance(value, bool) for value in values):
        return {"true": sum(values), "samples": len(values)}
    numbers = [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
    if not numbers or any(isinstance(value, str) for value in values):
        return None
    return _moments(numbers)


def _pool_lists(values: Sequence[list[Any]]) -> dict[str, Any] | None:
    entries = [_pool(column) for column in zip(*values, strict=False)]
    if len({len(value) for value in values}) > 1 or not all(isinstance(e, dict) and "mean" in e for e in entries):
        return None
    return {name: [entry[name] for entry in entries] for name in ("mean", "scatter")} if entries else None


def _moments(numbers: Sequence[float]) -> dict[str, Any]:
    """fmean is exact for equal numbers, so that samples that agree have no scatter."""
    scatter = statistics.stdev(numbers) if len(numbers) > 1 else None
    return {"mean": math.fsum(numbers) / len(numbers), "scatter": scatter, "samples": len(numbers)}


def _scattering(shells: Mapping[str, Any]) -> Scattering:
    """I(k) back from its JSON form, where None stands for NaN."""
    columns = {name: np.array(shells[name], dtype=float) for name in ("edges", "k", "intensity", "error", "vectors")}
    return Scattering(**columns, solid_fraction=float(shells["solid_fraction"]))


def _common(samples: Sequence[Scattering]) -> list[Scattering]:
    """The samples on the widest set of shells; smaller cells have nothing on the lowest ones."""
    widest = max(samples, key=lambda sample: len(sample.edges))

    def filled(sample: Scattering) -> Scattering:
        missing = len(widest.edges) - len(sample.edges)
        if not np.allclose(widest.edges[missing:], sample.edges, rtol=1e-12):
            raise InputError("the samples have different shells of k; measure them with the same length and one version")
        lead = {name: np.concatenate((np.full(missing, np.nan), getattr(sample, name))) for name in ("k", "intensity", "error")}
        vectors = np.concatenate((np.zeros(missing), sample.vectors))
        return Scattering(widest.edges, vectors=vectors, solid_fraction=sample.solid_fraction, **lead)

    return [filled(sample) for sample in samples]


def found_at(tree: Any, path: str) -> float | None:
    """The number at a.b.c of nested mappings, None if there is none."""
    for name in path.split("."):
        tree = tree.get(name) if isinstance(tree, Mapping) else None
    return float(tree) if isinstance(tree, int | float) and not isinstance(tree, bool) else None
