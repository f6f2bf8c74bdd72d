"""The report page: what is in it is what the frame and the series hold, and no name in it can do harm."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from workflow.data.frame import Frame, Interactions
from workflow.measures.packing import coordination, measure
from workflow.reports import page_data
from workflow.reports.network import kinds_of_fig2
from workflow.reports.page import with_error, write_report
from workflow.reports.page_data import KINDS, ReportData, unpacked
from workflow.reports.study_page import template, write_page
from workflow.reports.views import PackingView
from workflow.scene.method1 import Method1

CELL, ORIGIN = np.array([6.0, 4.0]), np.array([-2.0, 1.0])
EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)> \" ' & <!-- $title"


def sheet(seed: int = 1, **changes: Any) -> ReportData:
    """Random grains with interactions of every kind, and a series of two stages; a seed for the scene."""
    rng = np.random.default_rng(seed)
    n, m = 40, 60
    i, j = np.array(np.triu_indices(n, 1))[:, np.sort(rng.choice(n * (n - 1) // 2, m, replace=False))]
    position = ORIGIN + rng.uniform(-0.05, 1.05, (n, 2)) * CELL
    branch = position[j] - position[i]
    branch -= CELL * np.round(branch / CELL)
    elastic, gap = rng.uniform(0, 3, m), np.where(np.arange(m) < 50, -1e-3, 1e-4)
    elastic[:10], elastic[50:] = 1.0, 0.0
    table = Interactions(i, j, branch, gap, elastic, np.zeros(m), np.full(m, -1.0), *rng.normal(size=(4, m)),
                     *(rng.random((2, m)) > 0.5))  # fmt: skip
    d, still = rng.uniform(0.5, 1, n), np.zeros((n, 2))
    frame = Frame(7, 1.5, "settle", ORIGIN, CELL, np.arange(1, n + 1), d, d**2, position, still, still[:, 0], still,
                  still[:, 0], table)  # fmt: skip
    time = np.linspace(0.0, 10.0, 101)
    series = {"step": time * 100, "time": time, "stage": 1.0 + (time > 4), "solid_fraction": 0.3 + rng.random(101) / 9,
              "net_force": np.exp(-time), "net_moment": np.exp(-2 * time)}  # fmt: skip
    known = {
        "name": f"run {seed}", "title": "a title", "state": "finished", "reason": None, "note": "the last frame",
        "frame": frame, "force_unit": 1.0, "tolerance": 1e-4, "cohesive": True, "length": 1.0,
        "units": Method1(seed=seed).units, "view": PackingView(), "scene": Method1(seed=seed), "series": series, "measures": measure(frame, force_unit=1.0),
        "numbers": [("a", "1")], "provenance": [("command", "wf run")], "text": 'scene = "method1"',
    }  # fmt: skip
    return ReportData(**{**known, **changes})


class Page(HTMLParser):
    """Elements by name with their attributes, and the texts of each kind of element."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.open = ["page"]
        self.source = path.read_text(encoding="utf-8")
        self.feed(self.source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self.open.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.setdefault(self.open[-1], []).append(data)

    @property
    def data(self) -> Any:
        start = self.source.index('id="data">') + len('id="data">')
        return json.loads(self.source[start : self.source.index("</script>", start)])


def written(tmp_path: Path, *sheets: ReportData, **options: Any) -> Page:
    write_report(tmp_path / "page.html", sheets[0].name, sheets, **options)
    return Page(tmp_path / "page.html")


def test_network_of_the_page_is_that_of_the_frame(tmp_path: Path) -> None:
    one = sheet()
    frame, table = one.frame, one.frame.interactions
    net = written(tmp_path, one).data["runs"][0]["network"]
    found = {name: unpacked(array) for name, array in net["arrays"].items()}
    rattlers = coordination(frame, threshold=1e-4).rattlers
    for name, expected in {
        "id": frame.ids, "i": table.i, "j": table.j, "mark": rattlers, "flag": table.sliding + 2 * table.rolling,
        "normal": np.float32(table.normal_force), "tangential": np.float32(table.tangential),
        "moment": np.float32(table.moment), "gap": np.float32(table.gap), "d": np.float32(frame.diameter),
        "bx": np.float32(table.branch[:, 0]), "by": np.float32(table.branch[:, 1]),
    }.items():  # fmt: skip
        np.testing.assert_array_equal(found[name], expected, err_msg=name)
    place = np.column_stack((found["x"], found["y"]))
    assert (place >= ORIGIN - 1e-6).all() and (place <= ORIGIN + CELL + 1e-6).all()
    turns = (place - frame.position) / CELL
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6)  # float32 of lengths up to 6
    for name, (rows, *_) in kinds_of_fig2(frame, 1.0, 1e-4).items():
        assert (np.flatnonzero(found["kind"] == KINDS.index(name)) == np.flatnonzero(rows)).all() and rows.any(), name
    assert net["cell"] == CELL.tolist() and net["origin"] == ORIGIN.tolist()


def test_series_of_the_page_is_that_of_the_run(tmp_path: Path) -> None:
    one = sheet()
    run = written(tmp_path, one).data["runs"][0]
    assert set(run["arrays"]) >= {"time", "solid_fraction", "net_force", "net_moment"}
    for name in ("time", "solid_fraction", "net_force", "net_moment"):
        np.testing.assert_array_equal(unpacked(run["arrays"][name]), np.float32(one.series[name]), err_msg=name)
    chart = next(chart for chart in run["charts"] if "unbalanced" in chart["title"])
    assert chart["logy"] and [line["y"] for line in chart["lines"]] == ["net_force", "net_moment"]
    assert chart["levels"] == [{"name": "tolerance", "y": 1e-4}]
    begins = [(stage["name"], stage["x"]) for stage in chart["stages"]]
    assert begins == [("compress", 0.0), ("settle", pytest.approx(4.1))]


def test_long_series_is_thinned_and_the_page_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 101 rows in steps of 0.1 every fourth is kept, with the last of each stage: t = 4.0, and 10.0."""
    monkeypatch.setattr(page_data, "MOST_ROWS", 30)
    page = written(tmp_path, sheet())
    time = unpacked(page.data["runs"][0]["arrays"]["time"])
    np.testing.assert_allclose(time, np.union1d(np.arange(0.0, 10.05, 0.4), [4.0, 10.0]), rtol=1e-6)
    assert "One row in 4 of 101" in page.source


def test_the_film_of_the_page_holds_every_frame_once(tmp_path: Path) -> None:
    """The arrays of the frame that is shown are those of the network."""
    one = sheet()
    frames = [replace(sheet(seed).frame, step=seed, cell=CELL * seed) for seed in (1, 2)]
    found = [(EVIL, frames[0]), ("two", frames[1]), ("shown", one.frame)]
    page = written(tmp_path, replace(one, film=found))
    film = page.data["runs"][0]["film"]
    assert film["shown"] == 2 and [frame["label"] for frame in film["frames"]] == [EVIL, "two", "shown"]
    assert "arrays" not in film["frames"][2]
    for part, frame in zip(film["frames"], frames, strict=False):
        np.testing.assert_array_equal(unpacked(part["arrays"]["normal"]), np.float32(frame.interactions.normal_force))
        assert part["cell"] == frame.cell.tolist()
    slider = next(a for tag, a in page.elements if tag == "input" and a.get("aria-label") == "Frame")
    assert (slider["max"], slider["value"]) == ("2", "2")
    assert "film" not in written(tmp_path, one).data["runs"][0]


def test_names_are_text_and_nothing_else(tmp_path: Path) -> None:
    """Whoever names a run, a stage or a file cannot open an element, an attribute or the script."""
    evil = sheet(name=EVIL, title=EVIL, reason=EVIL, note=EVIL, state=EVIL, text=EVIL, numbers=[(EVIL, EVIL)],
                 provenance=[(EVIL, EVIL)])  # fmt: skip
    plain, page = written(tmp_path, sheet(), sheet(2)), written(tmp_path, evil, sheet(2), absent=[(EVIL, EVIL, EVIL)])
    count = [sum(tag == "script" for tag, _ in one.elements) for one in (plain, page)]
    assert count == [2, 2]
    assert not [tag for tag, _ in page.elements if tag == "img"]
    assert not [name for _, attributes in page.elements for name in attributes if name.startswith("on")]
    assert page.data["runs"][0]["name"] == EVIL
    for element in ("h1", "title", "pre", "td", "th", "p"):
        assert any(EVIL in text for text in page.texts[element]), element


def test_policy_lets_only_the_page_s_own_script_run(tmp_path: Path) -> None:
    page = written(tmp_path, sheet())
    policy = next(
        a["content"] for tag, a in page.elements if tag == "meta" and a.get("http-equiv") == "Content-Security-Policy"
    )
    script = page.source[page.source.rindex("<script>") + len("<script>") : page.source.rindex("</script>")]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert policy is not None and f"script-src 'sha256-{digest}'" in policy and "default-src 'none'" in policy
    fetched = [a[key] for _, a in page.elements for key in ("src", "href") if a.get(key)]
    assert all(place.startswith(("#", "data:")) for place in fetched if place)


def test_unfinished_run_says_so_and_misses_its_limits(tmp_path: Path) -> None:
    page = written(tmp_path, sheet(state="interrupted", reason="killed", measures=sheet().measures | {"equilibrated": False}))
    assert "interrupted" in page.texts["span"] and "not in equilibrium" in page.texts["span"]
    assert "killed" in page.texts["p"]
    assert "✗ not kept" in page.texts["td"]  # random forces do not balance


def test_table_of_runs_has_their_differences_and_the_mean(tmp_path: Path) -> None:
    pair = sheet(1), sheet(2)
    page = written(tmp_path, *pair, absent=[("third", "failed", "no results yet")])
    head = page.texts["button"]
    assert "seed" in head and "solid fraction Φ" in head and "kappa" not in head
    phi = [one.measures["solid_fraction"] for one in pair]
    error = abs(phi[0] - phi[1]) / 2  # of the mean of two
    assert with_error(float(np.mean(phi)), error) in page.texts["td"]
    assert "no results yet" in page.texts["td"] and "third" in page.texts["th"]
    other = written(tmp_path, sheet(1), sheet(2, scene=Method1(kappa=1e4)))
    assert "kappa" in other.texts["button"] and "mean ± standard error" not in other.texts["th"]


def test_curves_of_several_runs_are_named_by_what_tells_them_apart(tmp_path: Path) -> None:
    def named(*sheets: ReportData) -> list[str]:
        return [run["label"] for run in written(tmp_path, *sheets).data["runs"]]

    assert named(sheet(1), sheet(2)) == ["seed = 1", "seed = 2"]
    assert named(sheet(1), sheet(1, scene=Method1(kappa=1e4))) == ["kappa = 100000", "kappa = 10000"]
    many = sheet(1, scene=Method1(kappa=1e4, mu=0.3, n=100, rolling=True), name="other")
    assert named(sheet(1), many) == ["run 1", "other"]
    assert named(sheet(1), sheet(1, name="again")) == ["run 1", "again"]


def test_mean_is_written_to_the_digits_of_its_error() -> None:
    assert with_error(0.70689, 0.00257) == "0.7069 ± 0.0026"
    assert with_error(451.75, 12.34) == "452 ± 12"
    assert with_error(0.01, 0.0) == "0.01 ± 0"
    assert with_error(0.01, 3.2e-8) == "0.01 ± 3e-08"


def test_frame_without_any_interaction(tmp_path: Path) -> None:
    frame = sheet().frame
    bare = replace(frame, interactions=frame.interactions.select(np.zeros(len(frame.interactions), bool)))
    page = written(tmp_path, sheet(frame=bare, measures=measure(bare, force_unit=1.0), series={}, scene=None))
    assert len(unpacked(page.data["runs"][0]["network"]["arrays"]["i"])) == 0
    assert "undefined" in "".join(page.texts["dd"])  # the Rumpf ratio
    assert not re.search("Time series", page.source[: page.source.index("<script")])


def test_page_of_a_study_has_tables_and_escapes_them(tmp_path: Path) -> None:
    write_page(tmp_path / "study.html", EVIL, [("text", EVIL), ("table", [{"x_y": 0.12345, EVIL: None}])])
    page = Page(tmp_path / "study.html")
    assert [tag for tag, _ in page.elements].count("script") == 2
    assert page.texts["th"] == ["x y", EVIL.replace("_", " "), "0.123"] and page.texts["td"][0] == "—"


def luminance(colour: str) -> float:
    """Relative luminance of #rgb or #rrggbb (WCAG 2.2)."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


@pytest.mark.parametrize("theme", [0, 1])
def test_every_text_can_be_read(theme: int) -> None:
    """Contrast of 4.5 or more on both grounds, in light and in dark colours (WCAG 2.2, 1.4.3)."""
    pairs = re.findall(r"--(\w+): light-dark\((\S+?), (\S+?)\)", template("page.css"))
    colours = {name: pair[theme] for name, *pair in pairs}
    for text in ("ink", "muted", "link", "good", "bad"):
        for ground in ("paper", "shade"):
            low, high = sorted(luminance(colours[name]) for name in (text, ground))
            assert (high + 0.05) / (low + 0.05) >= 4.5, (text, ground)
