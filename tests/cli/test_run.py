"""`wf run`, `measure`, `plot`, `status` and `deck` on runs that go to their end."""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wf_process import QUICK, Wf, record, steps

from workflow.archive.read import Archive
from workflow.runs.checkpoint import confirmed, damaged, newest, step_of
from workflow.runs.directory import RunDirectory
from workflow.runs.installation import engine
from workflow.runs.outputs import Parts

RESULTS = ("series.txt", "grains.dump", "contacts.dump")
STABLE_KEYS = {
    "solid_fraction", "coordination", "coordination_backbone", "rattler_fraction", "neighbour_shares", "stress", "rumpf_ratio",
    "unbalanced_force", "kinetic_energy", "energy_residual", "equilibrated", "grains", "interactions",
}  # fmt: skip


def thermo(directory: Path) -> list[str]:
    """Lines of numbers of the log."""
    lines = (directory / "log.lammps").read_text().splitlines()
    return [line for line in lines if len(line.split()) == 11 and line.split()[0].isdigit()]


def written(directory: Path) -> dict[str, Any]:
    """measures.json, whose last entry is its checksum."""
    measures = dict(json.loads((directory / "measures.json").read_text()))
    assert len(measures.pop("checksum")) == 64
    return measures


def test_run_directory_says_everything(packing: Path) -> None:
    names = {path.name for path in packing.iterdir()}
    assert {
        "scene.toml",
        "deck.in",
        "grains.data",
        "run.json",
        "log.lammps",
        "run.h5",
        "measures.json",
        *RESULTS,
    } <= names
    assert not [name for name in names if name.endswith(".part")]
    state = record(packing)
    assert state["status"] == "finished"
    assert {"lammps", "mpich", "numpy", "python", "workflow"} <= set(state["versions"])
    with Archive(packing / "run.h5") as archive:
        assert archive.provenance["digest"] == state["digest"]
        assert archive.provenance["hashes"] == state["hashes"]


def test_measures_printed_as_json_are_those_of_the_run(packing: Path, wf: Wf) -> None:
    done = wf("measure", packing, "--json")
    numbers = json.loads(done.stdout)
    assert done.returncode == 0
    assert set(numbers) >= STABLE_KEYS
    assert numbers == written(packing)
    assert numbers["grains"] == 60
    assert numbers["equilibrated"] is True
    assert sum(numbers["neighbour_shares"]) == pytest.approx(1.0, abs=1e-12)  # shares of a whole, a sum of seven roundings
    mean = sum(k * share for k, share in enumerate(numbers["neighbour_shares"]))
    assert mean == pytest.approx(numbers["coordination"], abs=1e-12)
    assert numbers["coordination"] == pytest.approx(2 * sum(numbers["interactions"].values()) / 60, abs=1e-12)
    assert numbers["unbalanced_force"]["force"] < 1e-4  # G07 sec. II D
    assert 0.7 < numbers["solid_fraction"] < 0.88  # loose, but a jammed 2D packing


def test_first_frame_is_not_in_equilibrium(packing: Path, wf: Wf) -> None:
    """Frame 0 is the gas under no stress, far from the imposed one."""
    numbers = json.loads(wf("measure", packing, "--frame", 0, "--json").stdout)
    assert numbers["stress"]["xx"] == 0.0
    assert not numbers["equilibrated"]


def test_same_seed_same_bytes_other_seed_others(packing: Path, wf: Wf, tmp_path: Path) -> None:
    assert wf("run", *QUICK, "--out", "again").returncode == 0
    for name in ("run.h5", "measures.json", "deck.in", "grains.data", "scene.toml", *RESULTS):
        assert filecmp.cmp(tmp_path / "again" / name, packing / name, shallow=False), name
    assert wf("deck", *QUICK, "--seed", 2, "--out", "other").returncode == 0
    assert (tmp_path / "other" / "grains.data").read_bytes() != (packing / "grains.data").read_bytes()


def test_scene_file_of_a_run_repeats_it(packing: Path, wf: Wf, tmp_path: Path) -> None:
    assert wf("deck", packing / "scene.toml", "--out", "again").returncode == 0
    assert record(tmp_path / "again")["digest"] == record(packing)["digest"]
    assert filecmp.cmp(tmp_path / "again" / "deck.in", packing / "deck.in", shallow=False)


def test_plain_lmp_runs_the_same_deck(packing: Path, wf: Wf, tmp_path: Path) -> None:
    """In a directory whose name needs quoting: same thermo lines, same bytes."""
    name = 'it\'s a "tést" $x'
    assert wf("deck", *QUICK, "--out", name).returncode == 0
    found, folder = engine(), tmp_path / name
    done = subprocess.run(
        [found.lmp, "-in", "deck.in", "-screen", "none"],
        cwd=folder,
        env=found.variables(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert thermo(folder) == thermo(packing)
    assert len(thermo(folder)) > 3
    for file in RESULTS:
        assert filecmp.cmp(folder / file, packing / file, shallow=False), file
    measured = wf("measure", name, "--json")
    assert json.loads(measured.stdout) == written(packing)


def test_measure_follows_results_that_are_newer_than_the_archive(wf: Wf, copy: Path) -> None:
    """The deck was run by hand in two parts with a look at it in between."""
    full = {name: (copy / name).read_bytes() for name in (*RESULTS, "log.lammps")}
    (copy / "run.h5").unlink()
    (copy / "log.lammps").unlink()
    RunDirectory(copy).record(status="prepared")
    cut_back(copy, 1)
    assert json.loads(wf("measure", "copy", "--json").stdout)["step"] == 0
    for name, content in full.items():
        (copy / name).write_bytes(content)
    assert json.loads(wf("measure", "copy", "--json").stdout)["step"] == steps_of_archive(full["grains.dump"])


def cut_back(folder: Path, step: int) -> None:
    """Leave what a checkpoint of ``step`` goes on from."""
    parts = Parts(folder)
    parts.extents(step)
    parts.cut()


def steps_of_archive(dump: bytes) -> int:
    lines = dump.splitlines()
    return int(lines[max(k for k, line in enumerate(lines) if line == b"ITEM: TIMESTEP") + 1])


def test_two_ranks_give_the_same_physics(packing: Path, wf: Wf) -> None:
    done = wf("run", *QUICK, "--ranks", 2, "--out", "two", "--json")
    assert done.returncode == 0, done.stderr
    two, one = json.loads(done.stdout), written(packing)
    assert two["equilibrated"]
    # sums run in another order, so the samples part; six seeds of this scene scatter with a standard deviation of 0.019
    assert two["solid_fraction"] == pytest.approx(one["solid_fraction"], abs=3 * 0.019)


@pytest.mark.parametrize("words", [[], ["--dashpots", "0"], ["--step", "1e-3"]], ids=["settling", "no dashpots", "given step"])
def test_run_that_does_not_come_to_rest_ends_with_its_measures(words: list[str], wf: Wf, tmp_path: Path) -> None:
    """max_time is over: that is an outcome to report, not a fault."""
    done = wf("run", *QUICK, "--max-time", 0.5, *words, "--out", "short", "--json")
    assert done.returncode == 3, done.stderr
    assert "not in equilibrium" in done.stderr and "wf resume short --max-time T" in done.stderr
    numbers = json.loads(done.stdout)
    assert numbers["equilibrated"] is False
    assert numbers["time"] >= 0.5
    assert record(tmp_path / "short")["status"] == "finished"
    row = json.loads(wf("status", "short", "--json").stdout)[0]
    assert (row["status"], row["equilibrium"], row["remaining"]) == ("finished", False, None)
    assert "finished, not in equilibrium" in wf("status", "short").stdout


def test_every_step_has_one_row(wf: Wf, tmp_path: Path) -> None:
    """Also the step at which a stage ends and the next begins, when it falls on a row."""
    assert wf("run", *QUICK, "--series-interval", 1e-3, "--out", "run").returncode == 0
    assert record(tmp_path / "run")["result"]["stage"] == 2
    assert np.all(np.diff(steps(tmp_path / "run")) > 0)


def test_status_tells_runs_and_their_states(packing: Path, copy: Path, wf: Wf) -> None:
    done = wf("status", packing, copy, "--json")
    rows = json.loads(done.stdout)
    assert [row["status"] for row in rows] == ["finished", "finished"]
    assert rows[0]["directory"] == str(packing)
    line = wf("status", packing).stdout
    assert "finished" in line
    assert "Phi 0." in line


def test_one_damaged_run_does_not_hide_the_others(packing: Path, tmp_path: Path, wf: Wf) -> None:
    (tmp_path / "runs").mkdir()
    for name in ("a", "b", "c"):
        shutil.copytree(packing, tmp_path / "runs" / name)
    (tmp_path / "runs" / "b" / "run.json").write_text("{")
    done = wf("status")
    assert done.stdout.count("finished") == 2
    assert "b" in done.stdout + done.stderr
    assert wf("status", "runs").stdout == done.stdout


def test_plot_draws_png_and_svg(packing: Path, wf: Wf, tmp_path: Path) -> None:
    done = wf("plot", packing, "--out", "figures é")
    assert done.returncode == 0
    files = {path.name: path.read_bytes() for path in (tmp_path / "figures é").iterdir()}
    assert set(files) == {"forces.png", "forces.svg", "history.png", "history.svg"}
    for name, content in files.items():
        assert content.startswith(b"\x89PNG\r\n\x1a\n") if name.endswith("png") else b"<svg" in content, name
    assert sorted(done.stdout.split("\n")) == ["", *sorted(f"figures é/{name}" for name in files)]
    assert not [path for path in packing.iterdir() if path.suffix in (".png", ".svg")]


def test_commands_to_copy_are_quoted(wf: Wf) -> None:
    """What `wf deck` says to run can be pasted into a shell."""
    done = wf("deck", *QUICK, "--out", "two words")
    assert "cd 'two words'" in done.stderr


@pytest.mark.parametrize("ranks", [1, 2])
def test_engine_error_is_passed_on_and_what_was_written_stays(ranks: int, wf: Wf, tmp_path: Path) -> None:
    assert wf("deck", *QUICK, "--out", "bad").returncode == 0
    bad = tmp_path / "bad"
    deck = (bad / "deck.in").read_text()
    assert deck.count("run ${last_step} upto\n") == 2
    (bad / "deck.in").write_text(deck.replace("run ${last_step} upto\n", "run 1000\nrun nonsense\n", 1))
    done = wf("resume", "bad", "--any-deck", "--ranks", ranks)
    assert done.returncode == 1
    assert "'bad'" in done.stderr
    assert done.stderr.count("Expected integer parameter instead of 'nonsense'") == 1
    state = record(bad)
    assert state["status"] == "failed"
    assert "nonsense" in state["reason"]
    assert steps(bad)[-1] <= 1000
    assert len(steps(bad)) > 1
    assert "failed" in wf("status", "bad").stdout


def test_overlapping_start_is_refused_by_the_engine_not_by_a_crash(wf: Wf, tmp_path: Path) -> None:
    """Two discs on top of each other: the engine's words or a result, but no crash."""
    assert wf("deck", *QUICK, "--max-time", 1, "--out", "bad").returncode == 0
    data = tmp_path / "bad" / "grains.data"
    lines = data.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("1 1 "))
    lines[first] = " ".join([*lines[first].split()[:4], *lines[first + 1].split()[4:]])
    data.write_text("\n".join(lines) + "\n")
    done = wf("resume", "bad", "--any-deck")
    assert done.returncode in (0, 1)
    assert done.returncode == 0 or "ERROR" in done.stderr
    assert "signal" not in done.stderr


def test_the_newest_whole_checkpoint_of_a_run_is_chosen(packing: Path, copy: Path) -> None:
    found = newest(packing)
    assert found is not None
    assert found.step == step_of(found.path) <= record(packing)["result"]["step"] == step_of(packing / "checkpoint.2.end")
    assert confirmed(found.path)
    os.truncate(copy / found.path.name, 40)
    older = newest(copy)
    assert older is not None
    assert older.step < found.step
    assert [path.name for path in damaged(copy)] == [found.path.name]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_cut_back_leaves_a_prefix(share: float, packing: Path, copy: Path) -> None:
    last = int(steps(packing)[-1])
    cut_back(copy, max(int(share * last), 1))
    kept = steps(copy)
    assert kept[-1] <= share * last
    whole: Any = steps(packing)
    assert kept.tolist() == whole[whole <= share * last].tolist()
    for name in RESULTS:
        assert (packing / name).read_bytes().startswith((copy / name).read_bytes())
    assert (copy / "grains.dump").stat().st_size > 0  # the frame of step 0
