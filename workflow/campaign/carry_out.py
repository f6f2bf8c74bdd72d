"""Carry out a study: write it down, link the finished runs that are there, compute the rest here or submit it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from workflow.campaign.cluster import Profile
from workflow.campaign.local import Outcome, compute
from workflow.campaign.results import RESULTS, write_results
from workflow.campaign.slurm import preview, submit
from workflow.campaign.study import DONE, Study, remaining
from workflow.errors import InputError
from workflow.runs.installation import check_room, engine
from workflow.scene.progress import duration

Say = Callable[[str], None]


def to_stderr(text: str) -> None:
    """Print a line to standard error."""
    print(text, file=sys.stderr)


@dataclass(frozen=True)
class Orders:
    """How a study is carried out.

    ``jobs``: runs at a time (None: one, in a job array no limit); ``ranks``: MPI ranks of a run (None: one, or those it was
    begun with); ``retry``: run again what failed; ``adopt``: folders whose finished runs of the same scenes are linked;
    ``any_deck``: also those whose deck another version made; ``oversubscribe``: more ranks than cores are allowed.
    Raises InputError for numbers below 1.
    """

    jobs: int | None = None
    ranks: int | None = None
    retry: bool = False
    adopt: Sequence[Path] = ()
    any_deck: bool = False
    oversubscribe: bool = False

    def __post_init__(self) -> None:
        for name in ("jobs", "ranks"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise InputError(f"--{name} {value} is not allowed: it must be at least 1")

    @property
    def of_each_run(self) -> list[str]:
        """Options of the `wf resume` that computes a point."""
        given = {"--any-deck": self.any_deck, "--oversubscribe": self.oversubscribe, "--anew": self.retry}
        return [option for option, wanted in given.items() if wanted]


def carry_out(study: Study, orders: Orders, say: Say = to_stderr, *, compute_rest: bool = True) -> Outcome:
    """Write down the study, adopt what is there, compute the rest on this machine unless that is not wanted."""
    if not compute_rest:
        declare_and_adopt(study, orders, say)
        return Outcome()
    check_room(orders.ranks or 1, oversubscribe=orders.oversubscribe)
    engine()
    declare_and_adopt(study, orders, say)
    outcome = compute(study, jobs=orders.jobs or 1, ranks=orders.ranks, retry=orders.retry, options=orders.of_each_run)
    if outcome.elsewhere:
        say(f"{outcome.elsewhere} points are left to another wf that works on them")
    if outcome.interrupted:
        say("wf: interrupted; the same command continues")
    elif outcome.failed:
        say(f"wf: {outcome.failed} points failed: 'wf status {shlex.quote(str(study.folder))}' says why, --retry tries again")
    return outcome


def declare_and_adopt(study: Study, orders: Orders, say: Say = to_stderr) -> None:
    """Write down the study, link what is there."""
    study.save()
    adopted, left = study.adopt([study.folder, *orders.adopt], any_deck=orders.any_deck)
    if adopted:
        say(f"adopted {adopted} finished runs")
    if left:
        say(f"{left} finished runs have a deck that another version made of the scene; --any-deck adopts them")


def send(study: Study, profile: Profile, orders: Orders, say: Say = to_stderr) -> Path | None:
    """Write down the study, adopt what is there, submit the rest; where the results are if nothing was left to submit."""
    engine()
    declare_and_adopt(study, orders, say)
    sent = submit(study, profile, at_once=orders.jobs, retry=orders.retry)
    if sent:
        number, points, tasks = sent
        say(f"submitted {points} points as {tasks} tasks of job {number}; 'wf status {shlex.quote(str(study.folder))}' "
            "shows how far they are")  # fmt: skip
        return None
    say("nothing to submit: every point is done, in the queue, or failed (--retry tries those again)")
    return study.folder / RESULTS if write_results(study) else None


def plan(study: Study, profile: Profile | None, orders: Orders) -> str:
    """One line per point, then what is left to compute, and of a job the script that would be submitted."""
    standings = [study.standing(point) for point in study.points]
    rows = [f"{now.status:11s} {point.name}  {study.label(point)}" for point, now in zip(study.points, standings, strict=True)]
    done = sum(now.status == DONE for now in standings)
    left = remaining(study.points, standings)
    cost = f", about {duration(left)} of one core" if left else ""
    job = [preview(study, profile, at_once=orders.jobs, retry=orders.retry)] if profile else []
    return "\n".join([*rows, f"{len(study.points)} points, {done} done{cost}", *job])
