"""Files of other programs in every way of writing: the right number, or a sentence, never another number.

`WORKFLOW_FUZZ=100 pytest tests/unit/archive/test_foreign_files.py` draws a hundred times as many at random.
"""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn import examples
from foreign_files import MU, Way, contacts_text, direct, grains_text, packing, write
from hypothesis import given
from hypothesis import strategies as st

from workflow.campaign.measured import found_at
from workflow.cli.main import main


def measured(grains: list[Path], contacts: list[Path], *words: str) -> tuple[int, dict[str, Any], str]:
    """Status, numbers and complaints of `wf measure`."""
    out, err = io.StringIO(), io.StringIO()
    behind = ["--contacts", *map(str, contacts)] if contacts else []
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(["measure", *map(str, grains), *behind, "--json", "--only", "none", *words])
    return status, json.loads(out.getvalue()) if status == 0 else {}, err.getvalue()


def agree(found: dict[str, Any], wanted: dict[str, float], digits: int, *, all_known: bool) -> None:
    """Every number is the direct one or, unless ``all_known``, undefined."""
    for path, value in wanted.items():
        got = found_at(found, path)
        if got is None and not all_known:
            continue
        # rounding of printed digits, multiplied where overlaps are differences of positions a hundred times as large
        relative, absolute = (1e-9, 1e-9) if digits > 16 else (1e-4, 1e-4)
        assert got is not None, f"{path} is undefined"
        assert abs(got - value) <= relative * abs(value) + absolute, f"{path}: {got}, directly {value}"


FORMS = st.sampled_from(["", "s", "u", "su"])
ways = st.builds(
    Way,
    forms=st.tuples(FORMS, FORMS),
    size=st.sampled_from(["radius", "diameter"]),
    contact=st.sampled_from(["vector", "parts", "scalar", "own"]),
    branch=st.booleans(),
    gap=st.sampled_from(["", "gap", "overlap"]),
    flags=st.booleans(),
    order=st.integers(0, 2**32),
    junk=st.lists(st.sampled_from(["element", "type", "c_q[1]", "v_ratio", "name", "state", "ix", "proc"]), unique=True).map(
        tuple
    ),
    twice=st.sampled_from(["", "", "both", "some"]),
    header=st.lists(st.sampled_from(["units", "time", "tilt", "old", "label"]), unique=True).map(tuple),
    packed=st.sampled_from(["", "", "gz", "bz2", "xz"]),
    digits=st.sampled_from([17, 17, 10]),
)


@examples(30)
@given(way=ways, seed=st.integers(0, 2**32))
def test_whatever_the_order_the_forms_and_the_box_the_numbers_are_the_direct_ones(way: Way, seed: int) -> None:
    p = packing(seed)
    with tempfile.TemporaryDirectory() as folder:
        files = [write(Path(folder), name, [text(p, way)], way.packed)
                 for name, text in (("grains", grains_text), ("contacts", contacts_text))]  # fmt: skip
        status, found, err = measured(files[:1], files[1:], "--mu", str(MU))
    assert status == 0, err
    agree(found, direct(p), way.digits, all_known=True)
    notes = " ".join(found["notes"])
    assert ("repeat a pair" in notes) == bool(way.twice)
    assert ("header does not say" in notes) == ("old" in way.header)


GRAINS = ("id", "radius", "mass", "x", "y", "vx", "vy", "omegaz", "fx", "fy")
PAIRS = ("id_i", "id_j", "fx", "fy", "tx", "ty", "normal", "tangential", "elastic", "viscous", "attraction", "bx", "by", "gap")


@examples(30)
@given(
    way=ways, seed=st.integers(0, 2**32), grains=st.lists(st.sampled_from(GRAINS), max_size=4).map(tuple),
    pairs=st.lists(st.sampled_from(PAIRS), max_size=4).map(tuple), mu=st.booleans(),
)  # fmt: skip
def test_what_a_missing_column_would_have_told_is_undefined_and_nothing_else_changes(
    way: Way, seed: int, grains: tuple[str, ...], pairs: tuple[str, ...], mu: bool
) -> None:
    p = packing(seed)
    lost = {name + form for name in grains for form in (way.forms if name in "xy" else ("",))} | (
        {"diameter"} if "radius" in grains else set()
    )
    with tempfile.TemporaryDirectory() as folder:
        files = [write(Path(folder), "grains", [grains_text(p, replace(way, dropped=tuple(lost)))]),
                 write(Path(folder), "contacts", [contacts_text(p, replace(way, dropped=pairs))])]  # fmt: skip
        status, found, err = measured(files[:1], files[1:], *(["--mu", str(MU)] if mu else []))
    if status:
        assert err.startswith("wf: ") and len(err.splitlines()) == 1
        return
    agree(found, direct(p), way.digits, all_known=False)
    if "mass" in lost:
        assert found["stress"]["pressure"] is None and "masses" in found["notes"][-1]
    if "radius" in grains:
        assert found["solid_fraction"] is None and "diameters" in found["notes"][-1]


@examples(15)
@given(way=ways, seed=st.integers(0, 2**32), names=st.data())
def test_columns_are_what_the_user_says_they_are(way: Way, seed: int, names: st.DataObject) -> None:
    """Whatever else is in the file under our own names."""
    p = packing(seed)
    way = replace(way, contact="vector", gap="", junk=(), flags=False)
    numbered = {name: f"c_1[{k}]" for k, name in enumerate(("id_i", "id_j", "fx", "fy"), 1)}
    traps = names.draw(st.lists(st.sampled_from(["fx", "fy", "normal", "gap"]), unique=True))
    text = contacts_text(p, replace(way, renamed=numbered))
    head, _, body = text.partition("ITEM: ENTRIES ") if "label" not in way.header else text.partition("ITEM: CONTACTS ")
    label = "CONTACTS" if "label" in way.header else "ENTRIES"
    lines = [line + "".join(f" {name}" for name in traps) if not k else line + " 0" * len(traps) for k, line in
             enumerate(line.rstrip() for line in body.splitlines())]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        files = [write(Path(folder), "grains", [grains_text(p, way)], way.packed),
                 write(Path(folder), "contacts", [head, f"ITEM: {label} ", "\n".join(lines), "\n"], way.packed)]  # fmt: skip
        given_names = ",".join(f"{name}={column}" for name, column in numbered.items())
        status, found, err = measured(files[:1], files[1:], "--mu", str(MU), "--columns", given_names)
        misspelt = measured(files[:1], files[1:], "--columns", given_names.replace("c_1[4]", "c_1[44]"))
    if "gap" in traps:  # which nobody names, and which contradicts the positions
        assert status == 1 and "the gap of grains" in err
    else:
        assert status == 0, err
        agree(found, direct(p), way.digits, all_known=True)
    assert misspelt[0] == 2 and "'c_1[44]'" in misspelt[2] and "c_1[1]" in misspelt[2]


@examples(15)
@given(way=ways, seed=st.integers(0, 2**32), split=st.booleans(), first=st.integers(1, 4))
def test_a_later_writing_of_a_step_counts_wherever_it_stands(way: Way, seed: int, split: bool, first: int) -> None:
    """Appended files, and one file per step."""
    packings = [packing(seed + k) for k in range(3)]
    steps = [first, first + 2, first + 2] if not split else [first, first + 2, first + 3]
    if split:  # steps of one sample: the grains stay who they are
        packings = [packings[0], packings[0], replace(packings[0], velocity=packings[2].velocity)]
    with tempfile.TemporaryDirectory() as folder:
        files: list[list[Path]] = []
        for name, text in (("grains", grains_text), ("contacts", contacts_text)):
            texts = [text(p, replace(way, step=step)) for p, step in zip(packings, steps, strict=True)]
            if split:
                files.append([write(Path(folder), f"{name}.{k}", [part], way.packed) for k, part in enumerate(texts)])
            else:
                files.append([write(Path(folder), name, texts, way.packed)])
        status, found, err = measured(*files, "--mu", str(MU))
    assert status == 0, err
    assert found["step"] == steps[-1]
    agree(found, direct(packings[-1]), way.digits, all_known=True)
    notes = " ".join(found["notes"])
    assert ("is written twice; the later writing counts" in notes) != split
    assert ("steps of one sample" in notes) == split


def spoilt(kind: str, p: Any, way: Way) -> tuple[str, str]:
    """Files that cannot be right."""
    grains, contacts = grains_text(p, way), contacts_text(p, way)
    if kind == "space":
        z = replace(way, junk=())
        lines = grains_text(p, z).splitlines()
        head = next(k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
        lines[head] += " z"
        lines[head + 1 :] = [f"{line} {0.4 * k:g}" for k, line in enumerate(lines[head + 1 :])]
        grains = "\n".join(lines) + "\n"
    elif kind == "other sample":
        q = packing(p.ids[0] * 7919 + 1)
        contacts = contacts_text(replace(q, ids=p.ids, i=q.i, j=(q.i + len(p.ids) // 2) % len(p.ids)), way)
    elif kind == "other box":
        contacts = contacts_text(replace(p, cell=p.cell * 1.01), way)
    elif kind == "unknown grain":
        contacts = contacts_text(replace(p, ids=p.ids + 4 * len(p.ids)), way)
    elif kind == "contradiction":
        p2 = replace(p, normal=1.1 * p.normal, tangential=0.5 * p.tangential)
        other = contacts_text(p2, way).splitlines()[-1]
        rows = len(contacts_text(p, way).splitlines())
        contacts = contacts + other + "\n"
        contacts = contacts.replace(f"\n{_count(contacts)}\n", f"\n{_count(contacts) + 1}\n", 1) if rows else contacts
    elif kind == "wrong sign":
        contacts = contacts_text(replace(p, normal=-p.normal, tangential=-p.tangential), way)
    elif kind == "no forces":
        contacts = contacts_text(replace(p, normal=0 * p.normal, tangential=0 * p.tangential), way)
    elif kind == "lost rows":
        kept = np.delete(np.arange(len(p.i)), [0, len(p.i) // 2])
        short = {name: getattr(p, name)[kept] for name in ("i", "j", "branch", "normal", "tangential", "slides")}
        contacts = contacts_text(replace(p, **short), way)
    elif kind == "twice in grains":
        lines = grains.splitlines()
        grains = "\n".join([*lines[:-1], lines[-2]]) + "\n"
    return grains, contacts


def _count(text: str) -> int:
    lines = text.splitlines()
    return int(lines[next(k for k, line in enumerate(lines) if line.startswith("ITEM: NUMBER OF")) + 1])


KINDS = [
    "space",
    "lost rows",
    "other sample",
    "other box",
    "unknown grain",
    "contradiction",
    "wrong sign",
    "no forces",
    "twice in grains",
]


@examples(20)
@given(way=ways, seed=st.integers(0, 2**32), kind=st.sampled_from(KINDS))
def test_what_cannot_be_discs_with_their_contacts_is_refused_in_a_sentence(way: Way, seed: int, kind: str) -> None:
    p = packing(seed)
    way = replace(way, twice="", contact="scalar" if kind == "contradiction" else way.contact)
    grains, contacts = spoilt(kind, p, way)
    with tempfile.TemporaryDirectory() as folder:
        files = [write(Path(folder), "grains", [grains], way.packed), write(Path(folder), "contacts", [contacts], way.packed)]
        status, _, err = measured(files[:1], files[1:], "--mu", str(MU))
    assert status in (1, 2), kind
    assert err.startswith("wf: ") and len(err.splitlines()) == 1 and "damaged" not in err


@examples(20)
@given(way=ways, seed=st.integers(0, 2**32), which=st.booleans(), cut=st.floats(0, 1))
def test_a_file_that_ends_anywhere_gives_what_is_whole_or_a_sentence(way: Way, seed: int, which: bool, cut: float) -> None:
    """Two steps; a cut takes the second one, and that is said."""
    one, two = packing(seed), packing(seed + 1)
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for name, text in (("grains", grains_text), ("contacts", contacts_text)):
            parts = [text(p, replace(way, step=step)) for p, step in ((one, 5), (two, 6))]
            whole = write(Path(folder), name, parts, way.packed)
            if (name == "grains") == which:
                content = whole.read_bytes()
                whole.write_bytes(content[: int(cut * len(content))])
            files.append(whole)
        status, found, err = measured(files[:1], files[1:], "--mu", str(MU))
    if status:
        assert err.startswith("wf: ") and len(err.splitlines()) == 1
        return
    agree(found, direct({5: one, 6: two}[found["step"]]), way.digits, all_known=True)
    assert found["step"] == 6 or "left out" in " ".join(found["notes"])


CASES = next(filter(Path.is_dir, (up / "shared" / "cases" for up in Path(__file__).parents[4:])), Path("absent"))
BY_HAND = ["--columns", "id_i=c_fc[1],id_j=c_fc[2],fx=c_fc[4],fy=c_fc[5]"]
KEYWORDS = ["--liggghts", "id,force,force_normal,force_tangential,torque"]
AS_BASE = [
    ("01_liggghts_15", "grains", "contacts", BY_HAND), ("01_liggghts_15", "grains", "contacts", KEYWORDS),
    ("01_liggghts_15", "grains", "contacts14", BY_HAND), ("02_both_directions", "grains", "contacts", []),
    *[("03_element_column", one, two, []) for one in ("grains", "grains_nan") for two in ("contacts", "contacts_nan")],
    *[("05_coordinates", name, "contacts", []) for name in ("grains_xs", "grains_xu")],
    *[("06_box", one, two, []) for one in ("grains", "grains_tri0") for two in ("contacts", "contacts_label", "contacts_tri0")],
    ("19_file_per_step", "grains.*", "contacts.*", []), ("base", "grains", "contacts", []),
]  # fmt: skip


@pytest.mark.skipif(not CASES.is_dir(), reason="the folder shared/cases is not beside the checkout")
@pytest.mark.parametrize(("folder", "grains", "contacts", "words"), AS_BASE)
def test_the_collected_files_of_other_programs_are_measured(folder: str, grains: str, contacts: str, words: list[str]) -> None:
    status, found, err = measured([CASES / folder / f"{grains}.dump"], [CASES / folder / f"{contacts}.dump"], *words)
    assert status == 0, err
    assert found["interactions"] == {"contacts": 731, "distant": 0} and found["coordination"] == 3.655
    assert found["stress"]["pressure"] == pytest.approx(8.0476, abs=5e-5)
    assert found["stress"]["xx"] == pytest.approx(7.6569, abs=5e-5)
    assert found["solid_fraction"] == pytest.approx(0.8189, abs=5e-5)
    assert found["unbalanced_force"]["force"] < 1e-11


@pytest.mark.skipif(not CASES.is_dir(), reason="the folder shared/cases is not beside the checkout")
@pytest.mark.parametrize(
    ("folder", "words", "message"),
    [
        ("01_liggghts_15", ["--contacts", "contacts.dump"], "column id_i, id_j missing"),
        ("08_three_d", [], "three-dimensional"),
        (
            "17_silent_zero_forces",
            ["--contacts", "contacts.dump", "--columns", "fx=c_force[1],fy=c_force[2]"],
            "no column 'c_force[1]'",
        ),
    ],
)
def test_the_collected_files_that_cannot_be_measured_are_refused(
    folder: str, words: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(CASES / folder)
    assert main(["measure", "grains.dump", *words, "--only", "none"]) in (1, 2)
    assert message in capsys.readouterr().err


@pytest.mark.skipif(not CASES.is_dir(), reason="the folder shared/cases is not beside the checkout")
def test_pressure_without_masses_is_that_of_the_contacts_alone() -> None:
    folder = CASES / "09_no_mass"
    for name, pressure in (("grains", 485.84), ("grains_nomass", None)):
        _, found, _ = measured([folder / f"{name}.dump"], [folder / "contacts.dump"])
        assert found["stress"]["pressure"] == (pressure and pytest.approx(pressure, abs=5e-3))
        assert found["stress"]["contacts"]["pressure"] == pytest.approx(8.0476, abs=5e-5)
        assert (found["stress"]["kinetic"]["pressure"] is None) == (pressure is None)
