from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lammps_text import GRAINS, NUMBERED, contacts_text, grains_text, random_frame

from workflow.archive.dumps import CONTACT_COLUMNS, read_blocks, read_frames, read_tracks
from workflow.data import text
from workflow.data.frame import Frame, Interactions
from workflow.data.series import read_series
from workflow.errors import ArchiveError


def same(a, b):
    """Frames equal bit for bit: %.17g and float64 lose nothing."""
    for item, of_a, of_b in [(Frame, a, b), (Interactions, a.interactions, b.interactions)]:
        for field in fields(item):
            if field.name not in ("interactions", "cell"):
                np.testing.assert_array_equal(getattr(of_a, field.name), getattr(of_b, field.name), field.name)
    # The cell comes from the difference of two printed bounds: one rounding.
    np.testing.assert_allclose(a.cell, b.cell, rtol=1e-15)


@pytest.fixture
def write(tmp_path):
    def files(grains, contacts):
        (tmp_path / "grains").write_text(grains)
        (tmp_path / "contacts").write_text(contacts)
        return tmp_path / "grains", tmp_path / "contacts"

    return files


def test_frames_are_read_bit_for_bit(write):
    frames = [random_frame(step) for step in (0, 1000, 2000)]
    paths = write("".join(map(grains_text, frames)), "".join(map(contacts_text, frames)))
    read = list(read_frames(*paths))
    assert len(read) == 3
    for a, b in zip(read, frames, strict=True):
        same(a, b)


@pytest.mark.parametrize("rows", [1, 5, 12, 13])
def test_size_of_the_parts_of_a_table_does_not_matter(write, monkeypatch, rows):
    """A table is turned into numbers part by part; damage is named by its line wherever it is."""
    frame = random_frame()
    grains, contacts = grains_text(frame), contacts_text(frame)
    monkeypatch.setattr(text, "ROWS", rows)
    same(next(read_frames(*write(grains, contacts))), frame)
    lines = grains.splitlines(keepends=True)
    head = len(lines) - 12
    for bad in (head, head + 7, head + 11):
        damaged = [*lines[:bad], lines[bad].replace(" ", " x", 1), *lines[bad + 1 :]]
        with pytest.raises(ArchiveError, match=f"line {bad + 1}: expected .* finite numbers"):
            list(read_frames(*write("".join(damaged) + grains, contacts)))


def test_row_order_column_order_pair_order_and_idle_pairs_do_not_matter(write):
    frame = random_frame()
    shuffled = np.random.default_rng(3).permutation(20)
    columns = " ".join(reversed(GRAINS.split())) + " radius"
    paths = write(
        grains_text(frame, order=np.random.default_rng(2).permutation(12), columns=columns),
        contacts_text(frame, swap=range(0, 20, 3), order=shuffled, idle=4),
    )
    same(next(read_frames(*paths)), frame)


def read(folder, grains, contacts):
    """The frame of two texts."""
    (folder / "grains").write_text(grains)
    (folder / "contacts").write_text(contacts)
    return next(read_frames(folder / "grains", folder / "contacts"))


@given(
    grains=st.permutations(GRAINS.split()),
    contacts=st.permutations(range(15)),
    names=st.sampled_from([CONTACT_COLUMNS, NUMBERED]),
)
def test_columns_are_read_by_their_names_in_any_order(tmp_path_factory, grains, contacts, names):
    frame = random_frame()
    text = contacts_text(frame, swap=range(0, 20, 3), idle=2, names=names, columns=contacts)
    same(read(tmp_path_factory.mktemp("permuted"), grains_text(frame, columns=" ".join(grains)), text), frame)


@given(lost=st.integers(0, 14), twice=st.integers(0, 14), names=st.sampled_from([CONTACT_COLUMNS, NUMBERED]))
def test_a_contact_column_that_is_missing_or_there_twice_is_refused(tmp_path_factory, lost, twice, names):
    """Also where the number of columns is right: it is no table by position."""
    frame, folder = random_frame(), tmp_path_factory.mktemp("lost")
    columns = [twice if k == lost else k for k in range(15)] if lost != twice else [*range(15), twice]
    for chosen in (columns, [k for k in range(15) if k != lost]):
        with pytest.raises(ArchiveError, match=r"missing in|more than once"):
            read(folder, grains_text(frame), contacts_text(frame, names=names, columns=chosen))


@given(st.lists(st.sampled_from([*CONTACT_COLUMNS, *NUMBERED, "c_other[3]", "3", "gap2"]), min_size=15, max_size=15))
def test_names_that_are_not_those_of_a_contact_table_are_refused(tmp_path_factory, names):
    if sorted(names) in (sorted(CONTACT_COLUMNS), sorted(NUMBERED)):
        return
    frame = random_frame()
    with pytest.raises(ArchiveError, match=r"missing in|more than once"):
        read(tmp_path_factory.mktemp("names"), grains_text(frame), contacts_text(frame, names=names))


@pytest.mark.parametrize("name", ["id", "x", "tqz"])
def test_a_grain_column_that_is_missing_or_there_twice_is_refused(tmp_path, name):
    frame = random_frame()
    for columns, word in (
        (f"{GRAINS} {name}", f"{name} is there more than once"),
        (GRAINS.replace(name, "radius", 1), "missing"),
    ):
        with pytest.raises(ArchiveError, match=word):
            read(tmp_path, grains_text(frame, columns=columns), contacts_text(frame))


@given(st.permutations(["id", "x", "y", "radius"]))
def test_tracks_are_read_by_their_names_in_any_order(tmp_path_factory, columns):
    frame, file = random_frame(), tmp_path_factory.mktemp("tracks") / "tracks.dump"
    file.write_text(grains_text(frame, columns=" ".join(columns)))
    tracks = read_tracks(file)
    np.testing.assert_array_equal(tracks.ids, frame.ids)
    np.testing.assert_array_equal(tracks.position[0], frame.position)


def test_the_force_of_a_swapped_pair_is_opposite(write):
    frame = random_frame(pairs=1)
    text = contacts_text(frame, swap=[0])
    pair = frame.interactions
    row = np.array(text.splitlines()[-1].split(), float)
    n = row[3:5] / np.hypot(*row[3:5])
    force = row[6:9].sum() * n + row[9] * np.array([-n[1], n[0]])
    np.testing.assert_allclose(force, -pair.force[0], rtol=1e-14)  # rounding of a square root and a few products
    same(next(read_frames(*write(grains_text(frame), text))), frame)


def test_only_steps_present_in_both_files_make_frames(write):
    a, b, c, d = (random_frame(step) for step in (0, 1000, 2000, 3000))
    paths = write("".join(map(grains_text, (a, b, d))), "".join(map(contacts_text, (b, c, d))))
    assert [f.step for f in read_frames(*paths)] == [1000, 3000]


def test_a_step_written_twice_counts_once(write):
    a = random_frame(0)
    paths = write(grains_text(a) * 2, contacts_text(a) * 2)
    assert len(list(read_frames(*paths))) == 1


def test_a_frame_without_interactions_is_read(write):
    frame = random_frame(pairs=0)
    read = next(read_frames(*write(grains_text(frame), contacts_text(frame))))
    assert len(read.interactions) == 0 and read.interactions.branch.shape == (0, 2)


@pytest.mark.parametrize("which", [0, 1])
def test_any_truncation_of_the_last_frame_leaves_the_frames_before(write, which):
    frames = [random_frame(step, grains=4, pairs=3) for step in (0, 1000)]
    texts = ["".join(map(grains_text, frames)), "".join(map(contacts_text, frames))]
    first = len((grains_text, contacts_text)[which](frames[0]))
    for cut in range(first, len(texts[which]), 7):
        cut_texts = list(texts)
        cut_texts[which] = texts[which][:cut]
        assert [f.step for f in read_frames(*write(*cut_texts))] == [0], cut


@pytest.mark.parametrize(
    ("old", "new", "line", "expected"),
    [
        ("ITEM: TIME\n0\n", "", 1, "found 'ITEM: TIMESTEP', expected 'ITEM: TIME' (dump_modify ... time yes)"),
        ("ITEM: TIMESTEP", "ITEM: TIMESTAMP", 3, "expected 'ITEM: TIMESTEP'"),
        ("NUMBER OF ATOMS\n4", "NUMBER OF ATOMS\n4x", 6, "expected one integer"),
        ("\n3 ", "\n3 oops ", 14, "expected 13 finite numbers"),
        ("\n2 ", "\n2 nan ", 13, "expected 13 finite numbers"),
        ("-0.5 0.5", "-0.5", 10, "expected 2 finite numbers"),
        ("omegaz", "omega", 11, "column omegaz missing"),
        ("\n3 ", "\n2 ", 11, "grain id 2 occurs twice"),
    ],
)
def test_damage_before_the_end_names_file_line_and_expectation(write, old, new, line, expected):
    frames = [random_frame(step, grains=4, pairs=3) for step in (0, 1000)]
    grains = "".join(map(grains_text, frames)).replace(old, new, 1)
    paths = write(grains, "".join(map(contacts_text, frames)))
    with pytest.raises(ArchiveError) as error:
        list(read_frames(*paths))
    for part in (str(paths[0]), f"line {line}", expected):
        assert part in str(error.value)


def test_a_frame_cut_in_the_middle_of_the_file_is_damage(write):
    a, b = (random_frame(step, grains=4, pairs=3) for step in (0, 1000))
    cut = "\n".join(grains_text(a).splitlines()[:-1]) + "\n"
    with pytest.raises(ArchiveError, match="line 15"):
        list(read_frames(*write(cut + grains_text(b), contacts_text(a) + contacts_text(b))))


def test_a_contact_with_an_unknown_grain_is_damage(write):
    frame, smaller = random_frame(grains=12), random_frame(grains=5, pairs=3)
    with pytest.raises(ArchiveError, match="no grain of that frame"):
        list(read_frames(*write(grains_text(smaller), contacts_text(frame))))


def test_steps_that_go_back_are_damage(write):
    a, b = random_frame(0), random_frame(1000)
    with pytest.raises(ArchiveError, match="found step 0 after step 1000"):
        list(read_frames(*write(grains_text(b) + grains_text(a), contacts_text(b))))


def test_a_missing_file_is_named():
    with pytest.raises(ArchiveError, match="cannot read 'nowhere'"):
        next(read_blocks("nowhere", "ATOMS"))


def test_stage_of_a_frame_comes_from_the_series(write):
    frames = [random_frame(step) for step in (0, 1000, 1500, 1700, 9000)]
    paths = write("".join(map(grains_text, frames)), "".join(map(contacts_text, frames)))
    series = {"step": np.array([0, 1000, 1500, 1500, 2000.0]), "stage": np.array([1, 1, 1, 2, 2.0])}
    read = read_frames(*paths, series=series, stages={1: "aggregate", 2: "press"})
    assert [f.stage for f in read] == ["aggregate"] * 3 + ["press"] * 2


def test_series_columns_and_the_unfinished_last_line(tmp_path):
    path = tmp_path / "series"
    title = "# step time stage sxx\n"
    path.write_text(title + "0 0 1 nan\n" + title + "10 0.001 1 1e-2\n20 0.002 2 0.02\n30 0.0")
    series = read_series(path)
    assert list(series) == ["step", "time", "stage", "sxx"]
    np.testing.assert_array_equal(series["step"], [0, 10, 20])
    np.testing.assert_array_equal(series["sxx"], [np.nan, 0.01, 0.02])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1"),
        ("step time stage\n", "line 1"),
        ("# step time\n0 0\n", "expected '# step time ... stage ...'"),
        ("# step time stage\n0 0 1\n1 1\n2 2 2\n", "line 3"),
        ("# step time stage\n0 0 1\n1 x 1\n", "line 3"),
        ("# step time stage\n5 0 1\n1 1 1\n", "line 3"),
    ],
)
def test_a_damaged_series_names_file_and_line(tmp_path, text, message):
    (tmp_path / "series").write_text(text)
    with pytest.raises(ArchiveError, match=message):
        read_series(tmp_path / "series")


def test_a_series_without_rows_is_read_as_empty(tmp_path):
    (tmp_path / "series").write_text("# step time stage\n")
    assert {name: len(values) for name, values in read_series(tmp_path / "series").items()} == {
        "step": 0, "time": 0, "stage": 0,
    }  # fmt: skip
