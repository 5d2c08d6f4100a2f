"""A lab with a folder of videos, from nothing to agreed answers, in browsers alone.

It goes the way of docs/how-to/own-videos.md.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from annotation_app.core.config import Config
from corpus_tools.corpus.corpus_model import Corpus
from tests.annotation_app.in_browser import errors_of, late, look
from tests.annotation_app.pages.segmenting import place, start_from_nothing
from tests.annotation_app.real_server import running
from tests.annotation_app.signing_in import PASSWORD
from tests.annotation_app.study_setup.clips import clip

pytestmark = pytest.mark.slow

COMMAND = "Push the cup."
WHAT, WHERE = "Push what?", "Push where?"


def choose_login(page: Page, link: str, login: str) -> None:
    page.goto(link)
    page.get_by_label("Login").fill(login)
    page.get_by_label("Password, of").fill(PASSWORD)
    page.get_by_label("The password again").fill(PASSWORD)
    page.get_by_role("button", name=re.compile("Make the")).click()
    expect(page.get_by_role("link", name="Dashboard")).to_be_visible()


def agree(page: Page, address: str) -> None:
    """Read what the study is about, and begin."""
    page.goto(address)
    for box in page.get_by_role("checkbox").all():
        box.check()
    page.get_by_role("button", name="Begin").click()
    expect(page.get_by_role("heading", name="Your tasks")).to_be_visible()


def go_on(page: Page) -> None:
    page.get_by_role("button", name="Save and go on").click()


def make_study(page: Page, folder: Path) -> list[str]:
    """All steps, as an admin goes them."""
    page.get_by_role("link", name="Make a study").click()
    found = look(page, "new")
    page.get_by_label("Title").fill("Commands for an arm")
    page.get_by_label("What your robot is called").fill("robot arm")
    page.get_by_label("Name in addresses").fill("arm")
    lift, *others = sorted(folder.iterdir())
    with late(page, "*file=*"):
        with late(page, "upload.js"):
            page.get_by_role("button", name="Begin").click()
            page.set_input_files("#files", lift)
            expect(page.locator("#uploads")).to_be_empty()
            expect(page.get_by_text("or drop them here")).to_be_hidden()
        expect(page.locator("#uploads")).to_have_text("lift.mp4")
        with page.expect_response(f"**/*file={others[-1].name}*"):
            page.set_input_files("#files", others)
        page.wait_for_timeout(300)
        expect(page.locator("#uploads li")).to_have_count(3)  # the page waits for the first
    expect(page.get_by_text("3 videos: lift, push, wait")).to_be_visible()
    found += look(page, "videos")
    go_on(page)
    page.get_by_role("checkbox", name="Check").check()
    segment, check, rate = (page.get_by_role("group", name=n) for n in ("Segment", "Check", "Rate"))
    for task in (segment, check, rate):
        task.get_by_label("People practise first").uncheck()
    segment.get_by_label("Answers per item").fill("three")
    go_on(page)
    expect(page.get_by_role("alert")).to_contain_text("Segment, answers: Type a whole number.")
    segment.get_by_label("Answers per item").fill("3")
    segment.get_by_label("Suggestions").select_option("off")
    found += look(page, "tasks")
    go_on(page)
    page.get_by_label("Who does Segment").select_option("people with a login")
    for number, (name, share) in enumerate((("day", "2"), ("night", "1"))):
        page.get_by_label("Group", exact=True).nth(number).fill(name)
        page.get_by_label("Share", exact=True).nth(number).fill(share)
    page.get_by_label("Conditions").fill("I am at least 18 years old.")
    found += look(page, "people")
    go_on(page)
    page.get_by_label("Instructions").first.fill("1. Watch.\n2. Type what the arm **does**.")
    page.get_by_label("Video").first.select_option("push")
    page.get_by_label("Some that would do").first.fill("Well said!")
    with page.context.expect_page() as opened:
        page.get_by_role("button", name="Save and look at Describe").click()
    preview = opened.value
    expect(preview.locator(".instructions strong")).to_have_text("does")
    found += look(preview, "preview")
    preview.close()
    found += look(page, "texts")
    go_on(page)
    page.get_by_label("Question").first.fill("Have you worked with robots?")
    page.get_by_label("Answers to choose from").first.fill("Yes\nNo")
    found += look(page, "consent")
    go_on(page)
    expect(page.get_by_role("main")).to_contain_text("asks for 3 answers to each item")
    expect(page.get_by_role("main")).to_contain_text("group night has no members")
    found += look(page, "review")
    page.get_by_role("button", name="Start the study").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("The study is open")
    return found + look(page, "started")


def invited(page: Page, role: str) -> str:
    """A link for somebody new."""
    page.get_by_role("link", name="Administration").click()
    page.get_by_label("Role of the person you invite").select_option(role)
    page.get_by_role("button", name="Make an invitation").click()
    return page.get_by_label("The link").input_value()


def set_group(page: Page, name: str, *people: str) -> None:
    """Make a group of people on the page on which items are assigned."""
    for person in people:
        page.get_by_role("checkbox", name=person, exact=True).check()
    page.get_by_label("Name of a group").fill(name)
    page.get_by_role("button", name="Save the chosen as a group").click()
    expect(page.get_by_role("status")).to_have_text(f"The group {name} is saved.")
    expect(page.get_by_role("checkbox", name=name, exact=True)).to_be_visible()


def watch(page: Page) -> None:
    page.locator("video").first.evaluate("video => video.play()")
    expect(page.get_by_text("You have watched it to the end").first).to_be_visible()


def describe(page: Page, address: str) -> None:
    """Practise with one of the lab's videos, then type a command for one."""
    page.goto(f"{address}/describe")
    watch(page)
    page.locator("#text").fill("Anything.")
    page.get_by_role("button", name="Check my answer").click()
    expect(page.locator("#feedback")).to_contain_text("Well said!")
    page.get_by_role("link", name="Go on").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Describe")
    watch(page)
    page.locator("#text").fill(COMMAND)
    page.get_by_role("button", name="Send").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("You have done all")


def segment(page: Page, address: str, question: str) -> list[str]:
    """Give the words their places; people don't agree where "the cup" belongs."""
    page.goto(f"{address}/segment")
    start_from_nothing(page)
    place(page, (0,), "What to do?")
    place(page, (1, 2), question)
    expect(page.locator("#prompt")).to_contain_text("Every word has its place.")
    found = look(page, "segment")
    button = page.get_by_role("button", name="Send", exact=True)
    if question == WHERE:  # "the cup" says where without a word like "on"
        button.click()
        button = page.get_by_role("button", name="Send it all the same")
    with page.expect_navigation():
        button.click()
    expect(page.get_by_role("heading", level=1)).not_to_have_text("Segment")
    return found


def check(page: Page, address: str) -> list[str]:
    """Tell that another video doesn't show the command."""
    page.goto(f"{address}/check")
    expect(page.get_by_text("Does the whole video show")).to_contain_text("Push the cup")
    found = look(page, "check")
    watch(page)
    page.get_by_label("It doesn't match").check()
    page.get_by_role("button", name="Send").click()
    expect(page.get_by_role("heading", level=1)).not_to_have_text("Check")
    return found


def downloaded(page: Page, name: str) -> bytes:
    with page.expect_download() as got:
        page.get_by_role("link", name=name, exact=True).click()
    return got.value.path().read_bytes()


def test_a_lab_goes_from_a_folder_of_videos_to_agreed_answers(
    chromium: Browser, context: BrowserContext, config: Config, tmp_path: Path
) -> None:
    for name, shade in (("push", 40), ("lift", 140), ("wait", 90)):
        clip(tmp_path / f"clips/{name}.mp4", shade)
    studies = tmp_path / "studies"
    with running(config, tmp_path, "--studies", str(studies)) as server:
        link = re.search(r"http://\S+/setup/\S+", server.told)
        assert link
        address = f"http://localhost:{server.port}/s/arm"
        page = context.new_page()
        errors = errors_of(page)
        choose_login(page, link[0], "ada")
        found = make_study(page, tmp_path / "clips")
        assert page.get_by_label("The address of the study").input_value() == address
        people = []
        for number in range(3):
            person = chromium.new_context().new_page()
            choose_login(person, invited(page, "annotator"), f"ann-{number}")
            agree(person, address)
            people.append(person)
        judge = chromium.new_context(accept_downloads=True).new_page()
        choose_login(judge, invited(page, "adjudicator"), "grace")
        judge.goto(f"http://localhost:{server.port}/dashboard/arm/people")
        judge.get_by_role("link", name="Assign items").click()
        set_group(judge, "day", "ann-0", "ann-1", "ann-2")
        set_group(judge, "night", "grace")
        found += look(judge, "assign")
        shares = judge.get_by_role("region", name="People").get_by_role("listitem")
        expect(shares.filter(has_text="describe")).to_have_text(
            ["ann-0 1 describe", "ann-1 1 describe", "grace 1 describe"]
        )

        describe(people[0], address)
        for person, question in zip(people, (WHAT, WHERE, WHAT), strict=True):
            found += segment(person, address, question)
        judge.goto(f"http://localhost:{server.port}/dashboard/arm/queue")
        judge.get_by_role("link", name=COMMAND).click()
        choices = judge.get_by_role("button", name=re.compile("Choose answer"))
        expect(choices).to_have_count(3)
        judge.get_by_role("button", name="Choose answer 1").click()
        expect(judge.get_by_text("There is nothing to decide.")).to_be_visible()
        judge.goto(f"http://localhost:{server.port}/dashboard/arm/assign")
        judge.locator("[name=task]").select_option("check")
        judge.locator("[name=way]").select_option("each")
        judge.get_by_role("checkbox", name="ann-1", exact=True).check()
        judge.get_by_role("button", name="Assign", exact=True).click()
        expect(judge.get_by_role("status")).to_have_text("1 open item of check assigned.")
        found += check(people[1], address)

        judge.get_by_role("link", name="Exports").click()
        table = downloaded(judge, "Checked negatives (CSV)").decode()
        rows = list(csv.DictReader(io.StringIO(table)))
        answers = downloaded(judge, "Answers (CSV)").decode()
        zipfile.ZipFile(io.BytesIO(downloaded(judge, "Corpus (zip)"))).extractall(tmp_path)
        for person in (*people, judge):
            person.context.close()
    assert [(row["command"], row["type"], row["label"]) for row in rows] == [
        (COMMAND, "EVENT", "false")
    ]
    assert rows[0]["video"] != rows[0]["shown_video"]
    adopted = [row for row in csv.DictReader(io.StringIO(answers)) if row["adopted"] == "True"]
    trees = [row for row in adopted if row["task"] == "segment"]
    assert len(trees) == 1
    assert "OBJECT" in trees[0]["body"]
    assert [c.text for c in Corpus.load(tmp_path / "arm").commands.values()] == [COMMAND]
    assert found == []
    # The browser's console tells of the page with a problem.
    assert [error for error in errors if "422" not in error] == []
    assert (studies / "arm.yaml").is_file()
