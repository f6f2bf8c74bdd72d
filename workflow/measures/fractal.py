"""Fractal dimension and blob size from I(k): the fit of eq. 28 and the plain slope (G07 section V)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize, special, stats

from workflow.data.frame import Bools, Floats
from workflow.errors import InputError, WorkflowError
from workflow.measures.density import Scattering

CONFIDENCE = 0.6827  # of the intervals
SURE = 0.99  # that I(k) is no constant, else there is nothing to fit
LIMITS = ((0.05, 4.0), (-3.0, 3.0))  # of d_F, and of ln xi about its best value: beyond them an interval is open
FLOOR = 1e-3  # of I: a trial I(k) below it is taken for it, as the likelihood knows positive ones only

_Parameters = Floats  # d_F, ln xi, ln plateau, constant


@dataclass(frozen=True)
class FractalFit:
    """Fit of eq. 28: parameters in the order ``names`` with ``covariance`` (4, 4), standard errors from its diagonal.

    ``dimension`` d_F, ``xi`` [length], ``plateau`` I(0) - Cst [length^2], ``constant`` Cst [length^2].
    ``dimension_interval``, ``xi_interval``: 68 % intervals by profile likelihood, an end that the data leave open is NaN;
    they hold where the two are correlated and the likelihood is no parabola, as for one sample.  ``window``: the k allowed;
    ``points``: shells in it.  ``reduced_chi2``: mean square deviation in units of what the wave vectors give, about 1 for
    independent ones; covariance and intervals are scaled with it.
    """

    dimension: float
    xi: float
    plateau: float
    constant: float
    dimension_interval: tuple[float, float]
    xi_interval: tuple[float, float]
    covariance: Floats
    window: tuple[float, float]
    points: int
    reduced_chi2: float
    solid_fraction: float
    names: tuple[str, str, str, str] = ("dimension", "xi", "plateau", "constant")

    @property
    def errors(self) -> dict[str, float]:
        """Standard error of each parameter."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def wavelength(self) -> float:
        """2 pi xi [length], the wavelength at k xi = 1: xi itself for who counts k as 1/wavelength."""
        return 2.0 * np.pi * self.xi

    @property
    def ell(self) -> float:
        """The length of eq. 27, from plateau = 2 pi Phi ell^(2 - d_F) Gamma(d_F) xi^d_F; NaN for d_F >= 2."""
        if self.dimension >= 2.0:
            return float("nan")
        rest = 2 * np.pi * self.solid_fraction * special.gamma(self.dimension) * self.xi**self.dimension
        return float(np.exp(np.log(self.plateau / rest) / (2.0 - self.dimension)))


@dataclass(frozen=True)
class Slope:
    """I ~ k^-dimension within ``window``: least squares in log-log, ``error`` the standard error of the slope."""

    dimension: float
    error: float
    window: tuple[float, float]
    points: int


def fractal_intensity(k: Floats, phi: float, dimension: float, xi: float, ell: float, constant: float) -> Floats:
    """Eq. 28: I = Cst + 2 pi Phi ell^2 Gamma(d_F) (xi/ell)^d_F 2F1((1 + d_F)/2, d_F/2; 1; -xi^2 k^2) [length^2].

    It is the 2D Fourier transform of C(r) - Phi^2 = Phi (r/ell)^(d_F - 2) exp(-r/xi) (eq. 27).
    """
    plateau = 2.0 * np.pi * phi * ell ** (2.0 - dimension) * special.gamma(dimension) * xi**dimension
    return constant + plateau * _shape(k, dimension, xi)


def fit_fractal(data: Scattering, window: tuple[float, float]) -> FractalFit:
    """Fit eq. 28 to the shells with window[0] <= k <= window[1] by greatest likelihood (four free parameters).

    chi(k) is a sum of many terms, so |chi|^2 is distributed exponentially about its mean, and the mean over a shell of n
    wave vectors, of which k and -k count once, as a gamma variate of n/2 terms about I(k) of the fit, with one sample or
    many.  Minimised is the deviance D = sum n (I/fit - 1 - ln(I/fit)); an interval holds what raises D by no more than
    ``reduced_chi2`` times the quantile CONFIDENCE of F(1, points - 4) while the other parameters are free.
    Raises InputError for fewer than six shells, WorkflowError where a constant I(k) fits as well (F test at SURE).
    """
    rows = _window(data, window, 6)
    k, intensity, terms = data.k[rows], data.intensity[rows], 0.5 * data.vectors[rows]
    fit = _Deviance(k, intensity, terms)
    best, least, information = fit.least(_start(k, intensity))
    freedom = len(k) - 4
    dispersion = float((terms * (intensity / fit.model(best) - 1.0) ** 2).sum() / freedom)
    if fit.flat() - least <= 3.0 * dispersion * stats.f.ppf(SURE, 3, freedom):
        raise WorkflowError(
            f"fit of eq. 28 in {_words(window)} does not determine its parameters: I(k) does not fall there; widen the window "
            "(a packing without loose regions has no fractal range)"
        )
    bound = least + dispersion * float(stats.f.ppf(CONFIDENCE, 1, freedom))
    of_dimension = fit.interval(best, 0, bound, LIMITS[0])
    of_xi = np.exp(fit.interval(best, 1, bound, (best[1] + LIMITS[1][0], best[1] + LIMITS[1][1]))).tolist()
    scale = np.array([1.0, np.exp(best[1]), np.exp(best[2]), 1.0])  # from logarithms to the quantities themselves
    dimension, xi, plateau, constant = np.where([False, True, True, False], scale, best).tolist()
    covariance = np.asarray(dispersion * np.linalg.pinv(information) * np.outer(scale, scale))
    return FractalFit(
        dimension, xi, plateau, constant, of_dimension, (of_xi[0], of_xi[1]), covariance,
        (float(window[0]), float(window[1])), len(k), dispersion, data.solid_fraction,
    )  # fmt: skip


@dataclass(frozen=True)
class _Deviance:
    """The deviance of eq. 28 from measured ``intensity`` (S,) at ``k`` (S,), means of ``terms`` (S,) independent terms."""

    k: Floats
    intensity: Floats
    terms: Floats

    def model(self, q: _Parameters) -> Floats:
        """I(k) of the parameters."""
        return q[3] + np.exp(q[2]) * _shape(self.k, q[0], np.exp(q[1]))

    def least(self, start: _Parameters, fixed: int | None = None) -> tuple[_Parameters, float, Floats]:
        """Least deviance from ``start``, with parameter ``fixed`` held: where, how much, and half its second derivative."""
        free = [index for index in range(4) if index != fixed]

        def residuals(values: Floats) -> Floats:
            q = start.copy()
            q[free] = values
            ratio = self.intensity / np.maximum(self.model(q), FLOOR * self.intensity)
            return np.sign(ratio - 1.0) * np.sqrt(np.maximum(2.0 * self.terms * (ratio - 1.0 - np.log(ratio)), 0.0))

        scale = np.array([1.0, 1.0, 1.0, self.intensity.min()])[free]
        with np.errstate(all="ignore"):  # trial steps may leave the range of numbers
            found = optimize.least_squares(residuals, start[free], method="lm", x_scale=scale, max_nfev=1000)
        q = start.copy()
        q[free] = found.x
        return q, float(2.0 * found.cost), found.jac.T @ found.jac

    def flat(self) -> float:
        """The deviance from a constant I(k), least at the mean."""
        ratio = self.intensity / np.average(self.intensity, weights=self.terms)
        return float(2.0 * (self.terms * (ratio - 1.0 - np.log(ratio))).sum())

    def interval(self, best: _Parameters, index: int, bound: float, limits: tuple[float, float]) -> tuple[float, float]:
        """Where the deviance, least over the others, is ``bound`` on both sides of the best value; NaN beyond ``limits``."""
        low, high = (self._end(best, index, bound, limit) for limit in limits)
        return low, high

    def _end(self, best: _Parameters, index: int, bound: float, limit: float) -> float:
        def excess(value: float) -> float:
            start = best.copy()
            start[index] = value
            return self.least(start, index)[1] - bound

        inside, step = float(best[index]), 0.05 * np.sign(limit - best[index])
        if excess(inside) >= 0.0:  # data without noise
            return inside
        while abs(inside + step - best[index]) < abs(limit - best[index]):
            if excess(inside + step) > 0.0:
                return float(optimize.brentq(excess, inside, inside + step, xtol=1e-5))
            inside, step = inside + step, 1.6 * step
        return float("nan")


def fractal_slope(data: Scattering, window: tuple[float, float]) -> Slope:
    """Fractal dimension from the slope of ln I against ln k in the window, I ~ k^-d_F (eq. 26), without a cut-off."""
    rows = _window(data, window, 3)
    (slope, _), covariance = np.polyfit(np.log(data.k[rows]), np.log(data.intensity[rows]), 1, cov=True)
    return Slope(-float(slope), float(np.sqrt(covariance[0, 0])), (float(window[0]), float(window[1])), int(rows.sum()))


def _words(window: tuple[float, float]) -> str:
    return f"k = {window[0]:.3g} to {window[1]:.3g}"


def _window(data: Scattering, window: tuple[float, float], least: int) -> Bools:
    rows = (data.k >= window[0]) & (data.k <= window[1]) & (data.intensity > 0)
    if rows.sum() < least:
        raise InputError(f"window {_words(window)} holds {int(rows.sum())} shells, at least {least} are needed; widen it")
    return rows


def _shape(k: Floats, dimension: float, xi: float) -> Floats:
    """2F1((1 + d_F)/2, d_F/2; 1; -xi^2 k^2), 1 at k = 0 and ~ k^-d_F beyond 1/xi."""
    return special.hyp2f1(0.5 * (1 + dimension), 0.5 * dimension, 1.0, -((xi * k) ** 2))


def _start(k: Floats, intensity: Floats) -> _Parameters:
    """Starting values d_F, ln xi, ln plateau, constant: height of the first shells, k where half of it is left."""
    plateau = float(intensity[:3].max())
    half = k[np.argmax(intensity < 0.5 * plateau) or len(k) // 2]
    return np.array([1.7, -np.log(half), np.log(plateau), 0.0])
