"""The points of a study computed on this machine, several at a time, each by a `wf resume` of its own."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import IO, TextIO

from workflow.campaign.study import DONE, FAILED, INTERRUPTED, RUNNING, Point, PointLocks, PointStatus, Study, remaining
from workflow.data.notebook import progress_output
from workflow.errors import InputError
from workflow.runs import directory as rundir
from workflow.runs.child_process import with_parent
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import python_child
from workflow.scene.progress import duration

POLL = 0.1  # seconds between looks at the jobs
LINE_INTERVAL = 1.0  # seconds between changes of the line on a terminal


@dataclass
class Outcome:
    """What `compute` did: numbers of points ``done`` before and now, ``failed``, at work in another process
    (``elsewhere``); ``interrupted`` by the user."""

    done: int = 0
    failed: int = 0
    elsewhere: int = 0
    interrupted: bool = False


@dataclass
class Job:
    """A point with the process that computes it and what that says."""

    point: Point
    directory: RunDirectory
    process: subprocess.Popen[bytes]
    words: IO[bytes] = field(repr=False)
    before: float  # seconds that the point had run
    begun: float = field(default_factory=time.monotonic)


def compute(
    study: Study, *, jobs: int = 1, ranks: int | None = None, retry: bool = False, options: Sequence[str] = (),
    out: TextIO | None = None,
) -> Outcome:  # fmt: skip
    """Compute what is not done of ``study``, ``jobs`` points at a time on ``ranks`` MPI ranks each (None: one, or those it
    was begun with); those interrupted go on from their checkpoints.  ``options``: further ones of `wf resume`.

    Failed points stay as they are unless ``retry``.  A KeyboardInterrupt stops every job at its next checkpoint, a second
    one at once; the next call continues them.
    """
    with study.claims() as claims:
        crew = Runner(study, claims, jobs, ranks, retry, options, out or progress_output())
        try:
            while crew.waiting or crew.running:
                while crew.waiting and len(crew.running) < crew.jobs:
                    crew.start(crew.waiting.popleft())
                crew.look()
        except KeyboardInterrupt:
            crew.outcome.interrupted = True
            crew.stop()
        finally:
            crew.end()
    return crew.outcome


class Runner:
    """The jobs at work and the points that wait for one."""

    def __init__(
        self, study: Study, claims: PointLocks, jobs: int, ranks: int | None, retry: bool, options: Sequence[str], out: TextIO
    ) -> None:
        self.study, self.claims, self.jobs, self.ranks, self.out = study, claims, jobs, ranks, out
        self.options = [*(["--ranks", str(ranks)] if ranks else []), *options]
        self.standings: dict[str, PointStatus] = {point.digest: study.standing(point) for point in study.points}
        of = {DONE: 0, FAILED: 0} | {now.status: 0 for now in self.standings.values()}
        for now in self.standings.values():
            of[now.status] += 1
        self.outcome = Outcome(done=of[DONE], failed=0 if retry else of[FAILED])
        leave = (DONE,) if retry else (DONE, FAILED)
        todo = [point for point in study.points if self.standings[point.digest].status not in leave]
        # what was begun first
        self.waiting = deque(sorted(todo, key=lambda point: self.standings[point.digest].status != INTERRUPTED))
        self.running: list[Job] = []
        self.line, self.shown = "", 0.0
        self.passed = self.ran = 0.0  # seconds that ended jobs took, start and archive included; those of their runs

    def start(self, point: Point) -> None:
        """Begin or continue a point, unless another process has it."""
        if not self.claims.take(point):
            self.outcome.elsewhere += 1
            return
        now = self.study.standing(point)  # another process may have come first
        busy = now.status == RUNNING and self.study.directory(point).locked()  # else its machine failed, or its id lives on
        if now.status == DONE or busy:
            self.claims.give(point)
            self.standings[point.digest] = now
            self.outcome.done += now.status == DONE
            self.outcome.elsewhere += busy
            return
        try:
            directory = self.study.prepare(point)
        except InputError as fault:
            self.finish(point, str(fault))
            return
        words = tempfile.TemporaryFile()  # noqa: SIM115  (closed by `look`)
        process = subprocess.Popen(
            [*python_child("workflow.cli.main"), "resume", str(directory.path.resolve()),
             *self.options],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=words, start_new_session=True, preexec_fn=with_parent(),
        )  # fmt: skip
        self.running.append(Job(point, directory, process, words, now.seconds))

    def look(self) -> None:
        """Wait a moment, note what has ended, show where the study stands."""
        time.sleep(POLL)
        for job in [job for job in self.running if job.process.poll() is not None]:
            self.running.remove(job)
            with job.words:
                job.words.seek(0)
                lines = job.words.read().decode(errors="replace").strip().splitlines()
            self.passed += time.monotonic() - job.begun
            self.ran += self.study.standing(job.point).seconds - job.before
            self.finish(job.point, self.account(job, lines[-1] if lines else "it left no message"))
        self.show()

    def account(self, job: Job, words: str) -> str | None:
        """Why an ended job failed, None if it did not; a failure that the job could not record itself is recorded."""
        now, status = self.study.standing(job.point), job.process.returncode
        if now.status in (DONE, FAILED):
            return now.reason
        if self.outcome.interrupted or now.status == RUNNING:  # stopped by us, or in the hands of another wf
            return None
        reason = f"wf was killed by signal {-status}" if status < 0 else words.removeprefix("wf: ")
        job.directory.record(status=rundir.FAILED, reason=reason)
        return reason

    def finish(self, point: Point, reason: str | None) -> None:
        """Note and say what became of a point."""
        self.claims.give(point)
        now = self.standings[point.digest] = self.study.standing(point)
        self.outcome.done += now.status == DONE
        self.outcome.failed += now.status == FAILED
        seconds = f" ({now.seconds:.0f} s)" if now.seconds else ""
        self.say(f"{now.status} {self.study.label(point)}{seconds}{f': {reason}' if reason else ''}; {self.summary()}")

    def summary(self) -> str:
        """How far the study is, and the time left."""
        left = remaining(self.study.points, [self.current(point) for point in self.study.points])
        parts = [f"{self.outcome.done} of {len(self.study.points)} done"]
        parts += [f"{self.outcome.failed} failed"] if self.outcome.failed else []
        parts += [f"{self.outcome.elsewhere} elsewhere"] if self.outcome.elsewhere else []
        if left:
            hands = max(min(self.jobs, len(self.waiting) + len(self.running)), 1) * (self.ranks or 1)
            parts.append(f"left ~{duration(left / hands * (max(self.passed / self.ran, 1.0) if self.ran > 0.0 else 1.0))}")
        return ", ".join(parts)

    def current(self, point: Point) -> PointStatus:
        """The standing, read anew for points at work."""
        return self.study.standing(point) if any(job.point is point for job in self.running) else self.standings[point.digest]

    def show(self) -> None:
        """The line of a terminal, rewritten now and then."""
        if not self.out.isatty() or time.monotonic() - self.shown < LINE_INTERVAL:
            return
        self.shown = time.monotonic()
        line = f"{len(self.running)} running, {self.summary()}"[: shutil.get_terminal_size().columns - 1]
        self.out.write("\r" + line.ljust(len(self.line)))
        self.out.flush()
        self.line = line

    def say(self, text: str) -> None:
        """A line that stays."""
        if self.line:
            self.out.write("\r" + " " * len(self.line) + "\r")
            self.line = ""
        self.out.write(text + "\n")
        self.out.flush()

    def stop(self) -> None:
        """Ask the jobs to write their checkpoints and wait for them; a second interrupt ends them."""
        self.say(f"stopping {len(self.running)} runs at their next checkpoint")
        for job in self.running:
            _signal(job)
        try:
            while self.running:
                self.look()
        except KeyboardInterrupt:
            return  # `end` does the rest

    def end(self) -> None:
        """Leave no job behind."""
        for job in self.running:
            _signal(job)
            job.process.wait()
            job.words.close()
        if self.line:
            self.out.write("\n")


def _signal(job: Job) -> None:
    """Ask a job to stop, the second time at once.  To it alone: its engine follows it.  Not SIGINT, which a job of a study
    in the background ignores."""
    with suppress(ProcessLookupError):
        os.kill(job.process.pid, signal.SIGTERM)
