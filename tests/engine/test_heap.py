"""The deck of a heap in the engine: feed, removal, rest, energy, resume."""

from __future__ import annotations

import filecmp
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workflow.archive.dumps import read_frames, read_tracks
from workflow.data.frame import Frame
from workflow.data.series import read_series
from workflow.deck.template import DATA, data_file, fill, render, templates, whole
from workflow.measures.heap import Ground, base_forces, in_heap
from workflow.runs.installation import engine
from workflow.scene.heap import FLOOR, Heap

SMALL = {"grains": 30, "drop_height": 15.0, "frame_interval": 0.0, "hold": 0.5}


def prepare(folder: Path, scene: Heap, **changed: Any) -> Path:
    folder.mkdir()
    template = whole(templates() / "heap.in")
    (folder / "deck.in").write_text(fill(template, {**scene.variables(), "data": DATA, **changed}))
    (folder / DATA).write_text(data_file(scene.discs()))
    for name, text in scene.files().items():
        (folder / name).write_text(text)
    return folder


def run(folder: Path, *words: str) -> Path:
    command = [sys.executable, "-m", "workflow.runs.lammps_process", "deck.in", *words]
    done = subprocess.run(
        command, cwd=folder, env=engine().variables(), capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder


def last(folder: Path) -> Frame:
    return list(read_frames(folder / "grains.dump", folder / "contacts.dump"))[-1]


@pytest.fixture(scope="module")
def poured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Heap, Path]:
    scene = Heap(**SMALL)
    return scene, run(prepare(tmp_path_factory.mktemp("heap") / "run", scene))


def test_base_carries_the_weight(poured: tuple[Heap, Path]) -> None:
    scene, folder = poured
    frame, ground = last(folder), Ground(len(scene.base_discs()), scene.middle, FLOOR)
    own = in_heap(frame, ground)
    assert own.sum() == 30 and not any(frame.periodic)
    # at rest to a net force of 1e-4 m g per grain
    assert base_forces(frame, ground)[1].sum() == pytest.approx(frame.mass[own].sum(), abs=30 * 1e-4)
    assert "RESULT stage 1" in (folder / "log.lammps").read_text()
    assert "equilibrated 1 stopped 0 poured 30 removed 0" in (folder / "log.lammps").read_text()


def test_energy_account_closes_to_second_order_in_the_step(poured: tuple[Heap, Path], tmp_path: Path) -> None:
    scene, folder = poured

    def residual(where: Path) -> float:
        series = read_series(where / "series.txt")
        return abs(float(series["residual"][-1] / series["energy_in"][-1]))

    fine = run(prepare(tmp_path / "fine", Heap(**SMALL, steps_per_period=4 * scene.steps_per_period)))
    paper = run(prepare(tmp_path / "paper", Heap(**SMALL, scheme="paper")))
    # what the kicks take from the grains is known whichever velocity the dampers see; counted otherwise it was 1 to 6 % of
    # the energy that went in with the paper's scheme
    assert residual(folder) < 0.005 and residual(paper) < 0.005
    # four times the steps: 1/16, but for the first step of each contact (order 1/2 at worst)
    assert residual(fine) < 0.5 * residual(folder)


@pytest.mark.parametrize("scheme", ["second", "paper"])
def test_run_style_changes_no_bit(tmp_path: Path, scheme: str) -> None:
    """Steps on the kernel's arrays alone and LAMMPS's own, with weights, fixed discs, a feed and grains that leave."""
    scene = Heap(grains=25, drop_height=10.0, base_half_width=3.0, frame_interval=0.0, scheme=scheme)
    ours, lammps = (prepare(tmp_path / name, scene) for name in ("ours", "lammps"))
    deck = (lammps / "deck.in").read_text()
    (lammps / "deck.in").write_text(deck.replace("run_style verlet/disc", "run_style verlet"))
    run(ours), run(lammps)
    assert read_series(ours / "series.txt")["removed"][-1] >= 3
    for name in ("series.txt", "grains.dump", "contacts.dump", "tracks.dump"):
        assert filecmp.cmp(ours / name, lammps / name, shallow=False)


def test_closed_form_of_the_fall_changes_nothing(tmp_path: Path) -> None:
    """A grain that is an atom from the start of its fall meets the heap as one that becomes an atom just above it."""
    scene = Heap(grains=4, drop_height=15.0, base_half_width=6.0, feed_half_width=2.0, max_time=13.0, seed=3)
    short, whole = (run(prepare(tmp_path / name, scene, ahead=ahead)) for name, ahead in (("short", 2.0), ("whole", 100.0)))
    one, two = last(short), last(whole)
    # rounding of the fall by steps, amplified by the first collisions
    np.testing.assert_allclose(one.position, two.position, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(one.velocity, two.velocity, rtol=0.0, atol=1e-8)
    assert np.count_nonzero(one.interactions.elastic) > 3
    tracks = [read_tracks(folder / "tracks.dump") for folder in (short, whole)]
    assert np.isnan(tracks[0].position).sum() > np.isnan(tracks[1].position).sum()


@pytest.mark.parametrize("law", [{"index": 144, "cutoff": 1.047}, {"index": 300, "cutoff": 1.02}, {"hooke": 500.0}])
def test_step_holds_for_stiff_laws_and_full_impact(tmp_path: Path, law: dict[str, float]) -> None:
    """Falls from 100 sigma on a short base: what goes in is what is there, was lost or left."""
    scene = Heap(**law, grains=4, base_half_width=6.0, feed_half_width=2.0, max_time=25.0, frame_interval=0.0)
    series = read_series(run(prepare(tmp_path / "stiff", scene)) / "series.txt")
    assert series["poured"][-1] == 4
    # every impact is the hardest one: (2 pi/14)^2/24 of its energy
    assert np.abs(series["residual"]).max() < 0.0084 * series["energy_in"][-1]
    assert 1.0 - series["overlap"].max() > 0.9 * scene.closest


def test_mirrored_feed_makes_the_mirrored_heap(tmp_path: Path) -> None:
    scene = Heap(grains=5, drop_height=15.0, base_half_width=6.0, feed_half_width=2.0, max_time=14.0, seed=5)
    plain, mirrored = (prepare(tmp_path / name, scene) for name in ("plain", "mirrored"))
    rows = [line.split() for line in (plain / "feed.txt").read_text().splitlines()]
    text = "".join(f"{tag} {time} {2.0 * scene.middle - float(x)!r} {size}\n" for tag, time, x, size in rows)
    (mirrored / "feed.txt").write_text(text)
    one, two = last(run(plain)), last(run(mirrored))
    fed = one.ids > len(scene.base_discs())
    # rounding of mirrored places, amplified by the first collisions
    assert fed.sum() == 5
    np.testing.assert_allclose(one.position[fed, 0] + two.position[fed, 0], 2.0 * scene.middle, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(one.position[fed, 1], two.position[fed, 1], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(one.omega[fed], -two.omega[fed], rtol=0.0, atol=1e-7)
    assert np.abs(one.omega[fed]).max() > 0.1


def test_grains_that_leave_the_base_are_counted(tmp_path: Path) -> None:
    scene = Heap(grains=25, drop_height=10.0, base_half_width=3.0, frame_interval=0.0)
    folder = run(prepare(tmp_path / "narrow", scene))
    frame, series = last(folder), read_series(folder / "series.txt")
    gone = int(series["removed"][-1])
    assert gone >= 3
    assert frame.grains == len(scene.base_discs()) + 25 - gone
    assert abs(series["residual"][-1]) < 0.005 * series["energy_in"][-1]


def test_one_grain_leaves_as_the_next_becomes_an_atom(tmp_path: Path) -> None:
    """At the same look of the feed, left and right of the base: the engine's number of atoms stays right, or it writes no
    checkpoint."""
    scene = Heap(grains=2, drop_height=10.0, base_half_width=3.0, feed_half_width=2.0, frame_interval=0.0, max_time=12.0)
    values = scene.variables()
    look, height = values["feed_every"] * values["step"], FLOOR + scene.drop_height
    leaves = math.ceil(math.sqrt(2.0 * (height - 1.0)) / look) * look  # 1 above the lower face
    second = leaves - 0.5 * look - math.sqrt(2.0 * (height - 1.0 - values["ahead"]))
    folder = prepare(tmp_path / "both", scene, checkpoint_every=values["feed_every"])
    base, off = len(scene.base_discs()), scene.half_width + 5.0
    falls = [(base + 1, 0.0, scene.middle - off), (base + 2, second, scene.middle + off)]
    (folder / "feed.txt").write_text("".join(f"{tag} {time!r} {x!r} 1\n" for tag, time, x in falls))
    series = read_series(run(folder) / "series.txt")
    assert series["poured"][-1] == series["removed"][-1] == 2
    assert last(folder).grains == base


def test_no_heap_on_a_flat_floor(tmp_path: Path) -> None:
    scene = Heap(grains=20, drop_height=10.0, base="flat", base_half_width=8.0, max_time=150.0, frame_interval=0.0)
    series = read_series(run(prepare(tmp_path / "flat", scene)) / "series.txt")
    assert series["removed"][-1] >= 15 and series["top"][-1] < FLOOR + 2.5


def test_a_resumed_heap_ends_like_the_run(poured: tuple[Heap, Path], tmp_path: Path) -> None:
    """Stopped by hand, which is no part of its course; a kill changes no bit (tests/cli/test_exact_resume.py)."""
    scene, _ = poured
    folder = prepare(tmp_path / "cut", scene, checkpoint_every=scene.variables()["check_every"] * 40)
    (folder / "stop").touch()  # seen at the first check: poured a few, or none
    run(folder)
    (folder / "stop").unlink()
    series = run(folder, "resume", "yes", "restart", "checkpoint.1.end")
    assert "poured 30 removed" in (series / "log.lammps").read_text()
    assert in_heap(last(folder), Ground(len(scene.base_discs()), scene.middle, FLOOR)).sum() == 30


def test_two_ranks_pour_a_heap(tmp_path: Path) -> None:
    scene = Heap(grains=6, drop_height=8.0, base_half_width=5.0, frame_interval=0.0, hold=0.2)
    folder = prepare(tmp_path / "two", scene)
    found = engine()
    command = [str(found.mpiexec), "-n", "2", sys.executable, "-m", "workflow.runs.lammps_process", "deck.in"]
    done = subprocess.run(command, cwd=folder, env=found.variables(), capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    frame, ground = last(folder), Ground(len(scene.base_discs()), scene.middle, FLOOR)
    removed = read_series(folder / "series.txt")["removed"][-1]
    assert in_heap(frame, ground).sum() == 6 - removed
    assert base_forces(frame, ground)[1].sum() == pytest.approx(6.0 - removed, abs=6 * 1e-4)


@pytest.mark.parametrize(
    ("feed", "message"),
    [("32 5.0 30 1\n33 1.0 30 1\n", "times must increase"), ("32 0 30 1.5\n", "above the largest"), ("32 0 x\n", "line 1")],
)
def test_wrong_feeds_are_named(tmp_path: Path, feed: str, message: str) -> None:
    folder = prepare(tmp_path / "wrong", Heap(**SMALL))
    (folder / "feed.txt").write_text(feed)
    command = [sys.executable, "-m", "workflow.runs.lammps_process", "deck.in"]
    done = subprocess.run(
        command, cwd=folder, env=engine().variables(), capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 1 and message in done.stderr


def test_rendered_deck_declares_every_variable() -> None:
    assert "variable feed             index feed.txt" in render(Heap(**SMALL))
