"""Practice that a study's file brings: a verdict only where something is judged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from playwright.sync_api import BrowserContext, expect

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.items.scenes import aliases, read_scene
from annotation_app.studies.study_file import PracticeItem, TaskConfig, WrongAnswer
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.conftest import set_up
from tests.annotation_app.pages.conftest import STUDY, Site, served
from tests.annotation_app.pages.segmenting import place
from tests.annotation_app.pages.test_tasks import watch
from tests.annotation_app.rendered import VIDEOS

pytestmark = pytest.mark.slow

EXAMPLES = "“Fly to the red crate.” “To the crate, please.”"
OWN = {
    "describe": TaskConfig(
        prompt="Type what the pilot should tell the drone",
        practice_items=(PracticeItem(video=VIDEOS[0], good=EXAMPLES),),
    ),
    "subtasks": TaskConfig(practice_items=(PracticeItem(video=VIDEOS[0], good=EXAMPLES),)),
    "rate": TaskConfig(
        practice_items=(
            PracticeItem(
                video=VIDEOS[0], command="Land.", right=(1, 2), good="It flies on.", again="Look!"
            ),
        )
    ),
}


COMMAND = "Lift the red crate and put it down"
NOTATION = "EVENT(r = Lift, l = OBJ(f = the red crate)); EVENT(r = put down, l = OBJ(f = it))"
SDCS = to_json(parse_brackets(NOTATION, command=COMMAND))


def of_things(films: Path) -> dict[str, TaskConfig]:
    """Practice of the tasks whose answers name things of the first video."""
    names = aliases(read_scene(films / VIDEOS[0]), "practice", b"")
    alias = {real: name for name, real in names.objects.items()}
    right, wrong = (
        {"groundings": {n: {"objects": [alias[thing]], "places": []} for n in ("3", "5")}}
        for thing in ("tires-1", "truck")
    )
    about = {"video": VIDEOS[0], "command": COMMAND, "clauses": NOTATION}
    answers = {
        "segment": {"sdcs": SDCS},
        "ground": right,
        "check": {"verdicts": {"0": True, "1": True, "3": False, "5": False}},
    }
    reasons = {"ground": (WrongAnswer(wrong, "That is the truck."),)}
    return {
        task: TaskConfig(
            practice_items=(
                PracticeItem(**about, good="So it is.", answer=answer, wrong=reasons.get(task, ())),
            )
        )
        for task, answer in answers.items()
    }


@pytest.fixture(scope="module")
def own_practice(films: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A study with practice of its own."""
    tasks = {**STUDY.tasks, **OWN, **of_things(films)}
    study = msgspec.structs.replace(STUDY, tasks=tasks)
    database = open_instance(tmp_path_factory.mktemp("own") / "instance").instance / DATABASE_FILE
    set_up(database, study, films)
    with served(study, database) as found:
        yield found


@pytest.mark.parametrize("text", ["Fly to the crate", "blah"])
def test_what_nobody_judges_is_not_praised(
    own_practice: Site, context: BrowserContext, text: str
) -> None:
    page = own_practice.visit(context, "/practice/describe?study=sea")
    watch(page)
    page.get_by_label("Type what the pilot should tell the drone").fill(text)
    page.get_by_role("button", name="Check my answer").click()
    told = page.locator("#feedback")
    expect(told).to_contain_text(EXAMPLES)
    expect(told).not_to_contain_text("Well done")
    expect(told.get_by_role("link", name="Go on")).to_be_visible()


def test_steps_are_compared_with_the_studys_own(
    own_practice: Site, context: BrowserContext
) -> None:
    page = own_practice.visit(context, "/practice/subtasks?study=sea")
    watch(page)
    page.get_by_label("What is done").fill("Wave")
    page.get_by_role("button", name="Check my answer").click()
    expect(page.locator("#feedback")).to_contain_text(EXAMPLES)
    expect(page.locator("#feedback")).not_to_contain_text("Well done")


def test_what_is_judged_gets_a_verdict_with_its_reason(
    own_practice: Site, context: BrowserContext
) -> None:
    page = own_practice.visit(context, "/practice/rate?study=sea")
    watch(page)
    for rating, told in ((5, "Not quite. Look!"), (1, "Well done. It flies on.")):
        page.keyboard.press(str(rating))
        page.get_by_role("button", name="Check my answer").click()
        expect(page.locator("#feedback")).to_contain_text(told)


def test_segment_is_practised_with_the_studys_own_sentence(
    own_practice: Site, context: BrowserContext
) -> None:
    page = own_practice.visit(context, "/practice/segment?study=sea")
    expect(page.locator("#example")).to_have_count(0)
    place(page, (0,), "What to do?")
    place(page, (1, 2, 3), "Lift where?")
    check = page.get_by_role("button", name="Check my answer")
    check.click()
    told = page.locator("#feedback")
    expect(told).to_contain_text("Not quite. “the red crate” isn't in its place.")
    place(page, (1, 2, 3), "Lift what?")
    place(page, (5, 7), "What to do next?")
    place(page, (6,), "put down what?")
    check.click()
    expect(told).to_contain_text("Well done. So it is.")


def test_ground_is_practised_with_the_studys_own_things(
    own_practice: Site, context: BrowserContext
) -> None:
    page = own_practice.visit(context, "/practice/ground?study=sea")
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the red crate")
    clause = page.locator(".clause-bar button", has_text="the red crate").first
    told, verdicts = page.locator("#feedback"), []
    for label in "1234":
        clause.click()
        page.keyboard.press(label)
        for step in ("Lift the red crate", "put it down"):
            page.locator(".clause-bar button", has_text=step).click()
            page.get_by_role("button", name="The whole video").click()
        page.locator("#submit").click()
        page.locator("#submit").click()
        expect(told).to_be_visible()
        verdicts.append(told.locator("p").first.inner_text())
    assert sorted(verdicts) == [
        "Not quite. Look again at “the red crate”.",
        "Not quite. Look again at “the red crate”.",
        "Not quite. That is the truck.",
        "Well done. So it is.",
    ]


def test_check_is_practised_with_the_studys_own_video(
    own_practice: Site, context: BrowserContext
) -> None:
    page = own_practice.visit(context, "/practice/check?study=sea")
    for key in ("y", "y", "y", "n"):
        page.keyboard.press(key)
        page.get_by_role("button", name="Next clause").click()
    watch(page)
    check = page.get_by_role("button", name="Check my answer")
    check.click()
    told = page.locator("#feedback")
    expect(told).to_contain_text("Not quite. Look again at")
    page.locator(".clause-bar button").nth(2).click()
    page.keyboard.press("n")
    check.click()
    expect(told).to_contain_text("Well done. So it is.")
