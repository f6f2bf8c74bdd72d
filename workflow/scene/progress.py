"""What a running scene says of itself, from its time series: one line, and how long the present stage still takes.

A stage ends by its physics: vibrations decay exponentially below the tolerances and must stay there for a time, contacts stay
the same for a time, a stiffness ramp or a feed comes to its end.  Where the time series does not tell, the time left is
unknown: an extrapolation counts only if the ones from 70 % and 85 % of the stage's time so far would have said the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from workflow.data.frame import Floats

if TYPE_CHECKING:
    from workflow.scene.heap import Heap
    from workflow.scene.packing import Packing

Series = Mapping[str, Floats]
Decays = list[tuple[Callable[[Series], Floats], float]]  # a quantity, and the bound that it must fall below
EARLIER = (0.7, 0.85)  # shares of the time of the stage from which an extrapolation is repeated
AGREE = 0.5  # the ends that they give may differ by this share of the time left
FEWEST = 10  # rows of a fit
CLOSING = 0.8  # share of the time of a compression after which its end is not told by the barostat any more
SLIDE = 20.0  # time in which the flanks of a heap come to rest after the last grain, more or less [sqrt(sigma/g)]


def of_stage(series: Series) -> Series:
    """The rows of the present stage."""
    rows = series["stage"] == series["stage"][-1]
    return {name: values[rows] for name, values in series.items()}


def words(seconds: float | None) -> str:
    """A time left for people: ~40 s, or unknown."""
    return "unknown" if seconds is None else f"~{duration(seconds)}"


def duration(seconds: float) -> str:
    """A time for people: 40 s, 5 min, 3.0 h."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


# ---- what a stage still takes, in the unit of time of the scene; None: unknown
def packing_left(rows: Series, scene: Packing, stage: str) -> float | None:
    """Time left in a stage of a packing; ``rows``: of this stage."""
    kind, passed = stage.split()[0], float(rows["time"][-1] - rows["time"][0])
    if kind == "aggregate":
        return _unchanged(rows, getattr(scene, "quiet", 0.0), 0.7) if rows["aggregates"][-1] == 1 else None
    if kind == "compress":
        return _compression_left(rows, scene, stage, passed)
    if kind in ("load", "unload"):
        return _load_left(rows, scene, stage)
    if kind == "stiffen" and passed < scene.stiffening:  # type: ignore[attr-defined]
        return float(scene.stiffening - passed + scene.hold_time)  # type: ignore[attr-defined]
    return _equilibrium_left(rows, scene) if kind in ("relax", "free", "settle", "resettle", "stiffen") else None


def heap_left(rows: Series, scene: Heap) -> float | None:
    """Time left in the pouring of a heap: until the last grain is there and has held still; then until it is at rest."""
    now, fed = float(rows["time"][-1]), scene.grains / scene.feed_rate if scene.start == "pour" else 0.0
    if now < fed:
        return fed - now + scene.impact_speed + SLIDE + scene.hold if fed - now > SLIDE else None
    after = {name: values[rows["time"] >= fed] for name, values in rows.items()}
    return _equilibrium_left(after, scene) if len(after["time"]) >= FEWEST else None


def _compression_left(rows: Series, scene: Packing, stage: str, passed: float) -> float | None:
    """The barostat closes the cell in a known time; then stress and kinetic energy decay, and contacts stay the same."""
    stress, still = scene.pressure_of(stage) or 0.0, 2.0 * scene.hold_time
    quiet, borne = float(rows["quiet"][-1]), 0.5 * float(rows["stress_x"][-1] + rows["stress_y"][-1])
    if borne < 0.5 * stress and passed < CLOSING * scene.compression_time and quiet < 0.5 * still:
        return scene.compression_time - passed + still
    if quiet < 0.5 * still:
        return None
    bound = 10.0 * min(scene.force_tolerance * scene.force_unit, 0.01 * stress)
    decays: Decays = [(lambda r: r["kinetic_per_grain"], scene.energy_tolerance * scene.force_unit),
                      (lambda r: _swing(r, stress), bound)]  # fmt: skip
    left = _agreed(lambda r: _until_below(r, decays, envelope=True), rows)
    return None if left is None else max(left, still - quiet)


def _load_left(rows: Series, scene: Packing, stage: str) -> float | None:
    """A load ends when the stress is borne and contacts have not changed for a time; while they change nobody knows."""
    stress, wanted = scene.pressure_of(stage) or 0.0, getattr(scene, "quiet", 0.0)
    left = _unchanged(rows, wanted, 0.7)
    return left if left and _swing(rows, stress)[-1] < 0.5 * stress else None


def _equilibrium_left(rows: Series, scene: Packing | Heap) -> float | None:
    """Until all criteria have held for the time `hold`: what is left of it, or until they do, by their decay."""
    hold, held = float(getattr(scene, "hold_time", scene.hold or 0.0)), float(rows["held"][-1])
    if held > 0.0:
        return hold - held if held > 0.5 * hold else None
    force, energy = scene.force_tolerance * scene.force_unit, scene.energy_tolerance * scene.force_unit
    decays: Decays = [(lambda r: r["net_force"], force), (lambda r: r["net_moment"], force),
                      (lambda r: r["kinetic_per_grain"], energy)]  # fmt: skip
    left = _agreed(lambda r: _until_below(r, decays), rows)
    return None if left is None else left + hold


def _unchanged(rows: Series, wanted: float, share: float) -> float | None:
    """What is left of the time in which contacts must stay the same, once they did for a ``share`` of it."""
    quiet = float(rows["quiet"][-1])
    return wanted - quiet if share * wanted < quiet < wanted else None


def _swing(rows: Series, stress: float) -> Floats:
    """The larger difference of the stresses from the imposed one, (rows,)."""
    return np.maximum(abs(rows["stress_x"] - stress), abs(rows["stress_y"] - stress))


def _agreed(left: Callable[[Series], float | None], rows: Series) -> float | None:
    """``left`` of these rows, if it is less than they took, and earlier rows gave the same end."""
    now, time = left(rows), rows["time"]
    passed = time[-1] - time[0]
    if now is None or now > passed:
        return None
    for share in EARLIER:
        before = {name: values[time <= time[0] + share * passed] for name, values in rows.items()}
        then = left(before) if len(before["time"]) else None
        if then is None or abs(before["time"][-1] + then - time[-1] - now) > AGREE * now:
            return None
    return now


def _until_below(rows: Series, decays: Decays, *, envelope: bool = False) -> float | None:
    """Time until every quantity is below its bound, if it goes on falling as over the last half of ``rows``."""
    half = rows["time"] >= 0.5 * (rows["time"][0] + rows["time"][-1])
    times = [_decay(rows["time"][half], of(rows)[half], bound, envelope) for of, bound in decays]
    return None if None in times else max(time for time in times if time is not None)


def _decay(time: Floats, values: Floats, bound: float, envelope: bool) -> float | None:
    """Time until an exponential through ``values`` (``envelope``: through the largest of each eighth) is below ``bound``."""
    if len(time) < FEWEST:
        return None
    if envelope:
        parts = np.array_split(np.arange(len(time)), min(8, len(time)))
        time, values, end = (np.array([time[p].mean() for p in parts]), np.array([values[p].max() for p in parts]), time[-1])
        recent = values[-1]
    else:
        end, recent = time[-1], values[-max(len(values) // 5, 1) :].max()
    if recent <= bound:
        return 0.0
    above = values > 0.0
    slope, at_zero = np.polyfit(time[above], np.log(values[above]), 1) if above.sum() > 4 else (0.0, 0.0)
    return max(float((np.log(bound) - at_zero) / slope - end), 0.0) if slope < 0.0 else None


# ---- the line
def of_packing(series: Series, cohesion: bool) -> str:
    """Solid fraction, coordination number, pressure, unbalanced force, aggregates."""
    last = {name: float(values[-1]) for name, values in series.items()}
    parts = last.get("aggregates", 1.0) if cohesion else 1.0
    return (
        f"Phi {last['solid_fraction']:.4f}  z {last['coordination']:.2f}  "
        f"P {0.5 * (last['stress_x'] + last['stress_y']):9.3g}  unbalanced {last['net_force']:.1e}"
        + (f"  aggregates {parts:.0f}, largest {last['largest_aggregate']:.0f}" if parts > 1 else "")
    )


def of_heap(series: Series, grains: int, floor: float) -> str:
    """Grains poured and gone, height above the ``floor``, unbalanced force."""
    last = {name: float(values[-1]) for name, values in series.items()}
    return (
        f"grains {last['poured']:.0f} of {grains}  gone {last['removed']:.0f}  top {last['top'] - floor:6.2f}  "
        f"unbalanced {last['net_force']:.1e}"
    )
