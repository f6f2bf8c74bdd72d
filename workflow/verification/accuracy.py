"""Error against run time: the same few discs and the same packings over steps, laws and schemes.

Few bodies: error against the independent reference integrator of the exact law (workflow.reference).  Many bodies:
method 1 at small N, means over seeds, where trajectories are chaotic and only bulk numbers mean something.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TextIO

import numpy as np
from scipy.spatial import cKDTree

from workflow.data.discs import Discs
from workflow.data.progress import Meter
from workflow.scene.method1 import Method1
from workflow.scene.time_step import stiffest_period
from workflow.verification.few_discs import Case, cases
from workflow.verification.one_run import VARIANTS, Outcome, Variant, run

FIT_FROM = 20.0  # steps per period from which the order is fitted; coarser steps are outside the asymptotic range
START_COST = 0.3  # seconds of a process
COST = {"disc": 3e-8, "stock": 1.3e-7, "hooke": 1e-7}  # seconds per grain and step, for the estimate of the time left


@dataclass(frozen=True)
class Plan:
    """How much is computed: groups per case, steps per stiffest period, and the packings with their seeds and duration."""

    groups: int
    few: tuple[float, ...]
    many: tuple[float, ...]
    seeds: int
    grains: int
    duration: float


QUICK = Plan(6, (14, 28, 56, 112, 224), (14, 28), 2, 100, 12.0)
FULL = Plan(16, (7, 14, 20, 28, 40, 56, 112, 224, 448), (7, 14, 28, 56), 4, 120, 25.0)


@dataclass(frozen=True)
class FewBodyError:
    """One case, variant and step: ``error`` against the reference, ``residual`` of the energy account relative to the initial
    kinetic energy (None: the law keeps no account), ``seconds`` per simulated time unit T0: the
    median cost of a step over the runs of case and variant, times the steps (single runs are too short to time)."""

    case: str
    variant: str
    steps_per_period: float
    step: float
    error: float
    residual: float | None
    seconds: float
    grains: int


@dataclass(frozen=True)
class PackingStatistics:
    """Packings of one case, variant and step: means over seeds and their standard errors; ``stress``: largest deviation of
    the two axes from the imposed one in F1/a, ``residual`` of the energy account relative to the larger of work and loss."""

    case: str
    variant: str
    steps_per_period: float
    step: float
    seeds: int
    grains: int
    solid_fraction: float
    solid_fraction_error: float
    coordination: float
    coordination_error: float
    stress: float
    stress_error: float
    residual: float | None
    seconds: float


def few_bodies(plan: Plan, variants: Sequence[Variant], out: TextIO = sys.stderr) -> list[FewBodyError]:
    """Every case over steps and variants that can do it."""
    chosen = cases(plan.groups)
    jobs = [
        (case, variant, spp, math.ceil(case.duration * spp / period(case)))
        for case in chosen for variant in variants if variant.cohesion or not case.law.cohesive
        for spp in plan.few
    ]  # fmt: skip
    meter = Meter(sum(_cost(v, 3 * plan.groups, steps) for _, v, _, steps in jobs) + 5.0 * len(chosen), out)
    exact = {}
    for case in chosen:
        exact[case.name] = case.reference()
        meter.add(5.0, f"reference of {case.name}")
    rows = []
    for case, variant, spp, steps in jobs:
        discs, velocity, omega = case.discs()
        law = case.law
        values = {
            **asdict(law), "contact_model": variant.law, "scheme": variant.scheme, "step": case.duration / steps,
            "steps": steps,
        }  # fmt: skip
        outcome = run(discs, {**values, "pair_mass": 0.5}, velocity=velocity, omega=omega)
        rows.append(_few(case, variant, spp, case.error(outcome, exact[case.name]), outcome, steps))
        meter.add(_cost(variant, len(omega), steps), f"{case.name}, {variant.name}, {spp:g} steps per period")
    meter.end()
    return timed(rows)


def timed(rows: Sequence[FewBodyError]) -> list[FewBodyError]:
    """Rows with their seconds replaced by the median cost of a step times the steps in T0."""
    costs = {key: float(np.median([r.seconds * r.step for r in _of(rows, key)])) for key in {(r.case, r.variant) for r in rows}}
    return [replace(row, seconds=costs[row.case, row.variant] / row.step) for row in rows]


def _few(case: Case, variant: Variant, spp: float, error: float, outcome: Outcome, steps: int) -> FewBodyError:
    discs, velocity, omega = case.discs()
    kinetic = 0.5 * float(discs.diameter**2 @ ((velocity**2).sum(axis=1) + discs.diameter**2 * omega**2 / 8.0))
    residual = abs(outcome.result["end"] - outcome.result["begin"]) / kinetic if variant.law == "disc" else None
    seconds = outcome.seconds / case.duration
    return FewBodyError(case.name, variant.name, spp, case.duration / steps, error, residual, seconds, len(omega))


def period(case: Case) -> float:
    """Stiffest period of a case, as the step rule of the scenes estimates it."""
    smallest = min(float(group.diameter.min()) for group in case.groups)
    return stiffest_period(case.law, smallest)


def _cost(variant: Variant, grains: int, steps: float) -> float:
    return START_COST + COST[variant.law] * grains * steps


def many_bodies(plan: Plan, variants: Sequence[Variant], out: TextIO = sys.stderr) -> list[PackingStatistics]:
    """Method 1 for a fixed time over steps, variants and seeds; without the settling stage, which only we have."""
    scenes = {
        name: [Method1(n=plan.grains, seed=k, cohesion=cohesion, cell="strain") for k in range(1, plan.seeds + 1)]
        for name, cohesion in (("packing", False), ("cohesive packing", True))
    }
    jobs = [
        (name, variant, spp)
        for name, of in scenes.items() for variant in variants if variant.cohesion or not of[0].cohesion
        for spp in plan.many
    ]  # fmt: skip

    def cost(name: str, variant: Variant, spp: float) -> float:
        return _cost(variant, plan.grains, plan.duration * spp / scenes[name][0].step_choice.period) * plan.seeds

    meter = Meter(sum(cost(*job) for job in jobs), out)
    rows = []
    for name, variant, spp in jobs:
        rows.append(_packings(name, variant, spp, scenes[name], plan.duration))
        meter.add(cost(name, variant, spp), f"{name}, {variant.name}, {spp:g} steps per period")
    meter.end()
    return rows


def _packings(name: str, variant: Variant, spp: float, scenes: Sequence[Method1], duration: float) -> PackingStatistics:
    step = scenes[0].step_choice.period / spp
    steps = math.ceil(duration / step)
    numbers, residuals, seconds = [], [], []
    for scene in scenes:
        law, discs = scene.law_in_units, scene.discs()
        values = {
            **asdict(law), "contact_model": variant.law, "scheme": variant.scheme, "step": step, "steps": steps,
            "stress": scene.pressure, "cell_mass": scene.cell_mass, "start_fraction": scene.phi0,
            "skin": scene.neighbour_skin,
        }  # fmt: skip
        outcome = run(discs, values)
        result = outcome.result
        fraction = float(np.sum(np.pi * discs.diameter**2 / 4.0) / outcome.cell.prod())
        deviation = max(abs(result[axis] - scene.pressure) / scene.force_unit for axis in ("pxx", "pyy"))
        numbers.append((fraction, coordination(discs, outcome, law.d0), deviation))
        through = max(abs(result["work"]), result["lost"])
        residuals.append(abs(result["end"] - result["begin"]) / through if variant.law == "disc" else math.nan)
        seconds.append(outcome.seconds / (steps * step))
    mean = np.mean(numbers, axis=0)
    spread = np.std(numbers, axis=0, ddof=1) / math.sqrt(len(numbers)) if len(numbers) > 1 else np.zeros(3)
    residual = float(np.mean(residuals)) if variant.law == "disc" else None
    return PackingStatistics(
        name, variant.name, spp, step, len(scenes), len(discs.diameter), float(mean[0]), float(spread[0]), float(mean[1]),
        float(spread[1]), float(mean[2]), float(spread[2]), residual, float(np.mean(seconds)),
    )  # fmt: skip


def coordination(discs: Discs, outcome: Outcome, reach: float) -> float:
    """Mean number of contacts and distant pairs (gap up to ``reach``) per grain."""
    tree = cKDTree(np.mod(outcome.position, outcome.cell), boxsize=outcome.cell)
    pairs = tree.query_pairs(float(discs.diameter.max()) + reach, output_type="ndarray")
    away = outcome.position[pairs[:, 1]] - outcome.position[pairs[:, 0]]
    away -= outcome.cell * np.round(away / outcome.cell)
    gap = np.hypot(*away.T) - discs.diameter[pairs].mean(axis=1)
    return 2.0 * float(np.sum(gap <= reach if reach > 0.0 else gap < 0.0)) / len(discs.diameter)


def orders(rows: Sequence[FewBodyError]) -> dict[tuple[str, str], float]:
    """Order p of error ~ step^p per case and variant: least squares in logarithms over the finer steps."""
    found = {}
    for key in dict.fromkeys((row.case, row.variant) for row in rows):
        points = [(r.step, r.error) for r in _of(rows, key) if r.steps_per_period >= FIT_FROM and 0.0 < r.error < math.inf]
        if len(points) > 2:
            steps, errors = np.log(np.array(points)).T
            found[key] = float(np.polyfit(steps, errors, 1)[0])
    return found


def recommend(rows: Sequence[FewBodyError], wanted: float) -> list[dict[str, object]]:
    """Per case and variant the fewest steps per period from which on every error is at most ``wanted``.

    ``steps_per_period`` by interpolation between the steps that were run, ``step`` in T0 of that case; None, with the
    least error seen, where the law or the steps run do not get there.
    """
    answers = []
    for key in dict.fromkeys((row.case, row.variant) for row in rows):
        of = sorted(_of(rows, key), key=lambda row: row.steps_per_period)
        failing = [k for k, row in enumerate(of) if not row.error <= wanted]
        first = failing[-1] + 1 if failing else 0
        answer: dict[str, object] = {"case": key[0], "variant": key[1], "steps_per_period": None, "step": None}
        if first < len(of):
            spp = _crossing(of[first - 1], of[first], wanted) if first else of[0].steps_per_period
            answer |= {"steps_per_period": spp, "step": of[first].step * of[first].steps_per_period / spp}
        answers.append({**answer, "least_error": min(row.error for row in of)})
    return answers


def _crossing(coarse: FewBodyError, fine: FewBodyError, wanted: float) -> float:
    """Steps per period at which the line between two points, in logarithms, meets ``wanted``."""
    if not math.isfinite(coarse.error) or fine.error <= 0.0 or coarse.error <= fine.error:
        return fine.steps_per_period
    share = math.log(coarse.error / wanted) / math.log(coarse.error / fine.error)
    return coarse.steps_per_period * (fine.steps_per_period / coarse.steps_per_period) ** share


def _of(rows: Sequence[FewBodyError], key: tuple[str, str]) -> list[FewBodyError]:
    return [row for row in rows if (row.case, row.variant) == key]


def study(
    plan: Plan, *, variants: Sequence[Variant] = VARIANTS, out: TextIO = sys.stderr
) -> tuple[list[FewBodyError], list[PackingStatistics]]:
    """Both parts."""
    print("few bodies against the reference", file=out)
    few = few_bodies(plan, variants, out)
    print(f"packings of {plan.grains} grains, {plan.seeds} seeds", file=out)
    return few, many_bodies(plan, variants, out)
