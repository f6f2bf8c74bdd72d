"""What a file is, and several files at once."""

import gzip
import sys

import h5py
import numpy as np
import pytest
from foreign_files import Way, contacts_text, grains_text, packing, write

from workflow.archive.columns import Reading, liggghts_columns
from workflow.archive.dump_tables import Dump
from workflow.archive.formats import unpacked
from workflow.archive.samples import gathered
from workflow.cli.main import main
from workflow.errors import ArchiveError, EnvironmentFault, InputError

OTHERS = {
    "grains.csv": (b"step,id,x,y\n1,2,3,4\n", "table with commas"),
    "run.gsd": (b"\xdf\x65\xdf\x65\xdf\x65\xdf\x65" + bytes(300), "GSD file"),
    "grains.data": (b"LAMMPS data file\n\n400 atoms\n1 atom types\n\n0 1 xlo xhi\n", "data file of LAMMPS"),
    "start.data": (b"discs in a periodic cell\n\n400 atoms\n1 atom types\n", "data file of LAMMPS"),
    "old.bin": (np.array([100, 400], dtype="<i8").tobytes() + bytes(90), "binary"),
    "dump.bin": ((-10).to_bytes(8, "little", signed=True) + b"DUMPCUSTOM" + bytes(90), "binary2txt"),
    "restart": (b"LammpS RestartT\0" + bytes(90), "restart file"),
    "frame.vtk": (b"# vtk DataFile Version 3.0\n", "VTK"),
    "frame.vtp": (b'<?xml version="1.0"?>\n<VTKFile>', "XML"),
    "in.deck": (b"# pack\nunits lj\npair_style gran\n", "input script"),
    "scene.toml": (b'scene = "method1"\nn = 60\n', "scene file"),
    "log.lammps": (b"LAMMPS (22 Jul 2025)\n", "log of LAMMPS"),
    "xyz": (b"3\ncomment\nSi 0 0 0\n", "XYZ"),
    "nothing": (b"", "empty"),
    "words": (b"Dear \x1b[31mcolleague\n", "text that begins with 'Dear ?[31mcolleague'"),
    "d.yaml": (b"---\ncreator: LAMMPS\n", "YAML"),
    "series.txt": (b"# step time stage sxx\n0 0 1 0\n", "time series"),
    "a.npy": (b"\x93NUMPY\x01\x00", "NumPy"),
    "a.zip": (b"PK\x03\x04", "ZIP"),
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("packed", [False, True])
def test_a_file_of_another_kind_is_called_what_it_is(name, packed, tmp_path, capsys):
    content, what = OTHERS[name]
    path = tmp_path / name
    path.write_bytes(gzip.compress(content) if packed else content)
    assert main(["measure", str(path)]) == 2
    said = capsys.readouterr().err
    assert what in said and str(path) in said and "damaged" not in said and len(said.splitlines()) == 1
    assert "\x1b" not in said


def test_an_archive_given_by_mistake_is_called_one(tmp_path, capsys):
    h5py.File(tmp_path / "run.h5", "w").close()
    assert main(["measure", str(tmp_path / "run.h5")]) == 2
    assert "an HDF5 file" in capsys.readouterr().err


@pytest.fixture
def files(tmp_path):
    return [write(tmp_path, name, [text(packing(1), Way())]) for name, text in (("g", grains_text), ("c", contacts_text))]


def test_zstandard_is_read_or_the_package_is_named(files, tmp_path, monkeypatch):
    content = files[0].read_bytes()
    zstandard = pytest.importorskip("zstandard")
    path = tmp_path / "g.zst"
    path.write_bytes(zstandard.compress(content[:500]) + zstandard.compress(content[500:]))  # two frames, as zstd -c >> makes
    file, how = unpacked(path)
    with file:
        assert file.read() == content and how == "Zstandard"
    assert Dump([path]).snapshots.keys() == Dump([files[0]]).snapshots.keys()
    for name in ("compression.zstd", "zstandard"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(EnvironmentFault, match="pip install zstandard, or unpack it with 'zstd -d"):
        unpacked(path)


def test_a_contradiction_in_packed_data_is_said(files, tmp_path):
    content = bytearray(gzip.compress(files[0].read_bytes()))
    content[len(content) // 2] ^= 255
    (tmp_path / "g.gz").write_bytes(content)
    with pytest.raises((InputError, ArchiveError), match=r"gzip data end too early or are damaged|damaged there"):
        Dump([tmp_path / "g.gz"])


def test_a_killed_writer_costs_the_snapshot_it_was_writing(tmp_path):
    """The next one, of a run that appends, is read."""
    texts = [grains_text(packing(1), Way(step=step)) for step in (1, 2, 3)]
    cut = texts[1][: len(texts[1]) // 2]
    cut = cut[: cut.rindex("\n") + 1]
    dump = Dump([write(tmp_path, "g", [texts[0], cut, texts[2]])])
    assert list(dump.snapshots) == [1, 3]
    assert "cut off in line" in dump.notes[0] and "left out" in dump.notes[0]


def test_columns_without_names_have_their_numbers(tmp_path):
    """Headers older than the names of columns."""
    p = packing(1)
    text = grains_text(p, Way())
    head = next(line for line in text.splitlines() if line.startswith("ITEM: ATOMS"))
    names = head.split()[2:]
    path = write(tmp_path, "g", [text.replace(head, "ITEM: ATOMS")])
    (block,) = Dump([path]).snapshots.values()
    assert block.columns == tuple(map(str, range(1, len(names) + 1)))
    given = ",".join(f"{name}={names.index(name) + 1}" for name in ("id", "x", "y", "radius"))
    assert main(["measure", str(path), "--columns", given, "--only", "none"]) == 0


def test_files_of_one_sample_are_told_from_files_of_several(tmp_path):
    """One file per step, two samples with their contacts, and the word of the user."""
    one, two = packing(1), packing(2)
    steps = [write(tmp_path, f"s{step}", [grains_text(one, Way(step=step))]) for step in (1, 2, 3)]
    tables = [write(tmp_path, f"t{step}", [contacts_text(one, Way(step=step))]) for step in (1, 2, 3)]
    other = write(tmp_path, "other", [grains_text(two, Way(step=4))])
    (sample,) = gathered(steps, tables, Reading(), apart=False)
    assert sample.sample(Reading()).steps == [1, 2, 3]
    assert [len(found.grains) for found in gathered(steps, tables, Reading(), apart=True)] == [1, 1, 1]
    both = list(gathered([*steps[:2], other], [tables[0], tables[1], tables[2]], Reading(), apart=False))
    assert [(part.grains, part.contacts) for part in both] == [
        (tuple(steps[:2]), tuple(tables[:2])),
        ((other,), (tables[2],)),
    ]
    found = list(gathered([steps[0], other], [tables[0], tables[1]], Reading(), apart=False))
    assert [(part.grains, part.contacts) for part in found] == [((steps[0],), (tables[0],)), ((other,), (tables[1],))]
    with pytest.raises(InputError, match="2 samples in 2 files of grains, and 3 files of contacts"):
        list(gathered([steps[0], other], tables, Reading(), apart=False))


def test_samples_of_dumps_are_pooled_with_their_own_contacts(tmp_path, capsys):
    words = {"g": [], "c": []}
    for seed in (1, 2):
        for name, text in (("g", grains_text), ("c", contacts_text)):
            words[name].append(str(write(tmp_path, f"{name}{seed}", [text(packing(seed), Way())])))
    assert main(["measure", *words["g"], "--contacts", *words["c"], "--only", "none"]) == 0
    text = capsys.readouterr().out
    assert "coordination  " in text and "+-" in text and "step" not in text
    assert main(["measure", *words["g"], "--contacts", *reversed(words["c"]), "--only", "none"]) in (1, 2)


KEYWORDS = [
    ("", 22 + 3, {"id_i": 13, "id_j": 14, "fx": 16, "fy": 17, "fz": 18}),  # the default, with three columns of history
    ("pos id force", 12, {"id_i": 7, "id_j": 8, "fx": 10, "fy": 11, "fz": 12}),
    ("force id pos", 12, {"id_i": 7, "id_j": 8, "fx": 10, "fy": 11, "fz": 12}),  # LIGGGHTS has an order of its own
    ("id force_normal force_tangential", 9, {"id_i": 1, "id_j": 2, "fx": 4, "fy": 5, "fz": 6, "tx": 7, "ty": 8}),
    ("id force torque history contactArea delta", 14, {"id_i": 1, "id_j": 2, "fx": 4, "fy": 5, "fz": 6, "overlap": 14}),
]


@pytest.mark.parametrize(("keywords", "count", "places"), KEYWORDS)
def test_columns_of_liggghts_are_known_by_its_keywords(keywords, count, places, tmp_path):
    text = contacts_text(packing(1), Way())
    head = next(line for line in text.splitlines() if line.startswith("ITEM: ENTRIES"))
    names = " ".join(f"c_fc[{k}]" for k in range(1, count + 1))
    body = text[: text.index(head)].replace(f"\n{len(packing(1).i)}\n", "\n0\n")
    (block,) = Dump([write(tmp_path, "c", [body, f"ITEM: ENTRIES {names}\n"])]).snapshots.values()
    assert liggghts_columns(block, keywords.split()) == {name: f"c_fc[{place}]" for name, place in places.items()}
    with pytest.raises(InputError, match="unknown keyword"):
        liggghts_columns(block, ["idd"])
    with pytest.raises(InputError, match="give the keywords of the input script"):
        liggghts_columns(block, ["pos", "vel", "id", "force", "force_normal", "force_tangential", "contactPoint"])


def test_the_columns_of_a_file_are_shown_as_they_are_read(files, capsys):
    assert main(["measure", "--columns-of", str(files[0])]) == 0
    text = capsys.readouterr().out
    assert "grains (ATOMS), text" in text and "radius: radius" in text and "pp pp pp" in text
    assert main(["measure", "--columns-of", str(files[1]), "--columns", "normal=fx"]) == 0
    assert "normal: normal force" in capsys.readouterr().out


def test_the_command_line_names_what_is_misused(files, capsys):
    grains, contacts = map(str, files)
    for words, message in (
        (["--contacts", contacts, grains], "before --contacts"),
        ([grains, "--columns", "raduis=radius"], "did you mean radius"),
        ([grains, "--columns", "radius=r"], "there is no column 'r'"),
        ([grains, "--columns", "radius=radius,radius=mass"], "given twice"),
        ([grains, "--mu", "-1"], "--mu -1 is not allowed"),
        ([f"{grains}.*"], "names no file"),
        ([grains, grains], "named twice"),
        ([grains, "--contacts", grains], "column id_i, id_j missing"),
        ([contacts, "--contacts", contacts], "a table of contacts goes behind --contacts"),
    ):
        assert main(["measure", *words, "--only", "none"]) in (1, 2), words
        assert message in capsys.readouterr().err, words


def test_what_is_not_given_is_not_exported(files, tmp_path, capsys):
    assert (
        main(["export", str(files[0]), "--contacts", str(files[1]), "--out", str(tmp_path / "out"), "--to", "csv,vtk,graphml"])
        == 0
    )
    assert "not given" in capsys.readouterr().err
    frames, contacts = ((tmp_path / "out" / f"{name}.csv").read_text().splitlines()[0] for name in ("frames", "contacts"))
    assert "time" not in frames and "xi_t" not in contacts and "normal" in contacts
    pytest.importorskip("gsd")
    bare = write(tmp_path, "bare", [grains_text(packing(1), Way(dropped=("mass",)))])
    assert main(["export", str(bare), "--out", str(tmp_path / "out"), "--to", "gsd"]) == 2
    assert "masses" in capsys.readouterr().err


def test_figures_and_pages_of_what_is_missing_are_refused(files, tmp_path, capsys):
    for words, message in (
        (["plot", str(files[0])], "undefined, the source does not give normal forces"),
        (["report", str(files[0]), "--out", str(tmp_path / "page.html")], "does not give normal forces"),
        (["plot", *map(str, [files[0], "--contacts", files[1]]), "--figure", "cloud"], "give --mu"),
    ):
        assert main(words) == 2
        assert message in capsys.readouterr().err
    page = tmp_path / "page.html"
    assert main(["report", str(files[0]), "--contacts", str(files[1]), "--out", str(page)]) == 0
    assert "balance: the largest net force" in page.read_text()
