"""Pages in other languages: work done in German, and pages that are read from right to left."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from annotation_app.core import languages
from annotation_app.store.database import transaction
from annotation_app.work.handing_out import find_study
from tests.annotation_app.in_browser import errors_of, violations, width_of
from tests.annotation_app.pages.conftest import TASKS, Site
from tests.annotation_app.pseudo import write_pseudo

pytestmark = pytest.mark.slow

ENGLISH = """() => {
  const own = "script, style, noscript, bdi, code, kbd, svg, #command, .brand";
  const names = ["aria-label", "aria-valuetext", "title", "placeholder"];
  const texts = (element) => [...element.childNodes].filter((n) => n.nodeType === 3);
  const said = [...document.querySelectorAll("body, body *")].flatMap((element) => [
    ...(element.closest(own) ? [] : texts(element).map((n) => n.data)),
    ...names.map((name) => element.getAttribute(name) ?? ""),
  ]);
  return said.filter((text) => /[A-Za-z]{2,}/.test(text.replace(/Go|to|the|red|crate/g, "")));
}"""
"""What a page says in Latin letters, without commands and titles."""


def speak(site: Site, language: str) -> None:
    with transaction(site.engine) as session:
        study = find_study(session, site.study.name)
        study.config = {**study.config, "locale": language}


def test_somebody_works_in_german(site: Site, context: BrowserContext) -> None:
    speak(site, "de")
    page = site.open(context, "ground")
    errors = errors_of(page)
    expect(page.locator("html")).to_have_attribute("lang", "de")
    expect(page.locator(".clock").first).to_have_text("0,0 / 1,0 s")
    page.get_by_role("button", name="Senden").click()
    expect(page.get_by_role("alert")).to_contain_text(
        "Zeigen Sie, was mit „the red crate“ gemeint ist, oder wählen Sie „Weiß nicht“."
    )
    found = violations(page)
    page.get_by_role("button", name="Video abspielen").click()
    expect(page.get_by_role("heading", name="Was ist")).to_be_visible()
    page.keyboard.press("2")
    expect(page.locator(".asked")).to_contain_text("Das folgt aus Ihren Antworten")
    with page.expect_navigation():
        page.get_by_role("button", name="Ja: Senden").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Vielen Dank!")
    (answer,) = site.answers("ground")
    (grounding,) = answer.body["groundings"].values()
    assert len(grounding["objects"]) == 1
    page.goto(f"{site.url}/s/sea/describe")
    found += violations(page)
    page.get_by_label("Schreiben Sie den Befehl").fill("Fahr zu der Kiste.")
    expect(page.locator("#counter")).to_have_text("4 von höchstens 200 Wörtern")
    expect(page.locator("#saving")).to_have_text("Gespeichert")
    assert found == []
    assert errors == []


def test_pages_from_right_to_left_say_no_english(
    site: Site, context: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_pseudo(tmp_path / "translations")
    monkeypatch.setattr(languages, "FOLDER", tmp_path / "translations")
    speak(site, "ar")
    site.sign_in(context)
    page = context.new_page()
    errors = errors_of(page)
    practised = (*TASKS, "subtasks", "moments", "mark", "correct")
    for address in (
        *(f"/s/sea/{task}" for task in TASKS),
        *(f"/practice/{task}?study=sea" for task in practised),
    ):
        page.set_viewport_size({"width": 1280, "height": 800})
        page.goto(site.url + address)
        page.locator("#submit").click()
        expect(page.locator("#problems, #feedback").filter(has_text="ا").first).to_be_visible()
        assert page.evaluate(ENGLISH) == [], address
        if page.locator("#skip").count():
            page.locator("#skip").click()
            assert page.evaluate(ENGLISH) == [], address
            page.keyboard.press("Escape")
        page.set_viewport_size({"width": 360, "height": 740})
        assert width_of(page) <= 360, address
    assert_mirrored(page, site)
    assert violations(page) == []
    assert errors == []


def assert_mirrored(page: Page, site: Site) -> None:
    """The picture is at the right of the map, and time still goes to the right."""
    page.set_viewport_size({"width": 1280, "height": 800})
    page.goto(f"{site.url}/practice/ground?study=sea")
    picture, map_ = (page.locator(name).bounding_box() for name in (".picture", ".map-box"))
    assert picture is not None
    assert map_ is not None
    assert picture["x"] > map_["x"]
    handles = [page.locator(f".handle-{end}") for end in ("start", "end")]
    page.locator(".clause.type-EVENT").click()
    start, end = (handle.bounding_box() for handle in handles)
    assert start is not None
    assert end is not None
    assert start["x"] < end["x"]
