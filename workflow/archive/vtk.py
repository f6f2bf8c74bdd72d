"""VTK's XML files for points and lines, float64 as raw bytes: all that ParaView needs, without the VTK library."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from workflow.data.files import atomic_write
from workflow.data.frame import Floats

TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}
HEAD = '<VTKFile type="{}" version="1.0" byte_order="{}Endian" header_type="UInt64">\n'
ORDER = sys.byteorder.capitalize()


def write_polydata(
    path: Path, points: Floats, kind: str, data: Mapping[str, np.ndarray], whole: Mapping[str, np.ndarray]
) -> None:
    """One VTP file of ``points`` (P, 3) with ``data``, columns of one row per point or line, and ``whole``, of the file.

    ``kind``: Verts, a vertex at each point, or Lines, a line between each two points in a row.  A line's data stand at
    the line and at both its points (ParaView's tubes take their radius from points).
    """
    ends = 2 if kind == "Lines" else 1
    cells, arrays = len(points) // ends, _Arrays()
    at_points = {name: np.repeat(column, ends, axis=0) for name, column in data.items()}
    parts = [
        ("PointData", at_points), ("CellData", data if ends == 2 else {}), ("Points", {"points": points}),
        (kind, {"connectivity": np.arange(len(points)), "offsets": ends * np.arange(1, cells + 1)}),
    ]  # fmt: skip
    piece = "".join(f"<{tag}>\n{arrays.declared(columns)}</{tag}>\n" for tag, columns in parts)
    sizes = {"Points": len(points), "Verts": 0, "Lines": 0, "Strips": 0, "Polys": 0} | {kind: cells}
    counts = " ".join(f'NumberOf{name}="{number}"' for name, number in sizes.items())
    field = arrays.declared(whole, whole=True)
    text = f"<PolyData>\n<FieldData>\n{field}</FieldData>\n<Piece {counts}>\n{piece}</Piece>\n</PolyData>\n"
    with atomic_write(path) as draft, open(draft, "wb") as file:
        file.write((HEAD.format("PolyData", ORDER) + text + '<AppendedData encoding="raw">\n_').encode("ascii"))
        for block in arrays.blocks:
            file.write(np.uint64(block.nbytes).tobytes())
            file.write(block.tobytes())
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def write_collection(path: Path, members: Sequence[tuple[float, Path]]) -> None:
    """A PVD file: the time of each of the ``members``, files in the same folder."""
    rows = "".join(f'<DataSet timestep="{time!r}" part="0" file="{member.name}"/>\n' for time, member in members)
    with atomic_write(path) as draft:
        draft.write_text(
            HEAD.format("Collection", ORDER) + f"<Collection>\n{rows}</Collection>\n</VTKFile>\n", encoding="ascii"
        )


class _Arrays:
    """Arrays of a file, declared in the text and appended behind it, each after its length in bytes."""

    def __init__(self) -> None:
        self.blocks: list[np.ndarray] = []
        self.offset = 0

    def declared(self, columns: Mapping[str, np.ndarray], *, whole: bool = False) -> str:
        return "".join(self._declare(name, column, whole) for name, column in columns.items())

    def _declare(self, name: str, column: np.ndarray, whole: bool) -> str:
        block = np.ascontiguousarray(column.astype(np.uint8) if column.dtype == bool else column)
        size = f'NumberOfTuples="{len(block)}"' if whole else f'NumberOfComponents="{block[0].size if len(block) else 1}"'
        text = (
            f'<DataArray type="{TYPES[block.dtype.str[1:]]}" Name="{name}" {size} format="appended" offset="{self.offset}"/>\n'
        )
        self.blocks.append(block)
        self.offset += block.nbytes + 8
        return text
