"""Which language a page speaks, and that it speaks no other."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core import languages
from annotation_app.core.languages import gettext
from annotation_app.crowds.mturk import SITES
from annotation_app.crowds.participation import Offer, sign_offer
from annotation_app.people.account_links import first_admin_link
from annotation_app.store.database import transaction
from annotation_app.store.models import Item
from annotation_app.studies.study_file import restored
from annotation_app.study_setup.study_reading import study_problems
from annotation_app.work.handing_out import find_study
from annotation_app.work.page_data import new_offer
from tests.annotation_app.browser import Browser, engine_of, installation_of
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.pseudo import write_pseudo

GERMAN = {"Accept-Language": "de-AT,de;q=0.9,en;q=0.5"}
TASKS = tuple(STUDY.tasks)


@pytest.fixture
def arabic(app: Flask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Flask:
    """The app with a study in the pseudo-language."""
    write_pseudo(tmp_path / "translations")
    monkeypatch.setattr(languages, "FOLDER", tmp_path / "translations")
    set_language(app, "ar")
    return app


def set_language(app: Flask, language: str) -> None:
    with transaction(engine_of(app)) as session:
        study = find_study(session, "tests")
        payment = {"amount": 0.5, "currency": "EUR", "bonus": 0.0}
        study.config = {**study.config, "locale": language, "payment": payment}


def test_a_study_speaks_its_language_whatever_the_browser_asks_for(app: Flask) -> None:
    set_language(app, "de")
    person = Browser(app)
    for path in ("/s/tests", "/s/tests/describe", "/practice/rate?study=tests"):
        page = person.client.get(path, headers={"Accept-Language": "en"}).text
        assert '<html lang="de" dir="ltr">' in page
        assert "Aufgaben" in page
    welcome = app.test_client().get("/s/tests/welcome").text
    assert "Sie bekommen 0,50 EUR für jede Aufgabe." in welcome
    assert "Sie sehen kurze Videos eines Roboters oder" in welcome
    assert "Stimme voll zu" in person.client.get("/practice/rate?study=tests").text


def test_other_pages_speak_what_the_browser_asks_for(app: Flask) -> None:
    client = app.test_client()
    for path in ("/", "/login", "/nowhere", "/s/nowhere"):
        assert '<html lang="de" dir="ltr">' in client.get(path, headers=GERMAN).text
        assert '<html lang="en" dir="ltr">' in client.get(path).text
        assert '<html lang="en"' in client.get(path, headers={"Accept-Language": "tlh"}).text
    # A request leaves nothing behind for the next one.
    set_language(app, "de")
    Browser(app).client.get("/s/tests")
    assert gettext("Send") == "Send"
    assert '<html lang="en"' in client.get("/login").text


def test_researchers_pages_are_english(app: Flask) -> None:
    set_language(app, "de")
    admin = Browser(app, role="admin")
    for path in ("/dashboard/", "/dashboard/tests", "/try", "/admin/logins"):
        page = admin.client.get(path, headers=GERMAN).text
        assert '<html lang="en"' in page
        assert re.search("Dashboard|Try a command|Logins", page)


def test_what_is_wrong_with_an_answer_is_told_in_the_studys_language(app: Flask) -> None:
    set_language(app, "de")
    person = Browser(app)
    item = person.take("describe")["item"]
    refused = person.answer(item, {"text": " ", "played_to_end": True, "watched_s": 1.0})
    assert refused.status_code == 422
    assert refused.json["error"] == "Etwas in der Antwort muss geändert werden."
    assert refused.json["problems"][0]["message"] == "Geben Sie einen Befehl ein."


class _Said(HTMLParser):
    """What a page says: its text, and the names that its parts have."""

    NAMED = ("aria-label", "title", "placeholder", "alt")
    SILENT = ("script", "style", "bdi", "code", "kbd")

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.within: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.within.append(tag)
        self.found += [value or "" for name, value in attributes if name in self.NAMED]

    def handle_endtag(self, tag: str) -> None:
        while self.within and self.within.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if not set(self.SILENT) & set(self.within):
            self.found.append(data)


def said(page: str) -> str:
    parser = _Said()
    parser.feed(page)
    return " ".join(parser.found)


def english(page: str) -> list[str]:
    """Words with Latin letters, without the study's title and currency."""
    return re.findall(r"[A-Za-z]{2,}", said(page).replace("A study", "").replace("EUR", ""))


def test_no_page_of_workers_says_a_word_of_english(arabic: Flask) -> None:
    asked = {"Accept-Language": "ar"}
    stranger = arabic.test_client()
    with transaction(engine_of(arabic)) as session:
        setup = f"/setup/{first_admin_link(session)}"
    for path in ("/", "/login", "/login?signed_out=yes", "/nowhere", "/s/tests/welcome", setup):
        page = stranger.get(path, headers=asked).text
        assert '<html lang="ar" dir="rtl">' in page, path
        assert english(page) == [], path
    person = Browser(arabic)
    paths = ["/s/tests", *(f"/s/tests/{task}" for task in TASKS)]
    for path in (*paths, *(f"/practice/{task}?study=tests" for task in TASKS)):
        page = person.client.get(path, headers=asked).text
        assert 'dir="rtl"' in page, path
        assert english(page) == [], path
    form = {"csrf_token": person.csrf}
    wrong = person.client.post("/s/tests/welcome", data=form, headers=asked)
    assert wrong.status_code == 422
    assert english(wrong.text) == []


def test_nor_do_those_of_crowd_platforms(arabic: Flask) -> None:
    with transaction(engine_of(arabic)) as session:
        offer = Offer(find_study(session, "tests").id, "describe", 2)
    address = f"/crowd/mturk/{sign_offer(installation_of(arabic).config.secret_key, offer)}"
    client = arabic.test_client()
    preview = client.get(f"{address}?assignmentId=ASSIGNMENT_ID_NOT_AVAILABLE").text
    arrived = f"{address}?assignmentId=A1&workerId=W1&turkSubmitTo={min(SITES)}"
    assert client.get(arrived).status_code == 302
    for page in (preview, client.get("/crowd/finish").text):
        assert '<html lang="ar" dir="rtl">' in page
        assert english(page.replace("Amazon Mechanical Turk", "")) == []


def test_suggestions_are_for_english_commands(app: Flask) -> None:
    person = Browser(app)
    person.do("describe", {"text": "Pick up the tires.", "played_to_end": True, "watched_s": 2.0})
    item = person.take("segment")
    assert item["payload"]["suggestion"] is not None
    set_language(app, "de")
    with transaction(engine_of(app)) as session:
        kept = session.get_one(Item, item["item"])
        offer = new_offer(session, restored(find_study(session, "tests").config), kept)
    assert offer == {"state": "none", "suggestion": None}


def test_a_study_cant_have_a_language_that_nobody_has_translated() -> None:
    study = {"name": "a", "title": "A", "tasks": {"describe": {}}}
    assert study_problems({**study, "locale": "de"}) == []
    (problem,) = study_problems({**study, "locale": "fr"})
    assert problem.field == ("locale",)
    assert problem.what == "the pages don't speak fr"
    assert "en, de" in problem.fix
    assert study_problems({**study, "locale": "German, please"})


def test_a_studys_own_texts_stay_as_they_are(app: Flask) -> None:
    set_language(app, "de")
    with transaction(engine_of(app)) as session:
        study = find_study(session, "tests")
        labels = {"thing": "Objekt", "place": "Place", "robot": "the robot"}
        study.config = {**study.config, "labels": labels, "statement": "It does so."}
    page = Browser(app).client.get("/practice/ground?study=tests").text
    assert '"labels": {"place": "Ort", "robot": "das Boot", "thing": "Objekt"}' in page
    assert "It does so." in Browser(app).client.get("/practice/rate?study=tests").text
