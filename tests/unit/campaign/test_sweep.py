"""Declarations of studies, what a study knows of its points, and adopting: nothing is computed here."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from workflow.campaign.study import (
    DONE,
    FAILED,
    INTERRUPTED,
    RUNNING,
    WAITING,
    Point,
    PointLocks,
    PointStatus,
    Study,
    alive,
    remaining,
)
from workflow.campaign.sweep import points_of, read_sweep
from workflow.deck.template import render
from workflow.errors import ArchiveError, InputError
from workflow.scene.registry import SCENES, scene_from

SMALL = {"scene": "method1", "fixed": {"n": 60, "cohesion": False}}


def test_every_combination_is_a_point_once() -> None:
    points = points_of({**SMALL, "grid": {"mu": [0.1, 0.2, 0.3], "rolling": [True, False]}, "seeds": 4})
    expected = {
        scene_from({"scene": "method1", "n": 60, "cohesion": False, "mu": mu, "rolling": rolling, "seed": seed}).digest
        for mu, rolling, seed in itertools.product((0.1, 0.2, 0.3), (True, False), (1, 2, 3, 4))
    }
    assert len(points) == 24
    assert {point.digest for point in points} == expected


def test_several_grids_are_joined() -> None:
    """One parameter at a time around a reference, which two grids share."""
    points = points_of({**SMALL, "grid": [{"mu": [0.5, 0.3]}, {"zeta": [0.8, 0.2], "seed": [1, 2]}]})
    found = [(point.scene.mu, point.scene.zeta, point.scene.seed) for point in points]  # type: ignore[union-attr]
    assert found == [(0.5, 0.8, 1), (0.3, 0.8, 1), (0.5, 0.8, 1), (0.5, 0.8, 2), (0.5, 0.2, 1), (0.5, 0.2, 2)]
    assert points[0].digest == points[2].digest


def test_same_scene_twice_is_one_point(tmp_path: Path) -> None:
    """2 and 2.0, an explicit default, a repeated value: all the same run."""
    points = points_of({**SMALL, "grid": {"mu": [0.5, 0.5], "kappa": [100000, 1e5]}, "seeds": [1, 1]})
    assert len(Study(tmp_path, points).points) == 1
    assert points[0].digest == points_of(SMALL)[0].digest


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        ({**SMALL, "gird": {}}, "unknown key 'gird'; did you mean grid?"),
        ({**SMALL, "mu": 0.5}, "parameters go into fixed or grid"),
        ({**SMALL, "fixed": {"nu": 0.5}}, "unknown parameter 'nu'"),
        ({**SMALL, "grid": {"mu": 0.5}}, "grid.mu = 0.5 is not allowed: it must be a list"),
        ({**SMALL, "grid": {"mu": []}}, "must be a list of values"),
        ({**SMALL, "grid": {"mu": [0.5, "rough"]}}, "mu = 'rough' is not allowed"),
        ({**SMALL, "grid": {"n": [60, 70]}}, "'n' stands in fixed and in grid"),
        ({**SMALL, "grid": []}, "the grid has 0 points"),
        ({**SMALL, "grid": [{"mu": [0.1]}, 3]}, "grid = 3 is not allowed: it must be a table"),
        ({**SMALL, "seeds": 0}, "seeds = 0 is not allowed"),
        ({**SMALL, "seeds": True}, "seeds = True is not allowed"),
        ({**SMALL, "seeds": 2, "grid": {"seed": [1]}}, "'seed' stands beside seeds"),
        ({**SMALL, "fixed": {"scene": "heap"}}, "'scene' stands in fixed"),
        ({**SMALL, "fixed": 3}, "fixed = 3 is not allowed: it must be a table"),
        ({**SMALL, "grid": {"mu": [0.1] * 2000, "zeta": [0.5] * 2000}}, "the grid has 4000000 points"),
        ({"fixed": {}}, 'needs the key scene = "NAME"'),
        ({"scene": "method3"}, "unknown scene 'method3'"),
    ],
    ids=lambda value: value.replace(" ", "_")[:30] if isinstance(value, str) else "",
)
def test_what_is_wrong_is_said_with_what_is_allowed(declared: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(tomli_w.dumps(declared))
    with pytest.raises(InputError) as caught:
        read_sweep(path)
    assert words in str(caught.value)
    assert "study file" in str(caught.value)


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.toml' cannot be read"):
        read_sweep(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_bytes(b"scene = \xff\n")
    with pytest.raises(InputError, match="is not TOML"):
        read_sweep(tmp_path / "bad.toml")


names = st.sampled_from(["scene", "fixed", "grid", "seeds", "seed", "n", "mu", "kappa", "series", "x"])
leaves = st.one_of(st.integers(-2, 200), st.floats(allow_nan=False), st.booleans(), st.sampled_from([*SCENES, "A", ""]))
values = st.recursive(leaves, lambda part: st.lists(part, max_size=3) | st.dictionaries(names, part, max_size=3), max_leaves=8)


@given(st.dictionaries(names, values, max_size=4))
@examples(60)
def test_any_toml_is_a_study_or_a_sentence(declared: dict[str, Any]) -> None:
    try:
        points = points_of(declared)
    except InputError as fault:
        assert str(fault)
    else:
        assert points
        assert [point.scene.digest for point in points] == [point.digest for point in points]


def write_run(path: Path, digest: str, status: str, **more: Any) -> None:
    """A run directory as far as a study looks at it."""
    path.mkdir(parents=True)
    record = {"status": status, "scene": "method1", "digest": digest, "versions": {}, **more}
    (path / "run.json").write_text(json.dumps(record))
    (path / "run.h5").touch()


@pytest.fixture
def study(tmp_path: Path) -> Study:
    made = Study(tmp_path / "study", points_of({**SMALL, "seeds": 6}))
    made.save()
    return made


def test_a_point_stands_as_its_run_does(study: Study) -> None:
    point = study.points
    mine = {"pid": os.getpid(), "started": "2020-01-01T00:00:00Z"}
    write_run(study.directory(point[1]).path, point[1].digest, "finished", seconds=10.0)
    write_run(study.directory(point[2]).path, point[2].digest, "failed", reason="ERROR: lost atoms")
    write_run(study.directory(point[3]).path, point[3].digest, "running", **mine)
    dead = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, dead.pid, os.WEXITED | os.WNOWAIT)  # it has ended, but its entry stays
    assert not alive(dead.pid)
    dead.wait()
    assert not alive(dead.pid)
    write_run(study.directory(point[4]).path, point[4].digest, "running", **{**mine, "pid": dead.pid})
    study.directory(point[5]).path.mkdir()
    (study.directory(point[5]) / "run.json").write_text("{")
    found = [study.standing(one) for one in Study.open(study.folder).points]
    assert [one.status for one in found] == [WAITING, DONE, FAILED, RUNNING, INTERRUPTED, FAILED]
    assert found[1].seconds == 10.0
    assert found[2].reason == "ERROR: lost atoms"
    assert found[3].seconds > 1e6
    assert "cannot be read" in (found[5].reason or "")


def test_remaining_core_seconds_follow_those_done() -> None:
    """Per grain and scene: 1400 grains of method1 took 14 s, so 700 take 7; heaps cost what all cost on the mean."""

    def point(scene: str, grains: int) -> Point:
        return Point({"scene": scene}, f"{scene}{grains}", grains)

    points = [point("method1", 1400), point("method1", 700), point("method2", 100), point("method2", 1000), point("heap", 500)]
    standings = [
        PointStatus(DONE, None, 14.0), PointStatus(WAITING), PointStatus(DONE, None, 16.0), PointStatus(INTERRUPTED, None, 60.0),
        PointStatus(WAITING),
    ]  # fmt: skip
    assert remaining(points, standings) == pytest.approx(7.0 + (160.0 - 60.0) + 500 * 30.0 / 1500.0)
    assert remaining(points, [PointStatus(WAITING)] * 5) is None
    assert remaining(points[:2], [PointStatus(DONE, None, 14.0), PointStatus(FAILED)]) == 0.0


def test_finished_runs_are_adopted_by_digest(study: Study, tmp_path: Path) -> None:
    point = study.points
    elsewhere = tmp_path / "campaign"

    def same(k: int) -> dict[str, Any]:
        return {"hashes": {"deck.in": hashlib.sha256(render(point[k].scene).encode()).hexdigest()}}

    write_run(elsewhere / "one", point[0].digest, "finished", seconds=5.0, **same(0))
    write_run(elsewhere / "deep" / "two", point[1].digest, "finished", **same(1))
    write_run(elsewhere / "old", point[5].digest, "finished", hashes={"deck.in": "of another version"})
    write_run(elsewhere / "half", point[2].digest, "interrupted")
    write_run(elsewhere / "other", "0" * 64, "finished")
    write_run(study.folder / "inside", point[3].digest, "finished", **same(3))
    write_run(study.directory(point[4]).path, point[4].digest, "failed", reason="kept")
    write_run(elsewhere / "five", point[4].digest, "finished", **same(4))
    (elsewhere / "broken").mkdir()
    (elsewhere / "broken" / "run.json").write_text("[")
    assert study.adopt([study.folder, elsewhere]) == (3, 1)
    assert [study.standing(one).status for one in point] == [DONE, DONE, WAITING, DONE, FAILED, WAITING]
    assert study.directory(point[0]).path.resolve() == (elsewhere / "one").resolve()
    assert study.standing(point[0]).seconds == 5.0
    assert study.adopt([elsewhere]) == (0, 1)
    assert study.adopt([elsewhere], any_deck=True) == (1, 0)
    assert study.standing(point[5]).status == DONE
    (elsewhere / "one" / "run.json").unlink()  # what was adopted is gone
    assert study.standing(point[0]).status == WAITING
    with pytest.raises(InputError, match="is no directory"):
        study.adopt([tmp_path / "none"])


def test_a_killed_beginning_is_made_anew(study: Study) -> None:
    point = study.points[0]
    own = study.directory(point).path
    own.mkdir()
    (own / "grains.data").write_text("half")  # killed before run.json was written
    made = study.prepare(point)
    assert made.state["status"] == "prepared"
    assert made.state["digest"] == point.digest
    assert study.standing(point).status == WAITING
    before = (own / "grains.data").stat().st_mtime_ns
    study.prepare(point)
    assert (own / "grains.data").stat().st_mtime_ns == before


def test_a_point_is_claimed_by_one_process(study: Study) -> None:
    first, second = study.points[:2]
    code = (
        "import sys; from pathlib import Path; from workflow.campaign.study import Study\n"
        "study = Study.open(Path(sys.argv[1]))\n"
        "with study.claims() as claims: print([claims.take(point) for point in study.points[:2]])"
    )
    folder = Path(__file__).parents[3]
    command = [sys.executable, "-c", code, str(study.folder)]

    def other() -> str:
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()

    with study.claims() as claims:
        assert isinstance(claims, PointLocks)
        assert claims.take(first)
        assert other() == "[False, True]"
        claims.give(first)
        assert other() == "[True, True]"
        assert claims.take(second)
    assert other() == "[True, True]"  # the end of a process gives back what it had


def test_no_study_and_a_damaged_one_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no study"):
        Study.open(tmp_path)
    (tmp_path / "points.json").write_text('[{"digest": 1}]')
    with pytest.raises(ArchiveError, match="declare the study again"):
        Study.open(tmp_path)


def test_three_thousand_points_in_a_blink(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Counts are exact; the time is asserted far above what it takes (0.1 s of one core)."""
    import time

    from workflow.cli.main import main

    points = [Point({"scene": "method1", "seed": k}, f"{k:064x}"[::-1], 1400) for k in range(3000)]
    made = Study(tmp_path, points)
    made.save()
    record = {"scene": "method1", "versions": {}, "seconds": 36.0}
    for k, point in enumerate(points[:1500]):
        path = made.directory(point).path
        path.mkdir()
        status = "finished" if k < 1400 else "failed"
        (path / "run.json").write_text(json.dumps({"status": status, "digest": point.digest, "reason": "why", **record}))
    begun = time.process_time()
    assert main(["status", str(tmp_path), "--json"]) == 0
    assert time.process_time() - begun < 3.0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["counts"] == {"waiting": 1500, "running": 0, "interrupted": 0, "done": 1400, "failed": 100}
    assert row["core_hours_spent"] == pytest.approx(15.0)
    assert row["core_hours_left"] == pytest.approx(15.0)
    assert main(["status", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "3000 points: 1500 waiting, 1400 done, 100 failed" in text
    assert "and 80 more failed" in text
