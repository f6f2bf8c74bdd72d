import re
from dataclasses import replace
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from drawn import examples
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex, to_rgb
from PIL import Image

from workflow.data.frame import Frame, Interactions
from workflow.errors import ArchiveError, InputError
from workflow.reports import canvas, network
from workflow.reports import history as histories
from workflow.reports.history import history, spread
from workflow.reports.network import LOOK, force_network
from workflow.reports.paper import Paper, on

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
    return {"step": time * 100, "time": time, "stage": 1 + (time > 4), "solid_fraction": 0.3 + time / 50,
            "stress_x": 0.01 * time, "stress_y": 0.02 * time, "net_force": np.exp(-time), "net_moment": np.zeros(101)}  # fmt: skip


@pytest.fixture
def drawn(monkeypatch):
    """The figures that would be saved."""
    caught = []
    for module in (network, histories):
        monkeypatch.setattr(module, "save", lambda figure, path: caught.append(figure))
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
        kind = "distant" if k >= 50 else "no force" if k < 10 else "compressive" if n > 0 else "tensile"
        assert LOOK[kind][0].lower() in colours[match]
        assert widths[match[0]] == pytest.approx(max(abs(n) / 2 * network.BAND * scale(drawn[0]), canvas.THINNEST))


def scale(figure):
    """Points on paper per unit of length, from the axes as they are printed."""
    return 72 * figure.get_figwidth() * figure.axes[0].get_position().width / np.diff(figure.axes[0].get_xlim())[0]


def bars(figure):
    """Length and width in points of the lines in the legend's row of scales, and their words."""
    axes = next(axes for axes in figure.axes if axes.get_label() == "scales")
    points = 72 * figure.get_figwidth() * axes.get_position().width / np.diff(axes.get_xlim())[0]
    of = [(np.ptp(line.get_xdata()) * points, line.get_linewidth()) for line in axes.lines]
    return of, [text.get_text() for text in axes.texts]


@pytest.mark.parametrize("size", [None, 86, 60, 200])
@pytest.mark.parametrize("narrow", [1.0, 0.3])
def test_bars_of_length_and_force_are_those_of_the_drawing(size, narrow, frame, drawn):
    """What the legend says of its two lines, measured on the paper; at every width, and in a narrow cell."""
    with on(Paper(size)):
        force_network(replace(frame, cell=frame.cell * (narrow, 1.0)), "x.png", force_unit=2.0, symbol="F_0")
    figure = drawn[0]
    (length, force), words = bars(figure)
    assert length[0] == pytest.approx(float(words[0].strip("$").split("\\")[0]) * scale(figure))
    said = float(words[1].removeprefix("$|N| = ").split("\\")[0])
    assert force[1] == pytest.approx(said * network.BAND * scale(figure))
    assert said <= np.abs(frame.interactions.normal_force).max() / 2
    assert figure.get_figwidth() == pytest.approx((size or 178) / 25.4)


def test_signs_are_told_apart_by_dash_as_well_as_by_colour(frame, drawn):
    """Marks and gaps of the lines; those of a kind fit into a line several times, and the legend shows the same kinds."""
    force_network(frame, "x.png")
    dashes = {}
    for lines_of in drawn[0].axes[0].collections:
        if isinstance(lines_of, LineCollection) and len(lines_of.get_segments()):
            dashes[to_hex(lines_of.get_colors()[0])] = lines_of.get_linestyles()[0][1]
    looks = {kind: dashes[colour.lower()] for kind, (colour, _) in LOOK.items()}
    assert looks["compressive"] is None and looks["tensile"] is not None and looks["distant"] is not None
    usual = np.median(frame.interactions.distance) * scale(drawn[0])
    for kind, least in (("tensile", 3), ("distant", 6)):
        assert usual / sum(looks[kind]) > least
    assert sum(looks["tensile"]) > 2 * sum(looks["distant"])


CONFUSIONS = {  # what is left of linear red, green and blue: Machado, Oliveira & Fernandes, IEEE TVCG 15, 1291 (2009)
    "none": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def lab(colour, matrix):
    """CIE L*a*b* of a colour as it is seen."""
    c = np.array(to_rgb(colour))
    linear = np.clip(np.array(matrix) @ np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4), 0, 1)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear / [0.9505, 1, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("eyes", CONFUSIONS)
def test_kinds_are_told_apart_by_every_eye(eyes):
    """25 units of CIE76, ten times what is just seen side by side: lines are thin and lie apart."""
    for (_, (one, _)), (_, (two, _)) in combinations(LOOK.items(), 2):
        assert np.linalg.norm(lab(one, CONFUSIONS[eyes]) - lab(two, CONFUSIONS[eyes])) > 25, (one, two)


def test_files_are_equal_for_equal_input(tmp_path, frame, series):
    for turn in "ab":
        force_network(frame, [tmp_path / f"n{turn}.png", tmp_path / f"n{turn}.svg"])
        history(series, [tmp_path / f"h{turn}.png", tmp_path / f"h{turn}.svg"], targets={1: 0.01, 2: None})
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
    legend = drawn[0].legends[0]
    box, page = legend.get_window_extent(), drawn[0].bbox
    assert len(legend.get_texts()) >= 4
    assert page.x0 <= box.x0 and box.x1 <= page.x1 and box.y0 >= page.y0 and box.y1 <= drawn[0].axes[0].bbox.y0


def test_history_marks_stages_imposed_stress_and_tolerance(series, drawn):
    history(series, "x.png", targets={1: None, 2: 0.05}, tolerance=1e-3, stages={1: "fall", 2: "press"})
    top, middle, bottom = drawn[0].axes
    assert [text.get_text() for text in top.texts] == ["fall", "press"]
    for axes in (top, middle, bottom):
        assert any(np.allclose(line.get_xdata(), 4.1) for line in axes.lines)
    imposed = next(line for line in middle.lines if line.get_label() == "imposed 0.05")
    assert np.nanmin(imposed.get_xdata()) == pytest.approx(4.1) and np.nanmax(imposed.get_xdata()) == 10.0
    assert any(np.allclose(line.get_ydata(), 1e-3) for line in bottom.lines) and bottom.get_yscale() == "log"
    np.testing.assert_array_equal(top.lines[0].get_ydata(), series["solid_fraction"])
    words = [text.get_text() for axes in (middle, bottom) for text in axes.get_legend().get_texts()]
    assert not [word for word in words if "_x" in word.replace("_{", "") or "net_" in word], words


@pytest.mark.parametrize("size", [None, 86])
@pytest.mark.parametrize("count", [2, 13, 24])
def test_every_stage_is_named_and_no_name_covers_another(count, size, drawn):
    """Stages of a consolidation: the first lasts nearly as long as all others together."""
    time = np.concatenate([np.linspace(0, 900, 50), 900 + np.linspace(1, 100, 20 * (count - 1))])
    stage = np.concatenate([np.ones(50), 2 + np.repeat(np.arange(count - 1), 20)])
    stress = np.where(stage > 1, 10.0 ** (stage / 3 - 3), 0.0)
    series = {"time": time, "stage": stage, "solid_fraction": time, "stress_x": stress, "stress_y": stress,
              "net_force": stress, "net_moment": stress}  # fmt: skip
    names = {k: f"settle {10 ** (k / 3 - 3):.4g}" for k in range(1, count + 1)}
    with on(Paper(size)):
        history(series, "x.png", stages=names, targets={k: 10.0 ** (k / 3 - 3) if k > 1 else None for k in names})
    figure = drawn[0]
    figure.draw_without_rendering()
    top, middle, _ = figure.axes
    assert [text.get_text() for text in top.texts] == list(names.values())
    boxes = [text.get_window_extent() for text in top.texts]
    # the box of an annotation holds its line too: the words alone are as wide as their letters are high
    x = [top.transAxes.transform(text.xyann)[0] for text in top.texts]
    height = top.texts[0].get_fontsize() * figure.dpi / 72
    assert np.diff(x).min() > 0.99 * height
    assert min(box.x0 for box in boxes) > 0 and max(box.x1 for box in boxes) < figure.bbox.x1
    assert max(box.y1 for box in boxes) <= figure.bbox.y1 + 1
    assert middle.get_yscale() == ("log" if count > 10 else "linear")


@given(middles=st.lists(st.floats(0, 1), min_size=1, max_size=30), apart=st.floats(1e-3, 1 / 30))
@examples(200)
def test_labels_keep_their_order_and_distance(middles, apart):
    places = spread(np.sort(middles), apart)
    assert (np.diff(places) >= apart * (1 - 1e-9)).all()
    assert places[0] >= 0 and places[-1] <= 1 + 1e-12


def test_labels_that_have_room_stand_at_their_middles():
    assert spread(np.array([0.1, 0.5, 0.9]), 0.1) == pytest.approx([0.1, 0.5, 0.9])


@pytest.mark.parametrize("format", ["png", "svg", "pdf"])
def test_the_matplotlibrc_of_the_user_changes_nothing(format, tmp_path, frame, series):
    """Among others TeX, which many machines lack, tight boxes, another font, size and resolution."""
    for name, theirs in (("own", {}), ("theirs", {
        "text.usetex": True, "font.size": 20, "font.family": "serif", "savefig.bbox": "tight", "savefig.dpi": 30,
        "lines.linewidth": 5, "axes.facecolor": "black", "axes.grid": True, "savefig.transparent": True,
    })):  # fmt: skip
        with mpl.rc_context(theirs):
            force_network(frame, tmp_path / f"{name}.n.{format}")
            history(series, tmp_path / f"{name}.h.{format}")
    for figure in "nh":
        assert (tmp_path / f"own.{figure}.{format}").read_bytes() == (tmp_path / f"theirs.{figure}.{format}").read_bytes()


@pytest.mark.parametrize(("size", "dpi"), [(86, 300), (178, 100), (None, None)])
def test_a_figure_has_the_width_and_the_dots_that_were_asked_for(size, dpi, tmp_path, frame, series):
    with on(Paper(size, dpi)):
        force_network(frame, [tmp_path / "n.png", tmp_path / "n.svg"])
        history(series, tmp_path / "h.png")
    for name in "nh":
        with Image.open(tmp_path / f"{name}.png") as picture:
            assert picture.size[0] == pytest.approx((size or 178) / 25.4 * (dpi or 300), abs=1)
    wide = float(re.search(r'width="([\d.]+)pt"', (tmp_path / "n.svg").read_text())[1])
    assert wide == pytest.approx((size or 178) / 25.4 * 72, rel=1e-4)


@pytest.mark.parametrize("wrong", [{"width": 5}, {"width": 1e4}, {"width": float("nan")}, {"dpi": 1}, {"dpi": 10**6},
                                   {"width": 400, "dpi": 1200}])  # fmt: skip
def test_paper_that_nobody_has_is_refused(wrong):
    with pytest.raises(InputError, match=r"--(size|dpi) .* (is not allowed|pixels)"):
        Paper(**wrong)


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
