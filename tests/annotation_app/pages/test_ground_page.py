"""The page of Ground: all on one screen, one question after the other, nothing in the way."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

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
    site.only("ground", COMMAND, sdcs=to_json(parse_brackets(NOTATION, command=COMMAND)))
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
        expect(kinds).not_to_have_count(0)
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
    for label in ("5", "3"):
        expect(page.locator(".ask h2")).to_contain_text("What is")
        page.locator(".outlines .cap", has_text=label).tap()
    page.locator('.ask [data-key="right"]').tap()
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
    for key in ("x", "3", "a"):
        asked.append(question(page))
        page.keyboard.press(key)
    assert asked == ["your left", "the truck to your left", "on the truck to your left"]
    assert question(page) == "lift it"  # when it begins
    page.get_by_role("button", name="Back", exact=True).click()
    assert question(page) == "on the truck to your left"
    assert page.get_by_label("Place A").is_checked()
    page.keyboard.press("b")  # takes the place of A
    page.locator(".clause-bar .type-PLACE").click()
    assert page.get_by_label("Place B").is_checked()
    assert not page.get_by_label("Place A").is_checked()
    page.keyboard.press("Control+z")
    assert page.locator(".type-PLACE .said").inner_text() == "A"


def show_moment(page: Page, seconds: str) -> None:
    page.get_by_label("Time in the video, in seconds").fill(seconds)
    page.locator(".ask h2").click()


def test_six_answers_are_enough_for_three_steps(
    several_steps: Site, context: BrowserContext
) -> None:
    """The groundings of “it” and of a PATH follow, and are confirmed with one key."""
    page = several_steps.open(context, "ground")
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the red crate")
    for key in ("2", "x", "3", "a"):
        page.keyboard.press(key)
    page.keyboard.press("e")
    expect(page.locator(".hint")).to_contain_text("can’t begin at this moment")
    for seconds, step in (("0.3", "lift it"), ("0.7", "put it on the truck to your left")):
        assert question(page) == step
        show_moment(page, seconds)
        page.keyboard.press("e")
    expect(page.locator(".follows .phrase")).to_have_text(
        ["it", "it", "the truck", "to the red crate"]
    )
    assert violations(page) == []
    with page.expect_navigation():
        page.keyboard.press("y")
    (answer,) = several_steps.answers("ground")
    things = {node: one["objects"] for node, one in answer.body["groundings"].items()}
    assert things["6"] == things["8"] == things["10"] != []
    assert things["11"] == things["12"] != []
    assert answer.body["trims"] == {
        "0": [0.0, 0.3], "1": [0.3, 0.7], "2": [0.7, 1.0], "4": [0.0, 0.3]
    }  # fmt: skip
    assert answer.body["whole"] == {}


def test_what_follows_can_be_changed_before_it_is_sent(
    several_steps: Site, context: BrowserContext
) -> None:
    page = several_steps.open(context, "ground")
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the red crate")
    for key in ("2", "x", "3", "a"):
        page.keyboard.press(key)
    for seconds in ("0.3", "0.7"):
        show_moment(page, seconds)
        page.keyboard.press("e")
    page.get_by_role("button", name="Back", exact=True).click()
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("Look at what follows")
    page.locator(".follows button", has_text="it").first.click()
    expect(page.locator(".hint")).to_contain_text("follows from your other answers")
    page.keyboard.press("1")
    # The second “it” stands for the first.
    expect(page.locator(".follows .said")).to_have_text(["1", "3", "0.0–0.3 s"])
    with page.expect_navigation():
        page.get_by_role("button", name="Yes: Send").click()
    (answer,) = several_steps.answers("ground")
    things = {node: one["objects"] for node, one in answer.body["groundings"].items()}
    assert things["6"] == things["8"] != things["10"]


def test_nothing_arrives_ticked(site: Site, context: BrowserContext) -> None:
    """Even where there is nothing to choose, the whole video is but proposed."""
    page = site.open(context, "ground")
    expect(page.locator(".tick-mark")).to_have_count(0)
    expect(page.locator(".said", has_text="whole video?")).to_have_count(2)
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the red crate")
    page.keyboard.press("2")
    expect(page.locator(".follows .said")).to_have_text(["whole video", "whole video"])
    with page.expect_navigation():
        page.keyboard.press("y")
    (answer,) = site.answers("ground")
    assert answer.body["whole"] == {"0": "preset", "2": "preset"}


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
    expect(page.locator(".said", has_text="whole video")).to_have_count(2)  # the PATH as its EVENT
    expect(page.locator(".said", has_text="whole video?")).to_have_count(1)
    expect(page.locator(".said", has_text="0.2–0.6 s")).to_have_count(1)


PRACTICE_THINGS = {"the lighthouse": "5", "the buoy by the lighthouse": "3"}
"""What somebody sees in the picture."""


def test_who_does_what_the_page_says_practises_without_a_wrong_turn(
    site: Site, context: BrowserContext
) -> None:
    page = context.new_page()
    page.goto(f"{site.url}/practice/ground")
    for _ in range(12):
        told = page.locator(".ask").inner_text()
        if "Is this right, too?" in told:
            break
        if "watch the video" in told:
            page.get_by_role("button", name="Play the video").click()
            expect(page.locator(".ask h2")).not_to_contain_text("watch")
        else:
            assert "Click it in the picture or on the map" in told
            label = PRACTICE_THINGS[question(page)]
            page.locator(".outlines .cap", has_text=label).click()
    page.get_by_role("button", name="Yes: Check my answer").click()
    expect(page.locator("#feedback")).to_contain_text("Well done")
    assert page.locator("#problems li").count() == 0
    expect(page.locator("#feedback a")).to_be_visible()


def test_what_a_program_suggests_is_looked_at_one_by_one(
    site: Site, context: BrowserContext
) -> None:
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
    site.only("ground", command, sdcs=sdcs, suggestion=suggestion)
    page = site.open(context, "ground")
    expect(page.locator(".tick-mark")).to_have_count(0)
    page.keyboard.press("]")
    page.keyboard.press("]")  # the tires: they follow from "the tires by the truck"
    assert question(page) == "the truck"
    expect(page.locator(".hint")).to_contain_text("A program suggests what is marked")
    expect(page.locator(".map .thing.chosen")).to_have_count(1)
    assert violations(page) == []
    page.locator("#submit").click()
    expect(page.get_by_role("alert")).to_contain_text("say yes, or choose what is right")
    said = page.locator(".clause-bar [aria-current] .said")
    suggested = said.inner_text().removesuffix("?")
    others = [label for label in "1234" if label != suggested]
    page.keyboard.press(others[0])
    assert question(page) == "the tires by the truck"
    page.get_by_role("button", name="Yes").click()
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask")).to_contain_text("Is this right, too?")
    with page.expect_navigation():
        page.get_by_role("button", name="Yes: Send").click()
    (answer,) = site.answers("ground")
    assert answer.provenance is not None
    assert (answer.provenance["suggestion"], answer.provenance["unchanged"]) == ("shown", False)
    assert answer.provenance["likeness"] == 0.667
