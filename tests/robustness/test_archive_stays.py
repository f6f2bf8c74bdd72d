"""A good archive is never exchanged for a worse one, and what is sealed is believed, not what lies beside it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from workflow.archive.read import Archive, universe
from workflow.errors import ArchiveError
from workflow.runs.directory import RunDirectory

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]


def halved(content: bytes) -> bytes:
    return content[: len(content) // 2]


def cut_at_a_frame(content: bytes) -> bytes:
    """Sound as far as it goes: only its end is missing."""
    return content[: content.rindex(b"ITEM: TIME\n")]


def longer(content: bytes) -> bytes:
    return content + content[content.rindex(b"ITEM: TIME\n") :].replace(b"ITEM: TIMESTEP\n", b"ITEM: TIMESTEP\n1", 1)


@pytest.mark.parametrize(
    "change", [halved, cut_at_a_frame, longer, lambda content: b""], ids=["half", "frame", "longer", "empty"]
)
@pytest.mark.parametrize("name", ["grains.dump", "contacts.dump"])
def test_damaged_dumps_leave_the_archive(
    name: str, change: Callable[[bytes], bytes], packing: Path, fresh: Fresh, wf: Wf
) -> None:
    run = fresh(packing, {name: change((packing / name).read_bytes())})
    before = (run / "run.h5").read_bytes()
    status, out, err = wf("measure", run, "--json")
    assert status == 0
    assert json.loads(out) == json.loads(wf("measure", packing, "--json")[1])
    assert name in err and "run.h5', which is sound, stays as it is" in err
    assert (run / "run.h5").read_bytes() == before


@pytest.mark.parametrize("change", [halved, cut_at_a_frame, longer])
@pytest.mark.parametrize("name", ["grains.dump", "contacts.dump"])
def test_no_archive_is_made_of_damaged_dumps(
    name: str, change: Callable[[bytes], bytes], packing: Path, fresh: Fresh, wf: Wf
) -> None:
    run = fresh(packing, {name: change((packing / name).read_bytes()), "run.h5": None})
    status, _, err = wf("measure", run)
    assert status == 1 and name.split(".")[0] in err
    assert not (run / "run.h5").exists()


def test_one_changed_digit_in_a_dump_is_no_archive(packing: Path, fresh: Fresh, wf: Wf) -> None:
    whole = (packing / "grains.dump").read_bytes()
    at = whole.rindex(b"e-0") - 3
    changed = whole[:at] + (b"1" if whole[at : at + 1] != b"1" else b"2") + whole[at + 1 :]
    run = fresh(packing, {"grains.dump": changed, "run.h5": None})
    status, _, err = wf("measure", run)
    assert status == 1 and "grains.dump' is not what the run wrote" in err


def test_a_lost_archive_is_made_again_from_whole_dumps(packing: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, {"run.h5": None})
    assert json.loads(wf("measure", run, "--json")[1]) == json.loads(wf("measure", packing, "--json")[1])
    assert (run / "run.h5").read_bytes() == (packing / "run.h5").read_bytes()


def test_the_archive_of_another_run_is_refused(packing: Path, heap: Path, fresh: Fresh, wf: Wf) -> None:
    run = fresh(packing, {"run.h5": (heap / "run.h5").read_bytes()})
    status, _, err = wf("measure", run)
    assert status == 1 and "archive of another run" in err


@pytest.mark.parametrize("name", ["log.lammps", "series.txt"])
@pytest.mark.parametrize("kind", ["packing", "heap"])
def test_log_and_series_are_not_believed(name: str, kind: str, request: pytest.FixtureRequest, fresh: Fresh, wf: Wf) -> None:
    """Cut, gone, or with another digit: the measures are those of the sealed copies."""
    whole = request.getfixturevalue(kind)
    right = json.loads(wf("measure", whole, "--json")[1])
    text = (whole / name).read_bytes()
    for changed in (halved(text), None, text.replace(b"equilibrated 1", b"equilibrated 0").replace(b" 1 ", b" 2 ")):
        status, out, err = wf("measure", fresh(whole, {name: changed}), "--json")
        assert status == 0, err
        assert json.loads(out) == right


def external(file: h5py.File, other: Path) -> None:
    file["contacts/gap"] = h5py.ExternalLink(str(other), "contacts/gap")


def soft(file: h5py.File, other: Path) -> None:
    file["contacts/gap"] = h5py.SoftLink("/contacts/attraction")


def raw(file: h5py.File, other: Path) -> None:
    count = len(file["contacts/attraction"])
    file.create_dataset("contacts/gap", (count,), "f8", external=[(str(other), 0, 8 * count)])


def virtual(file: h5py.File, other: Path) -> None:
    shape = file["contacts/attraction"].shape
    layout = h5py.VirtualLayout(shape, "f8")
    layout[:] = h5py.VirtualSource(str(other), "contacts/gap", shape)
    file.create_virtual_dataset("contacts/gap", layout)


@pytest.mark.parametrize("kind", [external, soft, raw, virtual], ids=lambda kind: kind.__name__)
def test_bytes_of_other_files_are_not_read(
    kind: Callable[[h5py.File, Path], None], packing: Path, fresh: Fresh, wf: Wf
) -> None:
    run = fresh(packing, {})
    with h5py.File(run / "run.h5", "a") as file:
        del file["contacts/gap"]
        kind(file, packing / "run.h5")
    status, _, err = wf("measure", run)
    assert status == 1 and "'contacts/gap' is kept elsewhere" in err
    with pytest.raises(ArchiveError, match="kept elsewhere"):
        universe(run / "run.h5")


def test_the_archive_knows_how_the_run_ended(packing: Path) -> None:
    with Archive(packing / "run.h5") as archive:
        assert archive.provenance["result"] == RunDirectory(packing).state["result"]
        assert np.isfinite(archive.series["time"]).all()
