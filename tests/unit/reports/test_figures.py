from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

from workflow.data.frame import Frame, Interactions
from workflow.errors import ArchiveError, InputError
from workflow.reports import figures
from workflow.reports.figures import force_network, history

CELL, ORIGIN = np.array([6.0, 4.0]), np.array([-2.0, 1.0])


@pytest.fixture
def frame():
    """Random grains, some outside the cell as LAMMPS leaves them, bonds of every kind, some across the edges."""
    rng = np.random.default_rng(2)
    n, m = 40, 60
    position = ORIGIN + rng.uniform(-0.05, 1.05, (n, 2)) * CELL
    i, j = np.array(np.triu_indices(n, 1))[:, rng.choice(n * (n - 1) // 2, m, replace=False)]
    branch = position[j] - position[i]
    branch -= CELL * np.round(branch / CELL)
    elastic, attraction = rng.uniform(0, 3, m), np.full(m, -1.0)
    elastic[:10] = 1.0  # contacts without force
    gap = np.where(np.arange(m) < 50, -1e-3, 1e-4)
    elastic[50:] = 0
    zero = np.zeros(m)
    table = Interactions(i, j, branch, gap, elastic, zero, attraction, zero, zero, zero, zero, zero > 0, zero > 0)
    d = rng.uniform(0.5, 1, n)
    zeros = np.zeros((n, 2))
    return Frame(0, 1.5, "", ORIGIN, CELL, np.arange(n), d, d**2, position, zeros, zero[:n], zeros, zero[:n], table)


@pytest.fixture
def series():
    time = np.linspace(0, 10, 101)
    return {"step": time * 100, "time": time, "stage": 1 + (time > 4), "phi": 0.3 + time / 50, "sxx": 0.01 * time,
            "syy": 0.02 * time, "fmax": np.exp(-time), "mmax": np.zeros(101)}  # fmt: skip


@pytest.fixture
def drawn(monkeypatch):
    """The figures that would be saved."""
    caught = []
    monkeypatch.setattr(figures, "save", lambda figure, path: caught.append(figure))
    return caught


def lines(figure):
    """(segments (M, 2, 2), widths, colours) over all force lines."""
    found = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    segments = [s for c in found for s in c.get_segments()]
    widths = np.concatenate([np.broadcast_to(c.get_linewidths(), len(c.get_segments())) for c in found])
    colours = [to_hex(c.get_colors()[0]) for c in found for _ in c.get_segments()]
    return np.array(segments), widths, np.array(colours)


def test_no_line_runs_across_the_cell_and_both_ends_are_seen(frame, drawn):
    force_network(frame, "x.png")
    segments, _, _ = lines(drawn[0])
    longest = frame.interactions.distance.max()
    lengths = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    assert lengths.max() <= longest + 1e-12  # rounding of a difference
    ends = segments.reshape(-1, 2)
    inside = ((ends > ORIGIN - 1e-12) & (ends < ORIGIN + CELL + 1e-12)).all(axis=1)
    # Every interaction shows each of its two ends exactly once inside the cell.
    assert inside.sum() == 2 * len(frame.interactions)


def test_width_is_proportional_to_force_and_colour_tells_the_kind(frame, drawn):
    force_network(frame, "x.png", force_unit=2.0)
    segments, widths, colours = lines(drawn[0])
    table = frame.interactions
    starts = ORIGIN + np.mod(frame.position[table.i] - ORIGIN, CELL)
    for k in range(len(table)):
        match = np.flatnonzero(np.abs(segments[:, 0] - starts[k]).sum(axis=1)
                               + np.abs(segments[:, 1] - starts[k] - table.branch[k]).sum(axis=1) < 1e-9)  # fmt: skip
        n = table.normal_force[k]
        kind = figures.BLUE if k >= 50 else figures.INK if k < 10 else figures.RED if n > 0 else figures.GREEN
        assert kind.lower() in colours[match]
        points = 72 * figures.LONG_SIDE / 6
        assert widths[match[0]] == pytest.approx(max(abs(n) / 2 * figures.BAND * points, figures.THINNEST))


def test_files_are_equal_for_equal_input(tmp_path, frame, series):
    for turn in "ab":
        force_network(frame, [tmp_path / f"n{turn}.png", tmp_path / f"n{turn}.svg"])
        history(series, [tmp_path / f"h{turn}.png", tmp_path / f"h{turn}.svg"], targets=(0.01, None))
    for kind in ("n{}.png", "n{}.svg", "h{}.png", "h{}.svg"):
        first, second = ((tmp_path / kind.format(turn)).read_bytes() for turn in "ab")
        assert first == second and len(first) > 1000
    assert len(list(tmp_path.iterdir())) == 8


def test_a_frame_without_interactions_is_drawn(tmp_path, frame):
    nothing = frame.interactions.select(np.zeros(60, bool))
    force_network(Frame(**{**vars(frame), "interactions": nothing}), tmp_path / "gas.png")
    assert (tmp_path / "gas.png").stat().st_size > 1000


def test_the_legend_stays_on_the_sheet_of_a_narrow_cell(frame, drawn):
    tall = replace(frame, cell=frame.cell * (0.4, 1.0))
    force_network(tall, "x.png")
    legend = drawn[0].axes[0].get_legend()
    box, page = legend.get_window_extent(), drawn[0].bbox
    assert len(legend.get_texts()) >= 4
    assert page.x0 <= box.x0 and box.x1 <= page.x1 and box.y0 >= page.y0 and box.y1 <= drawn[0].axes[0].bbox.y0


def test_history_marks_stages_targets_and_tolerance(series, drawn):
    history(series, "x.png", targets=(0.05, None), tolerance=1e-3, stages={1: "fall", 2: "press"})
    top, middle, bottom = drawn[0].axes
    assert [text.get_text() for text in top.texts] == ["fall", "press"]
    for axes in (top, middle, bottom):
        assert any(np.allclose(line.get_xdata(), 4.1) for line in axes.lines)
    assert any(np.allclose(line.get_ydata(), 0.05) for line in middle.lines)
    assert any(np.allclose(line.get_ydata(), 1e-3) for line in bottom.lines) and bottom.get_yscale() == "log"
    np.testing.assert_array_equal(top.lines[0].get_ydata(), series["phi"])


def test_bad_requests(tmp_path, frame, series):
    with pytest.raises(InputError, match=r"suffix '\.bmp'"):
        force_network(frame, [tmp_path / "x.png", tmp_path / "x.bmp"])
    with pytest.raises(InputError, match="force_unit is 0"):
        force_network(frame, tmp_path / "x.png", force_unit=0)
    with pytest.raises(InputError, match="column 'density' is missing"):
        history(series, tmp_path / "x.png", density="density")
    with pytest.raises(InputError, match="no rows"):
        history({name: values[:0] for name, values in series.items()}, tmp_path / "x.png")
    with pytest.raises(ArchiveError, match="cannot write"):
        history(series, tmp_path / "absent" / "x.png")
    assert not list(tmp_path.iterdir())
