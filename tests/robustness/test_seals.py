"""What a checkpoint seals: a run goes on from where everything is what it was, or says what is not."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from drawn import examples
from hypothesis import given
from hypothesis import strategies as st
from kills import SCENES, environment, start

from workflow.data.series import read_series
from workflow.errors import ArchiveError
from workflow.runs import execute as launch
from workflow.runs.checkpoint import CheckpointChecksums, newest
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import python_child
from workflow.runs.outputs import Parts
from workflow.runs.resume_point import start_of

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]
PARTS = ("series.txt", "grains.dump", "contacts.dump")


def beyond_first_row(content: bytes) -> int:
    return content.index(b"\n", content.index(b"\n") + 1)


CHANGES: dict[str, Callable[[bytes], bytes | None]] = {
    "gone": lambda content: None,
    "empty": lambda content: b"",
    "half": lambda content: content[: len(content) // 2],
    "one row less": lambda content: content[: (at := beyond_first_row(content))] + content[content.index(b"\n", at + 1) :],
    "another digit": lambda content: content[:-400].replace(b"7", b"8", 1) + content[-400:],
    "a zero page": lambda content: content[:600] + bytes(400) + content[1000:],
}


def checkpoints(run: Path) -> list[tuple[int, str]]:
    """Steps and names of the sealed checkpoints, the oldest first."""
    return sorted((json.loads(path.read_text())["step"], path.name[:-5]) for path in run.glob("checkpoint.*.json"))


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("change", CHANGES)
def test_a_lost_or_changed_part_is_never_gone_on_from(name: str, change: str, packing: Path, fresh: Fresh) -> None:
    """Every checkpoint that needs what is lost is left out, with a sentence; the oldest may be before the damage."""
    run = fresh(packing, {name: CHANGES[change]((packing / name).read_bytes())})
    RunDirectory(run).record(status="interrupted")
    whole = {part: (packing / part).read_bytes() for part in PARTS}
    try:
        start_ = start_of(run)
    except ArchiveError as fault:
        assert name in str(fault) and "restore" in str(fault)
        return
    start_.cut_back()
    assert start_.checkpoint is not None
    sealed = json.loads((packing / f"{start_.checkpoint.path.name}.json").read_text())["parts"]
    named = any(name in words for words in start_.words)
    assert named or start_.checkpoint.step == checkpoints(packing)[-1][0], start_.words
    for part in PARTS:
        left = (run / part).read_bytes()
        assert left == whole[part][: sealed[part][0]]


@examples(25)
@given(data=st.data())
def test_any_damage_to_a_part_is_noticed(data: st.DataObject, packing: Path, heap: Path, fresh: Fresh) -> None:
    """A bit anywhere: what is gone on from is, byte for byte, what was written, or nothing is."""
    source = data.draw(st.sampled_from([packing, heap]))
    name = data.draw(st.sampled_from([*PARTS, "stage.1.in"]))
    content = bytearray((source / name).read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    run = fresh(source, {name: bytes(content)})
    try:
        found = start_of(run)
    except ArchiveError:
        return
    assert found.checkpoint is not None
    found.cut_back()
    for part in PARTS:
        assert (source / part).read_bytes().startswith((run / part).read_bytes())
    assert read_series(run / "series.txt")["step"].max() <= found.checkpoint.step


def test_a_torn_row_is_cut(packing: Path, fresh: Fresh) -> None:
    """Also in the middle, with rows behind it that a lost course wrote."""
    _, name = checkpoints(packing)[0]
    sealed = json.loads((packing / f"{name}.json").read_text())
    whole = (packing / "series.txt").read_bytes()
    size = sealed["parts"]["series.txt"][0]
    torn = whole[:size] + b"12345 0.5 1 0.2" + whole[size : size + 900]
    run = fresh(packing, {"series.txt": torn} | {f"{other}.json": None for _, other in checkpoints(packing)[1:]})
    for _, other in checkpoints(packing)[1:]:
        (run / other).unlink()
    found = start_of(run)
    assert found.checkpoint is not None and found.checkpoint.path.name == name
    found.cut_back()
    assert (run / "series.txt").read_bytes() == whole[:size]


def test_rows_that_were_not_written_stop_the_run(packing: Path, fresh: Fresh) -> None:
    """The engine does not look whether a row of the series reached the disk."""
    lines = (packing / "series.txt").read_text().splitlines(keepends=True)
    for missing in (slice(8, 12), slice(len(lines) // 2, None)):
        left = lines.copy()
        del left[missing]
        run = fresh(packing, {"series.txt": "".join(left).encode()})
        for path in run.glob("checkpoint.*.json"):
            path.unlink()
        with pytest.raises(ArchiveError, match=r"rows are missing behind step \d+"):
            CheckpointChecksums(run).look()
        with pytest.raises(ArchiveError, match=r"rows are missing behind step \d+"):
            Parts(run).finished(int(RunDirectory(packing).state["result"]["step"]))


def test_seals_of_version_0_2_0_are_taken_with_a_sentence(packing: Path, fresh: Fresh) -> None:
    run = fresh(packing, {})
    for path in run.glob("checkpoint.*.json"):
        seal = json.loads(path.read_text())
        del seal["parts"]
        path.write_text(json.dumps(seal))
    found = start_of(run)
    assert found.checkpoint == newest(run)
    assert "only their form is checked" in "\n".join(found.words)
    series = (run / "series.txt").read_text().splitlines(keepends=True)
    (run / "series.txt").write_text("".join(series[: 4 * len(series) // 5]))  # past the oldest checkpoint that is kept
    last = start_of(run).checkpoint
    assert last is not None and last.step < found.checkpoint.step  # type: ignore[union-attr]


def test_a_damaged_checkpoint_is_not_sealed_anew(packing: Path, fresh: Fresh) -> None:
    """`wf resume` does not give its blessing to what it found damaged."""
    found = newest(packing)
    assert found is not None
    content = bytearray(found.path.read_bytes())
    content[len(content) // 2] ^= 1
    run = fresh(packing, {found.path.name: bytes(content)})
    before = (run / f"{found.path.name}.json").read_bytes()
    CheckpointChecksums(run).look()
    assert (run / f"{found.path.name}.json").read_bytes() == before


def test_resume_of_a_run_whose_parts_are_lost_writes_nothing(
    packing: Path, fresh: Fresh, wf: Wf, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = fresh(packing, {"series.txt": None})
    RunDirectory(run).record(status="interrupted")
    monkeypatch.setattr("workflow.runs.launch.Child", None)
    before = {path.name: path.read_bytes() for path in run.iterdir() if path.name != ".lock"}
    status, _, err = wf("resume", run)
    assert status == 1 and "series.txt" in err and "restore the file" in err
    assert {path.name: path.read_bytes() for path in run.iterdir() if path.name != ".lock"} == before


def test_what_the_deck_noted_is_a_variable_and_no_command(packing: Path, fresh: Fresh) -> None:
    """The deck includes stage.1.in when it resumes."""
    run = fresh(packing, {"stage.1.in": b"variable last equal 100\nshell touch pwned\n"})
    for path in run.glob("checkpoint.*.json"):
        path.unlink()  # without seals only the form is known
    RunDirectory(run).record(status="interrupted")
    with pytest.raises(ArchiveError, match="expected 'variable NAME equal VALUE'"):
        launch._start(RunDirectory(run), True, io.StringIO())


@pytest.fixture
def tiny(tmp_path: Path) -> Iterator[Callable[[Path], Callable[[], None]]]:
    """Lets a file of a run directory be on a disk of its own, of some kilobytes; what it returns ends that."""
    disk, bound = tmp_path / "tiny", list[Path]()
    disk.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=12k", "tmpfs", disk], capture_output=True, check=False)
    if done.returncode:
        pytest.skip("cannot mount a tmpfs here")

    def bind(path: Path) -> Callable[[], None]:
        (disk / path.name).touch()
        path.touch()
        subprocess.run(["mount", "--bind", disk / path.name, path], check=True)
        bound.append(path)

        def free() -> None:
            content = path.read_bytes()
            subprocess.run(["umount", path], check=True)
            bound.remove(path)
            path.write_bytes(content)

        return free

    yield bind
    for path in [*bound, disk]:
        subprocess.run(["umount", path], check=True)


def test_a_quota_on_the_series_stops_the_run_and_it_goes_on_later(
    tiny: Callable[[Path], Callable[[], None]], tmp_path: Path
) -> None:
    """Only the series has no room: the engine itself notices nothing and would come to its end."""
    words = SCENES["method1"]
    assert start(tmp_path, "run", *words, "--out", "whole").wait(timeout=100) == 0
    assert start(tmp_path, "deck", *words, "--out", "run").wait(timeout=100) == 0
    free = tiny(tmp_path / "run" / "series.txt")
    assert start(tmp_path, "resume", "run").wait(timeout=100) == 1
    assert "series.txt: rows are missing behind step" in (tmp_path / "said").read_text()
    assert RunDirectory(tmp_path / "run").state["status"] == "failed"
    free()
    assert start(tmp_path, "resume", "run", "--anew").wait(timeout=100) == 0, (tmp_path / "said").read_text()
    for name in PARTS:
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.parametrize("limit", ["largest file", "inodes"])
def test_limits_of_the_system_leave_a_run_that_goes_on(limit: str, tmp_path: Path) -> None:
    """EFBIG, and a full table of inodes."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "nr_inodes=22", "tmpfs", disk], capture_output=True, check=False
    ).returncode:
        pytest.skip("cannot mount a tmpfs here")
    try:
        command = shutil.which("prlimit")
        assert command
        few = [command, "--fsize=40000"] if limit == "largest file" else []
        words = [*few, *python_child("workflow.cli.main"), "run", *SCENES["method1"], "--out", "disk/run"]
        if limit == "inodes":
            for k in range(3):
                (disk / f"filler{k}").touch()
        done = subprocess.run(words, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=100, check=False)
        assert done.returncode == 1, done.stderr
        assert "Traceback" not in done.stderr and done.stderr.splitlines()[-1].startswith("wf: "), done.stderr
        state = RunDirectory(disk / "run").state
        assert state["status"] in ("failed", "running"), state
        for k in range(3):
            (disk / f"filler{k}").unlink(missing_ok=True)
        subprocess.run(["mount", "-o", "remount,nr_inodes=1000", disk], check=True)
        words = [*python_child("workflow.cli.main"), "resume", "disk/run"]
        done = subprocess.run(words, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=100, check=False)
        assert done.returncode == 0, done.stderr
        assert not [name for name in os.listdir(disk / "run") if name.endswith(".part")]
    finally:
        subprocess.run(["umount", disk], check=True)
