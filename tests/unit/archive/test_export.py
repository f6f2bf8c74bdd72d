"""What is exported reads back, by readers that share no code with the writers, to the last bit."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from lammps_text import random_frame

from workflow.archive import export
from workflow.archive.export import FORMATS, contact_columns, grain_columns, graph
from workflow.data.build import make_frame
from workflow.errors import EnvironmentFault, InputError

FRAMES = [random_frame(0, stage="a", pairs=0, first_id=10), random_frame(1000, stage="b", first_id=10)]


def same_table(read: dict[str, list], expected: list[dict[str, np.ndarray]]) -> None:
    """``read`` holds the rows of all frames, to the last bit."""
    for name in expected[0]:
        column = np.concatenate([columns[name] for columns in expected])
        assert np.array_equal(np.array(read[name], dtype=column.dtype), column), name


def written(kind: str, folder: Path, frames=FRAMES) -> list[Path]:
    return FORMATS[kind].write(iter(frames), folder)


def test_csv_holds_every_digit(tmp_path):
    paths = written("csv", tmp_path)
    assert [path.name for path in paths] == ["frames.csv", "grains.csv", "contacts.csv"]

    def rows(path):
        with open(path, newline="") as file:
            title, *lines = csv.reader(file)
        kinds = {"True": True, "False": False}
        values = [
            [kinds[word] if word in kinds else word if word.isalpha() else float(word) for word in line] for line in lines
        ]
        return dict(zip(title, zip(*values, strict=True), strict=True))

    whole = rows(paths[0])
    assert list(whole["stage"]) == ["a", "b"] and list(whole["step"]) == [0, 1000]
    assert whole["cell_y"] == (9.25, 9.25) and whole["origin_x"] == (-1.0, -1.0)
    same_table(rows(paths[1]), [grain_columns(frame) for frame in FRAMES])
    same_table(rows(paths[2]), [contact_columns(frame) for frame in FRAMES])


def test_parquet_holds_the_same_tables(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    read = {path.stem: parquet.read_table(path).to_pydict() for path in written("parquet", tmp_path)}
    assert read["frames"]["time"] == [frame.time for frame in FRAMES]
    assert read["grains"]["step"] == [0] * 12 + [1000] * 12
    same_table(read["grains"], [grain_columns(frame) for frame in FRAMES])
    same_table(read["contacts"], [contact_columns(frame) for frame in FRAMES])


def vtp(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a VTP file by "section/name", taken apart here: the text declares offsets into what follows the mark."""
    text, data = path.read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)
    found, section = {}, ""
    for tag, attributes in re.findall(r"<(\w+)([^>]*)>", text.decode()):
        if tag != "DataArray":
            section = tag
            continue
        known = dict(re.findall(r'(\w+)="([^"]*)"', attributes))
        start = int(known["offset"])
        size = int.from_bytes(data[start : start + 8], "little")
        kind = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[known["type"]]
        values = np.frombuffer(data[start + 8 : start + 8 + size], kind)
        width = int(known.get("NumberOfComponents", 1))
        found[f"{section}/{known['Name']}"] = values.reshape(-1, width) if width > 1 else values
    return found


def test_vtk_files_hold_points_and_lines(tmp_path):
    paths = written("vtk", tmp_path)
    assert [path.name for path in paths] == ["grains.pvd", "contacts.pvd", "cell.pvd"]
    assert re.findall(r'timestep="(\S+)".*file="(\S+)"', paths[1].read_text()) == [
        (repr(frame.time), f"contacts.0000{k}.vtp") for k, frame in enumerate(FRAMES)
    ]
    frame, pairs = FRAMES[1], FRAMES[1].interactions
    grains, lines = (vtp(tmp_path / f"{name}.00001.vtp") for name in ("grains", "contacts"))
    assert np.array_equal(grains["Points/points"][:, :2], frame.position)
    assert np.array_equal(grains["PointData/diameter"], frame.diameter) and np.array_equal(grains["PointData/id"], frame.ids)
    assert np.array_equal(grains["PointData/velocity"], np.column_stack((frame.velocity, np.zeros(12))))
    assert grains["Verts/connectivity"].tolist() == list(range(12)) and grains["Verts/offsets"].tolist() == list(range(1, 13))
    ends = lines["Points/points"].reshape(-1, 2, 3)
    assert np.array_equal(ends[:, 0, :2], frame.position[pairs.i])
    assert ends[:, 1, :2] - ends[:, 0, :2] == pytest.approx(pairs.branch, abs=1e-15)  # the sum of two numbers near 1
    assert np.array_equal(lines["CellData/normal"], pairs.normal_force)
    assert np.array_equal(lines["PointData/sliding"], np.repeat(pairs.sliding, 2))
    assert lines["Lines/offsets"].tolist() == list(range(2, 41, 2))
    assert lines["FieldData/cell"].tolist() == [-1.0, 0.5, 7.0, 9.25]
    assert len(vtp(tmp_path / "contacts.00000.vtp")["Points/points"]) == 0


def test_vtk_files_are_xml_whose_arrays_fill_them(tmp_path):
    """What ParaView takes for granted: well-formed text, counts that are those of the arrays, and nothing else."""
    for path in written("vtk", tmp_path):
        members = ElementTree.parse(path).getroot().findall("Collection/DataSet")
        assert [float(member.get("timestep")) for member in members] == [frame.time for frame in FRAMES]
        for member in members:
            text, data = (tmp_path / member.get("file")).read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)
            piece = ElementTree.fromstring(text + b"</VTKFile>").find("PolyData/Piece")
            arrays = vtp(tmp_path / member.get("file"))
            assert len(arrays["Points/points"]) == int(piece.get("NumberOfPoints"))
            kind = "Verts" if "grains" in path.name else "Lines"
            assert len(arrays[f"{kind}/offsets"]) == int(piece.get(f"NumberOf{kind}"))
            size = sum(8 + array.nbytes for array in arrays.values())
            assert data[size:] == b"\n</AppendedData>\n</VTKFile>\n"


def test_vtk_lines_never_cross_the_cell(tmp_path):
    """A contact over the border is as long as one inside; the sides of the cell close around the grains."""
    written(
        "vtk", tmp_path, [make_frame([[0.1, 1.0], [9.9, 1.0], [5.0, 5.0], [5.3, 5.0]], 0.4, (10.0, 8.0), origin=(0.0, -1.0))]
    )
    ends = vtp(tmp_path / "contacts.00000.vtp")["Points/points"].reshape(-1, 2, 3)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx([0.2, 0.3])
    sides = vtp(tmp_path / "cell.00000.vtp")["Points/points"].reshape(-1, 2, 3)
    assert np.array_equal(sides[:, 1], np.roll(sides[:, 0], -1, axis=0))
    assert sides[:, 0].tolist() == [[0, -1, 0], [10, -1, 0], [10, 7, 0], [0, 7, 0]]


def test_vtk_itself_reads_them(tmp_path):
    pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    written("vtk", tmp_path)
    for number, frame in enumerate(FRAMES):
        for name, cells in (("grains", frame.grains), ("contacts", len(frame.interactions)), ("cell", 4)):
            reader = vtkXMLPolyDataReader()
            reader.SetFileName(str(tmp_path / f"{name}.{number:05d}.vtp"))
            reader.Update()
            data = reader.GetOutput()
            assert data.GetNumberOfCells() == cells
            assert data.GetFieldData().GetArray("TimeValue").GetValue(0) == frame.time
            if name == "contacts" and cells:
                normal = vtk_to_numpy(data.GetCellData().GetArray("normal"))
                assert np.array_equal(normal, frame.interactions.normal_force)


def test_gsd_file_holds_discs_and_bonds(tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd")
    (path,) = written("gsd", tmp_path)
    with hoomd.open(path) as file:
        assert [shot.configuration.step for shot in file] == [0, 1000]
        shot, frame = file[1], FRAMES[1]
    assert shot.configuration.box[:2].tolist() == [7.0, 9.25]
    assert np.abs(shot.particles.position[:, :2]).max() <= 9.25 / 2
    apart = (shot.particles.position[:, :2] - frame.position) / frame.cell
    # the same place up to one shift of all and whole cells, to the rounding of float32
    assert apart - apart[0] == pytest.approx(np.round(apart - apart[0]), abs=1e-6)
    assert shot.particles.diameter == pytest.approx(frame.diameter, rel=1e-7)
    assert np.array_equal(shot.bonds.group, np.column_stack((frame.interactions.i, frame.interactions.j)))
    assert np.array_equal(shot.log["bonds/normal"], frame.interactions.normal_force)  # float64
    assert np.array_equal(shot.log["bonds/sliding"].astype(bool), frame.interactions.sliding)
    assert np.array_equal(shot.log["particles/id"], frame.ids)


def test_ovito_reads_the_bonds_across_the_border(tmp_path):
    """Two pairs, one of them across the border: OVITO finds both short."""
    read = pytest.importorskip("ovito.io")
    frame = make_frame([[0.1, 1.0], [9.9, 1.0], [5.0, 5.0], [5.3, 5.0]], 0.4, (10.0, 10.0))
    (path,) = written("gsd", tmp_path, [frame])
    data = read.import_file(str(path)).compute()
    x, bonds = data.particles["Position"][...], data.particles.bonds
    i, j = bonds.topology[...].T
    branch = x[j] - x[i] + bonds.pbc_vectors[...] @ data.cell[:3, :3].T
    assert np.hypot(*branch.T[:2]) == pytest.approx([0.2, 0.3], abs=1e-5)
    assert data.particles["Radius"][...] == pytest.approx(0.2)


def test_graph_has_forces_at_its_edges(tmp_path):
    networkx = pytest.importorskip("networkx")
    frame, pairs = FRAMES[1], FRAMES[1].interactions
    found = graph(frame)
    assert sorted(found.nodes) == frame.ids.tolist()
    assert {frozenset(edge) for edge in found.edges} == {
        frozenset((frame.ids[i], frame.ids[j])) for i, j in zip(pairs.i, pairs.j, strict=True)
    }
    assert networkx.get_node_attributes(found, "diameter") == dict(zip(frame.ids.tolist(), frame.diameter, strict=True))
    (path,) = written("graphml", tmp_path, [frame])
    read = networkx.read_graphml(path, node_type=int)
    assert type(read) is type(found) and dict(read.nodes(data=True)) == dict(found.nodes(data=True))
    assert list(read.edges(data=True)) == list(found.edges(data=True))
    assert found.graph.items() <= read.graph.items()
    for i, j, normal, sliding in zip(pairs.i, pairs.j, pairs.normal_force, pairs.sliding, strict=True):
        edge = read.edges[frame.ids[i], frame.ids[j]]
        assert edge["normal"] == normal and edge["sliding"] == sliding
        assert (edge["id_i"], edge["id_j"]) == (frame.ids[i], frame.ids[j])  # the direction of the branch
    assert read.graph["step"] == 1000
    with pytest.raises(InputError, match="one network"):
        written("graphml", tmp_path)


def test_a_missing_package_is_named(monkeypatch, tmp_path):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(export, "import_module", missing)
    with pytest.raises(EnvironmentFault, match="pip install networkx"):
        graph(FRAMES[1])
    for kind in ("parquet", "gsd"):
        with pytest.raises(EnvironmentFault, match=f"pip install {FORMATS[kind].needs}"):
            written(kind, tmp_path)
    assert list(tmp_path.iterdir()) == []
