"""Files of a study's set-up in a real browser: added, replaced, used and deleted."""

from __future__ import annotations

from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, expect

from tests.annotation_app.in_browser import errors_of, look, serving, sign_in
from tests.annotation_app.making.test_making import begun, coco
from tests.annotation_app.signing_in import Member


@pytest.mark.firefox
@pytest.mark.slow
def test_boxes_for_some_videos_are_added_replaced_and_deleted(
    app: Flask, admin: Member, context: BrowserContext, root: Path, tmp_path: Path
) -> None:
    begun(admin)
    boxes = tmp_path / "boxes.json"
    boxes.write_bytes(coco("push"))
    with serving(app) as url:
        sign_in(context, admin, url)
        page = context.new_page()
        errors = errors_of(page)
        page.goto(f"{url}/admin/studies/arm/videos")
        videos = sorted((root / "clips").iterdir())
        page.set_input_files("#files", [*videos, boxes])
        expect(page.get_by_text("1 thing in 1 of 3 videos")).to_be_visible()
        listed = page.get_by_role("list", name="Files that are there").get_by_role("listitem")
        expect(listed.filter(has_text="boxes.json")).to_contain_text("what is where")
        found = look(page, "uploads")
        boxes.write_bytes(coco("push", "lift"))
        page.set_input_files("#files", boxes)
        page.locator("#uploads").get_by_role("button", name="Replace boxes.json").click()
        expect(page.get_by_text("2 things in 2 of 3 videos")).to_be_visible()
        other = tmp_path / "other.json"
        other.write_bytes(coco("push"))
        page.get_by_label("Replace boxes.json").set_input_files(other)
        expect(page.get_by_text("1 thing in 1 of 3 videos")).to_be_visible()
        page.get_by_role("button", name="Save and go on").click()
        expect(page.get_by_role("checkbox", name="Ground")).to_be_checked()
        expect(page.get_by_role("checkbox", name="Check", exact=True)).to_be_checked()
        ground = page.get_by_role("region", name="Ground")
        expect(ground.get_by_role("listitem")).to_have_text(["lift Draw", "wait Draw"])
        shown = ground.get_by_role("listitem").locator("img").first
        assert shown.evaluate("image => image.decode().then(() => image.naturalWidth)") > 0
        found += look(page, "uploads-tasks")
        page.go_back()
        listed.filter(has_text="boxes.json").get_by_text("Delete…").click()
        page.get_by_role("button", name="Delete it from the server").click()
        expect(page.get_by_text("boxes.json")).to_have_count(0)
        assert found == []
        assert [error for error in errors if "409" not in error] == []
