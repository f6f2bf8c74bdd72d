"""A run in files that other tools open: tables (CSV, Parquet), ParaView (VTK), OVITO (GSD), graph tools (GraphML).

All keep float64 but for the positions in GSD files, which that format holds as float32 (for pictures, not for gaps).
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from workflow.archive import layout
from workflow.archive.vtk import write_collection, write_polydata
from workflow.data.cells import cells
from workflow.data.files import atomic_write
from workflow.data.frame import Floats, Frame, plain_rows
from workflow.errors import EnvironmentFault, InputError

if TYPE_CHECKING:
    import networkx

Columns = dict[str, np.ndarray]
GRAPHML, TYPES = "http://graphml.graphdrawing.org/xmlns", {"i": "long", "f": "double", "b": "boolean"}
SIDES = np.array([[0, 0], [1, 0], [1, 0], [1, 1], [1, 1], [0, 1], [0, 1], [0, 0]])  # of the cell, each from corner to corner
PLAIN = {name: column for name, column in layout.COLUMNS.items() if name not in ("i", "j", "branch")}  # field: column


@dataclass(frozen=True)
class Format:
    """``needs``: the package it takes, "" for none.  ``write`` takes frames and a folder and gives the files."""

    meaning: str
    needs: str
    write: Callable[[Iterable[Frame], Path], list[Path]]


def grain_columns(frame: Frame) -> Columns:
    """Grains as columns (N,), in scene units, of what the frame has; names as in the dumps of a run."""
    (x, y), (vx, vy), (fx, fy) = frame.position.T, frame.velocity.T, frame.force.T
    columns = {"id": frame.ids, "diameter": frame.diameter, "mass": frame.mass, "x": x, "y": y, "vx": vx, "vy": vy,
               "spin": frame.omega, "fx": fx, "fy": fy, "torque": frame.torque}  # fmt: skip
    return _given(columns, frame, {"vx": "velocity", "vy": "velocity", "fx": "force", "fy": "force"})


def _given(columns: Columns, frame: Frame, of: dict[str, str]) -> Columns:
    """The columns of what the frame has; ``of``: the quantities of those that are named otherwise."""
    of = {**of, "spin": "omega", "stretch": "xi_t", "rotation": "xi_r"}  # retired: in files
    return {name: column for name, column in columns.items() if of.get(name, name) not in frame.lacks}


def contact_columns(frame: Frame) -> Columns:
    """Interactions as columns (M,): ids of the two grains, branch from i to j, ``normal`` = N, and those of `Interactions`,
    of what the frame has."""
    pairs = frame.interactions
    ends = {
        "id_i": frame.ids[pairs.i],
        "id_j": frame.ids[pairs.j],
        "branch_x": pairs.branch[:, 0],
        "branch_y": pairs.branch[:, 1],
    }
    values = {"normal": pairs.normal_force} | {column: getattr(pairs, name) for name, column in PLAIN.items()}
    return ends | _given(values, frame, dict.fromkeys(("elastic", "viscous", "attraction"), "normal"))


def tables(frame: Frame) -> dict[str, Columns]:
    """Three tables of one frame, the rows of each marked with its step: ``frames`` (one row), ``grains``, ``contacts``."""
    row = {"time": frame.time, "stage": frame.stage, "origin_x": frame.origin[0], "origin_y": frame.origin[1],
           "cell_x": frame.cell[0], "cell_y": frame.cell[1]}  # fmt: skip
    row = {name: value for name, value in row.items() if name not in frame.lacks}
    parts = {"frames": {name: np.array([value]) for name, value in row.items()}}
    parts |= {"grains": grain_columns(frame), "contacts": contact_columns(frame)}
    return {
        name: {"step": np.full(len(next(iter(columns.values()))), frame.step), **columns} for name, columns in parts.items()
    }


def graph(frame: Frame) -> networkx.Graph:
    """The interaction network as a networkx.Graph: nodes are grain ids with diameter, mass, x, y; the edges hold
    `contact_columns` (``branch`` and moments lead from ``id_i`` to ``id_j``).

    Raises EnvironmentFault if networkx is not installed.
    """
    whole, grains, contacts = _network(frame)
    result = _needed("networkx").Graph(**next(_records(whole)))
    result.add_nodes_from((row["id"], row) for row in _records(grains))
    result.add_edges_from((row["id_i"], row["id_j"], row) for row in _records(contacts))
    return result


def _network(frame: Frame) -> tuple[Columns, Columns, Columns]:
    """Tables of `graph`: the network (one row), its nodes, its edges."""
    clock = {} if "time" in frame.lacks else {"time": frame.time}
    whole = {"step": frame.step, **clock, "cell_x": frame.cell[0], "cell_y": frame.cell[1]}
    grains = {name: column for name, column in grain_columns(frame).items() if name in ("id", "diameter", "mass", "x", "y")}
    return {name: np.array([value]) for name, value in whole.items()}, grains, contact_columns(frame)


def write_csv(frames: Iterable[Frame], folder: Path) -> list[Path]:
    """``frames.csv``, ``grains.csv``, ``contacts.csv``: the shortest digits that read back to the same float64."""
    paths = {name: folder / f"{name}.csv" for name in ("frames", "grains", "contacts")}
    with ExitStack() as stack:
        drafts = {name: stack.enter_context(atomic_write(path)) for name, path in paths.items()}
        writers = {name: csv.writer(stack.enter_context(open(draft, "w", newline=""))) for name, draft in drafts.items()}
        for number, frame in enumerate(frames):
            for name, columns in tables(frame).items():
                if not number:
                    writers[name].writerow(columns)
                writers[name].writerows(map(cells, plain_rows(*columns.values())))
    return list(paths.values())


def write_parquet(frames: Iterable[Frame], folder: Path) -> list[Path]:
    """``frames.parquet``, ``grains.parquet``, ``contacts.parquet``; one row group a frame."""
    arrow, parquet = _needed("pyarrow"), _needed("pyarrow.parquet")
    paths = {name: folder / f"{name}.parquet" for name in ("frames", "grains", "contacts")}
    writers: dict[str, Any] = {}
    with ExitStack() as stack:
        drafts = {name: stack.enter_context(atomic_write(path)) for name, path in paths.items()}
        for frame in frames:
            for name, columns in tables(frame).items():
                table = arrow.table(columns)
                if name not in writers:
                    writers[name] = stack.enter_context(parquet.ParquetWriter(drafts[name], table.schema))
                writers[name].write_table(table)
    return list(paths.values())


def write_vtk(frames: Iterable[Frame], folder: Path) -> list[Path]:
    """``grains.pvd``, ``contacts.pvd`` and ``cell.pvd`` for ParaView, with a VTP file for each frame.

    Grains are points; each contact is a line of its own from the centre of i along the branch, so that contacts across a
    border of the cell stick out of it; the cell is its four sides.
    """
    series: dict[str, list[tuple[float, Path]]] = {"grains": [], "contacts": [], "cell": []}
    for number, frame in enumerate(frames):
        time = float(frame.step) if "time" in frame.lacks else frame.time  # ParaView needs one
        clock = {"TimeValue": np.array([time]), "cell": np.concatenate((frame.origin, frame.cell))}
        grains = {"id": frame.ids, "diameter": frame.diameter, "mass": frame.mass, "velocity": _spatial(frame.velocity),
                  "spin": frame.omega, "force": _spatial(frame.force), "torque": frame.torque}  # fmt: skip
        grains = _given(grains, frame, {})
        start = frame.position[frame.interactions.i]
        ends = np.stack((start, start + frame.interactions.branch), axis=1).reshape(-1, 2)
        sides = frame.origin + frame.cell * SIDES
        for name, points, kind, data in (
            ("grains", frame.position, "Verts", grains),
            ("contacts", ends, "Lines", contact_columns(frame)),
            ("cell", sides, "Lines", {}),
        ):
            path = folder / f"{name}.{number:05d}.vtp"
            write_polydata(path, _spatial(points), kind, data, clock)
            series[name].append((time, path))
    for name, members in series.items():
        write_collection(folder / f"{name}.pvd", members)
    return [folder / f"{name}.pvd" for name in series]


def write_gsd(frames: Iterable[Frame], folder: Path) -> list[Path]:
    """``run.gsd`` for OVITO: discs, contacts as bonds with their forces, the cell, all frames."""
    hoomd = _needed("gsd.hoomd")
    path = folder / "run.gsd"
    with atomic_write(path) as draft, hoomd.open(draft, "w") as file:
        for frame in frames:
            frame.need("a GSD file, which fills in what is missing", "diameter", "mass", "velocity")
            shot, pairs = hoomd.Frame(), contact_columns(frame)
            shot.configuration.step, shot.configuration.dimensions = frame.step, 2
            shot.configuration.box = [*frame.cell, 1.0, 0.0, 0.0, 0.0]
            shot.particles.N, shot.bonds.N = frame.grains, len(frame.interactions)
            inside = frame.position - frame.origin - frame.cell / 2  # the centre of a GSD box is the origin
            shot.particles.position = _spatial(inside - frame.cell * np.round(inside / frame.cell))
            shot.particles.velocity = _spatial(frame.velocity)
            shot.particles.diameter, shot.particles.mass = frame.diameter, frame.mass
            shot.bonds.group = np.column_stack((frame.interactions.i, frame.interactions.j))
            log = {"time": np.array([frame.time]), "particles/id": frame.ids, "particles/spin": frame.omega}
            shot.log = {name: values for name, values in log.items() if name.split("/")[-1] not in frame.lacks}
            for name in (name for name in ("normal", *PLAIN.values()) if name in pairs):
                column = pairs[name]
                shot.log[f"bonds/{name}"] = column.astype(np.uint8) if column.dtype == bool else column
            file.append(shot)
    return [path]


def write_graphml(frames: Iterable[Frame], folder: Path) -> list[Path]:
    """``contacts.graphml``: `graph` of one frame, row by row, for NetworkX, igraph, Gephi, Cytoscape."""
    frame, *more = islice(frames, 2)
    if more:
        raise InputError("a GraphML file holds one network; choose its frame with --frame, without --all")
    parts = dict(zip(("graph", "node", "edge"), _network(frame), strict=True))
    keys = [(kind, name, column.dtype.kind) for kind, columns in parts.items() for name, column in columns.items()]
    data = {kind: "".join(f'<data key="{kind}.{name}">%s</data>' for name in columns) for kind, columns in parts.items()}
    path = folder / "contacts.graphml"
    with atomic_write(path) as draft, open(draft, "w", encoding="utf-8") as file:
        print(f'<?xml version="1.0" encoding="utf-8"?>\n<graphml xmlns="{GRAPHML}">', file=file)
        for kind, name, of in keys:
            print(f'<key id="{kind}.{name}" for="{kind}" attr.name="{name}" attr.type="{TYPES[of]}"/>', file=file)
        (whole,) = plain_rows(*parts["graph"].values())
        print('<graph edgedefault="undirected">', data["graph"] % whole, file=file)
        file.writelines(
            f'<node id="%s">{data["node"]}</node>\n' % (row[0], *row) for row in plain_rows(*parts["node"].values())
        )
        edge = f'<edge source="%s" target="%s">{data["edge"]}</edge>\n'
        file.writelines(edge % (*row[:2], *row) for row in plain_rows(*parts["edge"].values()))
        print("</graph>\n</graphml>", file=file)
    return [path]


FORMATS = {
    "csv": Format("tables of frames, grains and contacts", "", write_csv),
    "parquet": Format("the same tables for pandas, polars, R", "pyarrow", write_parquet),
    "vtk": Format("grains and contacts for ParaView", "", write_vtk),
    "gsd": Format("grains and contacts for OVITO", "gsd", write_gsd),
    "graphml": Format("the network of one frame for NetworkX, Gephi", "", write_graphml),
}


def _needed(name: str) -> Any:
    """An optional package; EnvironmentFault that says how to get it."""
    try:
        return import_module(name)
    except ImportError:
        package = name.split(".")[0]
        raise EnvironmentFault(f"this export needs {package}, which is not installed; pip install {package}") from None


def _records(columns: Columns) -> Iterator[dict[str, Any]]:
    """The rows of a table, one dictionary of plain numbers each."""
    return (dict(zip(columns, row, strict=True)) for row in plain_rows(*columns.values()))


def _spatial(vectors: Floats) -> Floats:
    """(n, 2) as (n, 3) with zeros behind."""
    return np.column_stack((vectors, np.zeros(len(vectors))))
