"""Every instruction set gives the same bits: sums run in eight partial sums whatever the width, and nothing is contracted."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SAME = ["-std=c++17", "-ffp-contract=off", "-I", str(HERE.parents[2] / "plugins"), str(HERE / "pair_loop.cpp")]
BUILDS = {
    "widest of this machine": ["-O3", "-fno-math-errno", "-fno-trapping-math"],  # as the plugin is built
    "scalar": ["-O1", "-fno-tree-vectorize", "-DDISC_PLAIN", "-Wno-psabi"],
}


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    compiler = shutil.which("c++")
    assert compiler, "no C++ compiler: the plugin could not have been built either"
    results = {}
    for name, options in BUILDS.items():
        program = tmp_path_factory.mktemp("kernels") / "pair_loop"
        subprocess.run([compiler, *options, *SAME, "-o", str(program)], check=True, capture_output=True)
        results[name] = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    return results


def test_every_instruction_set_gives_the_same_bits(printed: dict[str, str]) -> None:
    """Bound on the difference: none."""
    assert printed["scalar"] == printed["widest of this machine"]


def test_the_laws_differ_from_each_other(printed: dict[str, str]) -> None:
    """Not a constant: the laws differ from each other."""
    lines = printed["scalar"].splitlines()[:-1]
    assert len({line[:64] for line in lines[::4]}) == 4


def test_lanes_without_a_pair_feel_no_attraction_of_any_range(printed: dict[str, str]) -> None:
    """Virial of a pass over that of its only pair, for ranges of 1, 10 and 1e9: one, to the last bit."""
    assert [float(word) for word in printed["scalar"].splitlines()[-1].split()] == [1.0, 1.0, 1.0]
