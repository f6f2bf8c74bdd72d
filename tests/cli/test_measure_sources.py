"""`wf measure`, `wf plot` and `wf export` on groups, on several samples, and on dumps."""

from __future__ import annotations

import csv
import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from workflow.cli.main import main

Wf = Callable[..., subprocess.CompletedProcess[str]]


def test_groups_named_come_beside_the_standard_numbers(packing: Path, wf: Wf) -> None:
    measures = json.loads(wf("measure", packing, "--json", "--only", "holes,pair_correlation").stdout)
    assert measures["holes"]["number"] > 0 and max(measures["pair_correlation"]["g"]) > 1.0
    assert measures["solid_fraction"] > 0.6 and "rigidity" not in measures
    assert measures["interactions"]["contacts"] > 0


def test_every_group_of_a_cohesive_packing(cohesive: Path, wf: Wf) -> None:
    done = wf("measure", cohesive, "--json", "--only", "all")
    measures = json.loads(done.stdout)
    assert measures["forces"]["distribution"]["unit"] == "F0"
    assert measures["vibrations"]["all"] is True
    assert measures["rigid_clusters"]["redundant"] >= 0
    missing = [name for name, part in measures.items() if isinstance(part, dict) and "error" in part]
    assert done.returncode == (1 if missing else 0)  # a dense packing has no fractal range, but that is said inside "fit"
    assert not missing


@pytest.fixture(scope="module")
def second(packing: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The packing with another seed."""
    folder = tmp_path_factory.mktemp("second")
    scene = (packing / "scene.toml").read_text()
    seed = next(line for line in scene.splitlines() if line.startswith("seed"))
    (folder / "scene.toml").write_text(scene.replace(seed, "seed = 4711"))
    assert main(["run", str(folder / "scene.toml"), "--out", str(folder / "run")]) == 0
    return folder / "run"


def test_samples_that_differ_in_the_seed_give_mean_and_scatter(packing: Path, second: Path, wf: Wf) -> None:
    both = json.loads(wf("measure", packing, second, "--json", "--only", "forces").stdout)
    each = [json.loads(wf("measure", one, "--json", "--only", "none").stdout)["solid_fraction"] for one in (packing, second)]
    assert both["solid_fraction"]["mean"] == pytest.approx(sum(each) / 2)
    assert both["solid_fraction"]["scatter"] == pytest.approx(abs(each[0] - each[1]) / 2**0.5)
    assert "time" not in both and "step" not in both
    text = wf("measure", packing, second, "--only", "none").stdout
    assert "solid_fraction" in text and "+-" in text
    assert "named twice" in wf("measure", packing, packing).stderr


def test_samples_that_differ_in_more_are_shown_apart_with_what_differs(
    packing: Path, second: Path, cohesive: Path, wf: Wf
) -> None:
    found = json.loads(wf("measure", packing, cohesive, second, "--json", "--only", "none").stdout)
    assert found["differ"]["cohesion"] == [False, True, False] and "seed" not in found["differ"]
    assert [kind["sources"] for kind in found["kinds"]] == [[str(packing), str(second)], [str(cohesive)]]
    assert found["kinds"][0]["measures"]["coordination"]["samples"] == 2
    alone = json.loads(wf("measure", cohesive, "--json", "--only", "none").stdout)
    assert found["kinds"][1]["measures"] == alone
    text = wf("measure", packing, cohesive, "--only", "none").stdout
    assert text.startswith("not averaged") and "cohesion = False | True" in text


def test_a_heap_and_a_packing_are_shown_apart(packing: Path, poured: tuple[Path, float], wf: Wf) -> None:
    found = json.loads(wf("measure", packing, poured[0], "--json").stdout)
    assert found["differ"]["scene"] == ["method1", "heap"]
    assert [list(kind["measures"])[:1] for kind in found["kinds"]] == [["grains"], ["scene"]]


def test_the_dumps_of_a_run_are_measured_as_the_run(packing: Path, wf: Wf) -> None:
    run = json.loads(wf("measure", packing, "--json", "--only", "rigidity,forces").stdout)
    scene = (packing / "scene.toml").read_text()
    assert "kappa = 1000" in scene  # K_N = kappa P, P = 1
    words = [
        "--contacts",
        packing / "contacts.dump",
        "--kn",
        "1000",
        "--force-unit",
        "1",
        "--json",
        "--only",
        "rigidity,forces",
    ]
    dumps = json.loads(wf("measure", packing / "grains.dump", *words).stdout)
    for part in (run, dumps):
        for rounding in ("smallest_pivot", "largest_residue"):  # the order of the pairs in the file changes these
            part["rigidity"].pop(rounding)
    for name in ("solid_fraction", "coordination", "interactions", "rigidity"):
        assert dumps[name] == run[name], name
    repulsive = [part["forces"]["populations"]["repulsive"]["mean"] for part in (dumps, run)]
    assert repulsive[0] == pytest.approx(repulsive[1], rel=1e-12)  # sums in another order
    assert dumps["forces"]["percolation"] == run["forces"]["percolation"]


def test_dumps_that_lack_something_are_refused(packing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In this process: starting `wf` takes longer than what is tested here."""
    bare = tmp_path / "bare.dump"
    bare.write_text((packing / "grains.dump").read_text().replace(" diameter ", " colour "))
    for words, message in (
        ([bare], "diameter or radius"),
        ([bare, "--columns", "diameter"], "NAME=COLUMN"),
        ([packing / "grains.dump", "--frame", "99999"], "frame 99999 does not exist"),
        ([packing / "grains.dump", "--f0", "1"], "--d0"),
        ([packing / "run.h5"], "no LAMMPS dump"),
        ([packing, "--window", "2", "1"], "--window 2 1"),
    ):
        assert main(["measure", *map(str, words)]) in (1, 2)
        assert message in capsys.readouterr().err, words
    assert main(["measure", str(bare), "--columns", "diameter=colour", "--only", "none"]) == 0
    assert "solid_fraction" in capsys.readouterr().out


def test_figures_are_drawn_by_name(
    packing: Path, second: Path, cohesive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def plot(*words: object) -> int:
        return main(["plot", *map(str, words)])

    out = [tmp_path / name for name in ("one", "two", "three")]
    assert plot(packing, "--figure", "cloud,holes", "--format", "png", "--out", out[0]) == 0
    assert sorted(path.name for path in out[0].iterdir()) == ["cloud.png", "holes.png"]
    assert plot(packing, second, "--figure", "angles", "--format", "svg", "--out", out[1]) == 0
    assert [path.name for path in out[1].iterdir()] == ["angles.svg"]
    capsys.readouterr()
    assert plot(packing, cohesive, "--figure", "angles", "--format", "svg", "--out", out[1]) == 0
    said = capsys.readouterr()
    assert said.out.split() == [str(out[1] / f"angles.{k}.svg") for k in (1, 2)]
    assert "not averaged" in said.err and "cohesion = False | True" in said.err
    dumps = [packing / "grains.dump", "--contacts", packing / "contacts.dump"]
    assert plot(*dumps, "--format", "png", "--out", out[2]) == 0
    assert [path.name for path in out[2].iterdir()] == ["forces.png"]
    assert plot(packing, cohesive, "--figure", "holes") == 2
    assert "shows one sample" in capsys.readouterr().err
    assert plot(packing, "--figure", "cluod") == 2
    assert "figure 'cluod' is not known" in capsys.readouterr().err


def test_exports_of_a_run_and_of_its_dumps(packing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def export(*words: object) -> int:
        return main(["export", *map(str, words)])

    def rows(name: str) -> list[dict[str, str]]:
        with open(tmp_path / name, newline="") as file:
            return list(csv.DictReader(file))

    dumps = [packing / "grains.dump", "--contacts", packing / "contacts.dump"]
    assert export(packing, "--out", tmp_path / "run", "--to", "csv,vtk", "--all") == 0
    assert capsys.readouterr().out.split()[-1] == str(tmp_path / "run" / "cell.pvd")
    assert export(*dumps, "--out", tmp_path / "dumps", "--all") == 0
    times = [row["time"] for row in rows("run/frames.csv")]
    assert len(times) == len(list((tmp_path / "run").glob("grains.*.vtp"))) > 1
    assert [row["time"] for row in rows("dumps/frames.csv")] == times
    assert rows("dumps/grains.csv") == rows("run/grains.csv")
    tables = [rows(f"{source}/contacts.csv") for source in ("dumps", "run")]
    for table in tables:  # the dump has its pairs in no order
        table.sort(key=lambda row: [int(row[name]) for name in ("step", "id_i", "id_j")])
    assert len(tables[0]) == len(tables[1]) > 0
    for name in ("step", "id_i", "id_j", "branch_x", "branch_y", "normal", "tangential", "gap", "stretch"):
        assert [float(row[name]) for row in tables[0]] == [float(row[name]) for row in tables[1]], name
    assert export(packing, "--out", tmp_path / "last") == 0
    assert {row["step"] for row in rows("last/contacts.csv")} == {rows("run/frames.csv")[-1]["step"]}
    capsys.readouterr()
    for words, message in (
        ([packing, "--to", "vtu"], "--to 'vtu' is not known; did you mean vtk? known are: csv, parquet"),
        ([packing, "--to", "graphml", "--all"], "one network"),
        ([packing, "--frame", "99"], "frame 99 does not exist"),
        ([packing / "scene.toml"], "no LAMMPS dump"),
        ([packing / "scene.toml", "--all"], "no LAMMPS dump"),
    ):
        assert export(*words, "--out", tmp_path / "none") in (1, 2)
        assert message in capsys.readouterr().err, words
