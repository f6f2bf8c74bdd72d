"""Every file of a run directory, damaged in every way: a sentence or the same numbers, in time, and never another number.

`WORKFLOW_FUZZ=K` draws K times as many, at random.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from mutations import deadline

from workflow.cli.main import main
from workflow.errors import EngineError
from workflow.runs.directory import RunDirectory

NUMBERS = ["1e18", "1000000000000000000", "-1", "0", "nan", "inf", "1e-300", "99999999999999999999999999", "1e5", "0x10", "1_0"]
WORDS = [b"\x1b[2J", b"../x", b"\xff\xfe", b"ITEM: TIME", b"[[[[[[", b"\n\n", b"\0" * 9, b"=cmd|'/C calc'!A0", b"a." * 3000]
MEASURE = ["measure", "--json", "--only", "none"]
COMMANDS = [MEASURE] * 6 + [
    ["measure", "--json"],
    ["measure", "--frame", "0", "--only", "none"],
    ["status"],
    ["status", "--json"],
]
COMMANDS += [["export"], ["resume"], ["resume"], ["verify"], ["verify", "--last"]]


class Copy:
    """A copy of a run that is damaged and mended again."""

    def __init__(self, run: Path, folder: Path) -> None:
        self.path = Path(shutil.copytree(run, folder / "run"))
        self.content = {path.name: path.read_bytes() for path in self.path.iterdir()}
        self.stamps: dict[str, tuple[int, ...]] = {}
        self.mend()

    def mend(self) -> None:
        """Every file as it was, no other."""
        for path in list(self.path.iterdir()):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            elif path.name not in self.content or self._stamp(path) != self.stamps.get(path.name):
                path.unlink()
        for name, content in self.content.items():
            path = self.path / name
            if not os.path.lexists(path):
                path.write_bytes(content)
                self.stamps[name] = self._stamp(path)

    @staticmethod
    def _stamp(path: Path) -> tuple[int, ...]:
        state = path.lstat()
        return state.st_mtime_ns, state.st_size, state.st_ino, state.st_mode


def damage(rng: random.Random, path: Path) -> str:
    """Damage a file in one of many ways; which."""
    data = bytearray(path.read_bytes())
    kind = rng.choice(["bit", "bits", "cut", "page", "number", "number", "word", "line", "gone", "directory", "fifo", "link",
                       "empty", "longer", "other"])  # fmt: skip
    if kind in ("gone", "directory", "fifo", "link"):
        path.unlink()
        if kind == "directory":
            path.mkdir()
        elif kind == "fifo":
            os.mkfifo(path)
        elif kind == "link":
            path.symlink_to(rng.choice(["/nowhere", path.name, "..", path.parent / "run.json"]))
        return kind
    at = rng.randrange(len(data)) if data else 0
    if kind in ("bit", "bits") and data:
        for _ in range(1 if kind == "bit" else 20):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "cut":
        del data[at:]
    elif kind == "page":
        start = at // 4096 * 4096
        data[start : start + 4096] = bytes(len(data[start : start + 4096]))
    elif kind == "number" and (found := list(re.finditer(rb"\d+", data[: 1 << 16]))):
        one = rng.choice(found)
        data[one.start() : one.end()] = rng.choice(NUMBERS).encode()
    elif kind == "word":
        data[at:at] = rng.choice(WORDS)
    elif kind == "line":
        lines = bytes(data).split(b"\n")
        del lines[rng.randrange(len(lines))]
        data = bytearray(b"\n".join(lines))
    elif kind == "longer":
        data += rng.choice([data[: len(data) // 2], b"1 2 3\n", bytes(4096)])
    elif kind == "other":
        data = bytearray(rng.choice(sorted(path.parent.glob("*.*"))).read_bytes())
    else:
        data = bytearray()
    path.write_bytes(bytes(data))
    return kind


def _not_started(*_: Any, **__: Any) -> None:
    raise EngineError("the engine is not started here")


def said(*words: Any) -> tuple[int, str, str]:
    """`wf words` in this process, in time: status, output and message, of which the last line says why it failed."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), deadline():
        status = main([str(word) for word in words])
    assert status in (0, 1, 2), status
    if status and words[0] != "status":
        last = err.getvalue().splitlines()[-1]
        assert last.startswith("wf: ") and 20 < len(last) < 2000, err.getvalue()
    return status, out.getvalue(), err.getvalue()


def attack(copy: Copy, rng: random.Random, reference: Any) -> str:
    """Damage one file, run one command, compare; what was done."""
    name, command = rng.choice(sorted(copy.content)), rng.choice(COMMANDS)
    if command[0] == "resume":
        RunDirectory(copy.path).record(status="interrupted")
    kind = damage(rng, copy.path / name)
    case = f"{' '.join(command)} with {name}: {kind}"
    try:
        status, out, err = said(command[0], copy.path, *command[1:])
    except BaseException as fault:
        raise AssertionError(f"{case}: {type(fault).__name__}: {fault}") from fault
    if command[:2] == MEASURE[:2] and status == 0:
        found = json.loads(out)
        assert found == {name: reference[name] for name in found}, f"{case}: other numbers, without a word"
    assert "\x1b" not in out + err, f"{case}: control characters on the terminal"
    copy.mend()
    return case


@pytest.mark.parametrize("kind", ["packing", "heap"])
def test_a_damaged_run_directory_gives_an_error_or_the_result(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = int(os.environ.get("WORKFLOW_FUZZ", "0"))
    rng = random.Random(os.environ.get("WORKFLOW_SEED") if times else kind)
    run = request.getfixturevalue(kind)
    monkeypatch.setattr("workflow.runs.launch.Child", _not_started)
    copy = Copy(run, tmp_path)
    reference = json.loads(said("measure", copy.path, "--json")[1])
    copy.mend()
    for _ in range(60 * max(times, 1)):
        attack(copy, rng, reference)
