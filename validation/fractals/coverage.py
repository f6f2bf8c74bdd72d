"""How often the 68 % intervals of the fit of eq. 28 hold the truth, on synthetic I(k).

    python validation/fractals/coverage.py        writes coverage.csv beside this file

I(k) of a periodic cell of side L on the shells of `wf measure` up to pi/a: eq. 28 with the given d_F and xi, times the mean
over samples and wave vectors of exponential variates, one for k and -k together.
"""

import contextlib
import csv
import sys
from pathlib import Path

import numpy as np

from workflow.data.progress import Meter
from workflow.errors import WorkflowError
from workflow.measures.density import Scattering
from workflow.measures.fractal import fit_fractal, fractal_intensity

REPLICAS = 100
CELLS = {1400: 46.0, 5600: 92.0}  # grains: L/a at Phi = 0.36
TRUTHS = ((1.53, 1.5), (1.53, 5.0), (1.93, 1.5), (1.93, 5.0))
SAMPLES = (1, 2, 4, 10)
PHI, ELL, CONSTANT = 0.36, 0.45, 0.01


def modes(side):
    """Edges, mean k and number of wave vectors of the shells, 16 per decade."""
    lowest = 2 * np.pi / side
    edges = lowest * 10.0 ** (np.arange(np.ceil(16 * np.log10(np.pi / lowest)) + 1) / 16) * (1 - 1e-9)
    whole = np.arange(-int(side), int(side) + 1)
    k = lowest * np.hypot(*np.meshgrid(whole, whole)).ravel()
    k = k[(k > 0) & (k < edges[-1])]
    vectors, total = np.histogram(k, edges)[0], np.histogram(k, edges, weights=k)[0]
    with np.errstate(invalid="ignore"):
        return edges, total / vectors, vectors.astype(float)


def coverage(grains, truth, samples, rng, meter):
    """One row: medians, how often the interval holds the truth, how often an end is open, how often there is no fit."""
    edges, k, vectors = modes(CELLS[grains])
    exact = np.where(vectors > 0, fractal_intensity(k, PHI, *truth, ELL, CONSTANT), np.nan)
    number = vectors * samples
    window, fits = (np.pi / CELLS[grains], np.pi), []
    for _ in range(REPLICAS):
        noise = np.where(vectors > 0, rng.gamma(np.maximum(number, 1) / 2, 2 / np.maximum(number, 1)), np.nan)
        with contextlib.suppress(WorkflowError):
            fits.append(fit_fractal(Scattering(edges, k, exact * noise, np.nan * k, number, PHI), window))
        meter.add(1, f"{grains} grains, {samples} samples")
    ends = np.array([[fit.dimension_interval, fit.xi_interval] for fit in fits])
    held = ~(ends[..., 0] > truth) & ~(ends[..., 1] < truth)
    is_open = np.isnan(ends).any(axis=2)
    row = {"grains": grains, "samples": samples, "d_F": truth[0], "xi": truth[1], "replicas": REPLICAS,
           "no fit": REPLICAS - len(fits), "median d_F": np.median([fit.dimension for fit in fits]),
           "median xi": np.median([fit.xi for fit in fits])}  # fmt: skip
    for column, name in enumerate(("d_F", "xi")):
        row |= {f"covers {name}": held[:, column].mean(), f"open {name}": is_open[:, column].mean()}
    return {name: f"{value:.4g}" for name, value in row.items()}


def main():
    rng = np.random.default_rng(28)
    meter = Meter(len(CELLS) * len(TRUTHS) * len(SAMPLES) * REPLICAS, sys.stderr)
    rows = [coverage(*case, rng, meter) for case in ((n, t, s) for n in CELLS for t in TRUTHS for s in SAMPLES)]
    meter.end()
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
