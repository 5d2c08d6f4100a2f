"""Each task from its page to the acknowledged answer.

`test_whole_way` does all of them with keys alone.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import BrowserContext, Page, expect
from sqlalchemy import select

from annotation_app.store.installation import now
from annotation_app.store.models import Slot
from annotation_app.tasks.describe import LONGEST_COMMAND_WORDS
from annotation_app.work.handing_out import HOLD_S
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import row_in
from tests.annotation_app.in_browser import violations
from tests.annotation_app.pages.conftest import Site

pytestmark = [pytest.mark.slow, pytest.mark.firefox]


def watch(page: Page) -> None:
    page.locator("video").first.evaluate("video => video.play()")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()


def send(page: Page, task: str) -> None:
    with page.expect_navigation():
        page.get_by_role("button", name="Send", exact=True).click()
    page.wait_for_url(f"**/s/sea/{task}")


def send_by_keys(page: Page) -> None:
    with page.expect_navigation():
        page.keyboard.press("Control+Enter")


def tab_to(page: Page, selector: str) -> None:
    """Go to an element as people without a mouse do."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if page.evaluate("s => document.activeElement.matches(s)", selector):
            return
    raise AssertionError(f"the Tab key doesn't reach {selector}")


def test_describe(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "describe")
    page.get_by_label("Type the command").fill("Go to the red crate.")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("Watch the video to its end first.")
    watch(page)
    send(page, "describe")
    (answer,) = site.answers("describe")
    assert answer.body["text"] == "Go to the red crate."
    assert answer.body["watched_s"] >= 0.9


def test_describe_tells_the_limit_of_words_beforehand(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "describe")
    watch(page)
    text, counter = page.get_by_label("Type the command"), page.locator("#counter")
    expect(counter).to_have_text(f"0 of at most {LONGEST_COMMAND_WORDS} words")
    text.fill("go " * LONGEST_COMMAND_WORDS)
    expect(counter).not_to_have_class("problem")
    text.fill("go " * (LONGEST_COMMAND_WORDS + 1))
    expect(counter).to_have_class("quiet problem")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#problems")).to_contain_text("Use at most 200 words")
    text.fill("go " * LONGEST_COMMAND_WORDS)
    send(page, "describe")
    assert len(site.answers("describe")) == 1


def test_video_that_was_skipped_through_was_not_watched(
    site: Site, context: BrowserContext
) -> None:
    page = site.open(context, "describe")
    page.locator("video").evaluate("video => { video.currentTime = 0.8; video.play(); }")
    expect(page.get_by_text("You have left out a part of the video")).to_be_visible()


def test_ground(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    page.get_by_role("button", name="Next", exact=True).click()
    expect(page.locator("#command mark")).to_have_text(["the", "red", "crate"])
    page.get_by_label("Several").check()
    page.locator(".outlines .hit").first.click(force=True)
    expect(page.locator(".map .thing.chosen")).to_have_count(1)
    page.get_by_label("Place A").check()
    page.get_by_role("button", name="Mark a place").click()
    box = page.locator("svg.map").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 40, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 120, box["y"] + 100, steps=4)
    page.mouse.up()
    expect(page.get_by_text("Marked place 1")).to_be_visible()
    page.locator(".clause-bar .type-EVENT").click()
    page.get_by_role("button", name="Part 2").click()
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("Watch the video to its end first.")
    watch(page)
    send(page, "ground")
    (answer,) = site.answers("ground")
    assert answer.body["watched_s"] >= 0.9
    (grounding,) = answer.body["groundings"].values()
    assert len(grounding["objects"]) == 1
    assert [sorted(place) for place in grounding["places"]] == [["place"], ["xy"]]
    assert answer.body["trims"] == {"0": [0.5, 1.0], "2": [0.5, 1.0]}
    assert answer.body["whole"] == {}


def test_ground_by_keys(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    tab_to(page, '[data-key="play"]')
    page.keyboard.press("Space")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()
    for key in ("s", "1", "3", "1", "m", "ArrowRight", "ArrowUp", "+", "Enter"):
        page.keyboard.press(key)
    tab_to(page, ".clause-bar .type-PATH")
    page.keyboard.press("Enter")
    tab_to(page, '[data-key="End"]')
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Home")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    tab_to(page, '[data-key="Start"]')
    page.keyboard.press("Home")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("alert")).to_contain_text("what follows from your answers")
    send_by_keys(page)
    (answer,) = site.answers("ground")
    (grounding,) = answer.body["groundings"].values()
    assert len(grounding["objects"]) == 1
    assert len(grounding["places"]) == 1
    assert answer.body["trims"] == {"2": [0.0, pytest.approx(0.4)]}


def test_ground_wants_every_clause(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("the red crate")
    page.get_by_role("button", name="Next", exact=True).click()
    page.get_by_role("button", name="Can't tell").click()
    watch(page)
    send(page, "ground")
    (answer,) = site.answers("ground")
    assert [g["cant_tell"] for g in answer.body["groundings"].values()] == [True]


def test_check(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    page.get_by_label("It doesn't match").check()
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("Watch the video for “to the red crate”")
    watch(page)
    page.get_by_role("button", name="Next clause").click()
    expect(page.locator(".map .thing.chosen")).to_have_count(1)
    page.get_by_role("radio", name="It matches").check()
    send(page, "check")
    (answer,) = site.answers("check")
    assert answer.body["verdicts"] == {"2": False, "3": True}


def test_check_by_keys(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    page.keyboard.press("y")
    watch(page)
    for key in ("Control+z", "y", "]", "n", "Control+z", "x"):
        page.keyboard.press(key)
    send_by_keys(page)
    (answer,) = site.answers("check")
    assert answer.body["verdicts"] == {"2": True, "3": "cant_tell"}


def test_single_keys_can_be_switched_off(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    page.get_by_text("Instructions", exact=True).click()
    page.get_by_text("Keys", exact=True).click()
    page.get_by_label("Use single keys as shortcuts").uncheck()
    page.reload()
    page.keyboard.press("y")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("alert")).to_contain_text("Tell whether")
    expect(page.locator(".tick-mark")).to_have_count(0)


def test_rate(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "rate")
    watch(page)
    page.get_by_label("Disagree", exact=False).nth(1).check()
    send(page, "rate")
    assert [answer.body["rating"] for answer in site.answers("rate")] == [2]


def test_skip_and_report(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    page.get_by_role("button", name="Report a problem").click()
    page.get_by_label("Tell the people").fill("The picture is black.")
    page.get_by_role("button", name="Send the report").click()
    expect(page.locator("#saving")).to_have_text("Reported. Thank you!")
    page.get_by_role("button", name="Skip", exact=True).click()
    with page.expect_navigation():
        page.get_by_role("button", name="Skip it").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("all that there is for you")


STEPS = "Go to the red crate and stop."
TWO_STEPS = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the red crate))); EVENT(r = stop)"


def test_nothing_is_preset_for_a_command_of_several_steps(
    site: Site, context: BrowserContext
) -> None:
    sdcs = to_json(parse_brackets(TWO_STEPS, command=STEPS))
    site.only("ground", STEPS, sdcs=sdcs)
    page = site.open(context, "ground")
    expect(page.locator(".tick-mark")).to_have_count(0)
    expect(page.locator(".ask [aria-pressed=true]")).to_have_count(0)
    assert violations(page) == []
    watch(page)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text(
        "Choose which part of the video shows “stop”."
    )
    page.locator(".clause-bar .type-EVENT").first.click()
    page.get_by_role("button", name="Part 1").click()
    page.locator(".clause-bar .type-EVENT", has_text="stop").click()
    page.get_by_role("button", name="Part 2").click()
    page.locator(".clause-bar .type-PATH").click()
    page.get_by_role("button", name="The whole video").click()
    page.locator(".clause-bar .type-OBJECT").click()
    page.get_by_role("button", name="Can't tell").click()
    expect(page.locator(".tick-mark")).to_have_count(6)  # with that of the steps
    send(page, "ground")
    (answer,) = site.answers("ground")
    assert answer.body["trims"] == {"0": [0.0, 0.5], "1": [0.5, 1.0]}
    assert set(answer.body["whole"].values()) == {"chosen"}


def test_the_first_click_leases_the_item(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "rate")

    def left_s() -> float:
        return row_in(site.engine, select(Slot.expires_at).where(Slot.expires_at > 0)) - now()

    assert left_s() <= HOLD_S
    with page.expect_response("**/begin") as reply:
        page.locator("#likert legend").click()
    assert reply.value.json() == {"leased": True}
    assert left_s() > HOLD_S


@pytest.mark.parametrize("text", ["Sail to the buoy that is next to the lighthouse", "Go"])
def test_practising_to_describe_gives_no_verdict(
    site: Site, context: BrowserContext, text: str
) -> None:
    page = site.visit(context, "/practice/describe?study=sea")
    watch(page)
    page.get_by_label("Type the command").fill(text)
    page.get_by_role("button", name="Check my answer").click()
    told = page.locator("#feedback")
    expect(told).to_contain_text("Compare yours with some that would do")
    expect(told).not_to_contain_text("Not quite")
    expect(told).not_to_contain_text("Well done")
    expect(told.get_by_role("link", name="Go on")).to_be_visible()
