"""`wf verify`: a run done again is the same, a tampered one is not, and it says where."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import pytest
from wf_process import Wf, record

from workflow.archive.dumps import TURNING
from workflow.campaign.verify import BOUNDS, _compare
from workflow.runs.directory import RunDirectory


def test_the_whole_run_is_reproduced(copy: Path, wf: Wf) -> None:
    before = {file.name: file.read_bytes() for file in copy.iterdir()}
    done = wf("verify", "copy")
    assert done.returncode == 0, done.stderr
    assert "reproduced: the whole run, every byte" in done.stdout
    assert {file.name: file.read_bytes() for file in copy.iterdir()} == before  # it looks and does not touch


def test_first_difference_is_named(copy: Path, wf: Wf) -> None:
    lines = (copy / "series.txt").read_text().splitlines(keepends=True)
    words = lines[-3].split()
    step, column = words[0], lines[0].split().index("coordination") - 1
    words[column] = "2.5"
    lines[-3] = " ".join(words) + "\n"
    (copy / "series.txt").write_text("".join(lines))
    done = wf("verify", "copy", "--json")
    assert done.returncode == 1
    verdict = json.loads(done.stdout)
    assert not verdict["reproduced"] and not verdict["same_bits"]
    first = verdict["first"]
    assert (first["file"], first["step"], first["quantity"], first["before"]) == ("series.txt", int(step), "coordination", 2.5)
    assert first["stage"] == "settle"


def test_a_changed_position_is_found_in_the_frames(copy: Path, wf: Wf) -> None:
    lines = (copy / "grains.dump").read_text().splitlines(keepends=True)
    words = lines[-1].split()
    words[3] = "1.25"
    lines[-1] = " ".join(words) + "\n"
    (copy / "grains.dump").write_text("".join(lines))
    done = wf("verify", "copy")
    assert done.returncode == 1
    assert "NOT reproduced" in done.stdout
    assert ", x (grains.dump): 1.25 then" in done.stdout


def test_other_ranks_are_judged_by_bounds(copy: Path, wf: Wf) -> None:
    done = wf("verify", "copy", "--ranks", "2", "--json")
    verdict = json.loads(done.stdout)
    assert done.returncode == (0 if verdict["reproduced"] else 1)
    assert verdict["expected"] == "1 ranks then, 2 now"
    # sums in another order: the same motion to rounding until collisions have amplified it
    assert verdict["agree_until"] > 1.0
    assert set(verdict["changes"]) == {"solid_fraction", "coordination"}


def another_machine(copy: Path) -> None:
    """The run says that it was made on another processor."""
    state = record(copy)
    state["versions"]["processor"] = "another"
    (copy / "run.json").write_text(json.dumps(state))


def shift_the_end(copy: Path, column: str, change: float) -> None:
    """Change the last value of a column of the series."""
    lines = (copy / "series.txt").read_text().splitlines(keepends=True)
    words, at = lines[-1].split(), lines[0].split().index(column) - 1
    words[at] = repr(float(words[at]) + change)
    (copy / "series.txt").write_text("".join([*lines[:-1], " ".join(words) + "\n"]))


def test_another_machine_may_differ_within_bounds_and_not_beyond(copy: Path, wf: Wf) -> None:
    """60 grains: the bounds are those of 1400 times sqrt(1400/60)."""
    another_machine(copy)
    done = wf("verify", "copy")
    assert done.returncode == 0
    assert "every byte" in done.stdout
    for column, bound in BOUNDS.items():
        whole = (copy / "series.txt").read_bytes()
        bound *= math.sqrt(1400 / 60)
        for change, status in ((0.9 * bound, 0), (-1.1 * bound, 1)):
            shift_the_end(copy, column, change)
            done = wf("verify", "copy", "--json")
            verdict = json.loads(done.stdout)
            assert done.returncode == status
            assert verdict["reproduced"] is (status == 0) and not verdict["same_bits"]
            assert verdict["expected"].startswith("processor another then")
            assert verdict["changes"][column] == pytest.approx(abs(change))
            (copy / "series.txt").write_bytes(whole)


def test_the_same_machine_may_not_differ(copy: Path, wf: Wf) -> None:
    shift_the_end(copy, "coordination", 1e-12)
    assert wf("verify", "copy").returncode == 1


def test_a_changed_deck_and_missing_checkpoints_are_named(copy: Path, wf: Wf) -> None:
    deck = (copy / "deck.in").read_text()
    (copy / "deck.in").write_text(deck.replace("dimension 2", "dimension 2 "))
    done = wf("verify", "copy")
    assert done.returncode == 2
    line = deck.splitlines().index("dimension 2") + 1
    assert f"'copy/deck.in', line {line}: 'dimension 2 ', but scene.toml gives 'dimension 2'" in done.stderr
    (copy / "deck.in").write_text(deck)
    for file in copy.glob("checkpoint.*"):
        file.unlink()
    assert "no whole checkpoint" in wf("verify", "copy", "--last").stderr
    (copy / "run.json").write_text(json.dumps({**record(copy), "status": "interrupted"}))
    done = wf("verify", "copy")
    assert done.returncode == 2
    assert "interrupted, not finished" in done.stderr


def shuffle_contacts(copy: Path) -> None:
    """Rows of each frame of the contact dump in another order, every second one seen from its other grain."""
    out: list[str] = []
    for frame in (copy / "contacts.dump").read_text().split("ITEM: TIME\n")[1:]:
        lines = frame.splitlines(keepends=True)
        rows = lines[10:]
        for k, row in enumerate(rows[::2]):
            words = row.split()
            words[0], words[1] = words[1], words[0]
            for column in TURNING:
                words[column] = repr(-float(words[column]))
            rows[2 * k] = " ".join(words) + " \n"
        out.append("".join(["ITEM: TIME\n", *lines[:10], *reversed(rows)]))
    (copy / "contacts.dump").write_text("".join(out))


def test_the_order_of_contacts_is_compared_too(copy: Path) -> None:
    """Nothing is free in a run, on any number of ranks."""
    whole = RunDirectory(Path(shutil.copytree(copy, copy.with_name("whole"))))
    assert _compare(whole, RunDirectory(copy), 0, None).same_bits
    shuffle_contacts(copy)
    found = _compare(whole, RunDirectory(copy), 0, None)
    assert not found.same_bits and not found.reproduced
