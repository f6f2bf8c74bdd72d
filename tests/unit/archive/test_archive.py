import filecmp
from dataclasses import replace

import h5py
import numpy as np
import pytest
from lammps_text import random_frame
from test_dumps import same

from workflow.archive.read import Archive, universe
from workflow.archive.write import write_archive
from workflow.data.units import Units
from workflow.errors import ArchiveError, InputError

SERIES = {"step": np.arange(0, 5000, 500.0), "time": np.arange(0, 0.5, 0.05), "stage": np.repeat([1.0, 2.0], 5),
          "phi": np.linspace(0.3, 0.8, 10)}  # fmt: skip
PROVENANCE = {"author": "A. Nonymous", "version": "0.1", "seed": 7, "law": {"mu": 0.5}}


@pytest.fixture
def frames():
    return [random_frame(step, stage=stage, first_id=10) for step, stage in [(0, "a"), (1000, "b"), (2000, "b")]]


@pytest.fixture
def path(tmp_path, frames):
    write_archive(tmp_path / "run.h5", iter(frames), SERIES, PROVENANCE)
    return tmp_path / "run.h5"


def test_what_is_written_is_read_back(path, frames):
    with Archive(path) as archive:
        assert len(archive) == len(archive.frames) == 3
        for a, b in zip(archive.frames, frames, strict=True):
            same(a, b)
        same(archive.frame(-1), frames[-1])
        assert [f.step for f in archive.frames[1:]] == [1000, 2000]
        assert archive.stages == ("a", "b", "b")
        assert archive.provenance == PROVENANCE
        assert list(archive.series) == list(SERIES)
        for name, values in SERIES.items():
            np.testing.assert_array_equal(archive.series[name], values)


def test_the_frame_nearest_to_a_time_is_found(path, frames):
    times = [frame.time for frame in frames]
    with Archive(path) as archive:
        assert [archive.nearest(time + 1e-9) for time in times] == [times.index(time) for time in times]
        assert archive.nearest(1e9) == len(frames) - 1


def test_poured_and_lost_grains_are_read_back(tmp_path):
    def part(step, rows):
        frame = random_frame(step, grains=6, pairs=0)
        chosen = {name: getattr(frame, name)[rows] for name in
                  ("ids", "diameter", "mass", "position", "velocity", "omega", "force", "torque")}  # fmt: skip
        return replace(frame, **chosen)

    frames = [part(0, [0, 1, 2]), part(1, [0, 1, 2, 3, 4]), part(2, [0, 2, 4, 5])]
    write_archive(tmp_path / "heap.h5", frames, {}, {})
    with Archive(tmp_path / "heap.h5") as archive:
        for a, b in zip(archive.frames, frames, strict=True):
            same(a, b)


def test_every_dataset_states_its_unit(tmp_path, frames):
    units = Units("a", "F₀", "T₀")
    write_archive(tmp_path / "run.h5", frames, SERIES, PROVENANCE, units=units)
    found = {}
    with h5py.File(tmp_path / "run.h5") as file:
        file.visititems(lambda name, item: found.update({name: item.attrs["units"].decode()} if hasattr(item, "dtype") else {}))
    assert {name: unit for name, unit in found.items() if unit == "unknown"} == {"observables/phi/value": "unknown"}
    for name, unit in {"particles/grains/velocity/value": "a/T0", "particles/grains/box/edges/value": "a", "contacts/i": "1",
                       "contacts/stretch": "a", "contacts/elastic": "F0", "provenance": "none"}.items():  # fmt: skip
        assert found[name] == unit, name
    with Archive(tmp_path / "run.h5") as archive:
        assert archive.units == archive.frame(0).units == Units("a", "F0", "T0")
        same(replace(archive.frame(0), units=None), frames[0])
    assert universe(tmp_path / "run.h5").trajectory.n_frames == len(frames)


def test_a_file_without_units_is_read(path):
    with Archive(path) as archive:
        assert archive.units is None and "a>" not in repr(archive.frame(0))


def test_the_file_is_h5md(path):
    with h5py.File(path) as file:
        assert list(file["h5md"].attrs["version"]) == [1, 1]
        assert file["h5md/author"].attrs["name"] == "A. Nonymous"
        assert {"name", "version"} <= set(file["h5md/creator"].attrs)
        grains = file["particles/grains"]
        assert grains["box"].attrs["dimension"] == 3 and len(grains["box"].attrs["boundary"]) == 3
        assert grains["box/edges/value"].shape == (3, 3)
        for name in ("position", "velocity", "force"):
            assert grains[f"{name}/value"].shape == (3, 12, 3)
            assert (grains[f"{name}/value"][..., 2] == 0).all()
            assert grains[f"{name}/step"][:].tolist() == [0, 1000, 2000]
        assert set(file["observables/phi"]) == {"step", "time", "value"}
        assert file["contacts/offset"][:].tolist() == [0, 20, 40, 60]
        assert file["contacts/i"][:].min() >= 10  # ids, not rows


def test_mdanalysis_opens_the_file(path, frames):
    u = universe(path)
    assert u.trajectory.n_frames == 3
    ts = u.trajectory[1]
    # MDAnalysis keeps float32: relative rounding 6e-8.
    np.testing.assert_allclose(u.atoms.positions[:, :2], frames[1].position, rtol=1e-7)
    np.testing.assert_allclose(u.atoms.velocities[:, :2], frames[1].velocity, rtol=1e-7)
    np.testing.assert_allclose(ts.dimensions[:2], frames[1].cell, rtol=1e-7)
    np.testing.assert_array_equal(u.atoms.masses, frames[1].mass)
    np.testing.assert_array_equal(u.atoms.radii, frames[1].diameter / 2)
    assert u.atoms.ids.tolist() == frames[1].ids.tolist()
    assert ts.data["phi"] == SERIES["phi"][2]  # the row of step 1000, not row 1


@pytest.mark.parametrize("rows", [0, 1, 10])
def test_mdanalysis_opens_the_file_plainly_whatever_the_length_of_the_series(tmp_path, frames, rows):
    import MDAnalysis

    series = {name: values[:rows] for name, values in SERIES.items()}
    write_archive(tmp_path / "run.h5", frames, series, {})
    u = MDAnalysis.Universe.empty(12)
    u.load_new(str(tmp_path / "run.h5"), format="H5MD", convert_units=False)
    assert [ts.data["step"] for ts in u.trajectory] == [0, 1000, 2000]
    with Archive(tmp_path / "run.h5") as archive:
        assert len(archive.series.get("phi", [])) == rows


def test_equal_input_gives_equal_bytes(tmp_path, frames):
    for name in ("a.h5", "b.h5"):
        write_archive(tmp_path / name, frames, SERIES, PROVENANCE)
    assert filecmp.cmp(tmp_path / "a.h5", tmp_path / "b.h5", shallow=False)


def test_a_failure_leaves_the_old_file_and_nothing_else(path, frames):
    before = path.read_bytes()

    def broken():
        yield frames[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_archive(path, broken(), SERIES, PROVENANCE)
    for bad in ([], [frames[0], replace(frames[1], mass=frames[1].mass * 2)], [frames[0], random_frame(1, first_id=2)]):
        with pytest.raises(ArchiveError, match=r"no complete frame|mass of grain 10|new grain id 2"):
            write_archive(path, bad, SERIES, PROVENANCE)
    with pytest.raises(InputError, match="provenance"):
        write_archive(path, frames, SERIES, {"law": object()})
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == ["run.h5"]


def test_an_unwritable_directory_is_named(tmp_path, frames):
    with pytest.raises(ArchiveError, match="cannot write"):
        write_archive(tmp_path / "absent" / "run.h5", frames, SERIES, PROVENANCE)


def test_frames_that_do_not_exist_are_named(path):
    with Archive(path) as archive, pytest.raises(InputError, match="allowed: -3 to 2"):
        archive.frame(3)


def test_files_that_are_no_archive_are_named(tmp_path, path):
    (tmp_path / "text.h5").write_text("no HDF5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["data"] = 1
    (tmp_path / "cut.h5").write_bytes(path.read_bytes()[:5000])
    for name, message in [("absent.h5", "cannot open"), ("text.h5", "not an HDF5 file"), ("cut.h5", "cut off"),
                          ("other.h5", "'h5md' is missing")]:  # fmt: skip
        with pytest.raises(ArchiveError, match=message):
            Archive(tmp_path / name)


@pytest.mark.parametrize("name", ["contacts/offset", "particles/grains/torque", "provenance"])
def test_a_missing_part_is_named(path, name):
    with h5py.File(path, "a") as file:
        del file[name]
    with pytest.raises(ArchiveError, match=name):
        Archive(path)


def test_names_in_the_file_are_those_of_every_version(path):
    """Archives of versions 0.2 and 0.3 and of this one are read by each other."""
    with h5py.File(path) as file:
        assert set(file["contacts"]) == {
            "i", "j", "branch", "gap", "elastic", "viscous", "attraction", "tangential", "moment", "stretch", "rotation",
            "sliding", "rolling", "offset",
        }  # fmt: skip
        assert {"angular_velocity", "torque", "position", "velocity", "force"} <= set(file["particles/grains"])
