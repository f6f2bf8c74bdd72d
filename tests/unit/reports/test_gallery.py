"""Every figure is drawn from frames, and shows what it says."""

import subprocess
import sys
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from matplotlib import colors
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection

from workflow.data.build import make_frame
from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.measures.holes import hole_triangles
from workflow.measures.modes import floppy_modes, mobility
from workflow.measures.registry import Settings
from workflow.measures.synthetic import ballistic_aggregate
from workflow.reports import charts, figures, maps, network, triangles
from workflow.reports.of_frames import MOST_DRAWN
from workflow.reports.registry import FIGURES, STUDY, figures_of
from workflow.reproduce import figures as of_papers
from workflow.reproduce import sketches
from workflow.scene.registry import SCENES
from workflow.verification import figures as of_studies

PLOTS = FIGURES["network"]
LAW = Settings(ContactLaw(kn=1.0, kt=1.0, mu=0.5, f0=1.0))


def lattice(seed: int = 0, side: int = 8, missing: int = 12):
    """A square lattice of touching discs with holes in it, and random forces."""
    rng = np.random.default_rng(seed)
    x, y = (axis.ravel() for axis in np.mgrid[:side, :side])
    kept = np.sort(rng.choice(side**2, side**2 - missing, replace=False))
    frame = make_frame(np.column_stack((x, y))[kept], 1.0 + 1e-6, (side, side))
    table, rows = frame.interactions, len(frame.interactions)
    pairs = {"i": table.i, "j": table.j, "branch": table.branch, "gap": table.gap,
             "normal": rng.normal(size=rows), "tangential": rng.normal(size=rows)}  # fmt: skip
    return make_frame(frame.position, frame.diameter, frame.cell, pairs)


def rhombus(strength: float = 0.1):
    """Discs 0 and 1 one above the other, 2 and 3 at their sides, alone in a large cell, with self-balanced forces: on each
    of the latter two vertical ones of ``strength`` through its contacts, so that 0 and 1 are pulled apart by twice that."""
    high = np.sqrt(0.75)
    place = np.array([[0.0, -0.5], [0.0, 0.5], [-high, 0.0], [high, 0.0]]) + 4.0
    i, j = np.array([2, 2, 3, 3, 0]), np.array([0, 1, 0, 1, 1])
    force = strength * np.array([[0, -1], [0, 1], [0, -1], [0, 1], [0, -2]])  # of i on j
    n = place[j] - place[i]
    pairs = {"i": i, "j": j, "normal": (force * n).sum(1), "tangential": force[:, 1] * n[:, 0] - force[:, 0] * n[:, 1]}
    return make_frame(place, 1.0 + 1e-6, (8.0, 8.0), pairs)


@pytest.fixture
def drawn(monkeypatch):
    """The figures that would be saved."""
    caught = []
    for module in (network, maps, charts, triangles):
        monkeypatch.setattr(module, "save", lambda figure, path: caught.append(figure))
    return caught


def test_every_figure_has_a_function_that_draws_it():
    """The registry names functions without importing them: a misspelt one would show first when somebody draws."""
    assert {of_papers.SKETCH, "accuracy"} <= set(FIGURES) and of_studies.FIGURES is FIGURES
    for group in FIGURES.values():
        for figure in group.values():
            place = dict(zip(figure.draw.__code__.co_freevars, figure.draw.__closure__, strict=True))
            module, name = (place[word].cell_contents for word in ("module", "name"))
            assert callable(getattr(import_module(module), name))
            assert figure.meaning


def test_names_of_figures_are_known_without_matplotlib():
    words = "import sys; from workflow.cli.main import parser; parser(); print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_figures_of_a_scene_are_registered(scene):
    found = figures_of(scene.figures)
    assert any(figure.unasked for figure in found.values())
    assert all(figure.of != STUDY for figure in found.values())


def test_a_group_of_figures_that_nobody_registered_is_named():
    with pytest.raises(InputError, match="'weather' is no group of figures"):
        figures_of(("network", "weather"))


@pytest.mark.parametrize("name", PLOTS)
def test_every_figure_is_drawn(name, tmp_path):
    samples = [(lattice(seed), LAW) for seed in range(2 if PLOTS[name].several else 1)]
    if name == "hole_sizes":
        samples = [(lattice(seed, missing=3), LAW) for seed in range(2)]
    if "triangle" in name:
        samples = [(rhombus(), LAW)]
    PLOTS[name].draw(samples, [tmp_path / "figure.png"])
    assert (tmp_path / "figure.png").stat().st_size > 5000


def test_unstressed_contacts_are_thin_and_dark_and_their_grains_grey(drawn):
    """Of three in a row the first contact carries a force: only the last grain is without."""
    pairs = {"i": [0, 1], "j": [1, 2], "normal": [0.5, 1e-6]}
    frame = make_frame([[1.0, 1], [2, 1], [3, 1]], 1.0, (6, 6), pairs)
    PLOTS["stressed"].draw([(frame, LAW)], ["x.png"])
    lines = [c for c in drawn[0].axes[0].collections if isinstance(c, LineCollection) and len(c.get_segments())]
    assert {colors.to_hex(c.get_colors()[0]) for c in lines} == {figures.RED.lower(), figures.INK}
    fill = next(c for c in drawn[0].axes[0].collections if isinstance(c, EllipseCollection) and len(c.get_facecolors()) == 3)
    assert [colors.to_hex(c) for c in fill.get_facecolors()] == [c.lower() for c in (*[figures.FILL] * 2, figures.RATTLER)]


def test_triangles_of_the_hole_map_cover_the_holes(drawn):
    """The triangles of a hole less the disc sectors are its area; all triangles together are the cell."""
    frame = lattice(3, missing=3)
    found, corners, hole = hole_triangles(frame)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert area.sum() == pytest.approx(frame.area, rel=1e-6)  # the nudge of a degenerate lattice
    assert hole.max() == len(found.area) - 1
    discs = np.pi / 4 * frame.grains
    assert area[hole >= 0].sum() - discs == pytest.approx(found.area.sum(), rel=1e-4)  # overlaps of 1e-6
    PLOTS["holes"].draw([(frame, LAW)], ["x.png"])
    patches = [c for c in drawn[0].axes[0].collections if isinstance(c, PolyCollection)]
    assert sum(len(c.get_paths()) for c in patches) >= (hole >= 0).sum()


def test_arrows_of_a_mechanism_are_on_the_grains_that_can_move():
    """A rigid lattice with one grain that hangs on a single contact: it alone moves, and around its neighbour."""
    side = 6
    x, y = (axis.ravel() for axis in np.mgrid[:side, :side])
    hexagons = np.column_stack((x + 0.5 * (y % 2), y * np.sqrt(0.75)))
    cell = np.array([side, side * np.sqrt(0.75)])
    place = np.vstack((np.delete(hexagons, 14, axis=0), [hexagons[14]]))
    frame = make_frame(place, np.append(np.full(35, 1.0 + 1e-6), 0.5), cell)
    pairs = frame.interactions
    table = {"i": np.append(pairs.i, 13), "j": np.append(pairs.j, 35)}
    frame = make_frame(place, frame.diameter, cell, table)
    motion = maps.own_motions(frame, mobility(frame), floppy_modes(frame))
    assert (np.hypot(*motion[:-1].T) < 0.2).all()
    assert np.hypot(*motion[-1]) == pytest.approx(1.0)
    branch = frame.interactions.branch[-1] / np.hypot(*frame.interactions.branch[-1])
    assert abs(motion[-1] @ branch) < 1e-6  # rolls about its neighbour without coming nearer


def test_forces_of_the_triangles_lie_on_their_lines(drawn):
    """Bars of the forces on D and D' run along the dotted lines, here upright; the one between 1 and 2 is twice as long."""
    PLOTS["double_triangle"].draw([(rhombus(), LAW)], ["x.png"])
    axes = drawn[0].axes[0]
    bars = np.array([line.get_xydata() for line in axes.lines if line.get_linewidth() == 2.5])
    length = np.abs(bars[:, 1] - bars[:, 0])
    assert length[:, 0] == pytest.approx(0.0, abs=1e-9)
    assert np.sort(length[:, 1]) / length[:, 1].min() == pytest.approx([1, 1, 1, 1, 2])
    dotted = [line.get_xy1()[0] for line in axes.lines if hasattr(line, "get_xy1") and line.get_linestyle() == "--"]
    assert np.ptp(dotted) == pytest.approx(np.sqrt(0.75), rel=1e-5)  # the discs overlap by 1e-6
    PLOTS["triangle"].draw([(rhombus(), LAW)], ["x.png"])
    assert drawn[1].axes[0].get_title() == "$|T/N|$ = 1.732, 1.732; eq. 20: 1.732"


def test_sketches_show_the_laws():
    """G07 eqs. 4, 5: -F0 at contact, 0 at h = D0 and at -F0/K_N.  B97: 1 mg at r = sigma; Hooke's law does the same work."""
    law = sketches.CohesiveLaw(kn=1e3, f0=1.0, d0=1e-3)
    force = sketches.normal_force(law, np.array([0.0, 0.5e-3, 1e-3, 2e-3, -1e-3]))
    assert force == pytest.approx([-1.0, -0.5, 0.0, 0.0, 0.0], abs=1e-12)
    gap = np.linspace(sketches.CLOSEST - 1.0, 0.2, 20001)[:-1]
    smooth = sketches.ContinuousLaw()
    hooke = sketches.ContinuousLaw(stiffness=sketches.equivalent_stiffness(36, 1.2, sketches.CLOSEST))
    work = [np.trapezoid(sketches.normal_force(one, gap), gap) for one in (smooth, hooke)]
    assert work[0] == pytest.approx(work[1], rel=1e-3)
    assert sketches.normal_force(smooth, np.zeros(1)) == pytest.approx(1.0)


def test_the_fourth_disc_closes_a_fifth_contact(monkeypatch, tmp_path):
    """It touches one disc, rolls on it with the contact closed, and meets the other: the double triangle of G07 fig. 13."""
    run = sketches.fourth_disc()
    assert [event.pair for event in run.events if event.kind == "close"] == [(1, 3), (0, 3)]
    assert not run.times_of("open")
    assert int((run.gap[-1] < 0).sum()) == 5
    monkeypatch.setattr(sketches, "fourth_disc", lambda: run)
    FIGURES["sketch"]["fourth_disc"].draw(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 5000


def test_the_intensity_is_drawn_with_its_fit(drawn):
    rng = np.random.default_rng(0)
    frames = [make_frame(ballistic_aggregate(256, rng), 0.999, (120.0, 120.0)) for _ in range(4)]
    PLOTS["scattering"].draw([(frame, replace(LAW, window=(0.05, 1.5))) for frame in frames], ["x.png"])
    axes = drawn[0].axes[0]
    assert axes.get_xscale() == axes.get_yscale() == "log"
    label = axes.get_legend_handles_labels()[1]
    assert any("d_F" in text for text in label), label


@pytest.mark.parametrize("name", ["scattering", "correlation"])
def test_a_figure_without_its_fit_says_why(name, drawn):
    """A dense lattice has no fractal range."""
    PLOTS[name].draw([(lattice(missing=0), LAW)], ["x.png"])
    title = drawn[0].axes[0].get_title().replace("\n", " ")
    assert "no curve" in title and ("fit of eq. 28" in title or "shells" in title), title


def test_what_cannot_be_drawn_is_said(tmp_path):
    alone = make_frame([[1.0, 1.0]], 1.0, (6.0, 6.0))
    for name in ("floppy", "hole_sizes", "distribution", "triangle", "double_triangle"):
        with pytest.raises(InputError):
            PLOTS[name].draw([(alone, LAW)], [tmp_path / "x.png"])
    assert not list(tmp_path.iterdir())
    assert MOST_DRAWN > 0
