"""Density correlations of a packing: I(k) and C(r) (G07 section V); the fit for the fractal dimension is in `fractal`.

The density field chi is 1 inside a disc and 0 outside.  The exact route sums the form factors of the discs (lens-shaped
overlaps of contacts count twice: a relative error of the order of (h/d)^(3/2)); the grid route is the paper's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from scipy import fft, special

from workflow.data.balance import solid_fraction
from workflow.data.frame import Bools, Floats, Frame
from workflow.errors import InputError
from workflow.measures.clusters import ring_edges, wrapped

_ACCURACY = 1e-9  # of the non-uniform FFT, relative; far below the statistical errors of I(k)
MESH_NODES = 2e7  # some seconds and 300 MB


@dataclass(frozen=True)
class Scattering:
    """I(k) averaged over directions [length^2].

    ``edges`` (B + 1,): shells of |k| [1/length].  Per shell (B,): ``k`` mean |k|, ``intensity``, ``error`` standard
    error over samples (NaN for fewer than two), ``vectors`` number of wave vectors (0: k and intensity are NaN).
    ``solid_fraction``: sum pi d^2/4 / A, mean over samples.
    """

    edges: Floats
    k: Floats
    intensity: Floats
    error: Floats
    vectors: Floats
    solid_fraction: float


@dataclass(frozen=True)
class Autocorrelation:
    """C(r) between ``edges`` (B + 1,): ``r`` mean distance of the mesh points of a ring, ``c`` (B,); else NaN."""

    edges: Floats
    r: Floats
    c: Floats


def scattering(frame: Frame, edges: Floats) -> Scattering:
    """I(k) = |chi(k)|^2 / A (eq. 25) without a grid, chi(k) = sum_i (2 pi R_i / k) J1(k R_i) exp(-i k.r_i).

    Exact on every reciprocal vector k = 2 pi (n1/L1, n2/L2), then averaged over the shells ``edges`` (B + 1,)
    [1/length]; k = 0 never counts.
    """
    return _shells(frame, *_disc_spectrum(frame, _checked(edges)), edges)


def grid_scattering(frame: Frame, edges: Floats, *, spacing: float) -> Scattering:
    """I(k) as in the paper: FFT of chi on a mesh of about ``spacing`` (the paper's a/100); a check on ``scattering``.

    Memory: about 12 bytes per mesh node, A / spacing^2 nodes.
    """
    chi = indicator(frame, spacing)
    pixel = frame.area / chi.size
    limits = _modes(frame, _checked(edges))
    if (2 * limits >= np.array(chi.shape)).any():
        raise InputError(f"spacing = {spacing} is too coarse for k = {np.max(edges):.6g}; take less than pi/k")
    half = fft.rfft2(chi.astype(np.float32))[:, : limits[1] + 1]
    half = half[np.arange(-limits[0], limits[0] + 1)] * pixel
    mirrored = half[::-1, :0:-1].conj()  # chi is real: chi(-k) is the conjugate of chi(k)
    return _shells(frame, np.hstack((mirrored, half)), _reciprocal(frame, limits), edges)


def average(samples: Sequence[Scattering]) -> Scattering:
    """Mean and standard error (standard deviation / sqrt(n)) over samples, shell by shell; all with the same shells.

    A shell that a small sample cannot resolve is averaged over the others.
    """
    if not samples or any(not np.array_equal(s.edges, samples[0].edges) for s in samples):
        raise InputError("samples to average need the same shell edges, and at least one sample; pass one array to all")
    vectors = np.array([s.vectors for s in samples])
    number = (vectors > 0).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        k = np.nansum([s.k * s.vectors for s in samples], axis=0) / vectors.sum(axis=0)
        mean = np.nansum([s.intensity for s in samples], axis=0) / number
        spread = np.nansum([(s.intensity - mean) ** 2 for s in samples], axis=0)
        error = np.where(number > 1, np.sqrt(spread / (number * (number - 1))), np.nan)
    phi = float(np.mean([s.solid_fraction for s in samples]))
    return Scattering(samples[0].edges, k, mean, error, vectors.sum(axis=0), phi)


def autocorrelation(frame: Frame, edges: Floats, *, spacing: float) -> Autocorrelation:
    """C(r) = <chi(R) chi(R + r)> (eq. 24) on a mesh of about ``spacing``: C(r) = sum_k I(k) exp(ik.r) / A.

    ``edges`` (B + 1,): rings in r, at most half the shorter cell length.  C(0) = Phi; C -> Phi^2 far away.  Single
    precision: 1e-6.  Memory: about 13 bytes per mesh node, A / spacing^2 nodes.
    """
    edges = ring_edges(frame, edges)
    chi = indicator(frame, spacing)
    shape, size = chi.shape, chi.size
    wave = fft.rfft2(chi.astype(np.float32))
    del chi
    wave.real[:] = wave.real**2 + wave.imag**2  # in place: the mesh may fill the memory
    wave.imag[:] = 0.0
    c = fft.irfft2(wave, s=shape, overwrite_x=True)
    step = frame.cell / shape
    reach = np.minimum(edges[-1] // step + 1, (np.array(shape) - 1) // 2).astype(int)
    x, y = (np.arange(-n, n + 1) for n in reach)
    r = np.hypot(*np.meshgrid(x * step[0], y * step[1], indexing="ij")).ravel()
    _, mean_r, mean_c = _bin_means(r, c[np.ix_(x, y)].ravel().astype(np.float64) / size, edges)
    return Autocorrelation(edges, mean_r, mean_c)


def mesh_spacing(frame: Frame, length: float) -> float:
    """The paper's mesh, ``length``/100, or the finest of at most MESH_NODES nodes."""
    return float(min(max(length / 100.0, np.sqrt(frame.area / MESH_NODES)), frame.cell.min()))


def indicator(frame: Frame, spacing: float) -> Bools:
    """chi at the centres of a periodic mesh, shape (n1, n2), first axis x; spacing at most ``spacing`` on each axis."""
    if not 0 < spacing <= frame.cell.min():
        raise InputError(f"spacing = {spacing} must be above 0 and at most the cell, {frame.cell.min():.6g}; try a/100")
    nodes = np.ceil(frame.cell / spacing * (1 - 1e-12)).astype(np.int64)
    shape = np.array([fft.next_fast_len(int(n), real=True) for n in nodes])  # a prime number of nodes would be slow
    step = frame.cell / shape
    row, low, high = _chords(wrapped(frame), 0.5 * frame.diameter, step)
    length = np.minimum(high - low + 1, shape[1])
    row, low = row % shape[0], low % shape[1]
    ends = np.zeros((shape[0], shape[1] + 1), dtype=np.int16)  # +1 where a chord begins, -1 behind its end
    beyond = np.maximum(low + length - shape[1], 0)  # the part of a chord that wraps to the front of the row
    np.add.at(ends, (row, low), 1)
    np.add.at(ends, (row, low + length - beyond), -1)
    np.add.at(ends, (row, np.zeros_like(low)), (beyond > 0).astype(np.int16))
    np.add.at(ends, (row, beyond), -(beyond > 0).astype(np.int16))
    np.cumsum(ends, axis=1, out=ends)
    return ends[:, :-1] > 0


def _chords(centre: Floats, radius: Floats, step: Floats) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mesh rows cut by each disc, with the first and last column inside: (row, low, high), not yet wrapped."""
    first = np.ceil((centre[:, 0] - radius) / step[0] - 0.5).astype(np.int64)
    last = np.floor((centre[:, 0] + radius) / step[0] - 0.5).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    disc = np.repeat(np.arange(len(radius)), count)
    row = np.arange(len(disc)) - np.repeat(np.cumsum(count) - count, count) + first[disc]
    half = np.sqrt(np.maximum(radius[disc] ** 2 - ((row + 0.5) * step[0] - centre[disc, 0]) ** 2, 0.0))
    low = np.ceil((centre[disc, 1] - half) / step[1] - 0.5).astype(np.int64)
    high = np.floor((centre[disc, 1] + half) / step[1] - 0.5).astype(np.int64)
    hit = high >= low
    return row[hit], low[hit], high[hit]


def _checked(edges: Floats) -> Floats:
    edges = np.asarray(edges, dtype=np.float64)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0).all() or not 0 <= edges[0] < edges[-1] < np.inf:
        raise InputError(f"shell edges = {edges} must be two or more ascending k >= 0; try geomspace(2 pi/L, 2 pi/a)")
    return edges


def _modes(frame: Frame, edges: Floats) -> np.ndarray:
    """Largest reciprocal index on each axis that |k| < edges[-1] needs."""
    return np.floor(edges[-1] * frame.cell / (2 * np.pi)).astype(np.int64)


def _reciprocal(frame: Frame, limits: np.ndarray) -> Floats:
    """|k| on the reciprocal lattice, indices -limit..limit on each axis."""
    k1, k2 = (2 * np.pi / length * np.arange(-n, n + 1) for length, n in zip(frame.cell, limits, strict=True))
    return np.hypot(k1[:, None], k2[None, :])


def _disc_spectrum(frame: Frame, edges: Floats) -> tuple[np.ndarray, Floats]:
    """chi(k) and |k| on the reciprocal lattice.

    The form factor depends on k and R together, which no single transform takes: interpolating it in R at a few
    Chebyshev nodes splits it into products (function of k) x (weight of the grain), one transform each.
    """
    limits = _modes(frame, edges)
    k = _reciprocal(frame, limits)
    inside = k <= edges[-1]
    radius = 0.5 * frame.diameter
    chi = np.zeros(k.shape, dtype=np.complex128)
    for node, weight in zip(*_interpolation(radius, edges[-1]), strict=True):
        chi[inside] += _form_factor(k[inside], node) * _transform(frame, weight, limits)[inside]
    return chi, k


def _form_factor(k: Floats, radius: float) -> Floats:
    """Transform of a disc, (2 pi R / k) J1(k R); pi R^2 at k = 0."""
    x = np.maximum(k * radius, 1e-9)  # J1(x)/x is 1/2 to rounding below
    return 2.0 * np.pi * radius**2 * special.j1(x) / x


def _interpolation(radius: Floats, k_max: float) -> tuple[Floats, Floats]:
    """Chebyshev nodes in R (m,) and the Lagrange weights of each grain at them (m, N).

    The coefficient of order m of a wave is at most 2 x^m / m!, x = k (Rmax - Rmin)/4: enough orders for 1e-9.
    """
    centre, half = 0.5 * (radius.max() + radius.min()), 0.5 * (radius.max() - radius.min())
    if half < 1e-14 * centre:
        return np.array([centre]), np.ones((1, len(radius)))
    x = 0.5 * k_max * half
    order = next(m for m in count(1) if m * np.log(x) - special.gammaln(m + 1) < np.log(_ACCURACY))
    unit = np.polynomial.chebyshev.chebpts1(order)
    basis = np.polynomial.chebyshev.chebvander(unit, order - 1)
    values = np.polynomial.chebyshev.chebvander((radius - centre) / half, order - 1)
    return centre + half * unit, np.linalg.solve(basis.T, values.T).astype(np.float64)


def _transform(frame: Frame, weight: Floats, limits: np.ndarray) -> np.ndarray:
    """sum_i weight_i exp(-i k.r_i) on the reciprocal lattice, (2 n1 + 1, 2 n2 + 1)."""
    phase = 2 * np.pi * (wrapped(frame) / frame.cell - 0.5)  # the shift of half a cell changes no modulus
    n1, n2 = (2 * limits + 1).tolist()
    import finufft  # slow to load, and few measures need it

    x, y = np.ascontiguousarray(phase.T)
    # one thread: a fixed order of summation, so that the same frame gives the same bits
    return finufft.nufft2d1(x, y, weight.astype(np.complex128), (n1, n2), eps=_ACCURACY, isign=-1, nthreads=1)


def _shells(frame: Frame, chi: np.ndarray, k: Floats, edges: Floats) -> Scattering:
    edges = np.asarray(edges, dtype=np.float64)
    used = k > 0
    intensity = (chi[used].real ** 2 + chi[used].imag ** 2) / frame.area
    number, mean_k, mean = _bin_means(k[used], intensity, edges)
    return Scattering(edges, mean_k, mean, np.full(len(mean), np.nan), number, solid_fraction(frame))


def _bin_means(x: Floats, y: Floats, edges: Floats) -> tuple[Floats, Floats, Floats]:
    """Number of points and means of x and y per bin [edge, next edge)."""
    bins = len(edges) - 1
    place = np.searchsorted(edges, x, side="right")  # 0 below the first edge, bins + 1 from the last on

    def total(weights: Floats | None) -> Floats:
        return np.bincount(place, weights, minlength=bins + 2)[1 : bins + 1].astype(np.float64)

    number = total(None)
    with np.errstate(invalid="ignore", divide="ignore"):
        return number, total(x) / number, total(y) / number
