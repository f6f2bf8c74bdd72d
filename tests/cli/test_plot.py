"""`wf plot`: all figures, formats, sizes, films, and places that take no files."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from workflow.archive.read import Archive
from workflow.cli.main import main
from workflow.reports.registry import figures_of

Wf = Callable[..., subprocess.CompletedProcess[str]]


def test_all_draws_what_applies_and_says_what_does_not(
    packing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run without cohesion that no two discs close to a double triangle; dumps have no history."""
    run = figures_of(("network", "history"))
    dumps = [packing / "grains.dump", "--contacts", packing / "contacts.dump", "--mu", "0.3", "--kn", "1000"]
    for number, (source, known) in enumerate((([packing], run), (dumps, figures_of(("network",))))):
        out = tmp_path / str(number)
        assert main(["plot", *map(str, source), "--figure", "all", "--format", "png", "--dpi", "50", "--out", str(out)]) == 0
        said = capsys.readouterr()
        drawn = {path.stem for path in out.iterdir()}
        assert sorted(said.out.split()) == sorted(str(path) for path in out.iterdir())
        left = [line.removeprefix("wf: note: not drawn: ") for line in said.err.splitlines() if "not drawn" in line]
        assert all(len(line.split(": ", 1)[1]) > 20 for line in left)
        assert drawn.isdisjoint(line.split(":")[0] for line in left)
        assert drawn | {line.split(":")[0] for line in left} == set(known)
        assert len(drawn) > 10


def test_formats_size_and_dots_are_as_asked(packing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["plot", str(packing), "--figure", "forces", "--figure", "angles,history", "--out", str(tmp_path / "a")]
    assert main([*words, "--format", "pdf,png", "--format", "svg", "--size", "86", "--dpi", "100"]) == 0
    names = {f"{name}.{kind}" for name in ("forces", "angles", "history") for kind in ("pdf", "png", "svg")}
    assert {path.name for path in (tmp_path / "a").iterdir()} == names
    for name in ("forces", "angles", "history"):
        assert (tmp_path / "a" / f"{name}.pdf").read_bytes().startswith(b"%PDF-")
        with Image.open(tmp_path / "a" / f"{name}.png") as picture:
            assert picture.size[0] == pytest.approx(86 / 25.4 * 100, abs=1)
    capsys.readouterr()
    for wrong, message in (
        (["--format", "bmp"], "--format 'bmp' is not known; known are: png, svg, pdf"),
        (["--format", ","], "--format is empty"),
        (["--figure", ","], "--figure is empty"),
        (["--size", "1"], "--size 1 is not allowed"),
        (["--size", "nan"], "--size nan is not allowed"),
        (["--dpi", "1000000"], "--dpi 1e+06 is not allowed"),
        (["--film", "x.avi"], "use .mp4 or .gif"),
    ):
        assert main([*words[:2], *wrong, "--out", str(tmp_path / "b")]) == 2
        assert message in capsys.readouterr().err, wrong
    assert not (tmp_path / "b" / "x.avi").exists()


@pytest.mark.parametrize("command", ["plot", "export"])
def test_a_place_that_takes_no_files_is_named(command: str, packing: Path, tmp_path: Path, wf: Wf) -> None:
    """A file in the place of the folder, and above it."""
    (tmp_path / "file").write_text("mine")
    for place in ("file", "file/below"):
        done = wf(command, packing, "--out", place)
        assert done.returncode in (1, 2) and f"'{place}'" in done.stderr and "--out" in done.stderr, done.stderr
        assert "Traceback" not in done.stderr and done.stdout == ""
    assert (tmp_path / "file").read_text() == "mine"


def test_a_film_has_every_frame_of_a_run_and_of_its_dumps(
    cohesive: Path, poured: tuple[Path, float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dumps = [cohesive / "grains.dump", "--contacts", cohesive / "contacts.dump", "--f0", "1", "--d0", "0.05", "--mu", "0.5"]
    for number, source in enumerate(([cohesive], dumps, [poured[0]])):
        out = tmp_path / str(number)
        assert main(["plot", *map(str, source), "--film", "x.gif", "--dpi", "50", "--out", str(out)]) == 0
        assert capsys.readouterr().out == f"{out / 'x.gif'}\n"
        with Archive((cohesive if number < 2 else poured[0]) / "run.h5") as archive, Image.open(out / "x.gif") as picture:
            assert picture.n_frames == len(archive)  # type: ignore[attr-defined]
    assert main(["plot", str(cohesive), str(poured[0]), "--film"]) == 2
    assert "--film shows one run" in capsys.readouterr().err
