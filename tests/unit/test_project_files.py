"""What states the same thing twice agrees: versions, names, dependencies and their reasons, the form of CHANGELOG."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

import workflow
from workflow.campaign.crate_files import RUN_FILES
from workflow.data.installed import installed_file
from workflow.runs import directory as rundir

ROOT = Path(__file__).resolve().parents[2]
SECTIONS = {"Bits", "Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}  # of Keep a Changelog, and Bits


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads(text("pyproject.toml"))["project"]


def test_version_and_name_are_the_same_everywhere(project: dict[str, Any]) -> None:
    codemeta = json.loads(text("codemeta.json"))
    cited = dict(re.findall(r"^(\w+): (.+)$", text("CITATION.cff"), re.MULTILINE))
    assert {codemeta["version"], cited["version"], metadata.version(workflow.DISTRIBUTION)} == {workflow.__version__}
    assert {codemeta["name"], cited["title"], project["name"]} == {workflow.DISTRIBUTION}
    assert codemeta["license"].endswith("/" + project["license"])
    assert cited["license"] == project["license"]
    assert [one["name"] for one in codemeta["author"]] == re.findall(r"^  - name: (.+)$", text("CITATION.cff"), re.MULTILINE)
    number = re.escape(workflow.__version__)
    assert re.search(rf"^## {number} - \d{{4}}-\d\d-\d\d$|^Version {number} in work", text("CHANGELOG.md"), re.MULTILINE)


def test_changelog_has_the_form_that_it_names() -> None:
    """Releases newest first, each with a day; kinds of change that everybody knows."""
    releases = re.findall(r"^## (.+)$", text("CHANGELOG.md"), re.MULTILINE)
    assert releases[0] == "Unreleased"
    numbers = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) - (\d{4}-\d\d-\d\d)", release) for release in releases[1:]]
    assert all(numbers), releases
    order = [tuple(map(int, number.groups()[:3])) for number in numbers if number]
    assert order == sorted(order, reverse=True)
    for release in re.split(r"^## .+$", text("CHANGELOG.md"), flags=re.MULTILINE)[1:]:
        kinds = re.findall(r"^### (.+)$", release, re.MULTILINE)
        assert set(kinds) <= SECTIONS and len(set(kinds)) == len(kinds), kinds


def test_every_dependency_has_its_reason(project: dict[str, Any]) -> None:
    needs = [*project["dependencies"], *(need for extra in project["optional-dependencies"].values() for need in extra)]
    names = {re.match(r"[\w-]+", need)[0].lower().replace("_", "-") for need in needs}  # type: ignore[index]
    rows = re.findall(r"^\| `([\w-]+)` \| [^|]+ \| \S.+ \|$", text("docs/dependencies.md"), re.MULTILINE)
    assert names - {project["name"]} <= {name.lower().replace("_", "-") for name in rows}
    assert "workflow" not in names  # an extra of ours is asked for by the name of the distribution: this one is another project
    assert len(rows) == len(set(rows))


def test_ci_runs_on_the_oldest_and_the_newest_python_that_are_stated(project: dict[str, Any]) -> None:
    stated = re.findall(r":: Python :: (3\.\d+)", "\n".join(project["classifiers"]))
    oldest = project["requires-python"].removeprefix(">=")
    tried = re.findall(r'"(3\.\d+)"', text(".github/workflows/ci.yml"))
    assert tried == [oldest, stated[-1]]
    assert stated[0] == oldest
    assert "run: .ci/run" in text(".github/workflows/ci.yml")
    assert ".ci/lint" in text(".ci/run") and "entry: .ci/lint" in text(".pre-commit-config.yaml")


@pytest.mark.parametrize(("message", "accepted"), [
    ("Refuse a step that is too long\n\nWhy, and how it was tested.\n", True), ("S" * 72 + "\n", True),
    ("S" * 73 + "\n", False), ("Subject\nthe body follows at once\n", False), ("Subject\n# a comment of git\n", True),
])  # fmt: skip
def test_a_commit_message_that_is_no_subject_is_refused(message: str, accepted: bool, tmp_path: Path) -> None:
    (tmp_path / "message").write_text(message)
    done = subprocess.run([ROOT / ".ci/commit_message", tmp_path / "message"], capture_output=True, check=False)
    assert (done.returncode == 0) == accepted, done.stderr


def test_a_file_of_the_installed_package_is_found() -> None:
    found = installed_file("discplugin.so")
    assert found and found.is_file()
    assert installed_file("discplugin.so", "no-such-package") is None
    assert installed_file("no such file") is None


def test_a_crate_knows_every_file_that_a_run_directory_says_it_has() -> None:
    """The list at the top of workflow/runs/directory.py, but for what only a resume needs."""
    listed = set(re.findall(r"\b[a-z]+\.(?:toml|json|in|lammps|data|txt|dump|h5)\b", rundir.__doc__ or ""))
    assert listed <= set(RUN_FILES)
