"""Dumps of other programs and MDAnalysis Universes."""

import MDAnalysis
import numpy as np
import pytest
from lammps_text import contacts_text, grains_text, random_frame
from MDAnalysis.analysis.rdf import InterRDF

from workflow.analysis.clusters import pair_correlation
from workflow.archive.dumps import read_frames
from workflow.archive.foreign import foreign_frames, universe_frame
from workflow.errors import ArchiveError, InputError

CELL = "ITEM: BOX BOUNDS pp pp pp\n0 10\n0 8\n-0.5 0.5\n"
HEAD = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF {0}\n{1}\n" + CELL + "ITEM: {0} {2}\n"
GRAINS = HEAD.format("ATOMS", 3, "id radius x y") + "3 0.5 9.6 1\n1 0.5 0.4 1\n2 0.5 1.2 1.5\n"


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


def test_dumps_of_this_package_are_read_alike(write):
    frame = random_frame()
    paths = write(grains_text(frame), contacts_text(frame, swap=range(0, 20, 3), idle=2))
    own, foreign = next(read_frames(*paths)), next(foreign_frames(*paths))
    order = np.lexsort((foreign.contacts.j, foreign.contacts.i))
    for name in ("i", "j", "branch", "gap", "elastic", "tangential", "moment", "stretch", "rotation", "sliding", "rolling"):
        np.testing.assert_array_equal(getattr(foreign.contacts, name)[order], getattr(own.contacts, name), name)
    for name in ("ids", "diameter", "mass", "position", "velocity", "spin", "force", "torque", "cell", "origin"):
        np.testing.assert_array_equal(getattr(foreign, name), getattr(own, name), name)


def test_without_contacts_the_overlaps_count(write):
    frame = next(foreign_frames(*write("ITEM: UNITS\nlj\n" + GRAINS)))
    assert frame.step == 7
    assert frame.ids.tolist() == [1, 2, 3]
    assert frame.diameter.tolist() == [1.0, 1.0, 1.0]
    assert list(zip(frame.contacts.i.tolist(), frame.contacts.j.tolist(), strict=True)) == [(0, 1), (0, 2)]


@pytest.mark.parametrize("row", ["1 3 2.0 0.5", "3 1 -2.0 -0.5"])
def test_force_on_the_first_grain_becomes_normal_and_tangential(write, row):
    """Grain 3 is to the left of 1 through the cell's edge and pushes it to the right with 2, upwards with 0.5."""
    table = next(foreign_frames(*write(GRAINS, pairs("id_i id_j fx fy", row)))).contacts
    assert table.branch[0] == pytest.approx([-0.8, 0.0])
    assert table.normal_force == pytest.approx([2.0])
    assert table.force[0] == pytest.approx([-2.0, -0.5])  # of 1 on 3


def test_tangential_part_in_columns_of_its_own_is_added(write):
    table = next(foreign_frames(*write(GRAINS, pairs("id_i id_j fx fy tx ty", "1 3 2.0 0 0 0.5")))).contacts
    assert table.force[0] == pytest.approx([-2.0, -0.5])


def test_columns_can_be_renamed(write):
    paths = write(GRAINS.replace("radius", "c_r"), pairs("c_1[1] c_1[2] c_2[1]", "2 1 3.5"))
    names = {"radius": "c_r", "id_i": "c_1[1]", "id_j": "c_1[2]", "normal": "c_2[1]"}
    frame = next(foreign_frames(*paths, names=names))
    assert frame.contacts.normal_force.tolist() == [3.5]


@pytest.mark.parametrize(
    ("grains", "contacts", "message"),
    [
        (GRAINS.replace("radius", "type"), None, "needed are id, x y .* diameter or radius"),
        (GRAINS, pairs("a b fx fy", "1 3 1 1"), "column id_i, id_j missing in a b fx fy"),
        (GRAINS, pairs("id_i id_j fx fy", "1 9 1 1"), "grain id 9"),
        (GRAINS.replace("\n2 0.5", "\n1 0.5"), None, "id 1 occurs twice"),
        (GRAINS.replace("pp pp pp", "ff pp pp"), None, "periodic in x and y"),
        (GRAINS.replace("pp pp pp", "xy xz yz pp pp pp"), None, "rectangle"),
    ],
)
def test_what_is_missing_is_named(write, grains, contacts, message):
    with pytest.raises(ArchiveError, match=message):
        next(foreign_frames(*write(grains, contacts)))


def test_steps_without_contacts_are_left_out(write):
    later = GRAINS.replace("\n7\n", "\n8\n")
    frames = list(foreign_frames(*write(GRAINS + later, pairs("id_i id_j normal", "1 2 1").replace("\n7\n", "\n8\n"))))
    assert [frame.step for frame in frames] == [8]


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
    assert (frame.contacts.gap < 0).all()
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
