"""Nothing is lost: no network, closed tabs, two tabs, a session that has run out."""

from __future__ import annotations

import contextlib

import pytest
from playwright.sync_api import BrowserContext, Page, expect
from playwright.sync_api import Error as PlaywrightError
from sqlalchemy import select

from annotation_app.store.models import Draft, Event
from tests.annotation_app.browser import rows_in
from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.segmenting import place, start_from_nothing
from tests.annotation_app.pages.test_tasks import watch

pytestmark = pytest.mark.slow


def saved(page: Page) -> None:
    expect(page.locator("#saving")).to_have_text("Saved")


def judge(page: Page) -> None:
    watch(page)
    for key in ("y", "]", "n"):
        page.keyboard.press(key)


def test_answer_is_kept_for_minutes_without_network(site: Site, context: BrowserContext) -> None:
    context.clock.install()
    page = site.open(context, "check")
    judge(page)
    context.set_offline(True)
    page.get_by_role("button", name="Send", exact=True).click()
    status = page.locator("#saving")
    expect(status).to_contain_text("Not sent yet")
    for _ in range(5):
        context.clock.fast_forward("00:30")
        expect(status).to_contain_text("Not sent yet")
    assert site.answers("check") == []
    context.set_offline(False)
    expect(page.get_by_role("heading", level=1)).to_contain_text("Thank you")
    (answer,) = site.answers("check")
    assert answer.body["verdicts"] == {"2": True, "3": False}


def test_text_typed_during_minutes_without_network_is_saved(
    site: Site, context: BrowserContext
) -> None:
    context.clock.install()
    page = site.open(context, "describe")
    context.set_offline(True)
    page.get_by_label("Type the command").fill("Go")
    expect(page.locator("#saving")).to_contain_text("not on the server yet")
    context.clock.fast_forward("02:30")
    page.get_by_label("Type the command").press_sequentially(" on")
    context.set_offline(False)
    saved(page)
    assert [d.body["text"] for d in rows_in(site.engine, select(Draft))] == ["Go on"]


def test_answer_survives_that_the_tab_is_closed_without_network(
    site: Site, context: BrowserContext
) -> None:
    page = site.open(context, "check")
    judge(page)
    context.set_offline(True)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#saving")).to_contain_text("Not sent yet")
    page.close()
    context.set_offline(False)
    again = context.new_page()
    again.goto(f"{site.url}/s/sea")
    expect(again.get_by_text("has now been sent")).to_be_visible()
    assert len(site.answers("check")) == 1
    assert len(rows_in(site.engine, select(Event))) == 1


@pytest.mark.parametrize("end", ["closed", "crashed"])
def test_draft_comes_back_in_another_tab(site: Site, context: BrowserContext, end: str) -> None:
    page = site.open(context, "describe")
    watch(page)
    page.get_by_label("Type the command").fill("Go to the")
    if end == "closed":
        page.close()
    else:
        saved(page)
        with contextlib.suppress(PlaywrightError), page.expect_event("crash"):
            page.goto("chrome://crash")
    again = context.new_page()
    again.goto(f"{site.url}/s/sea/describe")
    expect(again.get_by_label("Type the command")).to_have_value("Go to the")
    expect(again.get_by_text("You have watched it to the end")).to_be_visible()


def test_draft_comes_back_from_the_server(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "segment")
    start_from_nothing(page)
    place(page, (0,), "What to do?")
    saved(page)
    before = page.locator(".places").inner_text()
    page.evaluate("localStorage.clear()")
    page.reload()
    expect(page.locator(".places")).to_have_text(before, use_inner_text=True)


def test_who_types_and_loads_the_page_again_is_alone(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "describe")
    seen: list[str] = []
    for text in ("Go", "Go on", "Go on there"):
        page.get_by_label("Type the command").fill(text)
        page.reload()
        page.wait_for_timeout(300)
        seen.append(page.locator("#saving").inner_text())
        expect(page.get_by_label("Type the command")).to_have_value(text)
    saved(page)
    assert not [told for told in seen if "another tab" in told]


def test_work_goes_on_where_the_browser_keeps_nothing(site: Site, context: BrowserContext) -> None:
    context.add_init_script(
        "Object.defineProperty(window, 'localStorage', { get() { throw new Error('off'); } })"
    )
    page = site.open(context, "check")
    judge(page)
    saved(page)
    page.reload()
    expect(page.locator(".tick-mark")).to_have_count(2)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Thank you")
    assert len(site.answers("check")) == 1


def test_an_answer_in_one_tab_wins_over_a_draft_in_another(
    site: Site, context: BrowserContext
) -> None:
    first = site.open(context, "check")
    second = context.new_page()
    second.goto(first.url)
    judge(first)
    with first.expect_navigation():
        first.get_by_role("button", name="Send", exact=True).click()
    watch(second)
    second.keyboard.press("x")
    expect(second.locator("#saving")).to_contain_text("another tab")
    with second.expect_navigation():
        second.keyboard.press("]")
        second.keyboard.press("x")
        second.keyboard.press("Control+Enter")
    (answer,) = site.answers("check")
    assert answer.body["verdicts"] == {"2": True, "3": False}


def test_answer_waits_for_who_was_signed_out(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    judge(page)
    saved(page)
    cookies = context.cookies()
    context.clear_cookies()
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#saving")).to_contain_text("Open the study's address again")
    context.add_cookies(cookies)
    expect(page.get_by_role("heading", level=1)).to_contain_text("Thank you")
    assert len(site.answers("check")) == 1


def test_leaving_with_something_unsent_warns(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "check")
    judge(page)
    context.set_offline(True)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#saving")).to_contain_text("Not sent yet")
    with page.expect_event("dialog") as asked:
        page.close(run_before_unload=True)
    assert asked.value.type == "beforeunload"
    asked.value.accept()


def test_refused_answers_say_why_and_keep_the_draft(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "describe")
    watch(page)
    page.locator("#text").evaluate(
        "box => box.removeAttribute('maxlength')"
    )  # only the server knows
    page.get_by_label("Type the command").fill("go" * 1001)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#problems")).to_contain_text("2002 characters long")
    page.get_by_label("Type the command").fill("go")
    with page.expect_navigation():
        page.get_by_role("button", name="Send", exact=True).click()
    assert [answer.body["text"] for answer in site.answers("describe")] == ["go"]
