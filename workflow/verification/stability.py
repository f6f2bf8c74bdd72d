"""Which parameters are computed stably, inaccurately, unstably or not at all: one trial per value of a list of extremes.

Packings are the first stage of method 1 with few grains; gases and given positions run in a fixed cell; of heaps the
first grains fall on the base.  Every step is the one that the step rule of the scenes chooses.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.data.progress import Meter
from workflow.errors import EngineError, InputError, WorkflowError
from workflow.pipeline import run as pipeline_run
from workflow.runs.directory import RunDirectory
from workflow.scene.heap import Heap
from workflow.scene.method1 import Method1
from workflow.scene.parts import Numerics
from workflow.scene.placement import Floats, place_randomly
from workflow.scene.time_step import Step, choose_step
from workflow.verification.one_run import VARIANTS, Variant, run

STABLE, INACCURATE, UNSTABLE, REFUSED = "stable", "inaccurate", "unstable", "refused"
RESIDUAL = 0.05  # of the energy that went through; above, the run is inaccurate
BLOWN_UP = 0.5  # of the same; above, the energy account says nothing any more
OVERLAP = 0.05  # of the smallest radius; above, the linear law of small overlaps is used outside its range
TAIL_STEPS = 2.5  # spent in the tail at the fastest approach; below, the attraction is not resolved
GRAINS, MOST_STEPS, QUICK_STEPS, PATIENCE = 60, 200_000, 30_000, 120.0
INDICES = (2.0, 12.0, 20.0, 36.0, 72.0, 144.0, 200.0, 300.0, 1000.0, 2000.0)  # of the law of heaps


@dataclass(frozen=True)
class Setting:
    """What a trial runs: grains, law, step, and stress (0: fixed cell)."""

    discs: Discs
    law: ContactLaw
    choice: Step
    duration: float
    stress: float = 0.0
    skin: float = 0.1
    velocity: Floats | None = None


@dataclass(frozen=True)
class Trial:
    """``setting`` is made when the trial runs: making it may raise InputError, which is a refusal.  ``steps``: at most."""

    parameter: str
    value: float
    setting: Callable[[], Setting | Heap]
    steps: int = MOST_STEPS


@dataclass(frozen=True)
class Verdict:
    """One trial's outcome; numbers are None where it did not run to its end.

    ``residual`` of the energy account relative to the energy that went through, ``overlap`` relative to the smallest
    radius, ``tail_steps`` spent in the tail at the fastest approach, ``limit_share`` step over the stability limit.
    """

    parameter: str
    value: float
    scheme: str
    verdict: str
    reason: str
    step: float | None = None
    limit_share: float | None = None
    residual: float | None = None
    overlap: float | None = None
    tail_steps: float | None = None
    seconds: float | None = None


def packing(**changes: Any) -> Callable[[], Setting]:
    """Method 1 from grains close to each other until the packing has formed and come to rest or nearly so."""

    def setting() -> Setting:
        scene = Method1(**{"n": GRAINS, "phi0": 0.5, "pstar": 0.1, **changes})
        duration = scene.compression_time + scene.hold_time + 1.0
        return Setting(
            scene.discs(), scene.law_in_units, scene.step_choice, duration, scene.pressure, scene.neighbour_skin
        )  # fmt: skip

    return setting


def gas(speed: float) -> Callable[[], Setting]:
    """Grains of rms speed ``speed`` V* in a fixed cell, series A of G07, until each has met others a few times."""

    def setting() -> Setting:
        scene = Method1(n=GRAINS)
        rms, discs = speed * math.sqrt(scene.d0), scene.discs()
        velocity = np.random.default_rng(1).normal(size=(GRAINS, 2))
        velocity -= discs.diameter**2 @ velocity / np.sum(discs.diameter**2)
        velocity *= rms / math.sqrt(np.mean(np.sum(velocity**2, axis=1)))
        choice = choose_step(scene.law_in_units, scene.smallest, 3.0 * rms, Numerics())
        return Setting(discs, scene.law_in_units, choice, 3.0 / rms, velocity=velocity)

    return setting


def given(diameter: list[float], position: list[list[float]], length: float = 10.0) -> Callable[[], Setting]:
    """Discs at rest at given places in a fixed cell; the step knows nothing of an overlap."""

    def setting() -> Setting:
        scene = Method1(n=GRAINS)
        discs = Discs(np.array(diameter), np.array(position), np.full(2, length))
        choice = choose_step(scene.law_in_units, min(diameter), scene.approach_speed, Numerics())
        return Setting(discs, scene.law_in_units, choice, 1.0)

    return setting


def beyond(share: float, **changes: Any) -> Callable[[], Setting]:
    """A packing at ``share`` times the limit of stability, past the check of the scene: what the check prevents."""

    def setting() -> Setting:
        usual = packing(cohesion=False, **changes)()
        choice = usual.choice
        return replace(usual, choice=replace(choice, step=share * choice.limit))

    return setting


def heap_of(overlap: float) -> Callable[[], Setting]:
    """Grains at random places that may overlap: drawn for discs smaller by the factor 1 - ``overlap``."""

    def setting() -> Setting:
        scene = Method1(n=GRAINS, cohesion=False)
        rng = np.random.default_rng(1)
        small = place_randomly(np.full(GRAINS, 1.0), 0.5, 0.0, rng)
        discs = Discs(small.diameter / (1.0 - overlap), small.position, small.cell)
        return Setting(discs, scene.law_in_units, choose_step(scene.law_in_units, 1.0, 1.0, Numerics()), 1.0)

    return setting


def poured(**changes: Any) -> Callable[[], Heap]:
    """Six grains of a heap, from the full height on a base so small that every impact is hard (B97)."""
    few = {
        "grains": 6,
        "feed_rate": 0.5,
        "feed_half_width": 2.0,
        "base_half_width": 4.0,
        "max_time": 30.0,
        "frame_interval": 0.0,
    }
    return lambda: Heap(**{**few, **changes})


def equal_tail(index: float) -> float:
    """The range at which the force of this index is that of n = 36 at 1.2 sigma (B97 sec. III)."""
    return float(1.2 ** (37.0 / (index + 1.0)))


def _scan(parameter: str, values: tuple[float, ...], make: Callable[[float], Callable[[], Setting | Heap]]) -> list[Trial]:
    return [Trial(parameter, value, make(value)) for value in values]


def trials() -> list[Trial]:
    """The list of stiff and extreme cases."""
    inf = math.inf
    return [
        *_scan("kappa", (1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9), lambda v: packing(kappa=v)),
        *_scan("kappa, F0 = 0", (1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8), lambda v: packing(kappa=v, cohesion=False)),
        *_scan("zeta", (0.0, 0.1, 0.4, 0.8, 1.2, 1.6, 2.0, 2.5), lambda v: packing(zeta=v)),
        *_scan("zeta, mu = 0, F0 = 0", (0.0, 0.4, 0.8, 1.2, 1.6, 2.0), lambda v: packing(zeta=v, mu=0.0, cohesion=False)),
        *_scan("zeta, equal discs, mu = 0, F0 = 0", (0.0, 0.4, 0.8, 1.2, 1.6, 2.0),
               lambda v: packing(zeta=v, mu=0.0, cohesion=False, smallest=1.0)),
        *_scan("mu", (-1.0, 0.0, 0.15, 0.5, 1.0, 10.0, inf), lambda v: packing(mu=v)),
        *_scan("mu, F0 = 0", (0.0, 0.15, 0.5, 1.0, 10.0, inf), lambda v: packing(mu=v, cohesion=False)),
        *_scan("K_r/(K_N a^2), mu_r = 0.5", (1e-6, 1e-4, 1e-2, 1.0, 2.0), lambda v: packing(rolling=True, mur=0.5, kr_ratio=v)),
        *_scan("D0/a", (1e-7,), lambda v: packing(d0=v)),
        Trial("D0/a", 1e-6, packing(d0=1e-6), 15 * MOST_STEPS),  # a gap takes 1e6 steps of a fifth of D0
        *_scan("D0/a", (1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.2), lambda v: packing(d0=v)),
        *_scan("size ratio", (1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 200.0), lambda v: packing(smallest=1.0 / v)),
        *_scan("size ratio, F0 = 0", (1.0, 2.0, 5.0, 10.0, 30.0, 100.0), lambda v: packing(smallest=1.0 / v, cohesion=False)),
        *_scan("P*", (0.0, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3), lambda v: packing(pstar=v)),
        *_scan("V0/V*", (0.1, 1.0, 9.48, 30.0, 95.0, 300.0, 1000.0), gas),
        *_scan("steps per period", (4.0, 7.0, 10.0, 14.0, 20.0, 28.0, 56.0), lambda v: packing(steps_per_period=v)),
        *_scan("step [T0]", (1e-5, 1e-4, 3e-4, 5e-4, 1e-3), lambda v: packing(step=v)),
        *_scan("step/limit, zeta = 0.8, unchecked", (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0), lambda v: beyond(v)),
        *_scan("step/limit, zeta = 0, mu = 0, unchecked", (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0),
               lambda v: beyond(v, zeta=0.0, mu=0.0)),
        *_scan("step/limit, zeta = 2, mu = 0, unchecked", (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0),
               lambda v: beyond(v, zeta=2.0, mu=0.0)),
        *_scan("start fraction", (0.1, 0.36, 0.5, 0.57, 0.6, 0.7), lambda v: packing(phi0=v)),
        *_scan("grains", (1.0, 2.0, 5.0, 10.0, 20.0, 40.0), lambda v: packing(n=int(v))),
        Trial("grains, fixed cell", 1.0, given([1.0], [[5.0, 5.0]])),
        Trial("grains, fixed cell", 2.0, given([1.0, 0.5], [[5.0, 5.0], [5.7501, 5.0]])),
        *_scan("cell/diameter, one grain", (1.0, 1.5, 2.0, 2.5, 4.0), lambda v: given([1.0], [[0.2, 0.2]], v)),
        *_scan("overlap of two at the start", (1e-4, 1e-3, 1e-2, 1e-1, 0.5, 1.0),
               lambda v: given([1.0, 1.0], [[5.0, 5.0], [6.0 - v, 5.0]])),
        *_scan("overlap of many at the start", (0.0, 1e-2, 0.1, 0.3), heap_of),
        *_scan("heap, n, r0 = 1.2", INDICES, lambda v: poured(index=v)),
        *_scan("heap, n, r0 of equal force", INDICES, lambda v: poured(index=v, cutoff=equal_tail(v))),
        *_scan("heap, Hooke's k", (10.0, 50.0, 500.0, 5e3, 5e4, 5e5), lambda v: poured(hooke=v)),
        *_scan("heap, mu", (0.0, 0.2, 0.5, 1.0, 10.0), lambda v: poured(mu=v)),
        *_scan("heap, damping", (0.0, 0.1, 0.5, 1.0, 2.0, 3.0), lambda v: poured(damping=v)),
        *_scan("heap, steps per period", (3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 40.0), lambda v: poured(steps_per_period=v)),
    ]  # fmt: skip


def judge(trial: Trial, variant: Variant, most_steps: int) -> Verdict:
    """Run one trial."""
    try:
        setting = trial.setting()
        if isinstance(setting, Setting):
            return _measured(trial, variant, setting, most_steps)
        return _heap(trial, variant, replace(setting, scheme=variant.scheme))
    except InputError as fault:
        return Verdict(trial.parameter, trial.value, variant.name, REFUSED, str(fault))
    except WorkflowError as fault:  # an engine that stopped, or positions that are no numbers
        return Verdict(trial.parameter, trial.value, variant.name, UNSTABLE, str(fault).splitlines()[0])


def _measured(trial: Trial, variant: Variant, setting: Setting, most_steps: int) -> Verdict:
    law, choice = setting.law, setting.choice
    steps = min(math.ceil(setting.duration / choice.step), most_steps)
    values = {
        **{name: min(value, 1e100) for name, value in asdict(law).items()}, "scheme": variant.scheme,
        "stress": setting.stress, "skin": setting.skin, "step": choice.step, "steps": steps, "maxima": 1,
    }  # fmt: skip
    outcome = run(setting.discs, values, velocity=setting.velocity, patience=PATIENCE)
    result = outcome.result
    through = max(abs(result["work"]), result["lost"], abs(result["begin"]), 1e-300)
    residual = abs(result["end"] - result["begin"]) / through
    overlap = 2.0 * result["overlap"] / float(setting.discs.diameter.min())
    tail = law.d0 / (result["approach"] * choice.step) if law.d0 and result["approach"] > 0.0 else None
    if not math.isfinite(residual):
        raise EngineError("energy is not a number")
    verdict, reason = _verdict(residual, overlap, tail)
    if result["overlap"] == 0.0:
        reason = "no contact"
    if steps == most_steps:
        reason += f"; the first {steps * choice.step:.2g} of {setting.duration:.2g} T0"
    return Verdict(
        trial.parameter, trial.value, variant.name, verdict, reason, choice.step, choice.step / choice.limit, residual,
        overlap, tail, outcome.seconds,
    )  # fmt: skip


def _heap(trial: Trial, variant: Variant, scene: Heap) -> Verdict:
    """A heap to the end of its time, which is short whatever the step.  Its law is made for overlaps: they do not count."""
    with tempfile.TemporaryDirectory() as name:
        directory = RunDirectory.create(Path(name) / "run", scene)
        pipeline_run.run(directory, out=StringIO())
        series, seconds = directory.series(), directory.state["seconds"]
    assert series is not None
    residual = float(np.abs(series["residual"]).max() / series["energy_in"].max())
    if not math.isfinite(residual):
        raise EngineError("energy is not a number")
    choice, overlap = scene.step_choice, 2.0 * float(series["largest_overlap"][-1])
    verdict, reason = _verdict(residual, 0.0, None)
    return Verdict(
        trial.parameter, trial.value, variant.name, verdict, reason, choice.step, choice.step / choice.limit, residual,
        overlap, None, seconds,
    )  # fmt: skip


def _verdict(residual: float, overlap: float, tail: float | None) -> tuple[str, str]:
    """Verdict and the numbers that decide it."""
    if residual > BLOWN_UP:
        return UNSTABLE, f"energy residual {100.0 * residual:.0f} %"
    reasons = [
        words
        for words, bad in (
            (f"energy residual {100.0 * residual:.1f} %", residual > RESIDUAL),
            (f"overlap {overlap:.2g} of the smallest radius", overlap > OVERLAP),
            (f"{tail or 0.0:.1f} steps in the tail at the fastest approach", tail is not None and tail < TAIL_STEPS),
        )
        if bad
    ]
    return (INACCURATE, "; ".join(reasons)) if reasons else (STABLE, f"energy residual {100.0 * residual:.1f} %")


def study(*, quick: bool = False, variants: tuple[Variant, ...] = VARIANTS, out: TextIO = sys.stderr) -> list[Verdict]:
    """All trials with every scheme of the exact law; ``quick``: at most QUICK_STEPS steps each."""
    schemes = [variant for variant in variants if variant.law == "disc"]
    listed = [(trial, variant) for variant in schemes for trial in trials()]
    meter, found = Meter(len(listed), out), []
    for trial, variant in listed:
        found.append(judge(trial, variant, QUICK_STEPS if quick else trial.steps))
        meter.add(1.0, f"{trial.parameter} = {trial.value:g}: {found[-1].verdict}")
    meter.end()
    return found
