"""What a machine does to a run besides filling its disk: files that cannot be written, clocks that jump, a crash."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from wf_process import SLOW, Running, Wf, kill, record

from workflow.archive.dumps import read_frames
from workflow.archive.read import Archive
from workflow.cli.main import main
from workflow.runs.directory import RunDirectory

RESULTS = ("series.txt", "grains.dump", "contacts.dump")
# Takes the place of the C library's clock of the day: every look at it is a day before or after the last one.  Not in the
# engine's own process: MPI (UCX) does not always start under such a clock, and LAMMPS goes by the monotonic one.
JUMPING = r"""
#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static bool is_engine()
{
  char words[4096] = {};
  FILE *const file = fopen("/proc/self/cmdline", "r");
  const size_t length = file ? fread(words, 1, sizeof(words), file) : 0;
  if (file) fclose(file);
  return memmem(words, length, "lammps_process", 14) != nullptr;
}
static long jump()
{
  static long looks = 0;
  static const bool steady = is_engine();
  return steady ? 0 : ++looks % 2 ? 86400 : -86400 * looks;
}
extern "C" int clock_gettime(clockid_t id, struct timespec *t)
{
  const int status = syscall(SYS_clock_gettime, id, t);
  if (id == CLOCK_REALTIME) t->tv_sec += jump();
  return status;
}
extern "C" time_t time(time_t *out)
{
  struct timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  if (out) *out = t.tv_sec;
  return t.tv_sec;
}
extern "C" int gettimeofday(struct timeval *out, void *)
{
  struct timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  out->tv_sec = t.tv_sec, out->tv_usec = t.tv_nsec / 1000;
  return 0;
}
"""


@pytest.fixture(scope="module")
def jumping(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A library that makes the clock jump, for LD_PRELOAD."""
    folder = tmp_path_factory.mktemp("clock")
    (folder / "jump.cpp").write_text(JUMPING)
    compiler = shutil.which("c++")
    assert compiler, "no C++ compiler: the plugin could not have been built either"
    subprocess.run([compiler, "-shared", "-fPIC", "-o", "jump.so", "jump.cpp"], cwd=folder, check=True)
    return str(folder / "jump.so")


def test_a_clock_that_jumps_changes_nothing(jumping: str, packing: Path, wf: Wf, tmp_path: Path) -> None:
    """Same bytes of results, a run time that is one, and a status that can be read."""
    done = wf("run", str(packing / "scene.toml"), "--out", "run", LD_PRELOAD=jumping)
    assert done.returncode == 0, done.stderr
    for name in RESULTS:
        assert (tmp_path / "run" / name).read_bytes() == (packing / name).read_bytes()
    state = record(tmp_path / "run")
    assert state["started"][:10] != state["finished"][:10], "the clock did not jump"
    assert 0.0 < state["seconds"] < 100.0
    assert "finished" in wf("status", "run", LD_PRELOAD=jumping).stdout


@pytest.mark.parametrize("days", [-2, 2])
def test_the_archive_follows_the_dumps_whatever_their_times(days: int, copy: Path) -> None:
    """A part that was run after the clock was set back is not overlooked; one from the future is not read twice.

    Dumps that hold less than the archive never replace it.
    """
    archive, then = copy / "run.h5", (copy / "run.h5").stat().st_mtime + 86400 * days
    before = archive.stat().st_mtime_ns
    whole = {name: (copy / name).read_bytes() for name in RESULTS}

    def frames(contents: dict[str, bytes]) -> int:
        for name, content in contents.items():
            (copy / name).write_bytes(content)
            os.utime(copy / name, (then, then))
        assert main(["measure", str(copy)]) == 0
        with Archive(archive) as found:
            assert len(found) == len(list(read_frames(copy / "grains.dump", copy / "contacts.dump")))
            return len(found)

    count = frames(whole)
    assert archive.stat().st_mtime_ns == before, "made again for nothing"
    shorter = {name: whole[name][: whole[name].rindex(b"ITEM: TIME\n")] for name in RESULTS[1:]}
    for name, content in shorter.items():
        (copy / name).write_bytes(content)
    assert main(["measure", str(copy)]) == 0
    with Archive(archive) as found:
        assert len(found) == count
    log = copy / "log.lammps"
    text = log.read_text()
    archive.unlink()
    RunDirectory(copy).record(status="prepared")  # a deck that was run by hand, in two parts with a look between them
    log.unlink()
    assert frames(shorter) == count - 1
    log.write_text(text)
    assert frames(whole) == count


def test_a_read_only_run_can_be_looked_at(
    packing: Path, small_disk: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    disk = small_disk("size=50m")
    shutil.copytree(packing, disk / "run")
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    monkeypatch.chdir(tmp_path)
    places = {
        "measure": [],
        "status": [],
        "plot": ["--out", "here"],
        "export": ["--out", "here"],
        "report": ["--out", "a.html"],
    }
    for command, place in places.items():
        assert main([command, "disk/run", *place]) == 0
    capsys.readouterr()
    for command in ("plot", "report", "export", "resume"):
        assert main([command, "disk/run"]) in (1, 2)
        message = capsys.readouterr().err
        assert "disk/run" in message and len(message.splitlines()) == 1, message


def test_a_crashed_run_is_read_up_to_its_last_frame(running: Callable[..., Running], wf: Wf) -> None:
    """Everything at once killed while frames are written: no grain of a whole frame is lost, nothing half is read."""
    run = running(*SLOW, "--frame-interval", "0.05")
    run.wait_for_rows(15)
    for pid in [*run.engine(), run.process.pid]:
        kill(pid)
    run.process.wait(timeout=10)
    assert wf("measure", "slow").returncode == 0
    frames = list(read_frames(run.directory / "grains.dump", run.directory / "contacts.dump"))
    assert len(frames) > 10
    with Archive(run.directory / "run.h5") as archive:
        assert [frame.step for frame in archive.frames] == [frame.step for frame in frames]
        assert archive.frame(-1).position.tobytes() == frames[-1].position.tobytes()
    assert json.loads(wf("status", "slow", "--json").stdout)[0]["status"] == "interrupted"
