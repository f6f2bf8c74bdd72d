"""Films: every frame is in them, on one scale, and they are there as a whole or not at all."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image

from workflow.data.build import make_frame
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Frame
from workflow.errors import EnvironmentFault, InputError
from workflow.measures.registry import Settings
from workflow.reports import film as films
from workflow.reports.film import film
from workflow.reports.paper import Paper, on

LAW = Settings(ContactLaw(kn=1.0, kt=1.0, mu=0.5, f0=1.0))


@dataclass(frozen=True)
class Frames:
    """A source of frames in memory, as the dumps of another program are one."""

    every: Sequence[Frame]
    folder: Path
    name: str = "frames"
    run: Any = None

    def frame(self) -> tuple[Frame, Settings]:
        return self.every[-1], LAW

    def frames(self) -> Sequence[Frame]:
        return self.every


def shrinking(count: int) -> list[Frame]:
    """Three discs in a cell that gets smaller; the force between two of them grows, the third is a rattler."""
    frames = []
    for k in range(count):
        side = 6.0 - 2.0 * k / max(count - 1, 1)
        pairs = {"i": [0], "j": [1], "normal": [0.1 + 0.1 * k]}
        one = make_frame([[1.0, 1.0], [2.0, 1.0], [1.0, 3.0]], 1.001, (side, side), pairs)
        frames.append(replace(one, step=k, time=float(k), stage="compress"))
    return frames


def test_a_gif_has_every_frame_and_lasts(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    made = film(Frames(shrinking(5), tmp_path), tmp_path / "x.gif", said=lambda *words: told.append(words))
    with Image.open(made) as picture:
        assert (picture.n_frames, picture.format) == (5, "GIF")  # type: ignore[attr-defined]
        assert picture.info["duration"] == 500  # two frames a second at least
        pictures = []
        for k in range(5):
            picture.seek(k)
            pictures.append(np.asarray(picture.convert("RGB"), dtype=int))
    assert told == [(k, 5) for k in range(1, 6)]
    assert [path.name for path in tmp_path.iterdir()] == ["x.gif"]
    red = [int(((p[..., 0] > 120) & (p[..., 1] < 60) & (p[..., 2] < 70)).sum()) for p in pictures]
    key = red[0]  # pixels of the legend, and of the first force
    assert np.diff(red).min() > 0 and red[-1] > key, red


def test_all_frames_have_one_scale(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Points per length are those of the largest cell; a smaller one keeps its middle in the middle."""
    seen = []
    monkeypatch.setattr(films, "_gif", lambda figure, frames, draft, rate: [seen.append(look(figure)) for _ in frames])
    with pytest.raises(Exception, match="cannot write"):  # nothing was written
        film(Frames(shrinking(4), tmp_path), tmp_path / "x.gif")
    spans, middles, widths = (np.array(column) for column in zip(*seen, strict=True))
    assert spans == pytest.approx(6.0)
    sides = np.array([float(frame.cell[0]) for frame in shrinking(4)])
    assert middles == pytest.approx(sides / 2)
    assert widths / widths[0] == pytest.approx([1.0, 2.0, 3.0, 4.0])


def look(figure: Any) -> tuple[float, float, float]:
    """Span and middle of the axes, width of the one line."""
    axes = figure.axes[0]
    low, high = axes.get_xlim()
    lines = [c for c in axes.collections if hasattr(c, "get_segments") and len(c.get_segments())]
    return high - low, (low + high) / 2, float(lines[0].get_linewidths()[0])


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not installed")
def test_an_mp4_has_every_frame(tmp_path: Path) -> None:
    made = film(Frames(shrinking(5), tmp_path), tmp_path / "x.mp4")
    said = subprocess.run(["ffmpeg", "-i", made, "-f", "null", "-"], capture_output=True, text=True, check=True).stderr
    assert "h264" in said and "yuv420p" in said and "frame=    5" in said
    assert [path.name for path in tmp_path.iterdir()] == ["x.mp4"]


FAKE = """#!{python}
import sys
{does}
"""


def fake_ffmpeg(folder: Path, does: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program called ffmpeg on the path that ``does`` something; it answers the question for its version."""
    (folder / "bin").mkdir()
    program = folder / "bin" / "ffmpeg"
    program.write_text(FAKE.format(python=sys.executable, does=does))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder / "bin"), prepend=":")


def test_mp4_is_piped_to_ffmpeg_and_named_when_it_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in keeps what it is sent: raw pictures of one size, as many as there are frames."""
    fake_ffmpeg(tmp_path, "open(sys.argv[-1], 'wb').write(' '.join(sys.argv).encode() + b'\\n' + sys.stdin.buffer.read())",
                monkeypatch)  # fmt: skip
    with on(Paper(86, 100)):
        made = film(Frames(shrinking(3), tmp_path), tmp_path / "x.mp4")
    words, _, raw = made.read_bytes().partition(b"\n")
    wide, high = map(int, words.split(b"-s ")[1].split()[0].split(b"x"))
    assert wide % 2 == high % 2 == 0 and wide == pytest.approx(86 / 25.4 * 100, abs=2)
    assert len(raw) == 3 * wide * high * 4
    assert b"-f mp4" in words and b"yuv420p" in words
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bin", "x.mp4"]


@pytest.mark.parametrize("does", ["sys.exit('no such codec')", "sys.stdin.buffer.read(); sys.exit('no such codec')"])
def test_an_ffmpeg_that_fails_is_quoted_and_leaves_nothing(does: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_ffmpeg(tmp_path, does, monkeypatch)
    (tmp_path / "x.mp4").write_text("the film before")
    with pytest.raises(EnvironmentFault, match=r"ffmpeg stopped: .*\.gif"):
        film(Frames(shrinking(3), tmp_path), tmp_path / "x.mp4")
    assert (tmp_path / "x.mp4").read_text() == "the film before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bin", "x.mp4"]


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_an_interrupt_leaves_nothing(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a terminal ffmpeg gets the interrupt too, and ends with an error."""
    fake_ffmpeg(tmp_path, "sys.stdin.buffer.read(); sys.exit(255)", monkeypatch)

    def interrupt(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        film(Frames(shrinking(4), tmp_path), tmp_path / f"x{suffix}", said=interrupt)
    assert [path.name for path in tmp_path.iterdir()] == ["bin"]


def test_without_ffmpeg_the_film_is_a_gif(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert film(Frames(shrinking(2), tmp_path)).name == "film.gif"
    with pytest.raises(EnvironmentFault, match=r"ffmpeg, which is not installed.*\.gif"):
        film(Frames(shrinking(2), tmp_path), tmp_path / "x.mp4")
    assert shutil.which("ffmpeg") is None


def test_what_is_no_film_is_said(tmp_path: Path) -> None:
    for name in ("x.avi", "x", "x.png"):
        with pytest.raises(InputError, match=r"use \.mp4 or \.gif"):
            film(Frames(shrinking(2), tmp_path), tmp_path / name)
    with pytest.raises(InputError, match="two frames or more, there is 1"):
        film(Frames(shrinking(1), tmp_path), tmp_path / "x.gif")
    assert not list(tmp_path.iterdir())
