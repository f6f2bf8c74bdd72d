"""Runs under LAMMPS's own laws and barostats, from the deck to the archive: equilibrium, balance, resume, a plain `lmp`."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from wf_process import call, record

from workflow.archive.read import Archive
from workflow.data.balance import balance
from workflow.runs.installation import engine

FEW = ["method1", "--n", "60", "--kappa", "1e3", "--hold", "1"]
ROUTES = {
    "granular, nph": ["--law", "granular", "--no-cohesion", "--barostat", "nph"],
    "hooke/history, nph": ["--law", "hooke/history", "--no-cohesion", "--barostat", "nph"],
    "granular, inertial, rolling": ["--law", "granular", "--no-cohesion", "--rolling"],
    "granular with attraction": ["--law", "granular", "--pstar", "0.1", "--d0", "0.01"],
    "granular with attraction, nph": ["--law", "granular", "--pstar", "0.1", "--d0", "0.01", "--barostat", "nph"],
    "exact, nph": ["--no-cohesion", "--barostat", "nph"],
}
# variable of the deck -> element of fix disc/equilibrium
PAIRED = {"net_force": 1, "net_moment": 2, "stress_x": 3, "stress_y": 4, "kinetic_raw": 6, "contacts": 8}
EXACT = [name for name in ROUTES if "inertial" in name or "attraction" in name or "exact" in name]  # resume exactly


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A finished run of every route, made when it is first asked for."""
    folder = tmp_path_factory.mktemp("routes")

    class Made(dict[str, Path]):
        def __missing__(self, name: str) -> Path:
            out = folder / str(len(self))
            done = call("run", *FEW, *ROUTES[name], "--checkpoint-interval", "10", "--out", out, cwd=folder)
            assert done.returncode == 0, done.stderr
            self[name] = out
            return out

    return Made()


@pytest.mark.parametrize("name", ROUTES)
def test_every_route_ends_in_equilibrium_with_balanced_grains(name: str, runs: dict[str, Path]) -> None:
    """By the table of contacts of the archive: net forces within the criterion, and those of the engine.

    The table has the velocities of the grains at the end of the step, the engine's forces those of half a step before, with the
    motion of the cell: they differ by damping times that difference.  Moments of granular act at R - overlap/2; an overlap
    of 1 % of a moves them by 0.005 |T|.
    """
    assert record(runs[name])["result"]["equilibrated"] == 1.0
    with Archive(runs[name] / "run.h5") as archive:
        frame = archive.frame(-1)
    found = balance(frame)
    assert found.largest_force < 1e-4 and found.force_difference < 1e-4
    assert found.moment_difference < 0.01 * np.abs(frame.interactions.tangential).max()
    assert len(frame.interactions) > 60


@pytest.mark.parametrize("name", [name for name in ROUTES if "exact" not in name])
def test_what_lammps_does_not_tell_is_undefined(name: str, runs: dict[str, Path]) -> None:
    with Archive(runs[name] / "run.h5") as archive:
        frame, series = archive.frame(-1), archive.series
    assert frame.lacks == {"xi_t", "xi_r"} and np.isnan(frame.interactions.xi_t).all()
    assert all(np.isnan(series[column]).all() for column in ("elastic", "lost_sliding", "residual"))


@pytest.mark.parametrize("name", EXACT)
def test_a_run_resumes_to_the_same_bytes_where_the_plugin_is_there(name: str, runs: dict[str, Path]) -> None:
    done = call("verify", runs[name], "--last", cwd=runs[name].parent)
    assert done.returncode == 0 and "every byte" in done.stdout, done.stdout + done.stderr


def test_without_the_plugin_a_resumed_run_is_the_same_but_for_rounding(runs: dict[str, Path]) -> None:
    """And `wf verify` says why."""
    done = call("verify", runs["granular, nph"], "--last", cwd=runs["granular, nph"].parent)
    assert done.returncode == 0 and "LAMMPS's own restarts" in done.stdout, done.stdout + done.stderr


def test_a_heap_of_hooke_history_comes_to_rest_and_resumes_to_the_same_bytes(tmp_path: Path) -> None:
    """While grains are poured and leave the base; the base bears the weight of what lies on it."""
    words = ["--grains", "40", "--drop-height", "12", "--base-half-width", "4", "--feed-half-width", "2"]
    law = ["--hooke", "500", "--law", "hooke/history", "--checkpoint-interval", "30"]
    done = call("run", "heap", *words, *law, "--out", "heap", cwd=tmp_path)
    assert done.returncode == 0 and record(tmp_path / "heap")["result"]["equilibrated"] == 1.0, done.stderr
    with Archive(tmp_path / "heap" / "run.h5") as archive:
        frame = archive.frame(-1)
    assert frame.lacks == {"xi_t", "xi_r"}
    low = frame.position[:, 1] == frame.position[:, 1].min()  # the base, whose own sums read 0
    weight = frame.mass[~low].sum()
    assert -balance(frame).force[low, 1].sum() == pytest.approx(weight, rel=1e-3)
    again = call("verify", "heap", "--last", cwd=tmp_path)
    assert again.returncode == 0 and "every byte" in again.stdout, again.stdout + again.stderr


def test_criteria_by_lammps_alone_are_those_of_the_plugin(tmp_path: Path) -> None:
    """Both look at the same run: at every check, while grains collide and at the end.

    The virial of a step has the damping of the half step, the contacts of a check that of the check.  A grain is held for
    LAMMPS by two contacts, for the plugin by two that carry more than the tolerance.
    """
    call("deck", *FEW, *ROUTES["granular, nph"], "--out", "run", cwd=tmp_path)
    deck = (tmp_path / "run" / "deck.in").read_text()
    criteria = "unit 1 stress 1 1 hold ${hold} force ${force_tolerance} energy ${energy_tolerance} aggregates yes"
    ours = f"fix eq all disc/equilibrium ${{check_every}} {criteria}\n"
    told = " ".join(f"$(v_{name}:%.17g)" for name in PAIRED) + " " + " ".join(f"$(f_eq[{k}]:%.17g)" for k in PAIRED.values())
    row = f"fix both all print ${{check_every}} '{told} $(v_in_equilibrium) $(f_eq)' file both.txt screen no\n"
    at = deck.index("# Stage 1, compress")
    (tmp_path / "run" / "deck.in").write_text(deck[:at] + ours + "run 0\n" + row + deck[at:])
    found = engine()
    words = [found.lmp, "-in", "deck.in", "-log", "none", "-screen", "none"]
    subprocess.run(words, cwd=tmp_path / "run", check=True, env={**os.environ, **found.variables()}, timeout=60)
    table = np.loadtxt(tmp_path / "run" / "both.txt")
    lammps, plugin = (dict(zip(PAIRED, part, strict=True)) for part in (table.T[: len(PAIRED)], table.T[len(PAIRED) : -2]))
    for name in ("net_force", "net_moment", "contacts", "kinetic_raw"):
        assert lammps[name] == pytest.approx(plugin[name], rel=1e-12, abs=1e-14), name
    settled = plugin["net_force"] < 1e-4
    assert settled.sum() > 20
    for name in ("stress_x", "stress_y"):
        assert lammps[name][settled] == pytest.approx(plugin[name][settled], abs=1e-6), name
    assert table[-1, -2:].tolist() == [1.0, 1.0]


def test_a_plain_lmp_without_any_plugin_runs_the_deck(tmp_path: Path) -> None:
    done = call("deck", *FEW, *ROUTES["granular, nph"], "--scheduler", "slurm", "--out", "job", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "job" / "plugin").exists() and "GRANULAR" in (tmp_path / "job" / "README.txt").read_text()
    found = engine()
    (tmp_path / "lmp").write_text(f'#!/bin/sh\nLD_LIBRARY_PATH={found.mpi.parent} exec {found.lmp} "$@"\n')
    (tmp_path / "lmp").chmod(0o755)
    path = {"PATH": f"{tmp_path}:/usr/bin:/bin", "SLURM_SUBMIT_DIR": str(tmp_path / "job")}
    script = (tmp_path / "job" / "job.sh").read_text()
    (tmp_path / "job" / "job.sh").write_text(script.replace("launch=(srun)", "launch=()"))
    ended = subprocess.run(["bash", "job.sh"], cwd=tmp_path / "job", env=path, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and "finished: stage 2" in ended.stdout, ended.stdout + ended.stderr
