"""People who do what each page says, word by word, practise every task without a wrong turn.

Segment and Ground are practised so in `test_segment` and `test_ground_page`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from annotation_app.tasks.task_registry import task_names
from tests.annotation_app.in_browser import out_of_sight
from tests.annotation_app.pages.conftest import TASKS, Site

pytestmark = pytest.mark.slow

ELSEWHERE = {"segment", "ground"}
SMALLEST_PICTURE = 250
SAID = "Sail to the buoy by the lighthouse."
IS_ON_TOP = """selector => {
  const element = document.querySelector(selector);
  const {left, right, top, bottom} = element.getBoundingClientRect();
  return [top + 2, bottom - 2].every(
    y => document.elementFromPoint((left + right) / 2, y) === element);
}"""
"""Whether nothing covers an element, in the window as it is."""
MEANT = {"the buoy by the lighthouse": False, "the buoy": True, "the lighthouse": False}
"""Whether words could mean the buoy that is marked, which is far from the lighthouse."""


def watch(page: Page) -> None:
    page.locator(".player .play").click()
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()


def type_a_command(page: Page) -> None:
    page.get_by_label("Type the command").fill("Sail to the buoy next to the lighthouse.")


def read_and_watch(page: Page) -> None:
    expect(page.locator("#command")).to_have_text(SAID)
    watch(page)


def agree(page: Page) -> None:
    page.get_by_role("radio", name="Agree", exact=True).click()  # it has done so


def type_the_first_step(page: Page) -> None:
    page.get_by_label("What is done").fill("Wait")


def begin_the_next_step(page: Page) -> None:
    page.get_by_label("Time in the video, in seconds").fill("0.5")  # the boat begins to move
    page.get_by_role("button", name="A step begins here").click()
    page.keyboard.type("Sail to the buoy by the lighthouse")


def judge(page: Page) -> None:
    asked = page.locator(".ask h2")
    expect(asked).to_contain_text("which is marked")
    does = MEANT[asked.locator("bdi").inner_text()]
    page.get_by_text("It matches" if does else "It doesn't match", exact=True).click()


def judge_the_others(page: Page) -> None:
    """Go on as long as the page marks the button for it."""
    on = page.locator(".ask .primary")
    for _ in range(len(MEANT)):
        if on.count():
            expect(on).to_have_text("Next clause")
            on.click()
            judge(page)
    expect(page.locator(".clause-bar .tick-mark")).to_have_count(len(MEANT))


def nothing(_page: Page) -> None:
    """The instruction asks for no step."""


DOES: Mapping[str, Mapping[str, Callable[[Page], None]]] = {
    "describe": {
        "Watch the video to its end.": watch,
        "Imagine that you had told an expert operator": type_a_command,
        "Say what is to be done, not what you see": nothing,
        "Write as you would speak.": nothing,
    },
    "rate": {
        "Read the command, then watch the video to its end.": read_and_watch,
        "Tell how much you agree with the statement below it.": agree,
        "Some commands fit well": nothing,
    },
    "subtasks": {
        "Watch the video to its end.": watch,
        "Type what the robot does first. Begin with a verb": type_the_first_step,
        "Go to the moment at which the next step begins": begin_the_next_step,
        "A step ends when the next one begins.": nothing,
    },
    "check": {
        "For each clause something is shown": nothing,
        "Where words say what happens": nothing,  # these clauses are things
        "Choose “It matches” if": nothing,
        "Choose “It doesn't match” if": judge,
        "Go on with “Next clause” until every clause has a tick.": judge_the_others,
    },
}
"""What each instruction asks for, by how it begins."""
TOLD = {
    "describe": "Thank you. Compare yours with some that would do",
    "rate": "Well done.",
    "subtasks": "Thank you. Compare yours with some that would do",
    "check": "Well done.",
}
NEEDED = {
    "describe": ("video", ".player-bar", "#text", "#counter", "#submit"),
    "rate": ("#command", "video", ".player-bar", "#likert", "#likert label:last-child", "#submit"),
    "subtasks": ("video", ".player-bar", ".subtask .what", "#add", "#submit"),
    "check": ("#command", ".ask h2", ".ask .choices", "video", ".map", ".clause-bar", "#submit"),
    "segment": (".words", "#prompt", ".places", "#submit"),
    "ground": ("#command", ".ask h2", "video", ".map", ".clause-bar", "#submit"),
}
"""What people need of each page."""


def test_there_is_somebody_for_every_task() -> None:
    assert set(DOES) | ELSEWHERE == set(task_names()) == set(NEEDED)
    assert not set(DOES) & ELSEWHERE


@pytest.mark.parametrize("task", DOES)
def test_who_does_what_the_page_says_takes_no_wrong_turn(
    site: Site, context: BrowserContext, task: str
) -> None:
    page = context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    page.goto(f"{site.url}/practice/{task}")
    summary = page.locator("#instructions > summary")
    is_closed = not page.locator("#instructions[open]").count()
    if is_closed:
        summary.click()
    told = page.locator("#instructions .told li").all_inner_texts()
    if is_closed:
        summary.click()
    left = dict(DOES[task])
    for instruction in told:
        (known,) = [begin for begin in left if instruction.startswith(begin)]
        left.pop(known)(page)
    assert left == {}
    page.get_by_role("button", name="Check my answer").click()
    expect(page.locator("#feedback")).to_contain_text(TOLD[task])
    expect(page.locator("#feedback").get_by_role("link", name="Go on")).to_be_visible()
    assert page.evaluate(IS_ON_TOP, "#feedback a")
    assert page.locator("#problems li").count() == 0
    assert page.locator("#feedback").get_attribute("data-good") in ("true", "open")


def test_nothing_that_is_needed_is_below_the_fold(site: Site, context: BrowserContext) -> None:
    site.sign_in(context)
    page = context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    addresses = [(f"/practice/{task}", task) for task in NEEDED]
    for address, task in (*addresses, *((f"/s/sea/{task}", task) for task in TASKS)):
        page.goto(site.url + address)
        expect(page.locator("#submit")).to_be_enabled()
        page.wait_for_load_state("networkidle")
        assert out_of_sight(page, *NEEDED[task]) == [], address
        picture = page.locator("video").first.bounding_box()
        assert task == "segment" or (picture is not None and picture["height"] >= SMALLEST_PICTURE)
