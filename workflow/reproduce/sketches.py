"""Figures that need no sample: the contact laws (G07 fig. 1, B97 fig. 4) and a fourth disc that meets three (G07 fig. 13).

Drawn from the reference laws and the reference integrator, so that they show what is computed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from workflow.measures.heap import equivalent_stiffness
from workflow.reference.cohesive import CohesiveLaw, Floats, Motion, PairLaw
from workflow.reference.continuous import ContinuousLaw
from workflow.reference.discs import Discs, Trajectory
from workflow.reference.integrate import integrate
from workflow.reports.figures import BLUE, FILL, INK, OUTLINE, RATTLER, RED, PathLike, save, style

Path = PathLike | Sequence[PathLike]
CLOSEST = 0.915  # sigma: r_i of B97 fig. 4
OFFSET = 0.2  # delta of the fourth disc [a]


def normal_force(law: PairLaw, gap: Floats) -> Floats:
    """N of two discs at rest at each ``gap`` (P,)."""
    still, springs = np.zeros_like(gap), np.zeros((2, len(gap)))
    motion = Motion(gap, still, springs, still)
    memory, modes = law.start(motion, springs)
    return law.response(np.full_like(gap, 0.5), motion, memory, modes).normal


def draw_cohesive_law(path: Path) -> None:
    """G07 fig. 1: the normal force against the gap (kappa = 1000, D0 = 1e-3 a, which shows both slopes), and the Coulomb
    cone with its tip at N = -F0 (mu = 0.5)."""
    law = CohesiveLaw(kn=1e3, kt=1e3, mu=0.5, f0=1.0, d0=1e-3)
    gap = np.array([-2.5, 0.0, 1.0, 2.0]) * law.d0
    with style():
        figure = Figure(figsize=(6.8, 2.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(gap / law.d0, normal_force(law, gap), color=INK)
        left.set(xlabel="gap $h/D_0$", ylabel="normal force $N/F_0$")
        elastic = np.array([0.0, 2.5])
        for sign in (1, -1):
            right.plot(elastic - law.f0, sign * law.mu * elastic, color=INK)
        right.set(xlabel="normal force $N/F_0$", ylabel="tangential force $T/F_0$")
        _axes(left, right)
        save(figure, path)


def draw_continuous_law(path: Path) -> None:
    """B97 fig. 4: the continuous force (n = 36) and Hooke's law of the same work down to r_i = 0.915 sigma (eq. 14)."""
    smooth = ContinuousLaw()
    stiffness = equivalent_stiffness(smooth.index, smooth.cutoff, CLOSEST)
    distance = np.linspace(CLOSEST, smooth.cutoff, 400)
    with style():
        figure = Figure(figsize=(3.4, 2.7), layout="constrained")
        axes = figure.subplots()
        for law, colour, dash, name in (
            (smooth, INK, "-", "$n = 36$"),
            (ContinuousLaw(stiffness=stiffness), RED, (0, (5, 2)), f"Hooke, $k$ = {stiffness:.0f}"),
        ):
            axes.plot(distance, normal_force(law, distance - 1.0), color=colour, linestyle=dash, label=name)
        axes.set(xlabel=r"distance of the centres $r/\sigma$", ylabel=r"normal force $F_N/mg$", xlim=(0.9, 1.21))
        axes.legend(frameon=False, fontsize=8)
        _axes(axes)
        save(figure, path)


def fourth_disc() -> Trajectory:
    """Three discs at rest in a triangle, and a fourth that comes up at the offset delta = 0.2 a from its axis with the speed
    that the attraction alone gives it: it sticks to one, rolls and closes a fifth contact.

    Soft discs of a long range (kappa = 300, D0 = a/100), which roll the same way in a tenth of the computing time."""
    law = CohesiveLaw(kn=300.0, kt=300.0, zeta=0.8, mu=0.5, f0=1.0, d0=1e-2)
    side = 1.0 - law.f0 / law.kn  # the distance at which two discs rest
    below = np.sqrt((1.0 + 0.999 * law.d0) ** 2 - (side / 2 - OFFSET) ** 2)
    position = [[-side / 2, 0.0], [side / 2, 0.0], [0.0, np.sqrt(0.75) * side], [OFFSET, -below]]
    velocity = [[0.0, 0.0]] * 3 + [[0.0, float(np.sqrt(law.d0 / 0.75))]]
    discs = Discs(np.array(position), np.array(velocity), np.zeros(4), np.ones(4))
    return integrate(law, discs, 8.0, t_eval=np.linspace(0.0, 8.0, 161), rtol=1e-6)


def draw_fourth_disc(path: Path) -> None:
    """G07 fig. 13: the fourth disc as it comes, where it sticks (dotted), its way, and where it ends."""
    run = fourth_disc()
    start, stuck = run.position[0], run.position[int(np.argmax((run.gap[:, -3:] < 0).any(axis=1)))]
    with style():
        figure = Figure(figsize=(3.2, 3.8), layout="constrained")
        axes = figure.subplots()
        for centre in run.position[-1, :3]:
            axes.add_patch(Circle((centre[0], centre[1]), 0.5, facecolor=RATTLER, edgecolor=OUTLINE))
        for centre, dash in ((stuck[3], ":"), (run.position[-1, 3], "-")):
            axes.add_patch(Circle((centre[0], centre[1]), 0.5, facecolor=FILL, edgecolor=INK, linestyle=dash, alpha=0.7))
        axes.plot(*run.position[:, 3].T, color=BLUE, linewidth=1.2)
        axes.annotate("", start[3], start[3] - [0.0, 0.8], arrowprops={"arrowstyle": "-|>", "color": RED})
        axes.plot([0.0, 0.0], [start[3, 1] - 0.8, 0.2], color=INK, linewidth=0.6, linestyle="--")
        axes.text(OFFSET / 2, start[3, 1] - 0.75, r"$\delta$", ha="center")
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(f"$\\delta$ = {OFFSET} $a$, {int((run.gap[-1] < 0).sum())} contacts at the end", fontsize=8)
        save(figure, path)


def _axes(*panels: Axes) -> None:
    for axes in panels:
        axes.axhline(0.0, color=INK, linewidth=0.5, linestyle=":")
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(direction="in")
