"""Every reader, given what no program of ours wrote: the right answer or a sentence, in time, and nothing is executed.

The examples are the same each time: a failure here fails again.  `WORKFLOW_FUZZ=100 pytest tests/robustness` draws a hundred
times as many at random.
"""

from __future__ import annotations

import ast
import io
import json
import struct
from collections.abc import Callable
from dataclasses import fields
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import Any

import drawn
import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mutations import DEADLINE, VALUES, deadline, edited, flipped, replaced

import workflow
from workflow.archive.dumps import read_blocks, read_frames
from workflow.archive.foreign import foreign_frames
from workflow.archive.read import Archive
from workflow.data.series import read_series
from workflow.errors import ArchiveError, InputError, WorkflowError
from workflow.pipeline.collect import measures_of, stored_measures
from workflow.runs.checkpoint import step_of
from workflow.runs.directory import RunDirectory
from workflow.runs.execute import _start
from workflow.scene.registry import read_toml, scene_from, to_toml

Wf = Callable[..., tuple[int, str, str]]
Fresh = Callable[..., Path]
STUDY = b'scene = "method1"\nseeds = 3\n[fixed]\ncohesion = false\nn = 60\n[grid]\nmu = [0.15, 0.5]\nrolling = [false, true]\n'


examples = partial(drawn.examples, deadline=timedelta(seconds=DEADLINE))


def plain(value: Any) -> Any:
    """A value to compare: arrays by their bytes."""
    return value.tobytes() if isinstance(value, np.ndarray) else value


def content(path: Path) -> list[Any]:
    """Everything in an archive, to compare."""
    with Archive(path) as archive:
        frames = [
            [plain(getattr(part, entry.name)) for part in (frame, frame.interactions) for entry in fields(part)
             if entry.name != "interactions"]
            for frame in archive.frames
        ]  # fmt: skip
        series = {name: values.tobytes() for name, values in archive.series.items()}
        tracks = archive.tracks
        return [frames, series, archive.provenance, archive.stages, tracks and [a.tobytes() for a in vars(tracks).values()]]


@pytest.mark.parametrize("kind", ["packing", "heap"])
@examples(35)
@given(data=st.data())
def test_a_damaged_archive_gives_an_error_or_what_was_written(
    kind: str, data: st.DataObject, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    """Bits, cuts and insertions anywhere: never another number."""
    whole = request.getfixturevalue(kind) / "run.h5"
    path = tmp_path / "run.h5"
    path.write_bytes(data.draw(flipped(whole.read_bytes())))
    with deadline():
        try:
            found = content(path)
        except ArchiveError as fault:
            assert str(path) in str(fault)
        else:
            right = content(whole)
            assert found == right, [k for k in range(5) if found[k] != right[k]]


def alter(draw: Callable[..., Any], path: Path) -> None:
    """Change an archive through HDF5 itself: whole in form, not in content."""
    with h5py.File(path, "a") as file:
        names: list[str] = []
        file.visit(names.append)
        name = draw(st.sampled_from(sorted(names)))
        found, kind = file[name], draw(st.sampled_from(["gone", "other", "shape", "type", "value", "attributes"]))
        if kind == "attributes":
            for key in list(found.attrs):
                del found.attrs[key]
        elif kind == "value" and isinstance(found, h5py.Dataset) and found.size and found.dtype.kind in "if":
            at = np.unravel_index(draw(st.integers(0, found.size - 1)), found.shape)
            number = st.floats(width=32) if found.dtype.kind == "f" else st.integers(-(2**31), 2**31 - 1)
            found[at] = draw(st.one_of(number, st.sampled_from([0, -1])))
        elif kind in ("shape", "type") and isinstance(found, h5py.Dataset) and found.ndim:
            values = found[:]
            del file[name]
            file[name] = values[: draw(st.integers(0, len(values)))] if kind == "shape" else np.zeros(values.shape, "S3")
        else:
            del file[name]
            if kind == "other":
                file[name] = draw(st.sampled_from([7, "x", [0.0, np.nan], np.zeros((2, 2)), h5py.Empty("f8")]))


@examples(30)
@given(data=st.data())
def test_an_altered_archive_gives_an_error_or_measures(
    data: st.DataObject, packing: Path, heap: Path, fresh: Fresh, wf: Wf
) -> None:
    run = fresh(data.draw(st.sampled_from([packing, packing, heap])), {})
    alter(data.draw, run / "run.h5")
    words = data.draw(
        st.sampled_from([["measure", "--json"], ["export", "--all", "--to", "csv,vtk"], ["measure", "--frame", "0"]])
    )
    wf(words[0], run, *words[1:])


@examples(25)
@given(data=st.data())
def test_damaged_dumps_and_series_give_an_error_or_measures(
    data: st.DataObject, packing: Path, heap: Path, fresh: Fresh, wf: Wf
) -> None:
    """The archive is made anew from what the engine wrote; or the series alone is damaged."""
    source = data.draw(st.sampled_from([packing, heap]))
    names = ["grains.dump", "contacts.dump", "series.txt"] + (["tracks.dump"] if source == heap else [])
    name = data.draw(st.sampled_from(names))
    run = fresh(source, {name: data.draw(edited((source / name).read_bytes())), "run.h5": None})
    status, _, err = wf(data.draw(st.sampled_from(["measure", "export", "status"])), run)
    if status:
        assert str(run) in err, "the message does not say where"


@examples(40)
@given(data=st.data())
def test_a_cut_dump_is_read_up_to_its_last_whole_frame(data: st.DataObject, packing: Path, tmp_path: Path) -> None:
    """What a crash leaves: every frame before it, to the last bit."""
    files = [packing / "grains.dump", packing / "contacts.dump"]
    whole = list(read_frames(*files))
    which = data.draw(st.sampled_from([0, 1]))
    content = files[which].read_bytes()
    cut = data.draw(st.integers(0, len(content)))
    (tmp_path / "cut").write_bytes(content[:cut])
    files[which] = tmp_path / "cut"
    found = list(read_frames(*files))
    ends = [end for end in _ends(content) if end <= cut]
    assert len(found) == len(ends)
    for one, two in zip(found, whole, strict=False):
        assert one.step == two.step and np.array_equal(one.position, two.position)


def _ends(content: bytes) -> list[int]:
    """Where the frames of a dump end."""
    starts = [at for at in range(len(content)) if content.startswith(b"ITEM: TIME\n", at)]
    return [*starts[1:], len(content)]


@examples(40)
@given(data=st.data())
def test_damaged_dumps_of_other_programs_give_an_error_or_measures(
    data: st.DataObject, packing: Path, tmp_path: Path, wf: Wf
) -> None:
    names = ["grains.dump", "contacts.dump"]
    broken = data.draw(st.sampled_from(names))
    for name in names:
        whole = (packing / name).read_bytes()
        (tmp_path / name).write_bytes(data.draw(edited(whole)) if name == broken else whole)
    wf("measure", "grains.dump", "--contacts", "contacts.dump", "--only", "forces,clusters,rigidity")


@examples(40)
@given(
    columns=st.lists(
        st.sampled_from(["id", "x", "y", "diameter", "radius", "mass", "vx", "vy", "fx", "q"]), min_size=1, max_size=9
    ),
    rows=st.lists(st.lists(st.floats(width=32) | st.integers(-2, 9), min_size=9, max_size=9), max_size=5),
    faces=st.lists(st.floats(-1e3, 1e3) | st.just(0.0), min_size=4, max_size=4),
)
def test_any_dump_that_has_the_form_of_one_gives_an_error_or_measures(
    columns: list[str], rows: list[list[float]], faces: list[float], tmp_path: Path
) -> None:
    head = f"ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS pp pp pp\n"
    box = f"{faces[0]} {faces[1]}\n{faces[2]} {faces[3]}\n-0.5 0.5\nITEM: ATOMS {' '.join(columns)}\n"
    text = head + box + "".join(" ".join(repr(value) for value in row[: len(columns)]) + "\n" for row in rows)
    (tmp_path / "dump").write_text(text)
    with deadline():
        try:
            frames = list(foreign_frames(tmp_path / "dump"))
        except WorkflowError:
            return
    assert len(frames) == 1 and frames[0].grains == len(rows)


@examples(25)
@given(data=st.data())
def test_damaged_records_give_an_error_or_measures(
    data: st.DataObject, packing: Path, heap: Path, fresh: Fresh, wf: Wf
) -> None:
    """run.json and the log, as text and as data."""
    source = data.draw(st.sampled_from([packing, heap]))
    name = data.draw(st.sampled_from(["run.json", "run.json", "log.lammps"]))
    whole = (source / name).read_bytes()
    if name == "run.json" and data.draw(st.booleans()):
        changed = json.dumps(data.draw(replaced(json.loads(whole)))).encode()
    else:
        changed = data.draw(edited(whole))
    wf(data.draw(st.sampled_from(["measure", "status", "export"])), fresh(source, {name: changed}))


@examples(6)
@given(data=st.data())
def test_damaged_measures_are_measured_anew(data: st.DataObject, packing: Path, fresh: Fresh) -> None:
    """The right answer whatever measures.json says."""
    whole = (packing / "measures.json").read_bytes()
    document = replaced(json.loads(whole)).map(lambda tree: json.dumps(tree).encode())
    changed = data.draw(st.one_of(edited(whole), document))
    found = stored_measures(RunDirectory(fresh(packing, {"measures.json": changed})))
    assert json.dumps(found) == json.dumps(measures_of(RunDirectory(packing)))


@examples(60)
@given(data=st.data())
def test_any_scene_file_gives_a_scene_or_a_sentence(
    data: st.DataObject, packing: Path, heap: Path, tmp_path: Path, wf: Wf
) -> None:
    """A scene that can be written down and read again, or a sentence; and its deck."""
    source = data.draw(st.sampled_from([packing, heap]))
    (tmp_path / "scene.toml").write_bytes(data.draw(edited((source / "scene.toml").read_bytes())))
    try:
        with deadline():
            scene = scene_from(read_toml(tmp_path / "scene.toml"))
    except InputError as fault:
        assert len(str(fault)) < 2000
    else:
        (tmp_path / "again.toml").write_text(to_toml(scene))
        assert scene_from(read_toml(tmp_path / "again.toml")) == scene
    wf("deck", "scene.toml", "--dry-run")


@examples(60)
@given(data=st.data())
def test_any_study_file_gives_a_study_or_a_sentence(data: st.DataObject, tmp_path: Path, wf: Wf) -> None:
    (tmp_path / "study.toml").write_bytes(data.draw(edited(STUDY)))
    wf("sweep", "study.toml", "--dry-run")


@examples(40)
@given(data=st.data())
def test_damaged_records_of_studies_give_an_error_or_a_status(
    data: st.DataObject, packing: Path, tmp_path: Path, wf: Wf
) -> None:
    """points.json and the records of the points; no name in them leads out of the study."""
    digest = json.loads((packing / "run.json").read_text())["digest"]
    values = {"scene": "method1", "n": 60, "seed": 1}
    points = [
        {"digest": digest, "grains": 60, "values": values},
        {"digest": digest[::-1], "grains": 60, "values": {**values, "seed": 2}},
    ]
    run = tmp_path / "study" / "points" / digest[:16]
    run.mkdir(parents=True, exist_ok=True)
    state = json.loads((packing / "run.json").read_text())
    if data.draw(st.booleans()):
        points = data.draw(replaced(points))
    else:
        state = data.draw(replaced(state))
    (tmp_path / "study" / "points.json").write_text(json.dumps(points))
    (run / "run.json").write_text(json.dumps(state))
    wf("status", "study", *data.draw(st.sampled_from([[], ["--json"]])))


@examples(25)
@given(data=st.data())
def test_a_damaged_restart_file_is_never_resumed_from(data: st.DataObject, packing: Path, heap: Path, fresh: Fresh) -> None:
    """A restart file is taken only if it is, bit for bit, what was sealed, unless its seal is the one that is damaged."""
    source = data.draw(st.sampled_from([packing, heap]))
    names = sorted(path.name for path in source.iterdir() if path.name.startswith(("checkpoint.", "stage.")))
    name = data.draw(st.sampled_from([*names, "series.txt", "grains.dump", "contacts.dump", "log.lammps"]))
    whole = (source / name).read_bytes()
    run = fresh(source, {name: data.draw(edited(whole))})
    (run / "stop").unlink(missing_ok=True)
    directory = RunDirectory(run)
    directory.record(status="interrupted")
    with deadline():
        try:
            words = _start(directory, True, io.StringIO())
        except ArchiveError as fault:
            assert str(run) in str(fault)
            return
    if not words:
        return
    chosen = words["restart"]
    sealed = json.loads((source / f"{chosen}.json").read_text())
    assert (run / chosen).read_bytes() == (source / chosen).read_bytes()
    for part in ("grains.dump", "contacts.dump"):
        for block in read_blocks(run / part, "ATOMS" if part[0] == "g" else "ENTRIES"):
            assert block.step < sealed["step"], part
    assert read_series(run / "series.txt")["step"].max(initial=0) <= sealed["step"]


@pytest.mark.parametrize("length", [-8, -(2**31), 2**31 - 1])
def test_a_restart_file_whose_records_lead_back_ends(length: int, tmp_path: Path) -> None:
    """The length of a text in its head, negative: no walk in circles."""
    (tmp_path / "checkpoint.1.a").write_bytes(b"LammpS RestartT\0" + struct.pack("<iiii", 1, 3, 0, length) + bytes(600))
    with deadline():
        assert step_of(tmp_path / "checkpoint.1.a") is None


@pytest.mark.parametrize("value", [repr(value) for value in VALUES])
def test_values_of_every_kind_are_shown_in_a_report(value: str, packing: Path, fresh: Fresh, wf: Wf) -> None:
    """The page shows what the record says, or the command says what is wrong with it."""
    state = json.loads((packing / "run.json").read_text())
    for name in ("command", "seconds", "reason"):
        changed = json.dumps({**state, name: eval(value, {"nan": float("nan")})}).encode()
        wf("report", fresh(packing, {"run.json": changed}))


FORBIDDEN = {"eval", "exec", "compile", "__import__"}
LOADERS = {"pickle", "cPickle", "marshal", "shelve", "dill", "joblib", "yaml"}


@pytest.mark.parametrize("path", sorted(Path(workflow.__file__).parent.rglob("*.py")), ids=lambda path: path.stem)
def test_nothing_in_the_package_can_execute_data(path: Path) -> None:
    """No eval, no unpickling, no shell: neither called nor imported."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call):
            name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
            assert not (isinstance(node.func, ast.Name) and name in FORBIDDEN), f"{path}:{node.lineno}"
            owner = getattr(getattr(node.func, "value", None), "id", "")
            assert (owner, name) not in (("os", "system"), ("os", "popen")), f"{path}:{node.lineno}"
            given_words = {word.arg: word.value for word in node.keywords}
            for word in ("shell", "allow_pickle"):
                assert not getattr(given_words.get(word), "value", False), f"{path}:{node.lineno}"
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = {alias.name.split(".")[0] for alias in node.names} | {getattr(node, "module", None) or ""}
            assert not names & LOADERS, f"{path}:{node.lineno}"
