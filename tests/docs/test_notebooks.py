"""The notebooks and the recipes of the documentation run as they stand, in an empty directory, and show what they say."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

pytestmark = pytest.mark.engine
ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))
RECIPE = re.compile(r"^```python\n(.*?)^```$\n\n^```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SMALL = ("n=400, cohesion=False", "n=60, cohesion=False, phi0=0.6, kappa=1e3")


def form(line: str) -> str:
    """A line without its numbers and blanks."""
    return re.sub(r"\s+", " ", re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "1", line)).strip()


def test_there_are_three_notebooks_and_they_hold_no_outputs() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["first_packing", "force_network", "parameter_study"]
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            assert not cell.get("outputs") and cell.get("execution_count") is None, path.name


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a kernel that is this Python, whatever kernels the user has."""
    folder = tmp_path / "jupyter" / "kernels" / "here"
    folder.mkdir(parents=True)
    words = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (folder / "kernel.json").write_text(json.dumps({"argv": words, "display_name": "here", "language": "python"}))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path / "jupyter"))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    return "here"


def outputs(notebook: Any, kind: str) -> list[str]:
    return [
        output["data"][kind] for cell in notebook.cells for output in cell.get("outputs", []) if kind in output.get("data", {})
    ]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the libraries that run notebooks
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_from_above_to_below(path: Path, kernel: str, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(notebook, timeout=300, kernel_name=kernel, resources={"metadata": {"path": str(tmp_path)}})
    client.execute(env={**os.environ, "TMPDIR": str(tmp_path)})
    shown = {kind: outputs(notebook, kind) for kind in ("text/plain", "text/html", "image/png")}
    assert shown["image/png"], "it shows no picture"
    errors = [output for cell in notebook.cells for output in cell.get("outputs", []) if output.get("name") == "stderr"]
    assert not errors, "it writes to standard error"
    progress = [
        text for text in shown["text/plain"] if re.match(r"(?:settle|compress) +(?:\d/\d +)?t|\s*\d running|done ", text)
    ]
    assert progress, "it shows no progress"
    if path.stem == "first_packing":
        assert any("data:image/png;base64," in html and "solid fraction" in html for html in shown["text/html"])


def test_program_of_the_first_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(compile(program.replace("n=200, phi0=0.36", "n=60, phi0=0.6, kappa=1e3"), "docs/index.md", "exec"), {})
    assert out.getvalue().startswith("0.") and (tmp_path / "packing" / "forces.png").is_file()


def test_recipes_run_in_their_order_and_print_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "howto.md").read_text(encoding="utf-8")
    recipes = RECIPE.findall(page)
    assert len(recipes) == page.count("```python") > 5
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for program, expected in recipes:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(program.replace(*SMALL), "docs/howto.md", "exec"), names)
        assert [form(line) for line in out.getvalue().splitlines()] == [form(line) for line in expected.splitlines()]
    assert {"contacts.csv", "distribution.pdf", "dense.html"} <= {path.name for path in tmp_path.iterdir()}
