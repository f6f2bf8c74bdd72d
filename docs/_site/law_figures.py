"""Figures of the contact laws, drawn from the laws in `workflow.reference`: one for light pages, one for dark ones."""

from __future__ import annotations

import io
from collections.abc import Callable

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workflow.reference.cohesive import CohesiveLaw, Floats, Motion
from workflow.reference.continuous import ContinuousLaw
from workflow.reference.discs import Discs
from workflow.reference.integrate import integrate

INK = {"light": "#222222", "dark": "#dddddd"}
COLOURS = {"light": ("#0072b2", "#d55e00", "#008060"), "dark": ("#56b4e9", "#e69f00", "#40d0a0")}  # of Okabe and Ito
DASHES = ("-", "--", "-.")
STYLE = {"svg.hashsalt": "workflow", "svg.fonttype": "path", "font.size": 11.0}
KN, D0 = 1e5, 1e-3  # of table I: kappa, and the range of attraction [a]
COHESIVE = CohesiveLaw(kn=KN, kt=KN, zeta=0.8, mu=0.5, f0=1.0, d0=D0, kr=1e-4 * KN, mur=0.005)
HALF = 0.5  # reduced mass of two discs of mass 1


def law_figures() -> dict[str, bytes]:
    """Path on the site -> SVG."""
    found = {}
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, **STYLE}):
        for name, draw in FIGURES.items():
            for mode, ink in INK.items():
                found[f"laws/{name}.{mode}.svg"] = _svg(draw, ink, COLOURS[mode])
    return found


def _svg(draw: Callable[[Axes, Callable], None], ink: str, colours: tuple[str, ...]) -> bytes:
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    axes = figure.add_subplot()
    count = iter(range(9))

    def line(x: Floats, y: Floats, name: str) -> None:
        k = next(count)
        axes.plot(x, y, DASHES[k % 3], color=colours[k % 3], label=name, linewidth=1.6)

    draw(axes, line)
    axes.axhline(0.0, color=ink, linewidth=0.5) if axes.get_yscale() == "linear" else None
    figure.legend(loc="outside upper center", ncols=3, frameon=False, labelcolor=ink, fontsize=9, columnspacing=1.2)
    axes.tick_params(colors=ink)
    for text in (axes.xaxis.label, axes.yaxis.label):
        text.set_color(ink)
    for spine in axes.spines.values():
        spine.set_color(ink)
    out = io.BytesIO()
    figure.savefig(out, format="svg", transparent=True, metadata={"Date": None})
    return out.getvalue()


def _still(gap: Floats) -> Motion:
    none = np.zeros_like(gap)
    return Motion(gap, none, np.zeros((2, len(gap))), none)


def _forces(law: CohesiveLaw | ContinuousLaw, gap: Floats, memory: Floats) -> tuple[Floats, Floats, Floats]:
    """N, T and moment of pairs that stand still."""
    motion = _still(gap)
    memory, modes = law.start(motion, memory)
    found = law.response(np.full_like(gap, HALF), motion, memory, modes)
    return found.normal, found.tangential, found.moment


def tail(axes: Axes, line: Callable) -> None:
    """Eqs. 4 and 5 at rest, with and without attraction."""
    _at_rest(line, np.linspace(-0.02 * D0, 1.2 * D0, 2000), D0)
    axes.set(xlabel="gap h / D0", ylabel="normal force N / F0", ylim=(-1.2, 1.2))


def contact(axes: Axes, line: Callable) -> None:
    """Eq. 5 at rest, near the overlap at which the force vanishes."""
    _at_rest(line, np.linspace(-3e-5, 1e-5, 2000), 1e-5)
    axes.set(xlabel="gap h / (F0/K_N)", ylabel="normal force N / F0")


def _at_rest(line: Callable, gap: Floats, unit: float) -> None:
    for law, name in ((COHESIVE, "with attraction"), (CohesiveLaw(kn=KN), "without")):
        line(gap / unit, _forces(law, gap, np.zeros((2, len(gap))))[0], name)


def impact(axes: Axes, line: Callable) -> None:
    """Eqs. 4 to 6 in head-on impacts of two equal discs."""
    for law, speed, name in (
        (COHESIVE, 2.0, "rebound, 2 a/T0"),
        (COHESIVE, 0.5, "capture, 0.5 a/T0"),
        (CohesiveLaw(kn=KN, zeta=0.8), 2.0, "no attraction, 2 a/T0"),
    ):
        discs = Discs(
            position=np.array([[0.0, 0.0], [1.0 + 1.1 * D0, 0.0]]),
            velocity=np.array([[0.0, 0.0], [-speed, 0.0]]),
            omega=np.zeros(2),
            diameter=np.ones(2),
        )
        path = integrate(law, discs, 0.02, t_eval=np.linspace(0.0, 0.02, 4000))
        line(path.gap[:, 0] / D0, path.normal[:, 0], name)
    axes.set(xlabel="gap h / D0", ylabel="normal force N / F0", xlim=(-2.2, 1.2))


def _cycle(limit: float) -> tuple[Floats, Floats]:
    """A displacement to and fro, three times its limit wide, and the elastic part of it that is kept (eqs. 8, 10)."""
    way = 3.0 * limit * np.concatenate((np.linspace(0, 1, 200), np.linspace(1, -1, 400), np.linspace(-1, 1, 400)))
    kept = np.zeros_like(way)
    for k in range(1, len(way)):
        kept[k] = np.clip(kept[k - 1] + way[k] - way[k - 1], -limit, limit)
    return way, kept


def friction(axes: Axes, line: Callable) -> None:
    """Eq. 8 while two discs slide to and fro, at two overlaps."""
    for overlap in (1e-5, 2e-5):
        way, kept = _cycle(COHESIVE.mu * overlap)
        gap = np.full_like(way, -overlap)
        line(way / 1e-5, _forces(COHESIVE, gap, np.stack((kept, 0 * kept)))[1], f"elastic force {KN * overlap:g} F0")
    axes.set(xlabel="tangential displacement / 1e-5 a", ylabel="tangential force T / F0")


def rolling(axes: Axes, line: Callable) -> None:
    """Eq. 10 while two discs roll to and fro, at two overlaps."""
    for overlap in (1e-5, 2e-5):
        way, kept = _cycle(COHESIVE.mur * KN * overlap / COHESIVE.kr)
        gap = np.full_like(way, -overlap)
        line(way / 1e-4, _forces(COHESIVE, gap, np.stack((0 * kept, kept)))[2] / 1e-3, f"elastic force {KN * overlap:g} F0")
    axes.set(xlabel="relative rotation / 1e-4", ylabel="rolling moment / 1e-3 F0 a")


def continuous_normal(axes: Axes, line: Callable) -> None:
    """B97's repulsion for both exponents, and Hooke's law."""
    for law, name in (
        (ContinuousLaw(36, 1.2), "n = 36, r0 = 1.2"),
        (ContinuousLaw(144, 1.047), "n = 144, r0 = 1.047"),
        (ContinuousLaw(stiffness=500.0), "Hooke, k = 500"),
    ):
        gap = np.linspace(-0.06, 0.25, 3000)
        force = _forces(law, gap, np.zeros((2, len(gap))))[0]
        line(1.0 + gap[force > 0], force[force > 0], name)
    axes.set(xlabel="distance r / sigma", ylabel="normal force / m g", yscale="log")


def continuous_friction(axes: Axes, line: Callable) -> None:
    """Eq. 5 of B97 at two distances."""
    law = ContinuousLaw(36, 1.2)
    for distance in (0.97, 1.0):
        share = np.linspace(-1.0, 1.0, 801)
        gap = np.full_like(share, distance - 1.0)
        largest = law.alpha * law.mu * (law.cutoff - distance)
        tangential = _forces(law, gap, np.stack((share * largest, 0 * share)))[1]
        line(share, tangential, f"r = {distance:g} sigma")
    axes.set(xlabel="displacement d / d_max", ylabel="tangential force / m g")


FIGURES = {
    "tail": tail,
    "contact": contact,
    "impact": impact,
    "friction": friction,
    "rolling": rolling,
    "continuous_normal": continuous_normal,
    "continuous_friction": continuous_friction,
}
