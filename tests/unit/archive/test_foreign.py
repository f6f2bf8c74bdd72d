"""Dumps of other programs and MDAnalysis Universes."""

import foreign_files as files
import MDAnalysis
import numpy as np
import pytest
from foreign_files import MU, Way, packing
from lammps_text import NUMBERED, contacts_text, grains_text
from MDAnalysis.analysis.rdf import InterRDF

from workflow.archive.columns import Reading
from workflow.archive.dumps import CONTACT_COLUMNS, read_frames
from workflow.archive.foreign import Sample, foreign_frames, universe_frame
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Frame, Interactions
from workflow.errors import ArchiveError, InputError
from workflow.measures.clusters import pair_correlation
from workflow.measures.network import degrees, rigidity_matrix, row_owners
from workflow.measures.packing import measure, stress_parts
from workflow.measures.registry import Settings, measure_groups, slipping

CELL = "ITEM: BOX BOUNDS pp pp pp\n0 10\n0 8\n-0.5 0.5\n"
HEAD = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF {0}\n{1}\n" + CELL + "ITEM: {0} {2}\n"
GRAINS = HEAD.format("ATOMS", 3, "id radius x y") + "3 0.5 9.6 1\n1 0.5 0.4 1\n2 0.5 1.2 1.5\n"


def tilted(text: str, xy: str) -> str:
    """With the box of a triclinic cell."""
    for face in ("0 10", "0 8", "-0.5 0.5"):
        text = text.replace(f"\n{face}\n", f"\n{face} {xy if face == '0 10' else 0}\n")
    return text.replace("BOUNDS pp", "BOUNDS xy xz yz pp")


@pytest.fixture
def write(tmp_path):
    def files(grains, contacts=None):
        (tmp_path / "grains").write_text(grains)
        if contacts is None:
            return (tmp_path / "grains",)
        (tmp_path / "contacts").write_text(contacts)
        return tmp_path / "grains", tmp_path / "contacts"

    return files


def pairs(columns: str, *rows: str) -> str:
    return HEAD.format("ENTRIES", len(rows), columns) + "".join(f"{row}\n" for row in rows)


def plausible_frame():
    """Discs on a lattice with random numbers in every column that geometry leaves free."""
    p, rng = packing(1), np.random.default_rng(1)
    count, grains = len(p.i), len(p.ids)
    gap = np.hypot(*p.branch.T) - p.radius[p.i] - p.radius[p.j]
    table = Interactions(p.i, p.j, p.branch, gap, *rng.normal(size=(7, count)), *(rng.random((2, count)) > 0.5))
    return Frame(1000, 0.1, "", p.position.min(axis=0) - 0.1, p.cell, p.ids, 2 * p.radius, p.mass, p.position, p.velocity, p.omega,
                 rng.normal(size=(grains, 2)), rng.normal(size=grains), table)  # fmt: skip


@pytest.mark.parametrize(
    "columns", [range(15), (4, 3, 14, 0, 9, 6, 1, 13, 2, 12, 5, 11, 7, 10, 8)], ids=["in order", "permuted"]
)
@pytest.mark.parametrize("of_version", ["0.2", "now"])
def test_dumps_of_this_package_are_read_alike(of_version, columns, tmp_path):
    """By their names in any order; the numbered columns of version 0.2 in a run directory only."""
    frame = plausible_frame()
    count = len(frame.interactions)
    names = CONTACT_COLUMNS if of_version == "now" else NUMBERED
    text = contacts_text(frame, swap=range(0, count, 3), idle=2, names=names, columns=columns)
    paths = tmp_path / "grains.dump", tmp_path / "contacts.dump"
    for path, content in zip(paths, (grains_text(frame), text), strict=True):
        path.write_text(content)
    if of_version == "0.2":
        with pytest.raises(ArchiveError, match="column id_i, id_j missing in c_pairs"):
            next(foreign_frames(*paths))
        (tmp_path / "run.json").write_text('{"digest": "a run"}')
    own, foreign = next(read_frames(*paths)), next(foreign_frames(*paths))
    for name in ("i", "j", "branch", "gap", "elastic", "viscous", "attraction", "tangential", "moment", "xi_t", "xi_r",
                 "sliding", "rolling"):  # fmt: skip
        np.testing.assert_array_equal(getattr(foreign.interactions, name), getattr(own.interactions, name), name)
    assert not foreign.lacks
    for name in ("ids", "diameter", "mass", "position", "velocity", "omega", "force", "torque", "cell", "origin"):
        np.testing.assert_array_equal(getattr(foreign, name), getattr(own, name), name)


def test_without_contacts_the_overlaps_count(write):
    frame = next(foreign_frames(*write("ITEM: UNITS\nlj\n" + GRAINS)))
    assert frame.step == 7
    assert frame.ids.tolist() == [1, 2, 3]
    assert frame.diameter.tolist() == [1.0, 1.0, 1.0]
    assert list(zip(frame.interactions.i.tolist(), frame.interactions.j.tolist(), strict=True)) == [(0, 1), (0, 2)]


@pytest.mark.parametrize("row", ["1 3 2.0 0.5", "3 1 -2.0 -0.5"])
def test_force_on_the_first_grain_becomes_normal_and_tangential(write, row):
    """Grain 3 is to the left of 1 through the cell's edge and pushes it to the right with 2, upwards with 0.5."""
    table = next(foreign_frames(*write(GRAINS, pairs("id_i id_j fx fy", row)))).interactions
    assert table.branch[0] == pytest.approx([-0.8, 0.0])
    assert table.normal_force == pytest.approx([2.0])
    assert table.force[0] == pytest.approx([-2.0, -0.5])  # of 1 on 3


def test_tangential_part_in_columns_of_its_own_is_added(write):
    table = next(foreign_frames(*write(GRAINS, pairs("id_i id_j fx fy tx ty", "1 3 2.0 0 0 0.5")))).interactions
    assert table.force[0] == pytest.approx([-2.0, -0.5])


def test_columns_can_be_renamed(write):
    paths = write(GRAINS.replace("radius", "c_r"), pairs("c_1[1] c_1[2] c_2[1]", "2 1 3.5"))
    names = {"radius": "c_r", "id_i": "c_1[1]", "id_j": "c_1[2]", "normal": "c_2[1]"}
    frame = next(foreign_frames(*paths, names=names))
    assert frame.interactions.normal_force.tolist() == [3.5]


@pytest.mark.parametrize(
    ("grains", "contacts", "message"),
    [
        (GRAINS.replace("radius", "type"), None, "needed are id, x y .* diameter or radius"),
        (GRAINS, pairs("a b fx fy", "1 3 1 1"), "column id_i, id_j missing in a b fx fy"),
        (GRAINS, pairs("id_i id_j fx fy", "1 9 1 1"), "grain id 9"),
        (GRAINS.replace("\n2 0.5", "\n1 0.5"), None, "id 1 occurs twice"),
        (tilted(GRAINS, "0.5"), None, "line 8: the box is tilted"),
        (GRAINS.replace("pp pp pp", "abc origin"), None, "three vectors"),
        (GRAINS.replace("0 8", "8 0"), None, "a side must be longer than 0"),
        (GRAINS.replace("\n2 0.5", "\n2 x.5"), None, "line 12, column 2 \\(radius\\): found 'x.5'"),
        (GRAINS.replace("\n2 0.5", "\n2 0.5 7"), None, "line 12: 5 words, expected 4"),
        (GRAINS, pairs("id_i id_j fx fx", "1 3 1 1"), "column 'fx' .* is there 2 times"),
        (GRAINS, pairs("id_i id_j fx fy", "1 1 1 1"), "grain 1 touches itself"),
    ],
)
def test_what_is_missing_is_named(write, grains, contacts, message):
    with pytest.raises(ArchiveError, match=message):
        next(foreign_frames(*write(grains, contacts)))


def test_steps_without_contacts_are_left_out(write):
    later = GRAINS.replace("\n7\n", "\n8\n")
    frames = list(foreign_frames(*write(GRAINS + later, pairs("id_i id_j normal", "1 2 1").replace("\n7\n", "\n8\n"))))
    assert [frame.step for frame in frames] == [8]


def test_a_box_that_could_tilt_and_does_not_is_a_rectangle(write):
    flat = next(foreign_frames(*write(tilted(GRAINS, "0"))))
    assert flat.cell.tolist() == [10.0, 8.0] and len(flat.interactions) == 2


@pytest.mark.parametrize(("faces", "touching"), [("pp ff pp", 2), ("ff pp pp", 1), ("ss sm pp", 1)])
def test_nothing_is_wrapped_where_there_are_walls(write, faces, touching):
    """Grains 1 and 3 touch through the faces of x; groups that need a periodic cell are undefined."""
    frame = next(foreign_frames(*write(GRAINS.replace("pp pp pp", faces)), friction=0.0))
    assert len(frame.interactions) == touching
    assert "the box has walls" in "\n".join(frame.notes)
    law = Settings(ContactLaw(1.0, 1.0, mu=0.0))
    found = measure_groups(frame, law, ["rigidity", "holes", "pair_correlation", "density", "clusters"])
    for name in ("rigidity", "holes", "pair_correlation", "density"):
        assert "walls" in found[name]["error"], name
    assert found["clusters"]["aggregates"]["number"] == 3 - touching


def test_contacts_slide_where_the_coulomb_limit_is_reached(write):
    """Without flags in the file: |T| >= mu N (1 - 1e-3); without mu nobody knows."""
    rows = ["1 2 1.0 0.3", "1 3 2.0 -0.599"]
    paths = write(GRAINS, pairs("id_i id_j normal tangential", *rows))
    assert next(foreign_frames(*paths, friction=0.3)).interactions.sliding.tolist() == [True, False]
    assert "sliding" in next(foreign_frames(*paths)).lacks
    flagged = write(GRAINS, pairs("id_i id_j normal tangential sliding", *(f"{row} {k}" for k, row in enumerate(rows))))
    assert next(foreign_frames(*flagged, friction=0.3)).interactions.sliding.tolist() == [False, True]
    small = next(foreign_frames(*paths, friction=0.2))
    assert "|T| exceeds mu N in 2 of 2 contacts" in "\n".join(small.notes)


def test_with_an_attraction_contacts_are_cohesive_whatever_the_sign_of_their_force(write):
    """--f0 1: N = N_e - 1 in contact, the whole force at a distance; every interaction then holds."""
    paths = write(GRAINS, pairs("id_i id_j normal tangential", "1 2 1.0 0", "1 3 2.0 0.1"))
    frame = Sample([paths[0]], [paths[1]], Reading(friction=0.3, attraction=1.0)).frame(0)
    assert frame.interactions.attraction.tolist() == [-1.0, -1.0]
    assert frame.interactions.normal_force.tolist() == [1.0, 2.0] and frame.interactions.elastic.tolist() == [2.0, 3.0]
    assert measure(frame, force_unit=1.0)["rattler_fraction"] == 0.0
    plain = next(foreign_frames(*paths, friction=0.3))
    assert not plain.interactions.attraction.any() and measure(plain, force_unit=1.0)["rattler_fraction"] == 1.0


def test_sliding_contacts_count_once_in_the_pebble_game(write):
    rows = ["1 2 1.0 0.3", "1 3 2.0 0.1"]
    frame = next(foreign_frames(*write(GRAINS, pairs("id_i id_j normal tangential", *rows)), friction=0.3))
    law = Settings(ContactLaw(1.0, 1.0, mu=0.3))
    assert measure_groups(frame, law, ["rigid_clusters"])["rigid_clusters"]["independent"] == 3  # 1 and 2 bars


def test_sliding_contacts_lose_their_tangential_row_in_the_rigidity_matrix(tmp_path):
    """H and k by the singular values of the matrix without these rows."""
    p = packing(3)
    paths = [
        files.write(tmp_path, name, [text(p, Way())]) for name, text in (("g", files.grains_text), ("c", files.contacts_text))
    ]
    frame = next(foreign_frames(*paths, friction=MU))
    book = degrees(frame, friction=True, free_cell=True)
    matrix, owner = rigidity_matrix(frame, book).toarray(), row_owners(frame, book)
    tangential = np.arange(len(owner)) >= len(frame.interactions)
    kept = matrix[~(tangential & p.slides[owner])]
    rank = np.linalg.matrix_rank(kept, tol=1e-9)
    found = slipping(frame, Settings(ContactLaw(1.0, 1.0, mu=MU)))
    assert found == {"contacts": p.slides.sum(), "hyperstaticity": kept.shape[0] - rank, "floppy_modes": kept.shape[1] - rank}


def test_a_force_along_the_branch_alone_says_nothing_of_the_tangential_one(write):
    """As compute pair/local gives it without p1 p2, unless the law has no friction."""
    paths = write(GRAINS, pairs("id_i id_j fx fy", "3 1 -2.0 0"))
    assert "tangential" in next(foreign_frames(*paths)).lacks
    assert "tangential" not in next(foreign_frames(*paths, friction=0.0)).lacks
    both = stress_parts(next(foreign_frames(*paths)))["contacts"]
    assert both["pressure"] == pytest.approx(2.0 * 0.8 / (2 * 80)) and both["xx"] is None


def test_a_tangential_part_that_is_there_already_is_not_added_twice(write):
    with pytest.raises(ArchiveError, match="hold the tangential part; leave tx ty out"):
        next(foreign_frames(*write(GRAINS, pairs("id_i id_j fx fy tx ty", "1 3 2.0 0.5 0 0.5"))))
    paths = write(GRAINS, pairs("id_i id_j c_f[1] c_f[2] tx ty", "1 3 2.0 0.5 0 0.5"))
    named = next(foreign_frames(*paths, names={"fx": "c_f[1]", "fy": "c_f[2]"}))
    assert named.interactions.force[0] == pytest.approx([-2.0, -0.5])  # what the user names counts


def test_neighbours_that_do_not_touch_are_no_contacts(write):
    frame = next(foreign_frames(*write(GRAINS, pairs("id_i id_j normal tangential", "1 3 2.0 0", "2 3 0 0"))))
    assert len(frame.interactions) == 1 and any("1 of 2 rows are pairs that neither touch" in note for note in frame.notes)


def test_discs_that_overlap_and_are_not_in_the_table_are_said(write):
    paths = write(GRAINS, pairs("id_i id_j normal tangential", "1 3 2.0 0"))
    frame = next(foreign_frames(*paths))
    assert len(frame.interactions) == 1 and any(
        "1 of 2 pairs of discs that overlap are not in the" in note for note in frame.notes
    )
    with pytest.raises(InputError, match=r"deepest 1 and 2 by 0.0566: it is incomplete, or of another step; .* --partial"):
        Sample([paths[0]], [paths[1]], Reading(complete=True)).frame(0)


def test_positions_of_few_digits_leave_open_which_discs_touch(write):
    """Six digits, as LAMMPS writes unless told otherwise."""
    close = GRAINS.replace("2 0.5 1.2 1.5", "2 0.5 1.40001 1.00000")
    frame = next(foreign_frames(*write(close.replace("9.6 1", "9.61234 1.12345").replace("0.4 1", "0.40000 1.00000"))))
    assert "positions are given to 1e-05: whether 1 of" in "\n".join(frame.notes)


def test_two_images_of_a_pair_are_two_contacts(write):
    """In a cell as narrow as two grains only the branches tell them apart."""
    cell = GRAINS.replace("\n0 10\n", "\n0 1.8\n").replace("9.6 1", "1.3 1").replace("2 0.5 1.2 1.5\n", "2 0.5 0.4 5\n")
    table = pairs("id_i id_j bx by normal tangential", "1 3 0.9 0 1 0", "1 3 -0.9 0 1 0").replace("\n0 10\n", "\n0 1.8\n")
    assert len(next(foreign_frames(*write(cell, table))).interactions) == 2


def test_measures_of_what_is_missing_are_undefined(write):
    """Neither zero nor made up: no mass, no velocity, no forces, no diameters."""
    bare = GRAINS.replace("id radius x y", "id colour x y")
    frame = next(foreign_frames(*write(bare, pairs("id_i id_j", "1 3", "1 2"))))
    found = measure(frame, force_unit=1.0)
    assert found["coordination"] == pytest.approx(4 / 3) and found["grains"] == 3
    for name in ("solid_fraction", "rattler_fraction", "coordination_backbone", "neighbour_shares", "rumpf_ratio"):
        assert found[name] is None, name
    assert [found["stress"][name] for name in ("xx", "yy", "xy", "yx", "pressure")] == [None] * 5
    assert found["kinetic_energy"] == {"per_grain": None, "raw": None}
    assert found["unbalanced_force"]["force"] is None and found["interactions"]["contacts"] is None


@pytest.fixture
def universe():
    rng = np.random.default_rng(1)
    found = MDAnalysis.Universe.empty(200, trajectory=True)
    found.add_TopologyAttr("radii", np.full(200, 0.5))
    found.atoms.positions = np.column_stack((rng.uniform(0, 20, (200, 2)), np.zeros(200)))
    found.dimensions = [20.0, 20.0, 20.0, 90.0, 90.0, 90.0]
    return found


def test_a_universe_is_measured_with_a_warning_about_its_precision(universe):
    with pytest.warns(UserWarning, match="float32"):
        frame = universe_frame(universe)
    assert frame.grains == 200
    assert frame.cell.tolist() == [20.0, 20.0]
    assert {"mass", "velocity", "normal", "sliding"} <= frame.lacks and measure(frame, force_unit=1.0)["stress"][
        "pressure"
    ] is None
    assert (frame.interactions.gap < 0).all()
    universe.dimensions = [20.0, 20.0, 20.0, 90.0, 90.0, 60.0]
    with pytest.raises(InputError, match="90 degrees"):
        universe_frame(universe)


def test_pair_correlation_is_that_of_mdanalysis(universe):
    """Its InterRDF counts the same pairs; the spheres it divides by are rings here."""
    with pytest.warns(UserWarning, match="float32"):
        frame = universe_frame(universe, {"i": [], "j": []})
    ours = pair_correlation(frame, np.linspace(0.0, 8.0, 41))
    theirs = InterRDF(universe.atoms, universe.atoms, nbins=40, range=(0.0, 8.0), exclusion_block=(1, 1), norm="none").run()
    counts = ours.g * 200**2 / 400 * np.pi * np.diff(ours.edges**2)
    # at most one pair lies within float32 of an edge
    assert np.abs(counts - theirs.results.rdf).max() <= 2.0 + 1e-6
    assert counts.sum() == pytest.approx(theirs.results.rdf.sum(), abs=2.0)
