"""Charts of measures, as G07 draws them, from one sample or several: mean and standard error over samples.

One column of a journal wide; told apart by dash, symbol and shade as well as by colour, so that they can be read in grey.
"""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from scipy import special

from workflow.data.frame import Bools, Floats
from workflow.errors import InputError
from workflow.measures.density import Scattering, average
from workflow.measures.elasticity import Vibrations
from workflow.measures.forces import Histogram, NTScatter
from workflow.measures.fractal import FractalFit
from workflow.measures.holes import Holes
from workflow.reports.figures import BLUE, INK, RED, SHADE, Paths, panel, save, sized, style, width
from workflow.reports.paper import NARROW, PAGE

FAINT = 0.6  # opacity of single points


def _mean(rows: Sequence[Floats]) -> tuple[Floats, Floats | None]:
    """Mean over samples and standard error (None for one sample)."""
    table = np.array(rows)
    error = table.std(axis=0, ddof=1) / np.sqrt(len(table)) if len(table) > 1 else None
    return table.mean(axis=0), error


def _needed(full: Bools, what: str) -> Bools:
    """``full`` unless nothing of it is there to draw on a logarithmic axis."""
    if not full.any():
        raise InputError(f"{what}: there is nothing to draw in these samples; choose another frame or figure")
    return full


def _steps(axes: Axes, edges: Floats, rows: Sequence[Floats]) -> None:
    """Histogram as an outline over grey, the standard error as a band."""
    mean, error = _mean(rows)
    axes.stairs(mean, edges, fill=True, color=SHADE)
    axes.stairs(mean, edges, color=INK, linewidth=1.0)
    if error is not None:
        middle = 0.5 * (edges[1:] + edges[:-1])
        axes.errorbar(middle, mean, error, fmt="none", ecolor=BLUE, elinewidth=0.7)


def force_distribution(samples: Sequence[Histogram], path: Paths, *, unit: str) -> None:
    """Distribution of N, logarithmic (G07 figs. 9, 10); ``unit``: its name in the label."""
    with style():
        figure, axes = panel()
        edges, (mean, error) = samples[0].edges, _mean([s.density for s in samples])
        full = _needed(mean > 0, "distribution of N")
        middle = 0.5 * (edges[1:] + edges[:-1])
        axes.errorbar(middle[full], mean[full], None if error is None else error[full], fmt="o-", color=INK, markersize=2.5,
                      linewidth=0.7, elinewidth=0.6)  # fmt: skip
        axes.set_yscale("log")
        axes.axvline(0.0, color=INK, linewidth=0.5, linestyle=":")
        axes.set_xlim(middle[full].min() - 0.1, middle[full].max() + 0.1)
        axes.set(xlabel=rf"normal force $N/{unit}$", ylabel=rf"probability density $p(N/{unit})$")
        save(figure, path)


def nt_scatter(normal: Floats, tangential: Floats, lines: NTScatter, path: Paths, *, unit: str, cohesive: bool) -> None:
    """Every interaction in the N-T plane with Coulomb cone and T = +-sqrt(3) N (G07 figs. 14, 17), and a detail.

    ``normal``, ``tangential`` in units of ``unit``.  The detail shows the smallest half of the forces.
    """
    with style():
        beside = width(PAGE) >= NARROW
        figure = sized(0.5 if beside else 1.7, PAGE)
        whole, detail = figure.subplots(*((1, 2) if beside else (2, 1)))
        size = np.hypot(normal, tangential)
        limit = max(float(np.quantile(size, 0.5)), 1e-12) if len(size) else 1.0
        reach = 1.05 * max(float(np.abs(normal).max(initial=0.0)), float(np.abs(tangential).max(initial=0.0)), 1e-12)
        for axes, far in ((whole, reach), (detail, limit)):
            axes.plot(normal, tangential, ".", color=BLUE, markersize=2.5, alpha=FAINT, markeredgewidth=0, rasterized=True)
            for (x1, y1), (x2, y2) in lines.sqrt3_lines:
                axes.plot([x1 * 9, x2 * 9], [y1 * 9, y2 * 9], color=INK, linestyle=(0, (5, 3)), linewidth=0.8)
            axes.plot(*lines.cone.T, color=RED, linewidth=1.2)
            axes.set_aspect("equal", adjustable="box")
            axes.locator_params(axis="x", nbins=5)
            axes.set(xlim=(-far, far), ylim=(-far, far), xlabel=rf"normal force $N/{unit}$",
                     ylabel=rf"tangential force $T/{unit}$")  # fmt: skip
        detail.set_title("smaller half of the forces")
        whole.set_xlim(min(-1.1 if cohesive else 0.0, 1.05 * float(normal.min(initial=0.0))), reach)
        whole.plot([], [], color=INK, linestyle=(0, (5, 3)), linewidth=0.8, label=r"$T=\pm\sqrt{3}\,N$")
        whole.plot([], [], color=RED, linewidth=1.2, label="Coulomb limit")
        whole.plot([], [], ".", color=BLUE, markersize=5, label="one interaction")
        figure.legend(loc="outside lower center", ncols=3)
        save(figure, path)


def angles(samples: Sequence[Histogram], path: Paths) -> None:
    """Angle between force and normal (G07 fig. 15), with 60 and 120 degrees marked."""
    with style():
        figure, axes = panel()
        _steps(axes, samples[0].edges, [s.density for s in samples])
        for angle in (60, 120):
            axes.axvline(angle, color=INK, linewidth=0.7, linestyle="--")
        axes.set(xlim=(0, 180), xticks=range(0, 181, 30), xlabel=r"angle $\theta$ of force and normal [deg]",
                 ylabel=r"probability density $p(\theta)$ [1/deg]")  # fmt: skip
        save(figure, path)


def coordination_shares(samples: Sequence[Floats], path: Paths) -> None:
    """Percentage of grains with k neighbours, the last class six and more (G07 figs. 3, 6)."""
    with style():
        figure, axes = panel()
        mean, error = _mean([100.0 * s for s in samples])
        labels = [str(k) for k in range(len(mean) - 1)] + [f"≥{len(mean) - 1}"]
        axes.bar(labels, mean, yerr=error, color=SHADE, edgecolor=INK, linewidth=0.8, ecolor=BLUE)
        axes.set(xlabel="neighbours $k$", ylabel="share of the grains $x_k$ [%]")
        save(figure, path)


def scattering_chart(samples: Sequence[Scattering], fit: FractalFit | str, path: Paths) -> None:
    """I(k) with standard errors, the fit of eq. 28 and its window (G07 fig. 23), or why there is no ``fit``."""
    with style():
        figure, axes = panel(0.95)
        data = average(samples)
        full = _needed(data.vectors > 0, "I(k)")
        error = np.where(np.isfinite(data.error), data.error, 0.0)[full]
        axes.errorbar(data.k[full], data.intensity[full], error, fmt="o", color=INK, markersize=3, markerfacecolor="white",
                      markeredgewidth=0.8, elinewidth=0.7)  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel=r"wave number $k\,a$", ylabel=r"intensity $I(k)/a^2$")
        if isinstance(fit, str):
            _say(axes, f"no curve: {fit}")
        else:
            k = np.geomspace(*fit.window, 200)
            shape = special.hyp2f1(0.5 * (1 + fit.dimension), 0.5 * fit.dimension, 1.0, -((fit.xi * k) ** 2))
            label = (rf"eq. 28: $d_F$ = {fit.dimension:.2f} {_between(fit.dimension_interval)}, "
                     rf"$\xi/a$ = {fit.xi:.2f} {_between(fit.xi_interval)}" + ", one sample" * (len(samples) == 1))  # fmt: skip
            axes.plot(k, fit.constant + fit.plateau * shape, color=RED, linewidth=1.3, label=label, zorder=3)
            axes.axvspan(*fit.window, color=SHADE, alpha=0.4, linewidth=0, label="fit window")
            figure.legend(loc="outside upper center")
        save(figure, path)


def _say(axes: Axes, words: str) -> None:
    """A sentence above the axes, in lines that fit."""
    axes.set_title("\n".join(wrap(words, round(width() / 1.75))), fontsize=7)


def _between(interval: tuple[float, float]) -> str:
    """A 68 % interval; an end that the data leave open is a word."""
    return "[" + ", ".join("open" if np.isnan(end) else f"{end:.2f}" for end in interval) + "]"


def correlation_chart(r: Floats, samples: Sequence[Floats], phi: float, fit: FractalFit | str, path: Paths) -> None:
    """C(r) - Phi^2 over Phi - Phi^2 (G07 eq. 24), 1 at contact and 0 far away, with eq. 27 where
    its parameters were fitted; else why not."""
    with style():
        figure, axes = panel()
        mean, error = _mean([(c - phi**2) / (phi - phi**2) for c in samples])
        axes.errorbar(r, mean, error, color=INK, marker="o", markersize=2.5, linewidth=0.8, elinewidth=0.6)
        axes.axhline(0.0, color=INK, linewidth=0.5, linestyle=":")
        if isinstance(fit, str):
            _say(axes, f"no curve of eq. 27: {fit}")
        elif np.isfinite(fit.ell) and fit.ell > 0:
            near = np.linspace(max(0.3, float(r[r > 0].min())), float(r.max()), 300)
            law = phi * (near / fit.ell) ** (fit.dimension - 2) * np.exp(-near / fit.xi) / (phi - phi**2)
            axes.plot(near, law, color=RED, linewidth=1.2, linestyle="--", label="eq. 27 with the fit of $I(k)$")
            figure.legend(loc="outside upper center")
        axes.set(
            xlabel="distance $r/a$",
            ylabel=r"correlation $[C(r)-\Phi^2]\,/\,[\Phi-\Phi^2]$",
            ylim=(min(-0.1, float(np.nanmin(mean)) * 1.1), 1.05),
        )
        save(figure, path)


def vibration_chart(samples: Sequence[Vibrations], path: Paths, *, whole: bool) -> None:
    """Density of states (all modes known) or cumulative number, and participation ratio, against frequency."""
    with style():
        figure = sized(1.15)
        upper, lower = figure.subplots(2, 1, sharex=True)
        values = [s.frequency for s in samples]
        every = np.concatenate(values)
        top = float(every.max())
        mechanical = every != 0.0
        if whole:
            edges = np.linspace(0.0, top, 41)
            _steps(upper, edges, [np.histogram(v[v != 0.0], edges)[0] / (len(v) * np.diff(edges)) for v in values])
            upper.set_ylabel(r"density of states $D(\omega)$")
        else:
            for v in values:
                upper.step(v, np.arange(1, len(v) + 1), where="post", color=INK, linewidth=0.9)
            upper.set_ylabel("number of modes")
        share = np.concatenate([s.participation for s in samples])
        lower.plot(every[mechanical], share[mechanical], ".", color=BLUE, markersize=2.5, alpha=0.6, markeredgewidth=0)
        lower.set(xlabel=r"frequency $\omega$ $[1/T_0]$", ylabel="participation ratio", ylim=(0, None))
        zero = int((~mechanical).sum())
        if zero:
            upper.set_title(f"besides {zero} modes of zero frequency")
        save(figure, path)


def hole_sizes(samples: Sequence[Holes], path: Paths) -> None:
    """Number density of the equivalent radii, logarithmic on both axes, and <R>_w."""
    with style():
        figure, axes = panel()
        edges = np.geomspace(0.03, 30.0, 25)
        mean, error = _mean([s.distribution(edges) for s in samples])
        full, middle = _needed(mean > 0, "sizes of holes"), np.sqrt(edges[1:] * edges[:-1])
        axes.errorbar(middle[full], mean[full], None if error is None else error[full], fmt="o-", color=INK, markersize=3,
                      linewidth=0.7, elinewidth=0.6)  # fmt: skip
        weighted = [s.weighted_radius for s in samples if s.weighted_radius is not None]
        if weighted:
            value = float(np.mean(weighted))
            axes.axvline(value, color=RED, linestyle="--", linewidth=1.0, label=rf"$\langle R\rangle_w$ = {value:.2f} $a$")
            figure.legend(loc="outside upper center")
        axes.set(xscale="log", yscale="log", xlabel="equivalent radius $R_H/a$", ylabel="density of holes over $R_H$ $[1/a]$")
        save(figure, path)


def pair_chart(edges: Floats, samples: Sequence[Floats], path: Paths) -> None:
    """Pair correlation function g(r)."""
    with style():
        figure, axes = panel()
        mean, error = _mean(samples)
        middle = 0.5 * (edges[1:] + edges[:-1])
        axes.plot(middle, mean, color=INK, linewidth=1.0)
        if error is not None:
            axes.fill_between(middle, mean - error, mean + error, color=BLUE, alpha=0.3, linewidth=0, label="standard error")
        axes.axhline(1.0, color=INK, linewidth=0.5, linestyle=":")
        axes.set(xlabel="distance $r/a$", ylabel="pair correlation $g(r)$", xlim=(0, edges[-1]), ylim=(0, None))
        save(figure, path)
