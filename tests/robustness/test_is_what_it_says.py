"""Scene, deck, data and record of a run belong together: a difference is named and refused, or accepted and written down."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from workflow.archive.read import Archive
from workflow.campaign import verify
from workflow.campaign.cluster import Profile
from workflow.errors import EngineError, InputError
from workflow.runs.directory import RunDirectory

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]


def record(path: Path, **changes: object) -> bytes:
    return json.dumps({**json.loads((path / "run.json").read_bytes()), **changes}).encode()


def changed_deck(run: Path) -> dict[str, bytes]:
    return {"deck.in": (run / "deck.in").read_bytes().replace(b"mu               index 0.5", b"mu               index 0.3")}


def changed_scene(run: Path) -> dict[str, bytes]:
    return {"scene.toml": (run / "scene.toml").read_bytes().replace(b"\nmu = 0.5", b"\nmu = 0.3")}


def both_changed(run: Path) -> dict[str, bytes]:
    return changed_deck(run) | changed_scene(run)


def changed_data(run: Path) -> dict[str, bytes]:
    return {"grains.data": (run / "grains.data").read_bytes().replace(b"1 1 0.9", b"1 1 0.8").replace(b"2 1 0.", b"2 1 0.0")}


def shell_in_the_deck(run: Path) -> dict[str, bytes]:
    """And a record that fits: only the scene tells."""
    deck = (run / "deck.in").read_bytes() + b"shell touch pwned\n"
    hashes = json.loads((run / "run.json").read_bytes())["hashes"] | {"deck.in": hashlib.sha256(deck).hexdigest()}
    return {"deck.in": deck, "run.json": record(run, hashes=hashes)}


def changed_digest(run: Path) -> dict[str, bytes]:
    return {"run.json": record(run, digest="0" * 64)}


CHANGES = {
    "deck": (changed_deck, "deck.in', line"),
    "scene": (changed_scene, "deck.in', line"),
    "scene and deck": (both_changed, "is not the file that the run began with"),
    "data": (changed_data, "grains.data' is not the file that the run began with"),
    "shell": (shell_in_the_deck, "'shell touch pwned'"),
    "digest": (changed_digest, "scene.toml' is not the scene of the run"),
}


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Commands of engines that would have been started."""
    commands: list[list[str]] = []

    def child(command: list[str], *_: object) -> None:
        commands.append(command)
        raise EngineError("the engine is not started in this test")

    monkeypatch.setattr("workflow.runs.launch.Child", child)
    return commands


@pytest.mark.parametrize("command", ["measure", "resume", "verify", "export"])
@pytest.mark.parametrize("case", CHANGES)
def test_a_difference_is_named_and_refused(
    case: str, command: str, packing: Path, fresh: Fresh, wf: Wf, started: list[list[str]]
) -> None:
    change, words = CHANGES[case]
    run = fresh(packing, change(packing))  # type: ignore[operator]
    if command == "resume":
        RunDirectory(run).record(status="interrupted")
    status, _, err = wf(command, run)
    assert status == 2 and words in err and "--any-deck" in err, err
    assert not started


def test_the_line_and_both_values_are_named(packing: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, changed_deck(packing))
    number = (run / "deck.in").read_text().splitlines().index("variable mu               index 0.3") + 1
    assert f"deck.in', line {number}: 'variable mu               index 0.3', but scene.toml gives " in wf("measure", run)[2]


def test_what_is_accepted_is_written_down(packing: Path, fresh: Fresh, wf: Wf, started: list[list[str]]) -> None:
    """By run.json and by the archive, and by everybody from then on; another change is refused again."""
    run = fresh(packing, changed_deck(packing) | {"run.h5": None})
    assert wf("measure", run)[0] == 2
    assert wf("measure", run, "--any-deck")[0] == 0
    (entry,) = RunDirectory(run).state["accepted"]
    assert "index 0.3" in entry["differences"][0]
    assert entry["hashes"]["deck.in"] == RunDirectory(run).hash("deck.in")
    with Archive(run / "run.h5") as archive:
        assert archive.provenance["accepted"] == [entry]
    assert wf("measure", run)[0] == 0 and wf("export", run)[0] == 0
    (run / "deck.in").write_bytes((run / "deck.in").read_bytes() + b"# more\n")
    assert wf("measure", run)[0] == 2


@pytest.mark.parametrize("name", ["workflow", "lammps", "mpich"])
def test_another_version_does_not_go_on_without_a_word(
    name: str, packing: Path, fresh: Fresh, wf: Wf, started: list[list[str]]
) -> None:
    """It may be looked at."""
    versions = json.loads((packing / "run.json").read_bytes())["versions"]
    run = fresh(packing, {"run.json": record(packing, versions={**versions, name: "0.0.1"}, status="interrupted")})
    status, _, err = wf("resume", run)
    assert status == 2 and f"begun with {name} 0.0.1, here is {versions[name]}" in err
    assert wf("measure", run)[0] == 0
    assert wf("resume", run, "--any-deck")[0] == 1 and len(started) == 1


def test_a_run_of_another_version_is_read(packing: Path, fresh: Fresh, wf: Wf) -> None:
    """Its deck is the one its record has, though this version would render another."""
    deck = (packing / "deck.in").read_bytes().replace(b"# Method 1", b"# A method", 1)
    assert deck != (packing / "deck.in").read_bytes()
    state = json.loads((packing / "run.json").read_bytes())
    state["versions"]["workflow"] = "0.1.9"
    state["hashes"]["deck.in"] = hashlib.sha256(deck).hexdigest()
    run = fresh(packing, {"deck.in": deck, "run.json": json.dumps(state).encode()})
    assert wf("measure", run)[0] == 0


@pytest.mark.parametrize("name", ["../escaped", "/etc/passwd", "a/b", "..", ""])
def test_names_in_the_record_stay_inside(name: str, packing: Path, fresh: Fresh, wf: Wf) -> None:
    state = json.loads((packing / "run.json").read_bytes())
    run = fresh(packing, {"run.json": record(packing, hashes={**state["hashes"], name: "0" * 64})})
    for command in ("verify", "measure", "resume"):
        status, _, err = wf(command, run)
        assert status == 1 and "holds no record" in err
    assert not (run.parent / "escaped").exists()


@pytest.mark.parametrize("name", [".reserve", ".lock", "series.txt", "engine.err", "stop", "grains.dump", "log.lammps"])
def test_links_are_not_written_through(name: str, packing: Path, fresh: Fresh, wf: Wf, started: list[list[str]]) -> None:
    run = fresh(packing, {})
    target = run.parent / "target"
    target.write_text("mine")
    (run / name).unlink(missing_ok=True)
    (run / name).symlink_to(target)
    RunDirectory(run).record(status="interrupted")
    status, _, err = wf("resume", run)
    assert status in (1, 2) and name in err, err
    assert target.read_text() == "mine" and not started


def test_an_export_stays_in_the_run_directory(packing: Path, fresh: Fresh, wf: Wf, tmp_path: Path) -> None:
    run = fresh(packing, {})
    (tmp_path / "elsewhere").mkdir()
    (run / "export").symlink_to(tmp_path / "elsewhere")
    status, _, err = wf("export", run)
    assert status == 2 and "symbolic link" in err
    assert not list((tmp_path / "elsewhere").iterdir())
    assert wf("export", run, "--out", tmp_path / "elsewhere")[0] == 0


def test_a_verify_that_is_interrupted_says_so(packing: Path, wf: Wf, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is known then."""
    monkeypatch.setattr(verify, "run", lambda *_, **__: "interrupted")
    with pytest.raises(KeyboardInterrupt):
        verify.verify(RunDirectory(packing))


ESCAPES = ["--chd=/etc", "--chdi /etc", "--outpu=/etc/x", "-e /etc/x", "-D /etc", "--export=ALL,LD_PRELOAD=/x", "--wra=id",
           "--get-user-env=L", "--prolog=/x", "--propagate=ALL", "-mem=4G", "--C=rome", "--array 1-9"]  # fmt: skip


@pytest.mark.parametrize("word", ESCAPES)
def test_only_directives_of_a_list_are_allowed(word: str) -> None:
    with pytest.raises(InputError, match=r"directives: .* is not allowed"):
        Profile(directives=[word])


@pytest.mark.parametrize(
    ("scheduler", "word"), [("pbs", "-S /bin/x"), ("pbs", "-e x"), ("pbs", "-W x"), ("lsf", "-e x"), ("lsf", "-L x")]
)
def test_shells_and_files_are_not_among_them(scheduler: str, word: str) -> None:
    with pytest.raises(InputError, match=r"directives: .* is not allowed"):
        Profile(scheduler=scheduler, directives=[word])
