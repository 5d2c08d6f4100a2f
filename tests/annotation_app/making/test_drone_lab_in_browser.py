"""A lab with videos of a drone, from boxes drawn in the browser to a corpus: all five tasks.

Three people ground a command: with a mouse, on a telephone, and with keys alone. What is exported
is imported again, continued in the browser, and exported as it was.
"""

from __future__ import annotations

import csv
import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from annotation_app.core.config import Config, open_instance
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.treebank import TreebankCommand, read_treebank
from g3.sdc.sdc_notation import format_brackets
from tests.annotation_app.conftest import PATIENCE_MS
from tests.annotation_app.in_browser import errors_of, look
from tests.annotation_app.making.test_lab_in_browser import (
    COMMAND,
    WHAT,
    agree,
    choose_login,
    downloaded,
    go_on,
    invited,
    segment,
    watch,
)
from tests.annotation_app.real_server import running
from tests.annotation_app.study_setup.clips import clip

pytestmark = [pytest.mark.slow, pytest.mark.firefox]

TASKS = ("Describe", "Segment", "Ground", "Check", "Rate")
PHONE = {"width": 390, "height": 844}


def new_page(browser: Browser, **options: Any) -> Page:
    """A page of somebody else's browser."""
    context = browser.new_context(**options)
    context.set_default_timeout(PATIENCE_MS)
    return context.new_page()


def draw(page: Page, name: str, *shares: tuple[float, float, float, float]) -> None:
    """Draw boxes, given by parts of the picture's sides, in the open video, and name them."""
    expect(page.get_by_role("button", name="Box", exact=True)).to_be_visible()
    box = page.locator(".surface").bounding_box()
    assert box is not None
    for x, y, u, v in shares:
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + u * box["width"], box["y"] + v * box["height"], steps=3)
        page.mouse.up()
    for number in range(len(shares)):
        page.get_by_label(f"Name of thing {number + 1}").fill(name)
        page.keyboard.press("Enter")
    expect(page.get_by_text("Saved.")).to_be_visible()


def make_study(page: Page, files: list[Path]) -> list[str]:
    page.get_by_role("link", name="Make a study").click()
    page.get_by_label("Title").fill("A drone")
    page.get_by_label("What your robot is called").fill("drone")
    page.get_by_label("Name in addresses").fill("drone")
    page.get_by_role("button", name="Begin").click()
    page.set_input_files("#files", files)
    expect(page.get_by_text("6 without boxes")).to_be_visible()
    page.get_by_role("link", name="fly-0 Draw").click()
    draw(page, "cup", (0.1, 0.1, 0.3, 0.4), (0.5, 0.5, 0.8, 0.9))
    for number in (1, 2):
        page.get_by_role("link", name=f"Next video: fly-{number}").click()
        expect(page.get_by_role("heading", level=1)).to_contain_text(f"fly-{number}")
        draw(page, "cup", (0.2, 0.2, 0.4, 0.4))
    page.get_by_role("link", name="Back to the videos").click()
    expect(page.get_by_text("4 things in 3 of 6 videos")).to_be_visible()
    expect(page.get_by_text("3 without boxes")).to_be_visible()
    found = look(page, "drone-videos")
    go_on(page)
    for task in TASKS:
        page.get_by_role("region", name=task).get_by_label("People practise first").uncheck()
    page.get_by_role("region", name="Segment").get_by_label("Suggestions").select_option("off")
    page.get_by_role("region", name="Ground").get_by_label("Answers per item").fill("3")
    go_on(page)
    for task in TASKS:
        page.get_by_label(f"Who does {task}").select_option("people with a login")
    for _ in range(3):
        go_on(page)
    page.get_by_role("button", name="Start the study").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("The study is open")
    return found


def ground(page: Page, address: str, way: str, thing: int) -> None:
    """Watch the video and show what the cup is, in one of three ways."""
    page.wait_for_load_state()
    page.goto(f"{address}/ground")
    play = page.get_by_role("button", name="Play the video")
    if way == "keys":
        page.keyboard.press("k")
    elif way == "touch":
        play.tap()
    else:
        play.click()
    expect(page.locator(".ask q")).to_have_text("the cup")
    if way == "keys":
        page.keyboard.press(str(thing))
    elif way == "touch":
        page.locator(".outlines .cap text", has_text=str(thing)).tap(force=True)
    else:
        page.locator(".outlines .hit").nth(2 - thing).click(force=True)
    yes = page.get_by_role("button", name="Yes: Send")
    expect(yes).to_be_visible()
    with page.expect_navigation():
        if way == "keys":
            page.keyboard.press("y")
        elif way == "touch":
            yes.tap()
        else:
            yes.click()


def send(page: Page) -> None:
    with page.expect_navigation():
        page.get_by_role("button", name="Send", exact=True).click()


def do_the_others(page: Page, address: str) -> None:
    """Check what was grounded, rate the command with both videos, and describe one."""
    page.goto(f"{address}/check")
    expect(page.get_by_text("Does the whole video show")).to_be_visible()
    watch(page)
    for _ in range(page.locator(".clause-bar button").count()):
        page.get_by_label("It doesn't match").check()
        page.get_by_role("button", name="Next clause").click()
    send(page)
    page.goto(f"{address}/rate")
    watch(page)
    page.get_by_label("Strongly agree").check()
    send(page)
    page.goto(f"{address}/describe")
    watch(page)
    page.locator("#text").fill("Fly on.")
    send(page)


def continue_treebank(browser: Browser, treebank: Path, folder: Path) -> list[TreebankCommand]:
    """Import exported trees into a new installation and send them again; return its export."""
    folder.mkdir()
    instance = ("--instance", str(folder / "instance"))
    assert run(["annotate", "import", str(treebank), *instance]) == 0
    with running(open_instance(folder / "instance"), folder) as server:
        link = re.search(r"http://\S+/setup/\S+", server.told)
        assert link
        page = new_page(browser)
        choose_login(page, link[0], "eve")
        agree(page, f"http://localhost:{server.port}/s/drone")
        page.wait_for_load_state()  # in Firefox the way that agreeing leads may go on
        page.goto(f"http://localhost:{server.port}/s/drone/segment")
        expect(page.locator(".notice")).to_contain_text("start from nothing")
        expect(page.locator(".places .part")).to_have_count(2)
        with page.expect_navigation():
            page.get_by_role("button", name="Send", exact=True).click()
        page.context.close()
    out = folder / "out"
    assert run(["annotate", "export", str(out), *instance, "--format", "treebank"]) == 0
    return read_treebank(out)


def test_a_drone_lab_goes_from_its_videos_to_agreed_groundings(
    browser: Browser, context: BrowserContext, config: Config, tmp_path: Path
) -> None:
    files = [clip(tmp_path / f"clips/fly-{n}.mp4", 40 + 20 * n) for n in range(6)]
    commands = tmp_path / "commands.csv"
    commands.write_text(f"video,command\nfly-0,{COMMAND}\n")
    has_touch = browser.browser_type.name == "chromium"
    with running(config, tmp_path, "--studies", str(tmp_path / "studies")) as server:
        link = re.search(r"http://\S+/setup/\S+", server.told)
        assert link
        address = f"http://localhost:{server.port}/s/drone"
        page = context.new_page()
        errors = errors_of(page)
        choose_login(page, link[0], "ada")
        found = make_study(page, [*files, commands])
        phone = {"viewport": PHONE, "has_touch": True} if has_touch else {"viewport": PHONE}
        people = []
        for number, (way, thing, options) in enumerate(
            (("mouse", 1, {}), ("touch" if has_touch else "mouse", 1, phone), ("keys", 2, {}))
        ):
            person = new_page(browser, **options)
            choose_login(person, invited(page, "annotator"), f"ann-{number}")
            agree(person, address)
            if not number:
                found += segment(person, address, WHAT)
            ground(person, address, way, thing)
            people.append(person)
        judge = new_page(browser, accept_downloads=True)
        choose_login(judge, invited(page, "adjudicator"), "grace")
        judge.goto(f"http://localhost:{server.port}/dashboard/drone/queue")
        judge.get_by_role("link", name=COMMAND).click()
        judge.get_by_role("button", name="Choose answer 1").click()
        expect(judge.get_by_text("There is nothing to decide.")).to_be_visible()
        do_the_others(people[0], address)
        judge.get_by_role("link", name="Exports").click()
        table = downloaded(judge, "Groundings (CSV)").decode()
        for name in ("Corpus", "Treebank"):
            content = downloaded(judge, f"{name} (zip)")
            zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path / name)
        for person in (*people, judge):
            person.context.close()
    rows = [row for row in csv.DictReader(io.StringIO(table)) if row["things"]]
    assert [(row["command"], row["labels"]) for row in rows] == [(COMMAND, "cup 1")]
    drawn = json.loads((tmp_path / "studies/drone-videos/drawn.json").read_text())["annotations"]
    assert [json.loads(row["boxes"]) for row in rows] == [[drawn[0]["bbox"]]]
    corpus = Corpus.load(tmp_path / "Corpus/drone")
    assert {command.text for command in corpus.commands.values()} == {COMMAND, "Fly on."}
    assert [judgment.rating for judgment in corpus.judgments] == ["SA"]
    treebank, again = tmp_path / "Treebank/drone", tmp_path / "again"
    assert run(["import", "treebank", str(treebank), "--out", str(again)]) == 0
    for one in (corpus, Corpus.load(again)):
        (annotation,) = one.annotations
        assert annotation.command.text == COMMAND
        assert format_brackets(annotation.sdcs) == "EVENT_1(r = Push, l = OBJ_2(f = the cup))"
    assert continue_treebank(browser, treebank, tmp_path / "continued") == read_treebank(treebank)
    assert found == []
    assert errors == []
