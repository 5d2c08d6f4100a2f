"""Segment: words get their places, as people who have never done it would give them."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.in_browser import violations, width_of
from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.segmenting import (
    TREE,
    Reader,
    place,
    start_from_nothing,
    words_of,
)
from tests.annotation_app.pages.test_tasks import send

pytestmark = pytest.mark.slow

PRACTISED = "/practice/segment?study=sea"
PRACTICE = (
    ("Sail", "What to do?"),
    ("to", "Sail which way?"),
    ("the buoy", "to what?"),
    ("by", "the buoy: which one?"),
    ("the lighthouse", "by what?"),
)
STEPS = "Go to the red crate and stop."
TWO_STEPS = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the red crate))); EVENT(r = stop)"


def check(page: Page) -> None:
    page.get_by_role("button", name="Check my answer").click()


def test_who_follows_the_page_practises_without_a_wrong_turn(
    site: Site, context: BrowserContext
) -> None:
    reader = Reader(context.new_page())
    reader.page.goto(f"{site.url}/practice/segment")  # nobody need be known
    for said, question in PRACTICE:
        reader.give(said, question)
        expect(reader.page.locator(".part[aria-current] bdi")).to_have_text(said)
    expect(reader.page.locator("#prompt")).to_contain_text("Every word has its place.")
    check(reader.page)
    expect(reader.page.locator("#feedback")).to_contain_text("Well done")
    assert (reader.steps, reader.lost) == (8, 0)


def test_practice_names_the_word_that_is_wrong(site: Site, context: BrowserContext) -> None:
    reader = Reader(site.visit(context, PRACTISED))
    page = reader.page
    for said, question in (*PRACTICE[:3], ("by", "Sail where?"), PRACTICE[4]):
        reader.give(said, question)
    check(page)
    told = page.locator("#feedback")
    expect(told).to_contain_text(
        "“by” isn't in its place. Choose “by”, then “the buoy: which one?”."
    )
    expect(page.locator(".word.wrong")).to_have_text("by")
    expect(page.locator(".part.wrong bdi")).to_have_text("by")
    place(page, (4,), "the buoy: which one?")  # what is by goes along
    expect(told).to_be_hidden()
    check(page)
    expect(told).to_contain_text("Well done")


@pytest.mark.parametrize(
    ("placed", "told"),
    [
        (
            (("Sail", "What to do?"),),
            "“to” has no place yet. Choose “to”, then “Sail which way?”.",
        ),
        ((("Sail to", "What to do?"),), "“to” doesn't belong with “Sail”."),
        ((*PRACTICE[:2], ("the", "to what?")), "“the buoy” belong together."),
    ],
)
def test_practice_says_what_to_do_next(
    site: Site, context: BrowserContext, placed: tuple[tuple[str, str], ...], told: str
) -> None:
    reader = Reader(site.visit(context, PRACTISED))
    for said, question in placed:
        reader.give(said, question)
    check(reader.page)
    expect(reader.page.locator("#feedback")).to_contain_text(told)


def test_practice_shows_how_step_by_step(site: Site, context: BrowserContext) -> None:
    page = site.visit(context, PRACTISED)
    page.get_by_role("button", name="Show me how").click()
    for number, (said, question) in enumerate(PRACTICE, start=1):
        expect(page.locator(".lesson")).to_contain_text(f"Step {number} of 5.")
        expect(page.locator(".lesson")).to_contain_text(f"“{said}”")
        expect(page.locator(".place.pointed")).to_contain_text(question)
        page.keyboard.press("Enter")
        expect(page.locator(".places .part")).to_have_count(number)
    page.get_by_role("button", name="Now you").click()
    expect(page.locator(".places .part")).to_have_count(0)


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_words_and_places_are_in_sight(
    site: Site, context: BrowserContext, width: int, height: int
) -> None:
    reader = Reader(site.visit(context, PRACTISED))
    page = reader.page
    page.set_viewport_size({"width": width, "height": height})
    if width == 390:
        page.get_by_text("Instructions", exact=True).click()  # they have been read
    for said, question in PRACTICE:
        reader.choose(said)
        places = page.locator(".place").filter(has_text=question)
        for element in (page.locator(".words"), page.locator("#prompt"), places):
            box = element.bounding_box()
            assert box is not None
            assert box["y"] >= 0
            assert box["y"] + box["height"] <= height, question
        reader.answer(question)
    assert width_of(page) <= width
    if width == 1280:
        sending = page.get_by_role("button", name="Check my answer").bounding_box()
        last = page.locator(".places .part").last.bounding_box()
        assert sending is not None
        assert last is not None
        assert last["y"] + last["height"] <= sending["y"]
        assert sending["y"] + sending["height"] <= height
    else:
        assert page.evaluate("scrollY") == 0


def test_pages_in_use_have_no_violations(site: Site, context: BrowserContext) -> None:
    reader = Reader(site.visit(context, PRACTISED))
    page = reader.page
    found = []
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.reload()
        for said, question in PRACTICE[:3]:
            reader.give(said, question)
        found += violations(page)
        check(page)
        found += violations(page)
        page.locator(".places .part").first.click()
        expect(page.get_by_label("It says")).to_be_visible()
        found += violations(page)
        page.get_by_role("button", name="Show me how").click()
        found += violations(page)
        page.get_by_role("button", name="Stop").click()
    assert found == []


@pytest.mark.firefox
def test_segment(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "segment")
    start_from_nothing(page)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("begin with those that say what to do")
    place(page, (0,), "What to do?")
    place(page, (1,), "Go which way?")
    place(page, (2, 3, 4), "Go where?")
    undo, redo = (page.get_by_role("button", name=name, exact=True) for name in ("Undo", "Redo"))
    undo.click()
    expect(page.locator(".places .type-PLACE")).to_have_count(0)
    redo.click()
    expect(page.locator(".places .type-PLACE")).to_have_count(1)
    undo.click()
    place(page, (2, 3, 4), "to what?")
    expect(page.locator(".places .part")).to_have_count(3)
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == TREE


@pytest.mark.parametrize(
    ("text", "placed", "notation"),
    [
        (
            "Take the cup on the table",
            ("What to do?", "Take what?", "the cup: which one?", "on what?"),
            "EVENT(r = Take, l = OBJ(f = OBJ(f = the cup), r = on, l = OBJ(f = the table)))",
        ),
        (
            "Put the cup on the table",
            ("What to do?", "Put what?", "Put where?", "on what?"),
            "EVENT(r = Put, l = OBJ(f = the cup), l2 = PLACE(r = on, l = OBJ(f = the table)))",
        ),
        (
            "Drive the box to the truck",
            ("What to do?", "Drive what?", "Drive which way?", "to what?"),
            "EVENT(r = Drive, l = OBJ(f = the box), l2 = PATH(r = to, l = OBJ(f = the truck)))",
        ),
    ],
)
def test_places_make_the_trees_that_are_kept(
    site: Site,
    context: BrowserContext,
    text: str,
    placed: tuple[str, ...],
    notation: str,
) -> None:
    site.only("segment", text)
    page = site.open(context, "segment")
    start_from_nothing(page)
    for words, question in zip(((0,), (1, 2), (3,), (4, 5)), placed, strict=True):
        place(page, words, question)
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == to_json(parse_brackets(notation, command=text))


def test_words_need_not_stand_side_by_side_and_may_be_left_out(
    site: Site, context: BrowserContext
) -> None:
    text = "Robot put it down and then kindly stop"
    site.only("segment", text)
    page = site.open(context, "segment")
    start_from_nothing(page)
    place(page, (1, 3), "What to do?")
    place(page, (0,), "put down: who does it?")
    place(page, (2,), "put down what?")
    expect(page.locator("#prompt")).to_contain_text("kindly is chosen")
    page.get_by_role("button", name="Leave it out").click()
    place(page, (7,), "What to do next?")
    expect(page.locator("#prompt")).to_contain_text("Every word has its place.")
    send(page, "segment")
    (answer,) = site.answers("segment")
    notation = "EVENT(f = OBJ(f = Robot), r = put down, l = OBJ(f = it)); EVENT(r = stop)"
    assert answer.body["sdcs"] == to_json(parse_brackets(notation, command=text))


def test_parts_can_be_changed(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "segment")
    start_from_nothing(page)
    place(page, (0,), "What to do?")
    place(page, (1,), "Go where?")
    place(page, (2, 3), "Go what?")
    place(page, (4,), "More of “the red”")
    page.get_by_role("button", name="to where").click()
    page.get_by_label("It says").select_option("which way")
    page.get_by_label("There it comes").select_option("first")
    page.locator(".places .part", has_text="the red crate").click()
    page.get_by_label("It belongs to").select_option("to")
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == TREE


@pytest.mark.parametrize(
    ("text", "placed", "notation"),
    [
        (
            "The one with tires - take it over to the trailer",
            (
                ((5,), "What to do?"),
                ((0, 1), "take what?"),
                ((2,), "The one: which one?"),
                ((3,), "with what?"),
                ((7, 8), "take which way?"),
                ((9, 10), "over to what?"),
            ),
            "EVENT(r = take, l = OBJ(f = OBJ(f = The one), r = with, l = OBJ(f = tires)), "
            "l2 = PATH(r = over to, l = OBJ(f = the trailer)))",
        ),
        (
            "Tires to the truck",
            (((0,), "Do what?"), ((1,), "Do which way?"), ((2, 3), "to what?")),
            "EVENT(l = OBJ(f = Tires), l2 = PATH(r = to, l = OBJ(f = the truck)))",
        ),
    ],
)
def test_what_to_do_is_asked_first_wherever_it_stands(
    site: Site,
    context: BrowserContext,
    text: str,
    placed: tuple[tuple[tuple[int, ...], str], ...],
    notation: str,
) -> None:
    site.only("segment", text)
    page = site.open(context, "segment")
    start_from_nothing(page)
    expect(page.locator("#prompt")).to_contain_text("Which words say what to do?")
    expect(page.locator(".word[aria-pressed=true]")).to_have_count(0)
    if not placed[0][1].startswith("What to do"):
        page.get_by_role("button", name="No word says it").click()
    for words, question in placed:
        place(page, words, question)
    for label in page.locator(".place bdi, .part bdi").all_inner_texts():
        assert re.search(r"\w", label.removesuffix("what?").removesuffix("where?")), label
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == to_json(parse_brackets(notation, command=text))


def test_a_tree_without_an_action_is_asked_about(site: Site, context: BrowserContext) -> None:
    text = "Land on the white van"
    thing = "OBJ(f = OBJ(f = Land), r = on, l = OBJ(f = the white van))"
    site.only("segment", text, suggestion=to_json(parse_brackets(thing, command=text)))
    page = site.open(context, "segment")
    expect(page.locator("#prompt")).to_contain_text("Which words say what to do?")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("Nothing says what to do.")
    assert violations(page) == []
    place(page, (0,), "What to do next?")
    send(page, "segment")
    (answer,) = site.answers("segment")
    right = "EVENT(r = Land, l = PLACE(r = on, l = OBJ(f = the white van)))"
    assert answer.body["sdcs"] == to_json(parse_brackets(right, command=text))


def test_a_verb_as_a_thing_is_asked_about_and_may_be_sent(
    site: Site, context: BrowserContext
) -> None:
    text = "Take the box and lift it"
    wrong = "EVENT(r = Take, l = OBJ(f = the box lift it))"
    site.only("segment", text, suggestion=to_json(parse_brackets(wrong, command=text)))
    page = site.open(context, "segment")
    page.get_by_role("button", name="Send", exact=True).click()
    asked = page.get_by_role("alert")
    expect(asked).to_contain_text("“lift” is a thing here. Does it say what to do?")
    assert site.answers("segment") == []
    with page.expect_navigation():
        asked.get_by_role("button", name="Send it all the same").click()
    assert len(site.answers("segment")) == 1


def test_instructions_are_open_until_one_was_sent(site: Site, context: BrowserContext) -> None:
    site.add("segment", STEPS)
    page = site.open(context, "segment")
    expect(page.locator("#instructions")).to_have_attribute("open", "")
    start_from_nothing(page)
    place(page, (0,), "What to do?")
    send(page, "segment")
    expect(page.locator("#instructions")).not_to_have_attribute("open", "")


def test_a_draft_of_an_earlier_version_can_be_finished(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "segment")
    clause = {"id": 1, "type": "EVENT", "parent": None, "field": None, "f": [], "r": [0]}
    body = {"clauses": [clause], "next": 2, "current": 1, "field": "l"}
    page.evaluate(
        """draft => {
          const {who, item} = JSON.parse(document.getElementById("item").textContent);
          localStorage.setItem(`g3:${who}:draft:${item}`, JSON.stringify(draft));
        }""",
        {"revision": 99, "body": body},
    )
    page.reload()
    expect(page.locator(".places .part")).to_have_count(1)
    place(page, (1,), "Go which way?")
    place(page, (2, 3, 4), "to what?")
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == TREE


def test_a_suggestion_that_is_just_sent_is_unchanged(site: Site, context: BrowserContext) -> None:
    """The editor's form of a tree and the suggestion's are the same."""
    site.only("segment", STEPS, suggestion=to_json(parse_brackets(TWO_STEPS, command=STEPS)))
    page = site.open(context, "segment")
    expect(page.get_by_text("A program has placed the words")).to_be_visible()
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.provenance == {"suggestion": "shown", "unchanged": True, "likeness": 1.0}


def test_the_words_of_a_suggestion_can_be_moved(site: Site, context: BrowserContext) -> None:
    text = "Take the cup on the table"
    wrong = "EVENT(r = Take, l = OBJ(f = the cup), l2 = PLACE(r = on, l = OBJ(f = the table)))"
    right = "EVENT(r = Take, l = OBJ(f = OBJ(f = the cup), r = on, l = OBJ(f = the table)))"
    site.only("segment", text, suggestion=to_json(parse_brackets(wrong, command=text)))
    page = site.open(context, "segment")
    words_of(page).nth(3).click()
    page.locator(".place", has_text="the cup: which one?").click()
    send(page, "segment")
    (answer,) = site.answers("segment")
    assert answer.body["sdcs"] == to_json(parse_brackets(right, command=text))
    assert answer.provenance["unchanged"] is False


def test_a_word_of_a_corpus_may_be_several_of_the_page(site: Site, context: BrowserContext) -> None:
    """A corpus has "1.5", where the page has "1", "." and "5"; marks after a word are left out."""
    page = site.open(context, "segment")
    words = [("1", 0), (".", 1), ("5", 2), ("m", 4), (".", 5)]
    given = [{"type": "OBJECT", "f": [["1.5", 0], ["m.", 4]]}]
    found = page.evaluate(
        """async ({words, given}) => {
          const sdc = await import("/static/js/sdc.js");
          return sdc.toJson(sdc.fromJson(given, words), words);
        }""",
        {"words": [{"text": text, "start": start} for text, start in words], "given": given},
    )
    assert found == [{"type": "OBJECT", "f": [["1", 0], ["5", 2], ["m", 4]]}]
