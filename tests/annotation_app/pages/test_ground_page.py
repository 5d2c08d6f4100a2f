"""The page of Ground: all on one screen, one question after the other, nothing in the way."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from playwright.sync_api import Browser, BrowserContext, Page, expect
from sqlalchemy import delete, select

from annotation_app.store.database import transaction
from annotation_app.store.models import Item, Slot
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.conftest import PATIENCE_MS
from tests.annotation_app.in_browser import errors_of, out_of_sight, violations, width_of
from tests.annotation_app.pages.conftest import Site

pytestmark = pytest.mark.slow

COMMAND = "Go over to the red crate, lift it and put it on the truck to your left"
NOTATION = (
    "EVENT(r = Go over, l = PATH(r = to, l = OBJ(f = the red crate))); EVENT(r = lift, l = OBJ(f = "
    "it)); EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = OBJ(f = the truck), r = "
    "to, l = OBJ(f = your left))))"
)
ABOVE_THE_FOLD = ("#command", ".ask h2", "video", ".map", ".clause-bar [aria-current]", "#submit")


def box(page: Page, selector: str) -> dict[str, float]:
    found = page.locator(selector).first.bounding_box()
    assert found is not None, selector
    return dict(found)


def question(page: Page) -> str:
    return page.locator(".ask q").inner_text().strip("“”")


@pytest.fixture
def several_steps(site: Site) -> Site:
    """The only item of Ground is a command of three steps."""
    with transaction(site.engine) as session:
        session.execute(
            delete(Slot).where(Slot.item_id.in_(select(Item.id).filter_by(task="ground")))
        )
    site.add("ground", COMMAND, sdcs=to_json(parse_brackets(NOTATION, command=COMMAND)))
    return site


@pytest.fixture
def telephone(chromium: Browser) -> Iterator[BrowserContext]:
    made = chromium.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    made.set_default_timeout(PATIENCE_MS)
    yield made
    made.close()


@pytest.mark.parametrize("task", ["ground", "check"])
def test_everything_is_on_one_screen(
    several_steps: Site, context: BrowserContext, task: str
) -> None:
    page = several_steps.open(context, task)
    errors = errors_of(page)
    page.set_viewport_size({"width": 1280, "height": 800})
    for address in (f"/s/sea/{task}", f"/practice/{task}?study=sea"):
        page.goto(several_steps.url + address)
        kinds = page.locator(".clause-bar .clause")
        for at in range(kinds.count()):
            kinds.nth(at).click()
            assert out_of_sight(page, *ABOVE_THE_FOLD) == []
            assert page.evaluate("document.documentElement.scrollHeight") <= 800
            assert box(page, "video")["height"] >= 250
            assert box(page, ".map")["height"] >= 250
    assert errors == []


def test_a_telephone_keeps_the_question_in_sight(
    several_steps: Site, telephone: BrowserContext
) -> None:
    page = several_steps.open(telephone, "ground")
    page.locator(".clause-bar .type-OBJECT").first.click()
    page.locator(".map").scroll_into_view_if_needed()
    page.evaluate("document.querySelector('.map').scrollIntoView({block: 'end'})")
    asked, seen = box(page, ".ask"), box(page, ".map")
    assert 0 <= asked["y"] <= 4
    assert asked["y"] + asked["height"] <= 300
    assert seen["y"] + seen["height"] - (asked["y"] + asked["height"]) > 250
    for selector in (".chip", ".ask .actions button", ".zoom button", ".clause-bar button"):
        for one in page.locator(selector).all():
            size = one.bounding_box()
            assert size is not None
            assert min(size["width"], size["height"]) >= (36 if "clause" in selector else 43)
    assert width_of(page) == 390
    assert violations(page) == []


def test_practice_on_a_telephone_ends_where_the_question_is(
    site: Site, telephone: BrowserContext
) -> None:
    page = telephone.new_page()
    page.goto(f"{site.url}/practice/ground")
    page.get_by_role("button", name="Play the video").tap()
    for label in ("3", "5", "3"):
        expect(page.locator(".ask h2")).to_contain_text("What is")
        page.locator(".outlines .cap", has_text=label).tap()
    page.locator(".ask .send-here").tap()
    expect(page.locator("#feedback")).to_contain_text("Well done")
    expect(page.locator("#feedback")).to_be_in_viewport()


def test_two_fingers_and_buttons_zoom_the_map(
    several_steps: Site, telephone: BrowserContext
) -> None:
    page = several_steps.open(telephone, "ground")
    page.locator(".clause-bar .type-OBJECT").first.click()
    page.evaluate("document.querySelector('.map').scrollIntoView({block: 'end'})")

    def shown() -> float:
        return float(page.evaluate("document.querySelector('.map').viewBox.baseVal.width"))

    whole = shown()
    page.get_by_role("button", name="Closer").click()
    closer = shown()
    assert closer < 0.8 * whole
    seen = box(page, ".map")
    x, y = seen["x"] + seen["width"] / 2, seen["y"] + seen["height"] / 2
    cdp = telephone.new_cdp_session(page)
    for kind, apart in (("touchStart", 20), ("touchMove", 50), ("touchMove", 100), ("touchEnd", 0)):
        points = [{"x": x - apart, "y": y}, {"x": x + apart, "y": y}] if apart else []
        cdp.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    assert shown() < 0.5 * closer
    page.get_by_role("button", name="The whole map").click()
    assert shown() == whole
    assert page.locator(".chosen").count() == 0  # no gesture has chosen anything


def test_a_choice_goes_on_and_back_is_easy(several_steps: Site, context: BrowserContext) -> None:
    page = several_steps.open(context, "ground")
    expect(page.locator(".ask h2")).to_contain_text("watch the video")
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the red crate")  # by itself, at the video's end
    expect(page.locator(".outlines")).not_to_have_class(re.compile("away"))
    page.locator(".outlines .hit").first.dblclick(force=True)  # answers one question, not two
    asked = []
    for key in ("2", "2", "3", "x", "3", "a"):
        asked.append(question(page))
        page.keyboard.press(key)
    assert asked == [
        "it",
        "it",
        "the truck",
        "your left",
        "the truck to your left",
        "on the truck to your left",
    ]
    assert question(page) == "Go over to the red crate"
    page.get_by_role("button", name="Back", exact=True).click()
    assert question(page) == "on the truck to your left"
    assert page.get_by_label("Place A").is_checked()
    page.keyboard.press("b")  # takes the place of A
    page.locator(".clause-bar .type-PLACE").click()
    assert page.get_by_label("Place B").is_checked()
    assert not page.get_by_label("Place A").is_checked()
    page.keyboard.press("Control+z")
    assert page.locator(".type-PLACE .said").inner_text() == "A"


def test_several_things_are_chosen_before_going_on(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    page.keyboard.press("]")
    page.keyboard.press("s")
    for key in ("1", "2", "4", "2"):
        page.keyboard.press(key)
    assert question(page) == "the red crate"
    expect(page.locator(".map .thing.chosen")).to_have_count(2)
    expect(page.locator(".clause-bar [aria-current] .said")).to_have_text(
        re.compile("^[14], [14]$")
    )


def test_parts_of_the_video_by_keys_and_with_the_mouse(
    several_steps: Site, context: BrowserContext
) -> None:
    page = several_steps.open(context, "ground")
    expect(page.locator(".tick-mark")).to_have_count(0)
    page.locator(".clause-bar button", has_text="lift it").click()
    start, end = (
        page.get_by_role("slider", name=f"{name} of the part") for name in ("Start", "End")
    )
    for handle in (start, end):
        expect(handle).to_have_attribute("aria-valuetext", "not set")
    assert violations(page) == []
    start.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(start).to_have_attribute("aria-valuenow", "0.2")  # ten frames a second
    expect(end).to_have_attribute("aria-valuetext", "not set")
    expect(page.locator(".clause-bar [aria-current] .tick-mark")).to_have_count(0)
    end.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowLeft")  # a second, but never before the start
    expect(end).to_have_attribute("aria-valuenow", "0.3")
    expect(page.locator(".clause-bar [aria-current] .tick-mark")).to_have_count(1)
    track, handle = box(page, ".track"), box(page, ".handle-end")
    page.mouse.move(handle["x"] + handle["width"] / 2, handle["y"] + 10)
    page.mouse.down()
    page.mouse.move(track["x"] + 0.6 * track["width"], handle["y"] + 10, steps=5)
    page.mouse.up()
    expect(end).to_have_attribute("aria-valuenow", "0.6")
    page.locator(".clause-bar button", has_text="Go over").click()
    page.get_by_role("button", name="The whole video").click()
    page.get_by_role("button", name="The same as").click()  # the PATH, like its EVENT
    expect(page.locator(".said", has_text="whole video")).to_have_count(2)
    expect(page.locator(".said", has_text="0.2–0.6 s")).to_have_count(1)


PRACTICE_THINGS = {"the buoy": "3", "the lighthouse": "5", "the buoy by the lighthouse": "3"}
"""What somebody sees in the picture."""


def test_who_does_what_the_page_says_practises_without_a_wrong_turn(
    site: Site, context: BrowserContext
) -> None:
    page = context.new_page()
    page.goto(f"{site.url}/practice/ground")
    for _ in range(12):
        told = page.locator(".ask").inner_text()
        if "press “Check my answer”" in told:
            break
        if "watch the video" in told:
            page.get_by_role("button", name="Play the video").click()
            expect(page.locator(".ask h2")).not_to_contain_text("watch")
        else:
            assert "Click it in the picture or on the map" in told
            label = PRACTICE_THINGS[question(page)]
            page.locator(".outlines .cap", has_text=label).click()
    page.get_by_role("button", name="Check my answer").click()
    expect(page.locator("#feedback")).to_contain_text("Well done")
    assert page.locator("#problems li").count() == 0
    expect(page.locator("#feedback a")).to_be_visible()


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
            page.wait_for_timeout(150)
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
      const press = labelKeys(labels, (label) => found.push(label));
      for (const key of keys) press(key);
      await new Promise((done) => setTimeout(done, 1100));
      return [labels, found];
    }"""
    labels, found = modules.evaluate(typed, ["5", "1", "2", "1", "b", "a", "c", "a", "a"])
    assert len(set(labels)) == 36
    assert not set("IO0KMSXY") & {label[0] for label in labels}
    assert found == ["5", "12", "1", "B", "AC", "AA"]


def test_what_a_program_suggests_is_looked_at_one_by_one(
    site: Site, context: BrowserContext
) -> None:
    with transaction(site.engine) as session:
        session.execute(
            delete(Slot).where(Slot.item_id.in_(select(Item.id).filter_by(task="ground")))
        )
    notation = "EVENT(r = Take, l = OBJ(f = OBJ(f = the tires), r = by, l = OBJ(f = the truck)))"
    command = "Take the tires by the truck"
    sdcs = to_json(parse_brackets(notation, command=command))
    things = {"2": "tires-1", "3": "tires-1", "4": "boxes-1"}  # the last one is wrong
    suggestion = {
        "groundings": {
            node: {"objects": [thing], "places": [], "cant_tell": False, "time_s": 0.0}
            for node, thing in things.items()
        }
    }
    site.add("ground", command, sdcs=sdcs, suggestion=suggestion)
    page = site.open(context, "ground")
    expect(page.locator(".tick-mark")).to_have_count(1)  # the one EVENT is the whole video
    page.keyboard.press("]")
    expect(page.locator(".hint")).to_contain_text("A program suggests what is marked")
    expect(page.locator(".map .thing.chosen")).to_have_count(1)
    assert violations(page) == []
    page.keyboard.press("y")
    assert question(page) == "the truck"
    page.locator("#submit").click()
    expect(page.get_by_role("alert")).to_contain_text("say yes, or choose what is right")
    said = page.locator(".clause-bar [aria-current] .said")
    suggested = said.inner_text().removesuffix("?")
    others = [label for label in "1234" if label != suggested]
    page.keyboard.press(others[0])
    assert question(page) == "the tires by the truck"
    page.get_by_role("button", name="Yes").click()
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask")).to_contain_text("All questions are answered")
    with page.expect_navigation():
        page.get_by_role("button", name="Send", exact=True).click()
    (answer,) = site.answers("ground")
    assert answer.provenance is not None
    assert (answer.provenance["suggestion"], answer.provenance["unchanged"]) == ("shown", False)
    assert answer.provenance["likeness"] == 0.667
