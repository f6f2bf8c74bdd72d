"""A plugin built for one LAMMPS registers in no other: its styles are classes of that one."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PLUGINS = Path(__file__).parents[2] / "plugins"
SOURCE = """
#include "lammps_plugin.h"
extern "C" void lammpsplugin_init(void *lmp, void *, void *) { require_version(lmp, BUILT_FOR); }
"""
TWO: dict[str, Any] = {"position": np.array([[1.0, 1.0], [2.5, 1.0]]), "diameter": np.ones(2), "law": {"kn": 1000.0}}


def build(folder: Path, built_for: str | None = None) -> Path:
    """A plugin that states to be built for a release of LAMMPS, by default the installed one."""
    compiler = shutil.which("c++")
    assert compiler, "no C++ compiler: the plugin could not have been built either"
    where = subprocess.run([sys.executable, PLUGINS / "where.py"], capture_output=True, text=True, check=True)
    _, lammps, mpi, release = where.stdout.strip().split(";")
    (folder / "refuse.cpp").write_text(SOURCE)
    options = ["-std=c++17", "-O0", "-shared", "-fPIC", "-DLAMMPS_SMALLBIG", f'-DBUILT_FOR="{built_for or release}"']
    paths = ["-isystem", lammps, "-isystem", mpi, "-I", str(PLUGINS)]
    plugin = folder / "refuseplugin.so"
    subprocess.run([compiler, *options, *paths, folder / "refuse.cpp", "-o", plugin], check=True, capture_output=True)
    return plugin


def test_another_version_is_refused(discs: Callable[..., Any], tmp_path: Path) -> None:
    sample = discs(**TWO)
    with pytest.raises(Exception, match=r"built for LAMMPS 10 Sep 2025.*this is version 20250722: build it for this one"):
        sample.command(f"plugin load {build(tmp_path, '10 Sep 2025')}")


def test_the_same_version_is_accepted(discs: Callable[..., Any], tmp_path: Path) -> None:
    discs(**TWO).command(f"plugin load {build(tmp_path)}").run(1)
