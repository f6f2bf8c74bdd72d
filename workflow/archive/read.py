"""Reading a run's HDF5 file: frames on demand, time series, stage names, provenance, and a MDAnalysis Universe."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from types import TracebackType
from typing import TYPE_CHECKING, Any, overload

import h5py
import numpy as np

from workflow.archive import layout
from workflow.archive.dumps import rows_of
from workflow.data.files import PathLike
from workflow.data.frame import QUANTITIES, Floats, Frame, Interactions, Tracks, validate_frame
from workflow.data.units import Units
from workflow.errors import ArchiveError, EnvironmentFault, InputError, WorkflowError

if TYPE_CHECKING:
    import MDAnalysis

# what h5py raises, and NumPy on what it returns, when a file is damaged or is not what it claims to be
FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}  # those of `write_archive`
DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError, MemoryError,
          SystemError)  # fmt: skip


class Archive:
    """One run's file, open for reading; a context manager.

    Raises ArchiveError if the file is absent, no HDF5, lacks a part, or is damaged: HDF5 keeps checksums of all that
    `write_archive` writes, so a changed bit is an error, never another number.  InputError for a frame that does not exist.
    """

    def __init__(self, path: PathLike) -> None:
        self.path = path
        try:
            self._file = h5py.File(path, "r")
        except OSError as error:
            reason = error.strerror or "it is not an HDF5 file, or it is cut off"
            raise ArchiveError(f"cannot open archive '{path}': {reason}; give the archive of a finished run") from None
        try:
            with self._reading("layout"):
                misfit = self._misfit()
            if misfit:
                raise ArchiveError(
                    f"archive '{path}': {misfit}; expected the layout of workflow.archive.layout; delete it, and "
                    "'wf measure' of its run directory writes it again"
                )
        except ArchiveError:
            self.close()
            raise

    @contextmanager
    def _reading(self, what: str) -> Iterator[None]:
        """Whatever goes wrong within is an ArchiveError that names ``what``."""
        try:
            yield
        except WorkflowError:
            raise
        except DAMAGE as fault:
            words = str(fault).splitlines()[0] if str(fault) else type(fault).__name__
            raise ArchiveError(
                f"archive '{self.path}', {what}: {words}; the file is damaged: delete it, and 'wf measure' of its run "
                "directory writes it again"
            ) from None

    def _misfit(self) -> str | None:
        """What is not as the layout says, None if all is."""
        odd = self._leads_out()
        if odd:
            return f"'{odd}' is kept elsewhere (a link, raw or virtual storage, a filter), which is not followed"
        for name in ("h5md", layout.PROVENANCE):
            if name not in self._file:
                return f"'{name}' is missing"
        sizes: dict[str | int, int] = {}
        for name, (kinds, shape) in layout.REQUIRED.items():
            found = self._file.get(name)
            if not isinstance(found, h5py.Dataset):
                return f"'{name}' is missing"
            if found.dtype.kind not in kinds or found.ndim != len(shape):
                return f"'{name}' holds {found.dtype} of {found.ndim} dimensions"
            for length, wanted in zip(found.shape, shape, strict=True):
                if wanted == "F+1":
                    length, wanted = length - 1, "F"
                if length != (wanted if isinstance(wanted, int) else sizes.setdefault(wanted, length)):
                    return f"'{name}' has the shape {found.shape}, which does not fit the others"
        return None

    def _leads_out(self) -> str | None:
        """Name of the first thing whose bytes are not in this file, or need other code to be read; None if all are."""
        links: list[tuple[bytes, int, int]] = []
        self._file.id.links.visit(lambda name, link: links.append((name, link.type, link.u)), info=True)
        places = {place: name for name, kind, place in links if kind == h5py.h5l.TYPE_HARD}
        odd = [name for name, kind, _ in links if kind != h5py.h5l.TYPE_HARD]
        for name in places.values():
            found = h5py.h5o.open(self._file.id, name)
            if isinstance(found, h5py.h5d.DatasetID):
                made = found.get_create_plist()
                filters = {made.get_filter(k)[0] for k in range(made.get_nfilters())}
                if made.get_external_count() or made.get_layout() == h5py.h5d.VIRTUAL or not filters <= FILTERS:
                    odd.append(name)
        return odd[0].decode(errors="replace") if odd else None

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    def __len__(self) -> int:
        """Number of frames."""
        return int(self._file[layout.STAGE].shape[0])

    @property
    def frames(self) -> Frames:
        """All frames as a sequence; each is read when it is asked for."""
        return Frames(self)

    @cached_property
    def stages(self) -> tuple[str, ...]:
        """Stage name of every frame."""
        with self._reading("stages"):
            return tuple(self._file[layout.STAGE].asstr()[:])

    @cached_property
    def ends(self) -> dict[str, int]:
        """Number of the last frame of each stage, in the order of the stages."""
        return {stage: k for k, stage in enumerate(self.stages)}

    def nearest(self, time: float) -> int:
        """Number of the frame nearest to ``time``."""
        with self._reading("times"):
            return int(np.argmin(np.abs(self._file[f"{layout.GRAINS}/position/time"][:] - time)))

    @cached_property
    def series(self) -> dict[str, Floats]:
        """Time series, name -> (rows,) float64, beginning with ``step`` and ``time``; empty if none was written."""
        with self._reading("time series"):
            group = self._file.get(layout.SERIES, self._file.get(layout.SHORT_SERIES))
            if group is None:
                return {}
            first = next(iter(group.values()))
            clock = {name: first[name][:].astype(np.float64) for name in ("step", "time")}
            series = clock | {name: element["value"][:].astype(np.float64) for name, element in group.items()}
            for name, values in series.items():
                if values.shape != clock["step"].shape or values.ndim != 1:
                    raise ValueError(f"'{name}' has the shape {values.shape}, 'step' {clock['step'].shape}")
            return series

    @cached_property
    def provenance(self) -> dict[str, Any]:
        """What `write_archive` was given: parameters, seeds, versions, hashes."""
        with self._reading("provenance"):
            text = np.ravel(self._file[layout.PROVENANCE].asstr()[()])[0]
            found = json.loads(text)
            if not isinstance(found, dict):
                raise ValueError(f"found {text[:40]!r}, expected names and values")
            return found

    def frame(self, index: int) -> Frame:
        """Frame ``index``; negative counts from the end."""
        count = len(self)
        if not -count <= index < count:
            raise InputError(f"frame {index} does not exist in '{self.path}'; allowed: {-count} to {count - 1}")
        with self._reading(f"frame {index}"):
            return validate_frame(self._frame(index % count), f"archive '{self.path}', frame {index}")

    def _frame(self, k: int) -> Frame:
        group = self._file[layout.GRAINS]
        present = ~np.isnan(group["torque/value"][k])
        vectors = {field: group[f"{name}/value"][k, :, :2][present] for name, field in layout.VECTORS.items()}
        scalars = {field: group[f"{name}/value"][k][present] for name, field in layout.SCALARS.items()}
        constants = {field: group[name][:][present] for name, field in layout.CONSTANTS.items()}
        return Frame(
            step=int(group["position/step"][k]),
            time=float(group["position/time"][k]),
            stage=self.stages[k],
            origin=group["box/origin/value"][k],
            cell=group["box/edges/value"][k, :2],
            interactions=self._contacts(k, constants["ids"]),
            periodic=self._periodic,
            units=self.units,
            lacks=self._lacks,
            **vectors, **scalars, **constants,
        )  # fmt: skip

    @cached_property
    def units(self) -> Units | None:
        """Names of the units in ASCII; None for a file that states none, as those of version 0.3 and before.

        Attributes have no checksum: the names at the root must agree with those beside the data.
        """
        with self._reading("units"):
            names = [self._file.attrs.get(name) for name in layout.UNITS]
            group = self._file[layout.GRAINS]
            beside = [group[name].attrs.get("units") for name in ("position/value", "force/value", "position/time")]
            if names == beside == [None] * 3:
                return None
            units = Units(*(name.decode() for name in names))
            expected = [units.of(name) for name in ("position", "force", "time")]
            if expected != [name.decode() for name in beside]:
                raise ValueError(f"the units {', '.join(units)} are not those of the data")
            return units

    @cached_property
    def _lacks(self) -> frozenset[str]:
        """What the law of the run does not tell, of QUANTITIES."""
        names = self.provenance.get("lacks", [])
        if not set(names) <= set(QUANTITIES):
            raise ValueError(f"'lacks' names {names!r}, of which not all are quantities")
        return frozenset(names)

    @cached_property
    def _periodic(self) -> tuple[bool, bool]:
        x, y, *_ = (bool(face == b"periodic") for face in self._file[f"{layout.GRAINS}/box"].attrs["boundary"])
        return x, y

    @cached_property
    def tracks(self) -> Tracks | None:
        """Positions at short intervals, if the run recorded them."""
        with self._reading("tracks"):
            group = self._file.get(layout.TRACKS)
            if group is None:
                return None
            time, ids, position = (group[name][:] for name in ("time", "id", "position"))
            if position.shape != (*time.shape, *ids.shape, 2) or time.ndim != 1 or ids.dtype.kind not in "iu":
                raise ValueError(f"'position' has the shape {position.shape}, 'time' {time.shape}, 'id' {ids.shape}")
            return Tracks(time.astype(np.float64), ids, position.astype(np.float64))

    def _contacts(self, k: int, ids: np.ndarray) -> Interactions:
        start, stop = self._file[layout.OFFSET][k : k + 2]
        group = self._file[layout.CONTACTS]
        if not 0 <= start <= stop <= len(group["i"]):
            raise ValueError(f"rows {start} to {stop} of the contact table do not exist")
        columns = {name: group[column][start:stop] for name, column in layout.COLUMNS.items()}
        for name in ("i", "j"):
            columns[name] = rows_of(columns[name], ids, f"archive '{self.path}', frame {k}")
        return Interactions(**columns)


class Frames(Sequence[Frame]):
    """The frames of an archive, read on demand."""

    def __init__(self, archive: Archive) -> None:
        self._archive = archive

    def __len__(self) -> int:
        return len(self._archive)

    def __repr__(self) -> str:
        return f"<Frames: {len(self)} in {', '.join(self._archive.ends)}>"

    def __iter__(self) -> Iterator[Frame]:
        return (self._archive.frame(k) for k in range(len(self)))

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        if isinstance(index, slice):
            return [self._archive.frame(k) for k in range(*index.indices(len(self)))]
        return self._archive.frame(operator.index(index))


def universe(path: PathLike) -> MDAnalysis.Universe:
    """MDAnalysis Universe of the archive: grain ids, masses, radii, and the trajectory (float32, scene units).

    MDAnalysis pairs row k of a time series with frame k; here ``ts.data`` holds the row at or before the frame's step.
    Raises ArchiveError for a bad file, EnvironmentFault if MDAnalysis is not installed.
    """
    try:
        import MDAnalysis
    except ImportError:
        raise EnvironmentFault("MDAnalysis is not installed; pip install MDAnalysis h5py") from None
    with Archive(path) as archive:
        group = archive._file[layout.GRAINS]
        constants = {name: group[name][:] for name in layout.CONSTANTS}
        series = archive.series
    result = MDAnalysis.Universe.empty(len(constants["id"]), trajectory=False)
    result.add_TopologyAttr("ids", constants["id"])
    result.add_TopologyAttr("masses", constants["mass"])
    result.add_TopologyAttr("radii", constants["diameter"] / 2)

    def pair(ts: Any) -> Any:
        row = max(int(np.searchsorted(series["step"], ts.data["step"], "right")) - 1, 0)
        ts.data.update({name: values[row] for name, values in series.items() if name not in ("step", "time")})
        return ts

    result.load_new(os.fspath(path), format="H5MD", convert_units=False)
    if series:
        result.trajectory.add_transformations(pair)
    return result
