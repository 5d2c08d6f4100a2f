"""What people see while the study's database is gone, and what becomes of their answers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, Route, expect
from sqlalchemy import select

from annotation_app.store.models import Draft, Event
from tests.annotation_app.browser import rows_in
from tests.annotation_app.in_browser import violations, width_of
from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.test_network import judge, saved
from tests.annotation_app.pages.test_tasks import watch

pytestmark = pytest.mark.slow


@contextmanager
def database_gone(site: Site) -> Iterator[None]:
    file = Path(str(site.engine.url.database))
    moved = file.rename(file.with_name("moved"))
    yield
    moved.rename(file)


def send(page: Page) -> None:
    page.get_by_role("button", name="Send", exact=True).click()


def test_an_answer_waits_until_the_database_is_back(site: Site, context: BrowserContext) -> None:
    context.clock.install()
    page = site.open(context, "check")
    judge(page)
    saved(page)
    tries: list[int] = []
    page.on("response", lambda r: tries.append(r.status) if r.url.endswith("/answer") else None)
    status = page.locator("#saving")
    with database_gone(site):
        send(page)
        expect(status).to_contain_text("the study can't be reached")
        expect(status).to_contain_text("waits in this browser and is sent by itself")
        assert violations(page) == []
        # The server asked for ten seconds. The clock also goes on by itself.
        context.clock.fast_forward("00:05")
        page.wait_for_timeout(300)
        assert tries == [503]
        with page.expect_response("**/answer"):
            context.clock.fast_forward("00:08")
    context.clock.fast_forward("00:41")
    expect(page.get_by_role("heading", level=1)).to_contain_text("Thank you")
    (answer,) = site.answers("check")
    assert answer.body["verdicts"] == {"2": True, "3": False}
    assert len(rows_in(site.engine, select(Event))) == 1
    assert tries[-1] == 200
    assert set(tries[:-1]) == {503}


def test_an_answer_outlives_its_tab_while_the_database_is_gone(
    site: Site, context: BrowserContext
) -> None:
    page = site.open(context, "check")
    judge(page)
    with database_gone(site):
        send(page)
        expect(page.locator("#saving")).to_contain_text("Not sent yet")
        page.close()
        again = context.new_page()
        again.goto(f"{site.url}/s/sea")
        expect(again.get_by_role("heading", level=1)).to_contain_text("can't be reached")
        expect(again.get_by_text("wait in your browser")).to_be_visible()
        assert violations(again) == []
        for width in (390, 1280):
            again.set_viewport_size({"width": width, "height": 844})
            assert width_of(again) == width
    again.get_by_role("link", name="Try again").click()
    expect(again.get_by_text("has now been sent")).to_be_visible()
    assert len(site.answers("check")) == 1
    assert len(rows_in(site.engine, select(Event))) == 1


def test_a_draft_is_saved_when_the_database_is_back(site: Site, context: BrowserContext) -> None:
    context.clock.install()
    page = site.open(context, "describe")
    with database_gone(site):
        page.get_by_label("Type the command").fill("Go on")
        context.clock.fast_forward("00:02")
        expect(page.locator("#saving")).to_contain_text("Kept in this browser")
    context.clock.fast_forward("00:11")
    saved(page)
    assert [draft.body["text"] for draft in rows_in(site.engine, select(Draft))] == ["Go on"]


@pytest.mark.parametrize(
    ("status", "headers", "told"),
    [
        (429, {"Retry-After": "20"}, "a bit fast"),
        (500, {}, "the server has a problem"),
        (502, {}, "can't be reached"),
        (504, {}, "can't be reached"),
    ],
)
def test_what_proxies_and_limits_say_is_not_final(
    site: Site, context: BrowserContext, status: int, headers: dict[str, str], told: str
) -> None:
    context.clock.install()
    page = site.open(context, "describe")
    page.get_by_label("Type the command").fill("Go to the crate")
    watch(page)

    def refuse(route: Route) -> None:
        route.fulfill(status=status, headers=headers, body="<html>Bad Gateway</html>")

    page.route("**/answer", refuse)
    send(page)
    expect(page.locator("#saving")).to_contain_text(told)
    with page.expect_navigation():
        page.unroute("**/answer", refuse)
        context.clock.fast_forward("00:40")
    assert [answer.body["text"] for answer in site.answers("describe")] == ["Go to the crate"]


def test_a_cookie_that_is_not_taken_is_no_answer_that_is_wrong(
    site: Site, context: BrowserContext
) -> None:
    """As where the server's clock was set back: 400 is said of the token that comes with it."""
    context.clock.install()
    page = site.open(context, "check")
    judge(page)
    saved(page)
    cookies = context.cookies()
    answers: list[str] = []

    def refuse(route: Route) -> None:
        answers.append(route.request.url)
        route.fulfill(status=400, json={"error": "The CSRF session token is missing."})

    def nobody(route: Route) -> None:
        route.fulfill(json={"signed_in": False, "role": None, "csrf": "other"})

    page.route("**/answer", refuse)
    page.route("**/api/session", nobody)
    send(page)
    expect(page.locator("#saving")).to_contain_text("Not sent yet")
    assert len(answers) == 2
    page.unroute_all()
    context.add_cookies(cookies)
    with page.expect_navigation():
        context.clock.fast_forward("00:40")
    assert len(site.answers("check")) == 1


def test_without_a_connection_there_is_a_page_of_ours(site: Site, chromium: Browser) -> None:
    context = chromium.new_context()
    page = context.new_page()
    page.goto(f"{site.url}/login")
    page.wait_for_function("navigator.serviceWorker.ready.then(it => Boolean(it.active))")
    page.reload()  # the worker has the page from now on
    context.set_offline(True)
    page.goto(f"{site.url}/s/sea")
    expect(page.get_by_role("heading", level=1)).to_have_text("You are offline")
    assert page.url == f"{site.url}/s/sea"
    expect(page.locator(".card")).to_have_css("border-radius", "14px")
    assert violations(page) == []
    context.set_offline(False)
    page.get_by_role("link", name="Try again").click()
    expect(page.get_by_role("heading", level=1)).not_to_have_text("You are offline")
    context.close()


@pytest.mark.parametrize(
    ("path", "status"), [("/nothing", 404), ("/dashboard/sea", 403), ("/s/sea", 500)]
)
def test_errors_are_pages_with_a_next_step(
    site: Site, context: BrowserContext, path: str, status: int
) -> None:
    page = site.open(context, "describe")
    if status == 500:
        with site.engine.begin() as connection:
            connection.exec_driver_sql("DROP TABLE slot")
    reply = page.goto(site.url + path)
    assert reply is not None
    assert reply.status == status
    assert page.get_by_role("link", name="Start page").is_visible()
    assert (page.get_by_role("link", name="Sign in").count() == 1) == (status == 403)
    assert violations(page) == []
