"""Practice that a study's file brings: a verdict only where something is judged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from playwright.sync_api import BrowserContext, expect

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.studies.study_file import PracticeItem, TaskConfig
from tests.annotation_app.conftest import set_up
from tests.annotation_app.pages.conftest import STUDY, Site, served
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


@pytest.fixture(scope="module")
def own_practice(films: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A study with practice of its own."""
    study = msgspec.structs.replace(STUDY, tasks={**STUDY.tasks, **OWN})
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
