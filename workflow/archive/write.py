"""Frames, time series and provenance -> one HDF5 file that H5MD readers (MDAnalysis) open."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import h5py
import numpy as np

from workflow.archive import layout
from workflow.data.files import PathLike, atomic_write
from workflow.data.frame import Floats, Frame, Ints, Tracks
from workflow.data.units import Units
from workflow.errors import ArchiveError, InputError

# Rows per HDF5 chunk: 64 kB of float64, small against a frame of a real run and no waste in a small one.
CHUNK = 8192
# Measured on 20 frames of 5600 grains: 27 MB in 0.5 s plain, 15 MB in 1.5 s so; higher levels save 1 % more.
COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
# HDF5 1.10 and later have checksums in all their own records, fletcher32 adds those of the data: damage is noticed
FORMAT = ("v110", "v110")
CHECKED = {"fletcher32": True}
STAGE_NAME = h5py.string_dtype(length=32)  # of fixed length: what varies in length lies in a heap without checksum


def write_archive(
    path: PathLike,
    frames: Iterable[Frame],
    series: Mapping[str, Floats],
    provenance: Mapping[str, Any],
    tracks: Tracks | None = None,
    units: Units | None = None,
) -> None:
    """Write ``frames`` (streamed: one in memory at a time), ``series`` and ``provenance`` to one H5MD 1.1 file.

    ``series``: name -> (rows,) float64 with ``step`` and ``time`` (see `read_series`), or empty.  ``provenance``: JSON
    data; its ``author`` and ``version``, if any, fill the H5MD author and creator.  Grains may appear (with ids above
    those known) and vanish; mass and diameter are constant.  With ``units`` every dataset states its own in the attribute
    ``units`` (see `layout.quantity_of`; "1" for a number, "none" for text).  The file appears complete or not at all.  Raises
    ArchiveError (no frame, inconsistent grains, unwritable path) and InputError (provenance is no JSON).
    """
    try:
        document = json.dumps(dict(provenance), sort_keys=True, indent=1)
    except (TypeError, ValueError) as error:
        raise InputError(f"provenance: {error}; give only strings, numbers, lists and dictionaries") from None
    with atomic_write(path) as draft, h5py.File(draft, "w", libver=FORMAT) as file:
        _head(file, provenance)
        writer = _Writer(file, path)
        for frame in frames:
            writer.add(frame)
        if not writer.count:
            raise ArchiveError(f"nothing to write to '{path}': the run has no complete frame; let it run longer")
        _series(file, series, writer.count)
        if tracks is not None:
            _tracks(file, tracks)
        text = document.encode()
        kind = h5py.string_dtype(length=max(len(text), 1))
        file.create_dataset(layout.PROVENANCE, data=np.array([text], dtype=kind), chunks=(1,), **CHECKED)
        if units is not None:
            _state_units(file, units.plain)


def _head(file: h5py.File, provenance: Mapping[str, Any]) -> None:
    head = file.create_group("h5md")
    head.attrs["version"] = np.array([1, 1], dtype=np.int32)
    head.create_group("author").attrs["name"] = str(provenance.get("author", "unknown"))
    creator = head.create_group("creator")
    creator.attrs["name"] = "workflow"
    creator.attrs["version"] = str(provenance.get("version", "unknown"))
    box = file.create_group(f"{layout.GRAINS}/box")
    box.attrs["dimension"] = 3
    box.attrs["boundary"] = _boundary((True, True))


def _boundary(periodic: tuple[bool, bool]) -> np.ndarray:
    return np.array([b"periodic" if axis else b"none" for axis in (*periodic, False)])


class _Writer:
    """Appends frames; all datasets grow along their first axis, per-grain ones along the second too."""

    def __init__(self, file: h5py.File, path: PathLike) -> None:
        self.file, self.path, self.count, self.rows = file, path, 0, 0
        self.known: dict[str, np.ndarray] = {}

    def add(self, frame: Frame) -> None:
        if not self.count:
            self._create(frame)
        rows = self._register(frame)
        group = self.file[layout.GRAINS]
        self._append(group["position/step"], frame.step)
        self._append(group["position/time"], frame.time)
        self._append(group["box/edges/value"], [*frame.cell, 1.0])
        self._append(group["box/origin/value"], frame.origin)
        self._append(self.file[layout.STAGE], frame.stage.encode())
        for name, field in (layout.VECTORS | layout.SCALARS).items():
            self._append(group[f"{name}/value"], self._spread(getattr(frame, field), rows))
        self._contacts(frame)
        self.count += 1

    def _create(self, frame: Frame) -> None:
        """All datasets, empty; step and time are shared by hard links, as H5MD allows."""
        group = self.file[layout.GRAINS]
        group["box"].attrs["boundary"] = _boundary(frame.periodic)
        chunk = min(max(frame.grains, 1), CHUNK)
        for name in layout.VECTORS:
            _dataset(group, f"{name}/value", (0, 0, 3), (None, None, 3), (1, chunk, 3))
        for name in layout.SCALARS:
            _dataset(group, f"{name}/value", (0, 0), (None, None), (1, chunk))
        _dataset(group, "position/step", (0,), (None,), (256,), np.int64)
        _dataset(group, "position/time", (0,), (None,), (256,))
        _dataset(group, "box/edges/value", (0, 3), (None, 3), (256, 3))
        _dataset(group, "box/origin/value", (0, 2), (None, 2), (256, 2))
        for name in (*layout.VECTORS, *layout.SCALARS, "box/edges", "box/origin"):
            for clock in () if name == "position" else ("step", "time"):
                group[f"{name}/{clock}"] = group[f"position/{clock}"]
        for name, field in layout.CONSTANTS.items():
            self.known[name] = getattr(frame, field)[:0]
            _dataset(group, name, (0,), (None,), (chunk,), self.known[name].dtype)
        for name, stored in layout.COLUMNS.items():
            column = getattr(frame.interactions, name)
            _dataset(self.file, f"{layout.CONTACTS}/{stored}", (0, *column.shape[1:]),
                     (None, *column.shape[1:]), (CHUNK, *column.shape[1:]), column.dtype)  # fmt: skip
        _dataset(self.file, layout.OFFSET, (1,), (None,), (256,), np.int64, fill=0)
        _dataset(self.file, layout.STAGE, (0,), (None,), (256,), STAGE_NAME, fill=b"")

    def _register(self, frame: Frame) -> Ints:
        """Rows of the frame's grains in the file; grains with new ids are added behind the known ones."""
        known = self.known["id"]
        fresh = ~np.isin(frame.ids, known)
        if fresh.any() and len(known) and frame.ids[fresh][0] < known[-1]:
            raise ArchiveError(
                f"frames for '{self.path}', step {frame.step}: new grain id {frame.ids[fresh][0]} is below the known id "
                f"{known[-1]}; new grains need increasing ids; correct the insertion in the deck"
            )
        for name, field in layout.CONSTANTS.items():
            self.known[name] = np.concatenate((self.known[name], getattr(frame, field)[fresh]))
            if fresh.any():
                dataset = self.file[layout.GRAINS][name]
                dataset.resize(len(self.known[name]), axis=0)
                dataset[len(known) :] = self.known[name][len(known) :]
        rows = np.searchsorted(self.known["id"], frame.ids)
        for name, field in layout.CONSTANTS.items():
            changed = self.known[name][rows] != getattr(frame, field)
            if changed.any():
                raise ArchiveError(
                    f"frames for '{self.path}', step {frame.step}: {name} of grain {frame.ids[changed][0]} differs from "
                    "earlier frames; all frames must come from one run"
                )
        return rows

    def _spread(self, values: Floats, rows: Ints) -> Floats:
        """Per-grain values at their rows in the file, NaN where a grain is absent, third component 0."""
        if values.ndim == 2:
            values = np.column_stack((values, np.zeros(len(values))))
        full = np.full((len(self.known["id"]), *values.shape[1:]), np.nan)
        full[rows] = values
        return full

    def _append(self, dataset: h5py.Dataset, value: Any) -> None:
        shape = (self.count + 1, *np.shape(value))
        dataset.resize((shape[0], *(max(new, old) for new, old in zip(shape[1:], dataset.shape[1:], strict=True))))
        dataset[self.count] = value

    def _contacts(self, frame: Frame) -> None:
        start, self.rows = self.rows, self.rows + len(frame.interactions)
        for name, stored in layout.COLUMNS.items():
            dataset = self.file[layout.CONTACTS][stored]
            column = getattr(frame.interactions, name)
            dataset.resize(self.rows, axis=0)
            dataset[start:] = frame.ids[column] if name in ("i", "j") else column
        offset = self.file[layout.OFFSET]
        offset.resize(self.count + 2, axis=0)
        offset[-1] = self.rows


def _dataset(
    group: h5py.Group, name: str, shape: tuple, maximum: tuple, chunks: tuple, dtype: Any = np.float64, fill: Any = None
) -> None:
    if fill is None and dtype is np.float64:
        fill = np.nan
    group.create_dataset(name, shape, dtype, maxshape=maximum, chunks=chunks, fillvalue=fill, **COMPRESSION, **CHECKED)


def _tracks(file: h5py.File, tracks: Tracks) -> None:
    group = file.create_group(layout.TRACKS)
    position = tracks.position.astype(np.float32)
    for name, values in (("time", tracks.time), ("id", tracks.ids), ("position", position)):
        chunks = True if values.size else None  # of nothing there are none
        group.create_dataset(name, data=values, chunks=chunks, **({**COMPRESSION, **CHECKED} if values.size else {}))


def _state_units(file: h5py.File, units: Units) -> None:
    """The names of the units at the root, that of every dataset beside it.

    ``units``, as netCDF and its readers have it: H5MD's ``unit`` is for SI and the like, and MDAnalysis refuses all others.
    Of fixed length, as STAGE_NAME.
    """
    for name, unit in zip(layout.UNITS, units, strict=True):
        file.attrs[name] = np.bytes_(unit)

    def state(path: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            quantity, of_series = layout.quantity_of(path)
            text = item.dtype.kind in "SO"
            unit = "none" if text else units.of_series(quantity) if of_series else units.of(quantity)
            item.attrs["units"] = np.bytes_(unit)

    file.visititems(state)


def _series(file: h5py.File, series: Mapping[str, Floats], frames: int) -> None:
    if not series or not len(series["step"]):
        return
    name = layout.SERIES if len(series["step"]) >= frames else layout.SHORT_SERIES
    group = file.create_group(name, track_order=True)
    clock = {"step": np.asarray(series["step"], dtype=np.int64), "time": series["time"]}
    shared: dict[str, h5py.Dataset] = {}  # step and time are the same for all: written once, linked
    for name, values in series.items():
        if name not in clock:
            element = group.create_group(name)
            element.create_dataset("value", data=values, chunks=(min(len(values), CHUNK),), **CHECKED)
            for key, data in clock.items():
                if key not in shared:
                    shared[key] = element.create_dataset(key, data=data, chunks=(min(len(data), CHUNK),), **CHECKED)
                else:
                    element[key] = shared[key]
