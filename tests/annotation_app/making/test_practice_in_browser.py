"""Practice made in the set-up: an admin answers it, and keeps the answer as right or as wrong."""

from __future__ import annotations

from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import Browser, Locator, Page, expect

from annotation_app.study_setup.study_drafts import find_draft
from tests.annotation_app.in_browser import serving, sign_in, violations
from tests.annotation_app.making.test_making import TEXTS, begun, send
from tests.annotation_app.pages.segmenting import place
from tests.annotation_app.signing_in import Member

pytestmark = pytest.mark.slow

ITEM = {
    "item-segment-0-video": "push",
    "item-segment-0-command": "Push the cup",
    "item-segment-0-good": "It is.",
}


@pytest.mark.firefox
def test_an_answer_is_kept_as_right_and_another_as_wrong(
    app: Flask, admin: Member, root: Path, chromium: Browser
) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    send(admin, "tasks", **{"do-segment": "on", "answers-segment": "1", "practice-segment": "on"})
    texts = {**TEXTS, **ITEM}
    send(admin, "texts", then="stay", **texts)
    with serving(app) as url:

        def opened(path: str) -> Page:
            """A page in a browser that has no draft of an answer."""
            context = chromium.new_context()
            sign_in(context, admin, url)
            page = context.new_page()
            page.goto(f"{url}/admin/studies/arm/{path}")
            return page

        def answered(question: str) -> Locator:
            page = opened("preview/segment?item=0")
            place(page, (0,), "What to do?")
            place(page, (1, 2), question)
            page.get_by_role("button", name="Check my answer").click()
            return page.locator("#feedback")

        link = opened("texts").get_by_role("link", name="Answer it as people will")
        assert link.get_attribute("href") == "/admin/studies/arm/preview/segment?item=0"
        told = answered("Push what?")
        expect(told).to_contain_text("Compare yours: It is.")
        assert violations(told.page) == []
        told.get_by_role("button", name="Keep it as the right answer").click()
        expect(told).to_contain_text("Kept.")
        told = answered("Push what?")
        expect(told).to_contain_text("Well done. It is.")
        told = answered("Push where?")
        expect(told).to_contain_text("“the cup” isn't in its place")
        told.get_by_label("Why it is wrong").fill("A cup is no place.")
        told.get_by_role("button", name="Keep it as a wrong one").click()
        expect(told).to_contain_text("Kept.")
        told = answered("Push where?")
        expect(told).to_contain_text("Not quite. A cup is no place.")
    send(admin, "texts", then="stay", **texts)  # the form knows nothing of the answers
    draft = find_draft(root, "arm")
    assert draft is not None
    (item,) = draft.value["tasks"]["segment"]["practice_items"]
    assert item["answer"]["sdcs"][0]["l"] == [{"type": "OBJECT", "f": [["the", 5], ["cup", 9]]}]
    assert [one["why"] for one in item["wrong"]] == ["A cup is no place."]
    send(admin, "texts", then="stay", **{**texts, "item-segment-0-command": "Push it"})
    draft = find_draft(root, "arm")
    assert draft is not None
    assert "answer" not in draft.value["tasks"]["segment"]["practice_items"][0]
