"""Labels of things and places on pages: none covers another, and each has a key."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from playwright.sync_api import BrowserContext, Page, expect

from tests.annotation_app.in_browser import drawn_anew
from tests.annotation_app.pages.conftest import Site

pytestmark = pytest.mark.slow


def caps(page: Page, of: str) -> list[dict[str, float]]:
    return list(
        page.evaluate(
            "of => [...document.querySelectorAll(`${of} .cap:not(.left-out) rect`)].map(r => "
            "{ const {x, y, width, height} = r.getBoundingClientRect();"
            " return {x, y, w: width, h: height}; })",
            of,
        )
    )


def covered(boxes: list[dict[str, float]]) -> list[tuple[dict[str, float], dict[str, float]]]:
    """Pairs of boxes of which one covers more than half a pixel of the other."""
    return [
        (a, b)
        for i, a in enumerate(boxes)
        for b in boxes[:i]
        if min(a["x"] + a["w"], b["x"] + b["w"]) - max(a["x"], b["x"]) > 0.5
        and min(a["y"] + a["h"], b["y"] + b["h"]) - max(a["y"], b["y"]) > 0.5
    ]


def test_labels_of_the_page_never_cover_each_other(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    page.keyboard.press("]")
    for width in (1280, 700, 390):
        page.set_viewport_size({"width": width, "height": 800})
        for _ in range(3):
            drawn_anew(page)
            for of in (".map", ".outlines"):
                assert covered(caps(page, of)) == [], (width, of)
            page.get_by_role("button", name="Closer").click()
        page.get_by_role("button", name="The whole map").click()
        page.get_by_label("Time in the video, in seconds").fill("0.5")  # the robot has moved
    expect(page.locator(".map .cap:not(.left-out)").nth(3)).to_be_visible()  # four at least


SPOTS = st.tuples(
    st.floats(-50, 400), st.floats(-50, 300), st.floats(0, 200), st.floats(0, 200)
).map(lambda v: dict(zip("xywh", v, strict=True)))
LABELS = st.lists(st.tuples(SPOTS, st.floats(10, 40)), max_size=25)


@pytest.fixture
def modules(site: Site, context: BrowserContext) -> Page:
    """A page whose modules can be called."""
    page = context.new_page()
    page.goto(f"{site.url}/practice/ground")
    return page


def test_labels_never_cover_each_other(modules: Page) -> None:
    frame = {"x": 0, "y": 0, "w": 360, "h": 260}

    @settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow], deadline=None)
    @given(LABELS)
    def check(labels: list[Any]) -> None:
        wanted = [
            {"id": i, "w": w, "h": 20, "box": box, "isMinor": i > 12}
            for i, (box, w) in enumerate(labels)
        ]
        placed = modules.evaluate(
            "async ([wanted, frame]) => { const m = await import('/static/js/labels.js');"
            " return [...m.layOut(wanted, frame)]; }",
            [wanted, frame],
        )
        assert covered([spot for _, spot in placed]) == []
        for at, spot in placed:
            assert spot["w"] == wanted[at]["w"]
            assert at <= 12 or spot["line"] is None
            assert spot["x"] >= 0
            assert spot["y"] >= 0
            assert spot["x"] + spot["w"] <= frame["w"]
            assert spot["y"] + spot["h"] <= frame["h"]
        inside = [
            one
            for one in wanted
            if 60 <= one["box"]["x"] <= 200
            and one["box"]["w"] <= 60
            and 60 <= one["box"]["y"] <= 150
            and one["box"]["h"] <= 40
        ]
        if wanted and wanted[0] in inside:  # the first always finds room
            assert placed[0][0] == 0

    check()


SHOWN = """async () => {
  const { showMap } = await import("/static/js/map.js");
  const square = (x, y, r) => [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]];
  const things = [
    { id: "truck", number: "1", z: 1, footprint: square(0, 0, 4) },
    { id: "crate", number: "2", z: 2, footprint: square(3, 0, 0.4) },
  ];
  const zones = [{ id: "deck", letter: "A", polygon: square(-1, 0, 1.5) }];
  window.picked = [];
  const pick = (kind, id) => picked.push(`${kind} ${id}`);
  window.shown = showMap({ turn: 0, things, zones }, pick, () => {});
  document.querySelector("main").replaceChildren(shown.element);
  shown.show(0);
}"""


def test_a_place_on_a_thing_is_seen_and_chosen(modules: Page) -> None:
    """The place lies over the thing and is seen through; the question decides what is meant."""
    modules.evaluate(SHOWN)
    order = modules.evaluate("[...document.querySelectorAll('.map > g')].map(g => g.dataset.id)")
    assert order.index("deck") > order.index("truck")
    style = "getComputedStyle(document.querySelector('.map .zone polygon')).fillOpacity"
    assert float(modules.evaluate(style)) < 0.5

    def click(x: float, y: float) -> str:
        at = modules.evaluate(
            "([x, y]) => { const svg = document.querySelector('.map');"
            " const p = new DOMPoint(x, -y).matrixTransform(svg.getScreenCTM());"
            " return [p.x, p.y]; }",
            [x, y],
        )
        modules.mouse.click(*at)
        modules.wait_for_timeout(20)
        return str(modules.evaluate("picked.pop()"))

    modules.evaluate("shown.prefer('place')")
    assert click(-2, 1) == "place deck"
    modules.evaluate("shown.prefer('object')")
    assert click(-2, 1) == "object truck"
    assert click(3, 0.1) == "object crate"
    modules.locator(".map .cap.place").click()  # a label is what it names, whatever is asked
    assert modules.evaluate("picked.pop()") == "place deck"


def test_every_label_has_a_key(modules: Page) -> None:
    typed = """async (keys) => {
      const { labelKeys } = await import("/static/js/label-keys.js");
      const { numbered } = await import("/static/js/scene.js");
      const corner = (x) => [[x, 0], [x + 1, 0], [x + 1, 1]];
      const scene = numbered({ segmentation: { objects: [] }, map: { turn: 0,
        objects: Array.from({ length: 12 }, (_, i) => ({ id: `${i}`, footprint: corner(i) })),
        places: Array.from({ length: 24 }, (_, i) => ({ id: `${i}`, polygon: corner(i) })) } });
      const labels = [...scene.things.map((t) => t.number), ...scene.zones.map((z) => z.letter)];
      const found = [];
      const press = labelKeys(() => labels, (label) => found.push(label));
      for (const key of keys) press(key);
      await new Promise((done) => setTimeout(done, 1100));
      return [labels, found];
    }"""
    labels, found = modules.evaluate(typed, ["5", "1", "2", "1", "b", "a", "c", "a", "a"])
    assert len(set(labels)) == 36
    assert not set("IO0KMSXY") & {label[0] for label in labels}
    assert found == ["5", "12", "1", "B", "AC", "AA"]
