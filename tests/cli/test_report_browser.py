"""The pages of `wf report` in real Chromium, from the file: drawings, hover, zoom, touch, colours, phone, print."""

from __future__ import annotations

import base64
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import Reader, chromium
from matplotlib.colors import to_rgb
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from wf_process import call

from workflow.archive.read import Archive
from workflow.data.frame import Frame
from workflow.reports.figures import RED
from workflow.reports.study_page import write_page

Open = Callable[[Path], Reader]


@pytest.fixture(scope="module")
def open_page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Open]:
    """Opens a page; at the end nobody complained and nothing but the pages was asked for."""
    driver = chromium(tmp_path_factory.mktemp("profile"))
    try:
        yield lambda page: Reader(driver, page)
    finally:
        driver.quit()


def report(folder: Path, *words: object) -> Path:
    done = call("report", *words, "--out", "page.html", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "page.html"


@pytest.fixture(scope="module")
def page(cohesive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report(tmp_path_factory.mktemp("one"), cohesive)


@pytest.fixture(scope="module")
def study(packing: Path, cohesive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    assert call("deck", "method1", "--n", "60", "--out", "not-run", cwd=folder).returncode == 0
    return report(folder, packing, cohesive, "not-run")


@pytest.fixture
def reader(page: Path, open_page: Open) -> Iterator[Reader]:
    one = open_page(page)
    yield one
    assert one.complaints() == []
    assert one.requests() == [one.address]


@pytest.fixture(scope="module")
def frame(cohesive: Path) -> Frame:
    with Archive(cohesive / "run.h5") as archive:
        return archive.frame(-1)


def strongest(frame: Frame) -> int:
    """The contact of the largest force that lies whole inside the cell."""
    table = frame.interactions
    start = np.mod(frame.position[table.i] - frame.origin, frame.cell)
    inside = ((start + table.branch > 0) & (start + table.branch < frame.cell)).all(axis=1)
    return int(np.argmax(np.where(inside, np.abs(table.normal_force), 0.0)))


def central(frame: Frame) -> int:
    """The contact nearest to the middle of the cell: the view stops at the edges."""
    start = np.mod(frame.position[frame.interactions.i] - frame.origin, frame.cell)
    return int(np.argmin(np.hypot(*(start + frame.interactions.branch / 2 - frame.cell / 2).T)))


def place_of(reader: Reader, frame: Frame, contact: int) -> list[float]:
    """The contact point on the canvas, from the frame and the scale that the page draws with."""
    table = frame.interactions
    start = frame.origin + np.mod(frame.position[table.i[contact]] - frame.origin, frame.cell)
    middle = start + table.branch[contact] * frame.diameter[table.i[contact]] / 2 / table.distance[contact]
    return list(reader.run("return views[0].screen(...arguments)", *middle.tolist()))


def scale(reader: Reader) -> float:
    return float(reader.run("return views[0].scale"))


def pairs(text: str) -> dict[str, str]:
    """The lines "name = value unit" of the words beside the pointer."""
    return dict(line.split(" = ") for line in text.splitlines()[1:])


def same(text: str, value: float) -> bool:
    """The number that ``text`` begins with is ``value`` to five digits."""
    return abs(float(text.split()[0]) - value) <= 0.51e-4 * abs(value)


def test_pointing_at_a_contact_shows_its_forces(reader: Reader, frame: Frame) -> None:
    contact, table = strongest(frame), frame.interactions
    reader.point(reader.find("canvas"), *place_of(reader, frame, contact)).perform()
    words = reader.find(".tip").text
    ids = [frame.ids[table.i[contact]], frame.ids[table.j[contact]]]
    assert words.splitlines()[0].startswith(f"{ids[0]} – {ids[1]}: compressive")
    assert ("sliding" in words) == table.sliding[contact]
    found = pairs(words)
    assert same(found["normal force N"], table.normal_force[contact])
    assert same(found["tangential force T"], table.tangential[contact])
    assert same(found["gap h"], table.gap[contact])
    assert same(found["rolling moment"], table.moment[contact])


def test_a_grain_lists_its_interactions(reader: Reader, frame: Frame) -> None:
    table = frame.interactions
    grain = int(table.i[strongest(frame)])
    reader.control("find").send_keys(str(frame.ids[grain]), Keys.ENTER)
    own = (table.i == grain) | (table.j == grain)
    rows = reader.driver.find_elements(By.CSS_SELECTOR, ".pinned div tbody tr")
    shown = sorted(float(row.find_elements(By.TAG_NAME, "td")[1].text) for row in rows)
    np.testing.assert_allclose(shown, np.sort(table.normal_force[own]), rtol=0.51e-3)  # four digits
    reader.control("find").clear()
    reader.control("find").send_keys("99999", Keys.ENTER)
    assert "no grain 99999" in reader.find(".pinned").text


def test_zoom_keeps_the_place_under_the_pointer(reader: Reader, frame: Frame) -> None:
    """By buttons, by keys, and by the wheel, which scrolls the page until the drawing was clicked."""
    canvas, first = reader.find("canvas"), scale(reader)
    reader.control("in").click()
    assert scale(reader) == pytest.approx(1.6 * first)
    canvas.send_keys("-")
    canvas.send_keys("0")
    assert scale(reader) == pytest.approx(first)
    x, y = place_of(reader, frame, central(frame))
    reader.run("document.activeElement.blur()")
    reader.point(canvas, x, y).perform()
    origin = ScrollOrigin.from_element(canvas)
    ActionChains(reader.driver).scroll_from_origin(origin, 0, -60).perform()
    assert scale(reader) == pytest.approx(first)
    reader.point(canvas, x, y).click().perform()
    before = reader.run("return window.scrollY")
    ActionChains(reader.driver).scroll_from_origin(ScrollOrigin.from_viewport(*pointer(reader, x, y)), 0, -500).perform()
    assert scale(reader) > 1.5 * first and reader.run("return window.scrollY") == before
    assert place_of(reader, frame, central(frame)) == pytest.approx([x, y], abs=2.0)  # whole pixels of the pointer


def test_frames_are_played_to_the_last(reader: Reader, cohesive: Path) -> None:
    """The slider shows a frame with its numbers in the legend, the button plays from there on; scale and counts tell it."""
    with Archive(cohesive / "run.h5") as archive:
        frames = list(archive.frames)
    slider, button = reader.find(".player input"), reader.find(".player button")
    assert slider.get_attribute("max") == str(len(frames) - 1) == slider.get_attribute("value")
    slider.send_keys(Keys.HOME)
    reader.settle()
    assert reader.find(".player output").text.startswith(f"frame 1 of {len(frames)}: {frames[0].stage}")
    assert reader.run("return views[0].a.i.length") == len(frames[0].interactions)
    corners = np.array(reader.run("return views[0].net.window")).reshape(2, 2)
    assert corners[1] - corners[0] == pytest.approx(np.max([frame.cell for frame in frames], axis=0))
    assert corners.mean(axis=0) == pytest.approx(frames[0].origin + frames[0].cell / 2)
    button.click()
    end = time.monotonic() + 30
    while button.text != "Play":
        assert time.monotonic() < end
        time.sleep(0.05)
    assert slider.get_attribute("value") == str(len(frames) - 1)
    shown = sum(int(one.text) for one in reader.driver.find_elements(By.CSS_SELECTOR, ".keys label:has([data-kind]) output"))
    assert shown == len(frames[-1].interactions)
    found = reader.run("return Array.from(views[0].a.normal)")
    np.testing.assert_array_equal(np.float32(found), np.float32(frames[-1].interactions.normal_force))


def test_the_key_below_the_drawing_is_to_scale(reader: Reader) -> None:
    """The length bar is as long as it says, at every zoom."""
    for _ in range(3):
        reader.settle()
        canvas = reader.find("canvas")
        row = reader.pixels(canvas)[-14].astype(int).sum(axis=1)  # the middle of the strip below the drawing
        dark = np.flatnonzero(row < 3 * 120)
        length = int(np.flatnonzero(np.diff(dark, append=10**6) > 1)[0]) + 1
        said = reader.run("return views[0].key")
        assert length == pytest.approx(said * scale(reader), abs=1.5)  # whole pixels at both ends
        reader.control("in").click()


def pointer(reader: Reader, x: float, y: float) -> list[int]:
    """Place in the window of a place on the canvas."""
    box = reader.run("const b = document.querySelector('canvas').getBoundingClientRect(); return [b.left, b.top]")
    return [round(box[0] + x), round(box[1] + y)]


def reddish(pixels: np.ndarray) -> int:
    return int((np.abs(pixels.astype(float) - 255 * np.array(to_rgb(RED))).max(axis=2) < 3).sum())


def test_kinds_and_weak_forces_can_be_left_out(reader: Reader) -> None:
    canvas = reader.find("canvas")
    height = int(reader.run("return views[0].height"))  # below lie the scales
    every = reddish(reader.pixels(canvas)[:height])
    assert every > 100
    reader.find('[data-kind="0"]').click()
    assert reddish(reader.pixels(canvas)[:height]) == 0
    reader.find('[data-kind="0"]').click()
    assert reddish(reader.pixels(canvas)[:height]) == every
    reader.control("least").send_keys(Keys.END)  # more than ten force units
    assert reddish(reader.pixels(canvas)[:height]) < 0.2 * every


def test_charts_read_and_zoom_the_series(reader: Reader, cohesive: Path) -> None:
    with Archive(cohesive / "run.h5") as archive:
        series = archive.series
    figure = next(one for one in reader.driver.find_elements(By.CSS_SELECTOR, ".chart") if "kinetic energy" in one.text)
    canvas = figure.find_element(By.TAG_NAME, "canvas")
    reader.point(canvas, 200, 80).perform()
    reader.settle()
    number = figure.get_attribute("data-chart")
    chart = f"views.find((one) => one.root?.dataset.chart === '{number}')"
    row = int(np.argmin(np.abs(series["time"] - float(reader.run(f"return {chart}.group.cursor")))))
    shown = [float(one.text) for one in figure.find_elements(By.CSS_SELECTOR, ".lines .muted")]
    expected = [series[name][row] for name in ("kinetic_per_grain", "kinetic_per_grain_raw")]
    np.testing.assert_allclose(shown, expected, rtol=0.51e-3)  # four digits
    ends = [float(reader.run(f"return {chart}.across.value({x})")) for x in (150, 250)]
    reader.point(canvas, 150, 80).click_and_hold().move_by_offset(50, 0).move_by_offset(50, 0).release().perform()
    reader.settle()
    assert reader.run(f"return {chart}.group.range") == pytest.approx(ends, abs=(ends[1] - ends[0]) / 100)  # a pixel
    reader.control("whole").click()
    assert reader.run(f"return {chart}.group.range") is None
    reader.control("logx").click()
    reader.settle()
    assert reader.run(f"return {chart}.across.log") is True


def test_touch_pins_and_pinches(reader: Reader, frame: Frame) -> None:
    reader.cdp("Emulation.setTouchEmulationEnabled", enabled=True)
    try:
        canvas, first = reader.find("canvas"), scale(reader)
        reader.run("arguments[0].scrollIntoView({block: 'center'})", canvas)
        x, y = pointer(reader, *place_of(reader, frame, strongest(frame)))

        def touch(kind: str, *places: tuple[int, int]) -> None:
            points = [{"x": px, "y": py, "id": k} for k, (px, py) in enumerate(places)]
            reader.cdp("Input.dispatchTouchEvent", type=kind, touchPoints=points)

        touch("touchStart", (x, y))
        touch("touchEnd")
        assert "normal force" in reader.find(".pinned").text
        touch("touchStart", (x - 30, y), (x + 30, y))
        for apart in (40, 50, 60):
            touch("touchMove", (x - apart, y), (x + apart, y))
        touch("touchEnd")
        assert scale(reader) == pytest.approx(2 * first, rel=0.05)
    finally:
        reader.cdp("Emulation.setTouchEmulationEnabled", enabled=False)


def brightness(reader: Reader) -> float:
    """Mean of the page's ground and of the upper left corner of the drawing, 0 to 255."""
    ground = reader.run("return getComputedStyle(document.body).backgroundColor")
    corner = reader.pixels(reader.find("canvas"))[:4, :4].mean()
    return float(np.mean([*map(int, ground[4:-1].split(",")), corner]))


def test_colours_follow_the_system_and_the_button(reader: Reader) -> None:
    def system(name: str) -> None:
        reader.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": name}])

    try:
        system("light")
        assert brightness(reader) > 200
        system("dark")
        assert brightness(reader) < 80
        reader.control("theme").click()
        assert brightness(reader) > 200
        reader.control("theme").click()
        assert brightness(reader) < 80
    finally:
        reader.cdp("Emulation.setEmulatedMedia", features=[])


@pytest.mark.parametrize("which", ["page", "study"])
def test_a_phone_needs_no_sideways_scrolling(which: str, open_page: Open, request: pytest.FixtureRequest) -> None:
    one = open_page(request.getfixturevalue(which))
    try:
        one.cdp("Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=2, mobile=True)
        one.settle()
        assert one.run("return document.documentElement.scrollWidth") <= 360
        assert one.find("canvas").rect["width"] > 300
    finally:
        one.cdp("Emulation.clearDeviceMetricsOverride")
    assert one.complaints() == []


def test_prints_and_comes_back(reader: Reader) -> None:
    before = reader.pixels(reader.find("canvas")).shape
    reader.control("theme").click()
    pdf = base64.b64decode(reader.cdp("Page.printToPDF")["data"])
    assert pdf.startswith(b"%PDF") and len(pdf) > 50_000
    reader.settle()
    assert reader.run("return document.documentElement.dataset.theme") == "dark"
    assert reader.pixels(reader.find("canvas")).shape == before


def test_runs_are_chosen_and_sorted(study: Path, open_page: Open, packing: Path, cohesive: Path) -> None:
    one = open_page(study)

    def order() -> list[str]:
        return [row.text for row in one.driver.find_elements(By.CSS_SELECTOR, ".sortable tbody th")]

    def shown() -> int:
        return int(one.run("return [...document.querySelectorAll('article')].filter((a) => !a.hidden).length"))

    *names, absent = order()
    density = []
    for run in (packing, cohesive):
        with Archive(run / "run.h5") as archive:
            density.append(float(archive.series["solid_fraction"][-1]))
    button = next(b for b in one.driver.find_elements(By.CSS_SELECTOR, ".sortable button") if "solid fraction" in b.text)
    button.click()
    assert order() == [*(names[k] for k in np.argsort(density)), absent]
    button.click()
    assert order() == [*(names[k] for k in np.argsort(density)[::-1]), absent]  # what is not known stays below
    assert shown() == 1
    one.find("a[href='#r1']").click()
    one.settle()
    assert shown() == 1 and one.run("return document.querySelector('article:not([hidden])').id") == "r1"
    assert one.run("return document.querySelectorAll('#compare .lines button').length") == 2
    assert one.complaints() == [] and one.requests() == [one.address]


def test_names_do_no_harm_in_a_browser(packing: Path, open_page: Open, tmp_path: Path) -> None:
    """A directory, and a scene file, named to break out of the page."""
    evil = tmp_path / "<img src=x onerror=alert(1)>"
    evil.symlink_to(packing)
    one = open_page(report(tmp_path, evil.name))
    assert one.driver.find_elements(By.CSS_SELECTOR, "main img") == []
    assert one.requests() == [one.address]


def test_page_of_a_study_asks_for_nothing(open_page: Open, tmp_path: Path) -> None:
    """The pages of wf accuracy and wf stability share frame and policy; they have no script that says it is ready."""
    write_page(tmp_path / "study.html", "title", [("text", "words"), ("table", [{"a": 1.0}])])
    text = (tmp_path / "study.html").read_text()
    (tmp_path / "ready.html").write_text(text.replace("<html ", '<html data-ready="1" '))
    one = open_page(tmp_path / "ready.html")
    assert one.find("th").text == "a"
    assert one.complaints() == [] and one.requests() == [one.address]
