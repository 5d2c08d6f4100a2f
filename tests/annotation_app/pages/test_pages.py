"""Pages in use: accessible, safe, and leading on. `test_every_page` looks at each as it comes."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, BrowserContext, Response, expect

from annotation_app.people.account_links import first_admin_link
from annotation_app.store.database import transaction
from corpus_tools.world.state.thing_kinds import KINDS
from tests.annotation_app.in_browser import violations
from tests.annotation_app.pages.conftest import TASKS, Site
from tests.annotation_app.rendered import WORDS

pytestmark = pytest.mark.slow

NASTY = (
    "<script>document.title='hit'</script> \"a' & 😀 \u200fשלום\u200e <img src=x onerror=alert(1)>"
)
THINGS = {word for kind in KINDS.values() for word in (*kind.name.split("-"), *kind.labels)}
"""What the things of scenarios are called."""
CODE = {"box", "container", "fetch", "load", "other"}
"""Words of CSS and JavaScript."""
EVERYWHERE = {"post", "sign"}
"""Words of forms and of signing in, on all pages."""


def test_pages_in_use_have_no_serious_violations(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "ground")
    for key in ("]", "s", "1", "m", "Enter"):
        page.keyboard.press(key)
    found = violations(page)
    page.locator(".clause-bar .type-EVENT").click()
    page.get_by_role("button", name="It starts here").click()
    found += violations(page)
    page.locator("#flag").click()
    found += violations(page)
    page.goto(f"{site.url}/practice/describe")
    page.get_by_label("Type the command").fill("The boat is moving")
    page.get_by_role("button", name="Check my answer").click()
    found += violations(page)
    assert found == []


def test_text_of_people_is_shown_as_text(site: Site, context: BrowserContext) -> None:
    sdcs = [{"type": "OBJECT", "f": [["<script>document.title='hit'</script>", 0]]}]
    shown = {"0": {"video": "hall_fetch_tires", "objects": ["truck"], "places": []}}
    site.only("segment", NASTY)
    site.only("ground", NASTY, sdcs=sdcs)
    site.only("check", NASTY, sdcs=sdcs, shown=shown)
    site.only("rate", NASTY, own_video="hall_fetch_tires", right=None)
    page = site.open(context, "describe")
    page.on("dialog", lambda dialog: pytest.fail("a script of a text has run"))
    for task in TASKS[1:]:
        page.goto(f"{site.url}/s/sea/{task}")
        if task == "segment":
            expect(page.locator(".word")).not_to_have_count(0)
            words = page.locator(".word").all_inner_texts()
            assert "script" in words
            assert "😀" in words
            assert "שלום" in words
        else:
            expect(page.locator("#command")).to_have_text(NASTY)
        assert page.title() != "hit"
        assert page.locator("#work img, #work script").count() == 0
    page.goto(f"{site.url}/s/sea/describe")
    page.get_by_label("Type the command").fill(NASTY)
    expect(page.locator("#saving")).to_have_text("Saved")
    page.reload()
    expect(page.get_by_label("Type the command")).to_have_value(NASTY)


@pytest.mark.parametrize("address", ["/s/sea/describe", "/practice/describe?study=sea"])
def test_describe_tells_nothing_of_the_video(
    site: Site, context: BrowserContext, address: str
) -> None:
    seen: list[str] = []

    def keep(response: Response) -> None:
        is_text = response.headers.get("content-type", "").startswith("text/")
        body = response.text() if is_text else ""
        seen.append(f"{response.url} {response.all_headers()} {body}")

    site.sign_in(context)
    page = context.new_page()
    page.on("requestfinished", lambda request: keep(request.response()))
    page.goto(site.url + address)
    page.wait_for_load_state("networkidle")
    assert any("/work.js" in one for one in seen)
    for one in seen:
        names = (
            {*WORDS, *THINGS} - EVERYWHERE - (CODE if "/static/" in one.split(" ")[0] else set())
        )
        assert names.isdisjoint(re.findall("[a-z]+", one.lower())), one[:100]


def test_the_first_admin_signs_in_and_out(site: Site, context: BrowserContext) -> None:
    with transaction(site.engine) as session:
        token = first_admin_link(session)
    page = context.new_page()
    page.goto(f"{site.url}/setup/{token}")
    page.get_by_label("Login").fill("ada")
    page.get_by_label("Password, of").fill("long enough 1")
    page.get_by_label("The password again").fill("other words 2")
    page.get_by_role("button", name="Make the admin").click()
    expect(page.get_by_role("alert")).to_contain_text("differ")
    page.get_by_label("Password, of").fill("long enough 1")
    page.get_by_label("The password again").fill("long enough 1")
    page.get_by_role("button", name="Make the admin").click()
    page.get_by_role("button", name="Sign out").click()
    page.goto(f"{site.url}/login?next=//elsewhere.example")
    page.get_by_label("Login").fill("ada")
    page.get_by_label("Password").fill("wrong")
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("alert")).to_contain_text("no such login")
    page.get_by_label("Password").fill("long enough 1")
    page.get_by_role("button", name="Sign in").click()
    page.wait_for_url(f"{site.url}/")


def test_why_there_is_no_item(site: Site, chromium: Browser) -> None:
    contexts = [chromium.new_context() for _ in range(3)]
    *_, third = [site.open(context, "rate") for context in contexts]
    expect(third.get_by_role("heading", level=1)).to_contain_text("Others are at work")
    expect(third.get_by_role("link", name="Describe")).to_be_visible()
    for context in contexts:
        context.close()


def test_welcome_says_what_is_missing_and_leads_to_the_task(
    site: Site, context: BrowserContext
) -> None:
    page = context.new_page()
    page.goto(f"{site.url}/s/sea/describe")
    page.get_by_role("button", name="Begin").click()
    expect(page.get_by_role("alert")).to_contain_text("Something is missing")
    assert violations(page) == []
    page.get_by_label("I am at least 18").check()
    page.get_by_label("I have read this").check()
    page.get_by_role("button", name="Begin").click()
    page.wait_for_url("**/s/sea/describe")
    expect(page.get_by_label("Type the command")).to_be_visible()
