"""States, what is read from logs, and that every row comes out whole; nothing is said of how fast."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from workflow.data.discs import Discs
from workflow.errors import EngineError, EnvironmentFault
from workflow.verification.bench import OTHER, PROGRAMS, bench, missing, own_states, read_loop
from workflow.verification.bench_states import dense, gas

LAMMPS = """
Loop time of 9.0 on 1 procs for 10 steps with 4 atoms
Pair    | 9.0        | 9.0        | 9.0        |   0.0 | 90.00
Loop time of 2.0 on 2 procs for 1000 steps with 1000 atoms
Section |  min time  |  avg time  |  max time  |%varavg| %total
Pair    | 0.9        | 1.0        | 1.1        |   0.3 | 50.00
Neigh   | 0.1        | 0.2        | 0.3        |   0.2 | 10.00
Comm    | 0.3        | 0.3        | 0.3        |   0.3 | 15.00
Output  | 2.7e-05    | 2.7e-05    | 2.7e-05    |   0.0 |  0.00
Modify  | 0.4        | 0.4        | 0.4        |   0.0 | 20.00
Other   |            | 0.1        |            |       |  5.00
"""
LIGGGHTS = """
Loop time of 0.5 on 1 procs for 1000 steps with 1000 atoms, finish time Sun
Pair  time (%) = 0.4 (80)
Neigh time (%) = 0 (0)
Comm  time (%) = 0.01 (2)
Outpt time (%) = 0.0 (0)
Other time (%) = 0.09 (18)
"""


def solid_fraction(discs: Discs) -> float:
    return float(np.sum(np.pi * discs.diameter**2 / 4.0) / discs.cell.prod())


def spacing(discs: Discs) -> float:
    """Median distance of rows that follow each other, through the periodic cell."""
    step = np.diff(discs.position, axis=0)
    return float(np.median(np.hypot(*(step - discs.cell * np.round(step / discs.cell)).T)))


def test_gas_is_what_it_is_called() -> None:
    discs = gas(400)
    assert solid_fraction(discs) == pytest.approx(0.36, rel=1e-12)
    assert discs.velocity is not None
    assert np.sqrt(np.mean(np.sum(discs.velocity**2, axis=1))) == pytest.approx(0.3, rel=1e-12)
    assert not cKDTree(discs.position, boxsize=discs.cell).query_pairs(0.5)  # nothing closer than two least radii
    assert np.array_equal(discs.position, gas(400).position)


@pytest.mark.engine
def test_dense_state_is_a_packing_in_spatial_order(tmp_path: Path) -> None:
    discs = dense(400, tmp_path)
    assert solid_fraction(discs) == pytest.approx(0.80, rel=1e-12)
    assert np.array_equal(np.sort(discs.diameter), np.sort(gas(400).diameter))
    pairs = cKDTree(discs.position, boxsize=discs.cell).query_pairs(1.0, output_type="ndarray")
    branch = np.subtract(*discs.position[pairs.T])
    branch -= discs.cell * np.round(branch / discs.cell)
    gaps = np.hypot(*branch.T) - discs.diameter[pairs].mean(axis=1)
    # jammed with friction: z >= 3 among the grains that carry force (3 equations each, 2 forces per contact), of which up
    # to a quarter may be rattlers; stiff: the deepest overlap, 0.023 here, is far below a radius
    assert 2.0 * np.sum(gaps < 0.0) / 400 > 3.0 * 0.75
    assert gaps.min() > -0.05
    # rows in strips: the next row is a near grain, where rows at random are some nine diameters (half a cell) apart
    assert spacing(discs) < 2.0


def test_last_loop_is_read_with_its_parts() -> None:
    loop = read_loop(LAMMPS, 1_000_000)
    assert loop.total == pytest.approx(2000.0)
    assert loop.parts == pytest.approx({"pair": 1000.0, "neigh": 200.0, "comm": 300.0, "modify": 400.0, "other": 100.0})
    older = read_loop(LIGGGHTS, 1_000_000)
    assert older.parts == pytest.approx({"pair": 400.0, "neigh": 0.0, "comm": 10.0, "other": 90.0})
    assert read_loop("Loop time of 1.0 on 1 procs", 1000).parts == {}
    with pytest.raises(EngineError, match="no loop time"):
        read_loop("nothing", 1)


@pytest.mark.engine
def test_every_engine_that_is_here_gives_its_rows() -> None:
    timings = bench(own_states([100], ["gas", "dense"]), rounds=1, steps=50, switches=True, out=io.StringIO())
    rows = {(timing.state, timing.engine): timing for timing in timings}
    assert len(rows) == len(timings)
    here = {"exact", "stock", "hooke/history", "granular", *PROGRAMS} - set(missing(PROGRAMS))
    for state in ("gas", "dense"):
        assert here <= {engine for of, engine in rows if of == state}
    assert ("gas", "exact, cohesion") in rows and ("dense", "exact, cohesion") not in rows
    for (state, engine), row in rows.items():
        assert 0.0 < row.least <= row.ns_per_grain_step <= row.most
        assert row.grain_steps_per_second * row.ns_per_grain_step == pytest.approx(1e9)
        assert row.n == 100 and row.ranks == 1 and row.rounds == 1 and row.steps == 50
        assert row.ratio is not None and row.ratio_to_exact is not None
        assert min(row.ratio, row.ratio_to_exact) > 0.0
        assert (row.pair is None) == (engine == "yade")
        assert rows[state, "hooke/history"].ratio == rows[state, "exact"].ratio_to_exact == 1.0


@pytest.mark.engine
def test_another_installation_takes_turns_with_this_one() -> None:
    """The other one is this one too: the same deck on the same state, so the same shares, whatever the machine does."""
    rows = bench(own_states([100], ["gas"]), ["exact"], rounds=2, steps=50, against=Path(sys.executable), out=io.StringIO())
    assert [row.engine for row in rows] == ["exact", OTHER]
    assert all(row.steps == 50 and row.rounds == 2 and row.pair for row in rows)
    with pytest.raises(EngineError, match="stopped"):
        bench(own_states([100], ["gas"]), ["exact"], rounds=1, steps=50, against=Path("/bin/false"), out=io.StringIO())


@pytest.mark.engine
def test_ranks_take_turns() -> None:
    timings = bench(own_states([400], ["gas"]), ["exact", "liggghts"], ranks=[1, 2], rounds=1, steps=20, out=io.StringIO())
    assert {timing.ranks for timing in timings if timing.engine == "exact"} == {1, 2}
    assert {timing.ranks for timing in timings if timing.engine == "liggghts"} <= {1}
    assert {timing.ratio for timing in timings} == {None}


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert missing(["exact", "yade", "liggghts"]) == ["yade", "liggghts"]
    with pytest.raises(EnvironmentFault, match="apt-get install yade"):
        bench(own_states([100], ["gas"]), ["yade"], out=io.StringIO())


def test_states_are_made_in_order() -> None:
    assert [name for name, _ in own_states([50, 60], ["dense", "gas"])] == ["dense", "gas", "dense", "gas"]
    sizes = [len(make(Path()).diameter) for _, make in own_states([50, 60], ["gas"])]
    assert sizes == sorted(set(sizes))
