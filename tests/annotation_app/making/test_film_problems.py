"""The pages of a study's set-up name films that people couldn't watch as they are meant."""

from __future__ import annotations

from pathlib import Path

from flask import Flask

from corpus_tools.video.probe import probe
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.making.test_making import begun, made, send
from tests.annotation_app.signing_in import Member
from tests.small_films import cut_off, film


def page_of(admin: Member, step: str) -> str:
    return str(admin.client.get(f"/admin/studies/arm/{step}").text)


def test_a_film_that_is_cut_off_is_named_before_the_start(admin: Member, root: Path) -> None:
    cut_off(film(root / "clips/half.mp4", 30, keys=4), 0.5)
    begun(admin)
    told = "half.mp4: the video isn&#39;t whole: it is cut off"
    assert told in send(admin, "videos", videos="clips").text
    assert told in page_of(admin, "review")
    assert send(admin, "review").status_code == 422


def test_another_film_under_the_same_name_is_named(admin: Member, app: Flask, root: Path) -> None:
    made(admin)
    worker = Browser(app, study="arm")
    worker.practise("describe")
    item = worker.lease("describe", "arm").json["item"]
    assert worker.answer(item, described()).status_code == 200
    assert "replaced" not in page_of(admin, "review")
    for clip in (root / "clips").iterdir():
        film(clip, 15)
    assert page_of(admin, "review").count("has been replaced") == 1  # of others nobody was asked
    assert send(admin, "review", confirm="on").status_code == 422


def test_an_upload_that_is_cut_off_is_refused(admin: Member, root: Path) -> None:
    begun(admin)
    content = cut_off(film(root / "half.mp4", 30, keys=4), 0.5).read_bytes()
    address = f"/admin/studies/arm/upload?file=half.mp4&offset=0&size={len(content)}"
    headers = {"X-CSRFToken": admin.csrf, "Content-Type": "application/octet-stream"}
    reply = admin.client.post(address, data=content, headers=headers)
    assert reply.status_code == 422
    assert "cut off" in reply.json["error"]
    assert not (root / "arm-videos/half.mp4").exists()


def test_a_preview_shows_a_part_with_its_length(admin: Member, root: Path) -> None:
    film(root / "long.mp4", 40)
    (root / "t.csv").write_text("video,id,start_s,end_s\nlong.mp4,part,1,2.5\n")
    begun(admin)
    send(admin, "videos", videos="t.csv")
    send(admin, "tasks", **{"do-describe": "on", "answers-describe": "2"})
    with admin.client.get("/admin/studies/arm/video/0") as shown:
        assert shown.status_code == 200
        (root / "shown.mp4").write_bytes(shown.data)
    assert probe(root / "shown.mp4").duration_s == 1.5
