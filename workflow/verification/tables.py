"""What `wf bench`, `wf scale` and `wf crosscheck` found, as lines for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # a command does not load what it does not run
    from workflow.verification.bench import Timing
    from workflow.verification.crosscheck import Mean, Packed
    from workflow.verification.crosscheck_few import FewBodyError
    from workflow.verification.scale import Estimate, Stage

TITLES = f"{'ns per grain and step':26s}  median    least ..   most  /hooke  /exact   pair  neigh   comm modify  other"


def bench_table(timings: Sequence[Timing]) -> str:
    """The timings in words, one block per state."""
    lines: list[str] = []
    for timing in timings:
        head = (
            f"{timing.state}, {timing.n} grains, {timing.ranks} rank{'s' * (timing.ranks > 1)}, "
            f"{timing.rounds} rounds of {timing.steps} steps"
        )
        if head not in lines:
            lines += ["", head, TITLES]
        parts = " ".join(_shown(part, 6, 1) for part in (timing.pair, timing.neigh, timing.comm, timing.modify, timing.other))
        lines.append(
            f"{timing.engine:26s} {timing.ns_per_grain_step:7.1f}  {timing.least:7.1f} .. {timing.most:6.1f} "
            f"{_shown(timing.ratio, 7, 2)} {_shown(timing.ratio_to_exact, 7, 2)} {parts}"
        )
    return "\n".join(lines[1:])


def scale_table(rows: Sequence[Stage]) -> list[str]:
    """The stages for people, one block per scene."""
    lines: list[str] = []
    for row in rows:
        head = f"{row.state}, {row.n} grains"
        if head not in lines:
            titles = f"{'stage':30s} ranks   seconds  processor  peak GB  bytes/grain  ns/grain/step      MB   ghosts"
            lines += ["", head, titles]
        numbers = f"{row.seconds:9.1f} {row.processor_seconds:10.1f} {row.peak_GB:8.2f} {row.bytes_per_grain:12.0f}"
        rest = f"{_shown(row.ns_per_grain_step, 14, 2)} {_shown(row.MB, 7, 0)} {_shown(row.ghosts, 8, 0)}"
        lines.append(f"{row.stage:30s} {row.ranks:5d} {numbers} {rest}")
    return lines[1:]


def estimate_lines(one: Estimate) -> list[str]:
    """An estimate for people."""
    return [
        "",
        f"estimate: {one.state}, {one.n:.3g} grains on {one.ranks} ranks, {one.grains_per_rank:.0f} grains each",
        f"memory of a rank        {one.memory_GB:.3f} GB",
        f"a million steps         {one.seconds_per_million_steps / 3600:.2f} h",
        f"messages of a rank      {one.sent_kB:.1f} kB a step for {one.ghosts:.0f} ghosts, {one.sent_MB_per_second:.0f} MB/s",
        f"data file               {one.data_GB:.1f} GB",
        f"frame                   {one.frame_GB:.1f} GB as text in at most {one.frame_seconds:.0f} s through one rank, "
        f"{one.archive_GB:.1f} GB in the archive",
        f"restart                 {one.restart_GB:.1f} GB in {one.restart_seconds:.0f} s through one rank, "
        f"{one.restart_seconds_parallel:.1f} s at {one.bandwidth:g} GB/s",
    ]


def few_table(rows: Sequence[FewBodyError]) -> list[str]:
    """Few bodies: for each case and engine the errors at the coarsest and finest step."""
    if not rows:
        return []
    coarse, fine = min(r.steps_per_period for r in rows), max(r.steps_per_period for r in rows)
    table = {(row.case, row.engine, row.steps_per_period): row for row in rows}
    heads = "".join(f"{f'{many:g} steps':>14s}" for many in (coarse, fine, coarse, fine))
    lines = [
        "few discs, rms over groups of the largest difference of positions, velocities, surface velocities; steps per period",
        f"{'':50s}{'to the reference of our law':>28s}{'to granular of LAMMPS':>28s}",
        f"{'case':26s}{'engine':24s}{heads}",
    ]
    for case, name in dict.fromkeys((row.case, row.engine) for row in rows):
        first, last = table[case, name, coarse], table[case, name, fine]
        lines.append(
            f"{case:26s}{name:24s}{first.error:14.1e}{last.error:14.1e}{first.to_granular:14.1e}{last.to_granular:14.1e}"
        )
    return lines


def packing_table(rows: Sequence[Packed], found: Sequence[Mean]) -> list[str]:
    """Packings: means over seeds with standard errors, differences seed by seed, distances of the force distributions."""
    if not rows:
        return []
    lines = ["", f"packings of {rows[0].n} grains, {len({row.seed for row in rows})} seed(s): mean +- standard error"]
    for number in dict.fromkeys(mean.number for mean in found):
        lines += ["", f"{number.replace('_', ' '):26s}{'mean':>22s}{'difference to exact':>24s}"]
        lines += [_line(mean) for mean in found if mean.number == number]
    lines += ["", f"{'force distribution':26s}{'KS distance to exact':>22s}{'5 % level':>12s}{'kinetic energy':>18s}"]
    for name in dict.fromkeys(row.engine for row in rows):
        of = [row for row in rows if row.engine == name]
        ks, level, kinetic = (max(getattr(row, key) for row in of) for key in ("ks", "ks_critical", "kinetic"))
        lines.append(f"{name:26s}{f'{min(r.ks for r in of):.3f} .. {ks:.3f}':>22s}{level:12.3f}{kinetic:18.1e}")
    return lines


def _line(mean: Mean) -> str:
    def shown(value: float, error: float | None, sign: str = "") -> str:
        return f"{value:{sign}.4f}" + (f" +- {error:.4f}" if error is not None else "")

    apart = shown(mean.difference, mean.difference_error, "+") if mean.difference else ""
    return f"  {mean.engine:24s}{shown(mean.mean, mean.error):>22s}{apart:>24s}"


def _shown(value: float | None, width: int, digits: int) -> str:
    return "-".rjust(width) if value is None else f"{value:{width}.{digits}f}"
