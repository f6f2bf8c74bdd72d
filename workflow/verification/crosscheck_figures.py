"""Figures of `wf crosscheck`: errors over steps, and packings on their way and at their end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from workflow.reports.figures import BLUE, GREEN, ORANGE, RED, PathLike, save, style
from workflow.verification.accuracy_figures import LOOK, panel
from workflow.verification.crosscheck import CONTROL, EXACT, Result
from workflow.verification.crosscheck_few import FewBodyError

COLOURS = {EXACT: BLUE, CONTROL: GREEN, "liggghts": ORANGE, "yade": RED}
EDGES = np.linspace(0.0, 4.5, 19)  # of N/<N>


def few_figure(rows: Sequence[FewBodyError], path: PathLike) -> None:
    """One column per case: above the difference to the reference of our law, below that to LAMMPS's `granular`."""
    names = list(dict.fromkeys(row.case for row in rows))
    engines = list(dict.fromkeys(row.engine for row in rows))
    with style():
        figure = Figure(figsize=(2.3 * len(names), 5.6), layout="constrained")
        grid = figure.subplots(2, len(names), squeeze=False, sharex=True, sharey="row")
        for column, name in zip(grid.T, names, strict=True):
            for axes, number in zip(column, ("error", "to_granular"), strict=True):
                first = name == names[0]
                words = {"error": "to the reference of our law", "to_granular": "to LAMMPS's granular"}[number] if first else ""
                panel(axes, name if number == "error" else "", "steps per period" if number != "error" else "", words)
                for engine, (colour, mark, size) in zip(engines, LOOK, strict=False):
                    of = [row for row in rows if (row.case, row.engine) == (name, engine) and getattr(row, number)]
                    across, up = [row.steps_per_period for row in of], [getattr(row, number) for row in of]
                    axes.plot(across, up, color=colour, marker=mark, markersize=size, linewidth=size / 3.0, label=engine)
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(engines), frameon=False)
        save(figure, path)


def packing_figure(results: Sequence[Result], path: PathLike) -> None:
    """Solid fraction over time of the first seed, N/<N> at the end over all seeds, and what each seed gives."""
    seeds = list(dict.fromkeys(result.row.seed for result in results))
    with style():
        figure = Figure(figsize=(12.0, 3.8), layout="constrained")
        course, forces, ends = figure.subplots(1, 3)
        for k, (name, colour) in enumerate(COLOURS.items()):
            of = [result for result in results if result.row.engine == name]
            if not of:
                continue
            course.plot(*of[0].course.T, color=colour, label=name)
            density, _ = np.histogram(np.concatenate([result.force for result in of]), EDGES, density=True)
            forces.stairs(density, EDGES, color=colour, label=name, linewidth=1.2)
            shift = 0.08 * (k - 1.5)
            ends.plot([result.row.seed + shift for result in of], [result.row.coordination for result in of], "o", color=colour,
                      markersize=4, label=f"{name}: z")  # fmt: skip
        course.set(
            xlabel=r"time [$T_0$]", ylabel=r"solid fraction $\Phi$", xlim=(0.0, 4.0), title=f"seed {seeds[0]}, first 4 $T_0$"
        )
        forces.set(xlabel=r"$N/\langle N\rangle$", ylabel="density", yscale="log", title=f"{len(seeds)} seeds")
        ends.set(xlabel="seed", ylabel="coordination $z$", xticks=seeds, title="at the end")
        for axes in (course, forces):
            axes.legend(frameon=False, fontsize=7)
        save(figure, path)
