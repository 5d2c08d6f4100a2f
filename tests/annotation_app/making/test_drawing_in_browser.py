"""Drawing what is where in the videos of a study, in its set-up."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, Page, expect

from annotation_app.study_setup.study_drafts import StudyDraft, find_draft, keep_draft
from tests.annotation_app.in_browser import errors_of, look, serving, sign_in
from tests.annotation_app.signing_in import Member
from tests.annotation_app.study_setup.clips import film

SIZE = (320, 240)
STEP_PX = 8


def moving(path: Path) -> None:
    """Two seconds of a thing that goes to the right, 80 pixels a second."""
    random = np.random.default_rng(3)
    thing = cv2.resize(random.integers(0, 255, (8, 10, 3), np.uint8), (60, 48))
    pictures = []
    for number in range(20):
        picture = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
        left = 30 + STEP_PX * number
        picture[100:148, left : left + 60] = thing
        pictures.append(picture)
    film(path, pictures)


@pytest.fixture
def draft(root: Path) -> StudyDraft:
    moving(root / "clips/go.mp4")
    value = {"name": "arm", "title": "An arm", "videos": "clips", "tasks": {"describe": {}}}
    made = StudyDraft("arm", root / "arm.yaml")
    return keep_draft(root, made, value)


def coco(root: Path) -> Any:
    return json.loads((root / "arm-videos/drawn.json").read_text())


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Draw from one spot of the picture to another, in its pixels."""
    box = page.locator(".screen").bounding_box()
    assert box is not None
    scale = box["width"] / SIZE[0]
    (x, y), (u, v) = start, end
    page.mouse.move(box["x"] + x * scale, box["y"] + y * scale)
    page.mouse.down()
    page.mouse.move(box["x"] + u * scale, box["y"] + v * scale, steps=4)
    page.mouse.up()


@pytest.mark.firefox
@pytest.mark.slow
def test_a_thing_is_drawn_named_followed_and_corrected(
    app: Flask, admin: Member, root: Path, draft: StudyDraft, context: BrowserContext
) -> None:
    page = context.new_page()
    errors = errors_of(page)
    with serving(app) as url:
        sign_in(context, admin, url)
        page.goto(f"{url}/admin/studies/arm/videos")
        expect(page.get_by_text("4 without boxes")).to_be_visible()
        found = look(page, "videos-to-draw")
        page.get_by_role("link", name="go Draw").click()
        expect(page.get_by_role("button", name="Box", exact=True)).to_be_visible()
        drag(page, (30, 100), (90, 148))
        page.keyboard.press("Enter")
        page.keyboard.type("parcel")
        page.keyboard.press("Enter")
        expect(page.locator(".surface :focus")).to_have_attribute(
            "aria-label", re.compile("1 parcel")
        )
        page.keyboard.press("b")
        page.keyboard.press("Delete")
        expect(page.get_by_text("Saved.")).to_be_visible()
        page.get_by_role("button", name="Follow them to the end").click()
        expect(page.locator("#followed")).to_contain_text("Followed to the end")
        expect(page.get_by_text("Saved.")).to_be_visible()
        found += look(page, "draw")
        page.set_viewport_size({"width": 1280, "height": 900})
        last = coco(root)["annotations"][-1]
        assert last["keyframe"] is False
        assert last["bbox"][0] == pytest.approx(30 + 19 * STEP_PX, abs=4)

        page.get_by_label("Time in the video, in seconds").fill("1")
        expect(page.locator(".surface .drawn")).to_have_attribute(
            "aria-label", re.compile("1 parcel: 3[34] % from the left")
        )
        drag(page, (140, 120), (140, 160))
        expect(page.locator("#followed")).to_contain_text(re.compile("Followed|lost"))
        page.get_by_role("link", name=re.compile("^Next video|^Back")).last.click()
        page.get_by_role("link", name="go 1 thing").click()
        expect(page.get_by_label("Name of thing 1")).to_have_value("parcel")
        expect(page.locator("#names option")).to_have_attribute("value", "parcel")
    keys = [one["image_id"] for one in coco(root)["annotations"] if one["keyframe"]]
    times = {image["id"]: image["time_s"] for image in coco(root)["images"]}
    assert [times[key] for key in keys] == [0, pytest.approx(1, abs=0.06)]
    kept = find_draft(root, "arm")
    assert kept is not None
    assert kept.value["things"] == "arm-videos/drawn.json"
    assert {"ground", "check"} <= kept.value["tasks"].keys()
    assert found == []
    assert errors == []


def test_two_people_do_not_undo_each_others_work(
    app: Flask, admin: Member, root: Path, draft: StudyDraft
) -> None:
    page = admin.client.get("/admin/studies/arm/video/0/draw").text
    data = json.loads(re.search(r'id="drawn">(.*?)</script>', page)[1])  # type: ignore[index]
    corners = [[2, 3], [22, 3], [22, 33], [2, 33]]
    thing = {
        "id": "5",
        "name": "cup",
        "is_box": True,
        "moments": [{"time_s": 0, "polygons": [corners], "is_keyframe": True}],
    }
    sent = {"video": data["video"], "state": data["state"], "things": [thing]}
    assert admin.send("POST", data["save"], sent).status_code == 200
    reply = admin.send("POST", data["save"], {**sent, "things": []})
    assert (reply.status_code, "Somebody else" in reply.json["error"]) == (409, True)
    outside = {**thing, "moments": [{"time_s": 9, "polygons": [corners]}]}
    state = admin.client.get("/admin/studies/arm/video/0/draw").text
    data = json.loads(re.search(r'id="drawn">(.*?)</script>', state)[1])  # type: ignore[index]
    reply = admin.send("POST", data["save"], {**sent, "state": data["state"], "things": [outside]})
    assert reply.status_code == 422
    assert "where there is no picture" in reply.json["error"]
    assert len(coco(root)["annotations"]) == 1
