"""Fractal dimension of objects that have a known one: exact fractals, and ballistic aggregates by two rules.

    python validation/fractals/fractals.py        writes fractals.csv beside this file (about 15 s of one core)

Slopes of I(k) (eq. 26) by `scattering` and `fractal_slope`; slopes of R_g against the number of discs.  Errors are standard
errors: of the fit for R_g (independent aggregates at each size), of 200 bootstraps over aggregates for I(k).
"""

import csv
import platform
import time
from pathlib import Path

import numpy as np

from workflow.data.build import make_frame
from workflow.measures.density import average, scattering
from workflow.measures.fractal import fractal_slope
from workflow.measures.synthetic import ballistic_aggregate

SIZES = 2 ** np.arange(6, 11)
EACH = 40  # aggregates of each size
LARGE = 1024  # of which I(k) is taken
CELL = 400.0
NONE = {name: np.zeros(0, dtype=int) for name in ("i", "j")}
CARPET = [[i, j] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
GASKET = [[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]]


def discs(points, cell: float, diameter: float = 0.02):
    """Small discs, so that their own form factor is flat."""
    return make_frame(points, diameter, (cell, cell), NONE)


def exact(name: str, generator, ratio: float, levels: int, width: float, known: float):
    """Points repeated at scales ratio^k; shells of one period average out the log-periodic wiggle."""
    points = np.zeros((1, 2))
    for level in range(levels):
        points = (points[:, None] + np.asarray(generator) * ratio**level).reshape(-1, 2)
    size = ratio**levels
    edges = 2 * np.pi / size * ratio ** np.arange(1.6, levels - 1.3)
    found = fractal_slope(scattering(discs(points, width * size), edges), (edges[0], edges[-1]))
    yield {"object": name, "number": 1, "discs": len(points), "measure": "I(k)", "low": edges[0], "high": edges[-1],
           "dimension": found.dimension, "error": found.error, "known": known}  # fmt: skip


def aggregates(equal: bool):
    """R_g of EACH aggregates of each size, I(k) of those of LARGE."""
    name = "ballistic, equal clusters" if equal else "ballistic, free flight"
    edges = np.geomspace(0.03, 1.3, 41)
    points, samples = [], []
    for size in SIZES:
        radii = []
        for seed in range(EACH):
            centres = ballistic_aggregate(int(size), np.random.default_rng((int(size), seed)), equal=equal)
            radii.append(0.5 * np.log((centres**2).sum(axis=1).mean()))
            if size == LARGE:
                samples.append(scattering(discs(centres, CELL), edges))
        points.append((np.log(size), np.mean(radii), np.std(radii, ddof=1) / np.sqrt(EACH)))
        print(name, size, np.exp(points[-1][1]), flush=True)
    common = {"object": name, "number": EACH, "known": 1.55}
    for low in (64,):
        x, y, error = np.array([p for p in points if p[0] >= np.log(low) - 1e-9]).T
        (slope, _), covariance = np.polyfit(x, y, 1, w=1 / error, cov="unscaled")
        yield common | {"discs": int(SIZES[-1]), "measure": "R_g", "low": low, "high": int(SIZES[-1]), "dimension": 1 / slope,
                        "error": np.sqrt(covariance[0, 0]) / slope**2}  # fmt: skip
    rng = np.random.default_rng(1)
    for window in ((0.06, 0.6), (0.12, 0.6), (0.12, 1.2)):
        draws = [rng.integers(EACH, size=EACH) for _ in range(200)]
        spread = np.std([fractal_slope(average([samples[k] for k in rows]), window).dimension for rows in draws])
        yield common | {"discs": LARGE, "measure": "I(k)", "low": window[0], "high": window[1],
                        "dimension": fractal_slope(average(samples), window).dimension, "error": spread}  # fmt: skip


def main() -> None:
    """Measure everything, write the table."""
    rows = [
        *exact("Sierpinski carpet", CARPET, 3.0, 6, 1.0, np.log(8) / np.log(3)),
        *exact("Sierpinski gasket", GASKET, 2.0, 9, 3.0, np.log(3) / np.log(2)),
        *aggregates(equal=False), *aggregates(equal=True),
    ]  # fmt: skip
    made = {"numpy": np.__version__, "python": platform.python_version(), "date": time.strftime("%Y-%m-%d", time.gmtime())}
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0] | made)
        writer.writeheader()
        writer.writerows(
            {**row, "dimension": round(row["dimension"], 4), "error": round(row["error"], 4)} | made for row in rows
        )


if __name__ == "__main__":
    main()
