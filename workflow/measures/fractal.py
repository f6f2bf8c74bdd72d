"""Fractal dimension and blob size from I(k): the fit of eq. 28 and the plain slope (G07 section V)."""

from __future__ import annotations

from dataclasses import dataclass
from warnings import catch_warnings

import numpy as np
from scipy import optimize, special

from workflow.data.frame import Bools, Floats
from workflow.errors import InputError, WorkflowError
from workflow.measures.density import Scattering

FEW = 5  # samples from which their standard errors weight the fit; those of two would give some shells all the weight
PASSES = 5  # of the fit that takes its weights from the last one
MOST_SPREAD = 1.0  # standard error of d_F or ln xi beyond which a fit says nothing


@dataclass(frozen=True)
class FractalFit:
    """Fit of eq. 28: parameters in the order ``names`` with ``covariance`` (4, 4), standard errors from its diagonal.

    ``dimension`` d_F, ``xi`` [length], ``plateau`` I(0) - Cst [length^2], ``constant`` Cst [length^2].  ``window``:
    the k allowed; ``points``: shells in it.  ``reduced_chi2``: about 1 for a good fit.
    """

    dimension: float
    xi: float
    plateau: float
    constant: float
    covariance: Floats
    window: tuple[float, float]
    points: int
    weighted: bool
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


def fit_fractal(data: Scattering, window: tuple[float, float], *, weighted: bool) -> FractalFit:
    """Fit eq. 28 to the shells with window[0] <= k <= window[1] by Levenberg-Marquardt (four free parameters).

    ``weighted``: residuals in units of the standard errors over samples, covariance absolute; for FEW samples and more.
    Otherwise residuals in units of the noise of a shell of n wave vectors, I sqrt(2/n) with I of the fit (chi is a sum of
    many terms, so |chi|^2 is distributed exponentially, and k and -k count once), covariance scaled to the scatter.
    Raises InputError for fewer than five shells or missing errors, WorkflowError when the fit does not converge or
    leaves d_F or ln xi open by MOST_SPREAD.
    """
    rows = _window(data, window, 5)
    k, intensity = data.k[rows], data.intensity[rows]
    noise = np.sqrt(2.0 / data.vectors[rows])
    sigma = data.error[rows] if weighted else noise * intensity
    if not (sigma > 0).all():
        raise InputError("weighted fit: a shell has no standard error; average two samples or more, or weighted=False")

    def model(k: Floats, dimension: float, log_xi: float, log_plateau: float, constant: float) -> Floats:
        return constant + np.exp(log_plateau) * _shape(k, dimension, np.exp(log_xi))

    try:
        with np.errstate(all="ignore"), catch_warnings(action="ignore"):  # trial steps may leave the range of numbers
            best = _start(k, intensity)
            for _ in range(1 if weighted else PASSES):
                best, covariance = optimize.curve_fit(
                    model, k, intensity, best, sigma, absolute_sigma=weighted, method="lm", maxfev=20000
                )
                sigma = sigma if weighted else noise * np.abs(model(k, *best))
    except RuntimeError as error:
        raise WorkflowError(f"fit of eq. 28 in {_words(window)} did not converge; change the window") from error
    spread = np.sqrt(np.abs(np.diag(covariance)))  # of d_F, ln xi, ...
    if not (np.isfinite(covariance).all() and best[0] > 0 and spread[0] < MOST_SPREAD and spread[1] < MOST_SPREAD):
        raise WorkflowError(
            f"fit of eq. 28 in {_words(window)} does not determine its parameters; widen the window "
            "(a packing without loose regions has no fractal range)"
        )
    chi2 = float((((model(k, *best) - intensity) / sigma) ** 2).sum() / (len(k) - 4))
    scale = np.array([1.0, np.exp(best[1]), np.exp(best[2]), 1.0])  # from logarithms to the quantities themselves
    dimension, xi, plateau, constant = np.where([False, True, True, False], scale, best).tolist()
    covariance = covariance * np.outer(scale, scale)
    window = (float(window[0]), float(window[1]))
    return FractalFit(dimension, xi, plateau, constant, covariance, window, len(k), weighted, chi2, data.solid_fraction)


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


def _start(k: Floats, intensity: Floats) -> list[float]:
    """Starting values d_F, ln xi, ln plateau, constant: height of the first shells, k where half of it is left."""
    plateau = float(intensity[:3].max())
    half = k[np.argmax(intensity < 0.5 * plateau) or len(k) // 2]
    return [1.7, -float(np.log(half)), float(np.log(plateau)), 0.0]
