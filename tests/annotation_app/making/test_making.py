"""Making and changing a study by the forms of its steps."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.store.audit import trail
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Assignment, Item, Role, Study
from annotation_app.studies.study_file import CONSENT, STATEMENT, KnownCommand
from annotation_app.study_setup.study_reading import read_study
from annotation_app.work.assigning import set_group
from corpus_tools.tables.curve_file import Curve, write_curves
from tests.annotation_app.browser import (
    Browser,
    described,
    engine_of,
    row_in,
    rows_in,
    session_of,
)
from tests.annotation_app.signing_in import Member, signed_in
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH

TASKS = {"do-describe": "on", "answers-describe": "2", "practice-describe": "on"}
SCALE = ("No", "Hardly", "Partly", "Mostly", "Yes")
TEXTS = {
    "title": "An arm",
    "robot": "arm",
    "statement": "The {robot} does it.",
    **{f"scale-{i}": label for i, label in enumerate(SCALE)},
    "label-thing": "Part",
    "label-place": "Spot",
    "label-robot": "the arm",
    "instructions-describe": "1. Watch.\r\n2. Type.  ",
}


def send(member: Member, step: str, **form: str) -> Any:
    return member.post(f"/admin/studies/arm/{step}", **form)


def begun(admin: Member) -> None:
    assert admin.post("/admin/studies/new", title="An arm", name="arm").status_code == 303


def made(admin: Member, texts: Mapping[str, str] = TEXTS, role: Role = "worker") -> None:
    """A running study."""
    begun(admin)
    made_in(admin, texts, role)


def made_in(
    admin: Member, texts: Mapping[str, str], role: Role = "worker", videos: str = "clips"
) -> None:
    """The draft is a running study."""
    for step, form in (
        ("videos", {"videos": videos}),
        ("tasks", TASKS),
        ("people", {"access": "open", "role-describe": role}),
        ("texts", texts),
        ("consent", {"consent": CONSENT}),
    ):
        assert send(admin, step, **form).status_code == 303, step
    assert send(admin, "review").location.endswith("/admin/studies/arm/started")


@pytest.mark.parametrize(
    ("role", "said"),
    [("worker", "Whoever opens it can take part."), ("annotator", "All tasks ask for a login.")],
)
def test_the_last_page_says_who_can_take_part(admin: Member, role: Role, said: str) -> None:
    made(admin, role=role)
    assert said in admin.client.get("/admin/studies/arm/started").text


@pytest.mark.parametrize(
    ("host", "is_only_here"),
    [
        ("localhost", True),
        ("127.0.0.1", True),
        ("192.168.1.7", False),
        ("lab.example.org", False),
    ],
)
def test_the_last_page_says_if_nobody_else_reaches_the_address(
    admin: Member, host: str, is_only_here: bool
) -> None:
    made(admin)
    admin.client.set_cookie("session", session_of(admin), domain=host)
    page = admin.client.get("/admin/studies/arm/started", headers={"Host": host}).text
    assert ("Only browsers on this computer" in page) == is_only_here


def test_the_usual_consent_is_read_in_the_studys_language(app: Flask, admin: Member) -> None:
    begun(admin)
    page = admin.client.get("/admin/studies/arm/consent").text
    assert "You will watch short videos of a robot, or read" in page
    made_in(admin, {**TEXTS, "locale": "de"})
    welcome = app.test_client().get("/s/arm/welcome").text
    assert "Sie sehen kurze Videos eines Roboters oder lesen" in welcome


def in_database(app: Flask) -> Study | None:
    with reading(engine_of(app)) as session:
        return session.scalars(select(Study)).first()


def test_the_steps_write_a_file_and_start_the_study(app: Flask, admin: Member, root: Path) -> None:
    page = admin.client.get("/dashboard/").text
    assert "There are no studies yet" in page
    assert "/admin/studies/new" in page
    made(admin)
    study = read_study(root / "arm.yaml")
    assert (study.title, study.robot, study.videos, study.scale) == (
        "An arm",
        "arm",
        "clips",
        SCALE,
    )
    assert study.tasks["describe"].instructions == "1. Watch.\n2. Type."
    assert study.tasks["describe"].answers == 2
    found = in_database(app)
    assert found is not None
    assert found.file == str(root / "arm.yaml")
    worker = Browser(app, study="arm")
    worker.practise("describe")
    page = worker.lease("describe", "arm").json
    assert worker.answer(page["item"], described("Push it.")).status_code == 200
    assert not list((root / ".drafts").iterdir())


def test_all_that_is_wrong_is_told_at_once_and_nothing_is_lost(admin: Member, root: Path) -> None:
    begun(admin)
    reply = send(admin, "videos")
    assert reply.status_code == 422
    assert "Choose the videos." in reply.text
    assert send(admin, "videos", videos="clips").status_code == 303
    reply = send(admin, "tasks", **{**TASKS, "answers-describe": "many", "lease-describe": "0"})
    assert reply.status_code == 422
    assert "Describe, answers: Type a whole number." in reply.text
    assert "Describe, minutes: Type a number above 0" in reply.text
    assert 'value="many"' in admin.client.get("/admin/studies/arm/tasks").text
    reply = send(admin, "tasks")
    assert "Tasks: Choose a task." in reply.text
    reply = send(admin, "review")
    assert reply.status_code == 422
    assert "to be put right" in reply.text
    assert not (root / "arm.yaml").exists()


def test_videos_that_browsers_cannot_play_are_all_named(admin: Member, root: Path) -> None:
    (root / "bad").mkdir()
    for name in ("a", "b"):
        (root / f"bad/{name}.mp4").write_bytes(b"no video")
    begun(admin)
    reply = send(admin, "videos", videos="bad")
    assert reply.status_code == 422
    assert "a.mp4: the video can" in reply.text
    assert "b.mp4" in reply.text
    assert "2 things have to be put right" in reply.text


@pytest.mark.parametrize(
    "chosen", ["..", "../../etc", "/etc", "table.csv", "link", "views.csv", "curves.csv"]
)
def test_no_path_leads_out_of_the_folder_of_studies(
    admin: Member, root: Path, tmp_path: Path, chosen: str
) -> None:
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside/secret.mp4").write_bytes((root / "clips/push.mp4").read_bytes())
    curves = tmp_path / "outside/secret.safetensors"
    write_curves(curves, [Curve("state", "joint")], 10, 1, [])
    (root / "table.csv").write_text("video\n../outside/secret.mp4\n")
    (root / "views.csv").write_text("video,video_2\nclips/push.mp4,../outside/secret.mp4\n")
    (root / "curves.csv").write_text(f"video,curves\nclips/push.mp4,{curves}\n")
    (root / "link").symlink_to(tmp_path / "outside")
    begun(admin)
    reply = send(admin, "videos", videos=chosen)
    assert reply.status_code == 422
    assert "not in the folder of studies" in reply.text
    assert admin.client.get("/admin/studies/arm/video/0").status_code == 404


def test_a_change_of_what_was_asked_is_named_and_confirmed(
    app: Flask, admin: Member, root: Path
) -> None:
    made(admin)
    worker = Browser(app, study="arm")
    worker.practise("describe")
    worker.answer(worker.lease("describe", "arm").json["item"], described("Push it."))
    file = root / "arm.yaml"
    file.write_text(file.read_text() + "# Ask Ann before you change this.\n")
    new = {**TEXTS, "instructions-describe": "Type it.", "title": "The arm"}
    assert send(admin, "texts", **new).status_code == 303
    page = admin.client.get("/admin/studies/arm/review").text
    assert "2 changes" in page
    assert "1 answer to describe came before." in page
    assert "Ask Ann before" in page
    assert send(admin, "review").status_code == 422
    assert send(admin, "review", confirm="on").status_code == 422  # the comment would go
    assert read_study(file).title == "An arm"
    assert send(admin, "review", confirm="on", comments="on").status_code == 303
    assert read_study(file).title == "The arm"
    (old,) = (root / "versions").iterdir()
    assert "Ask Ann" in old.read_text()
    with reading(engine_of(app)) as session:
        entry = trail(session, action="changed a study")[0]
    assert (entry.actor, entry.about) == ("ada", "arm")
    assert entry.details["confirmed"] == (
        "tasks.describe.instructions: 1 answer to describe came before"
    )
    assert entry.details["before"] == old.name
    worker.practise("describe")
    assert "Type it." in worker.client.get("/s/arm/describe").text


def test_who_changes_the_file_meanwhile_loses_nothing(admin: Member, root: Path) -> None:
    made(admin)
    send(admin, "texts", **{**TEXTS, "title": "Mine"})
    file = root / "arm.yaml"
    file.write_text(file.read_text().replace("An arm", "Theirs"))
    reply = send(admin, "review", confirm="on")
    assert reply.status_code == 422
    assert "since you began" in reply.text
    assert read_study(file).title == "Theirs"
    assert admin.post("/admin/studies/arm/discard").status_code == 303
    assert 'value="Theirs"' in admin.client.get("/admin/studies/arm/texts").text


def test_what_the_steps_do_not_ask_for_stays_in_the_file(admin: Member, root: Path) -> None:
    made(admin)
    file = root / "arm.yaml"
    file.write_text(file.read_text() + "seed: 7\nonly: [push, lift]\n")
    assert send(admin, "texts", **{**TEXTS, "title": "The arm"}).status_code == 303
    assert send(admin, "review").status_code == 303
    study = read_study(file)
    assert (study.seed, study.only, study.title) == (7, ("push", "lift"), "The arm")


def test_a_name_is_taken_once(admin: Member) -> None:
    begun(admin)
    for name in ("arm", "An Arm!", "../x", "a" * 61):
        assert admin.post("/admin/studies/new", title="T", name=name).status_code == 422
    assert admin.post("/admin/studies/new", title="", name="").status_code == 422


def test_previews_have_the_drafts_words(admin: Member) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    send(admin, "tasks", **TASKS)
    practice = {"item-describe-0-video": "lift", "item-describe-0-good": "Well said!"}
    send(admin, "texts", **{**TEXTS, "summary-describe": "Look at **it**"}, **practice)
    send(admin, "consent", consent="Do you **agree** to the {robot}?")
    welcome = admin.client.get("/admin/studies/arm/preview/welcome").text
    assert "<strong>agree</strong> to the arm?" in welcome
    assert "no answer is sent" in welcome
    assert "Look at **it**" in admin.client.get("/admin/studies/arm/preview/tasks").text
    page = admin.client.get("/admin/studies/arm/preview/describe").text
    assert "<li>Watch.</li>" in page
    assert "/admin/studies/arm/video/0" in page
    with admin.client.get("/admin/studies/arm/video/0") as film:
        assert film.mimetype == "video/mp4"


def test_attention_checks_are_made_of_known_commands(admin: Member, root: Path) -> None:
    made(admin)
    rate = {**TASKS, "do-rate": "on", "answers-rate": "3"}
    known = {"known-0-text": "Push it.", "known-0-video": "push", "known-0-wrong_video": "lift"}
    send(admin, "tasks", **rate, attention="0.7", **{**known, "known-0-text": ""})
    page = admin.client.get("/admin/studies/arm/review").text
    assert "Attention checks: Type a number of 0.5 or less." in page
    assert "Command, text 1: This is empty." in page
    send(admin, "tasks", **rate, attention="0.2")
    page = admin.client.get("/admin/studies/arm/review").text
    assert "Attention checks: There are no known commands to check with" in page
    assert send(admin, "tasks", **rate, attention="0.2", **known).status_code == 303
    assert send(admin, "review", confirm="on").status_code == 303
    study = read_study(root / "arm.yaml")
    assert study.attention_checks == 0.2
    assert study.known_commands == (KnownCommand("Push it.", "push", "lift"),)
    page = admin.client.get("/admin/studies/arm/tasks").text
    assert 'value="Push it."' in page
    assert page.count("<option selected>push</option>") == 1
    send(admin, "tasks", **rate, attention="")
    send(admin, "review", confirm="on")
    assert read_study(root / "arm.yaml").known_commands == ()


@pytest.mark.parametrize("rule", ["majority", "0.75", "adjudicator"])
def test_a_task_says_when_an_answer_is_adopted(admin: Member, root: Path, rule: str) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    segment = {"do-segment": "on", "answers-segment": "3", "adoption-segment": rule}
    refused = send(admin, "tasks", **TASKS, **segment, **{"overlap-segment": "2"})
    assert "Segment, overlap: " in refused.text
    send(admin, "tasks", **TASKS, **segment, **{"overlap-segment": "0,2"})
    page = admin.client.get("/admin/studies/arm/tasks").text
    assert f'<option value="{rule}" selected>' in page
    assert send(admin, "review").status_code == 303
    made = read_study(root / "arm.yaml").tasks["segment"]
    assert (str(made.adoption), made.overlap) == (rule, 0.2)


def test_a_study_names_groups_and_what_share_they_get(
    app: Flask, admin: Member, root: Path
) -> None:
    people = [signed_in(app, name, "annotator").person.id for name in ("ann", "bob", "cy", "dan")]
    with app.app_context(), transaction(engine_of(app)) as session:
        set_group(session, "day shift", people[:2], actor="test")
    begun(admin)
    send(admin, "videos", videos="clips")
    send(admin, "tasks", **TASKS)
    wrong = {"group-0-name": "day shift", "group-0-share": "much"}
    refused = send(admin, "people", access="open", **wrong)
    assert refused.status_code == 422
    assert 'id="f-groups-day-shift"' in refused.text
    shares = {"group-0-share": "1", "group-1-name": "night", "group-1-share": "1"}
    assert send(admin, "people", access="open", **wrong | shares).status_code == 303
    for step, form in (("texts", TEXTS), ("consent", {"consent": CONSENT})):
        send(admin, step, **form)
    assert "group night has no members" in admin.client.get("/admin/studies/arm/review").text
    send(admin, "review")
    assert read_study(root / "arm.yaml").groups == {"day shift": 1, "night": 1}
    items = rows_in(app, select(Item.id))
    assert len(items) > 1
    assigned = select(Assignment.item_id, Assignment.person_id)
    with reading(engine_of(app)) as session:
        first = {person for _, person in session.execute(assigned)}
    assert first == {*people[:2]}
    with app.app_context(), transaction(engine_of(app)) as session:
        set_group(session, "night", people[2:], actor="test")
    with reading(engine_of(app)) as session:
        of_items: dict[str, set[str]] = {}
        for item, person in session.execute(assigned):
            of_items.setdefault(item, set()).add(person)
    assert set(of_items) == set(items)
    day = sum(one == {*people[:2]} for one in of_items.values())
    assert all(one in ({*people[:2]}, {*people[2:]}) for one in of_items.values())
    assert abs(2 * day - len(items)) <= 1


def test_a_task_says_which_styles_of_text_people_write(admin: Member, root: Path) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    page = admin.client.get("/admin/studies/arm/tasks").text
    assert 'name="style-moments" value="vqa" checked' in page
    assert 'name="style-moments" value="plan">' in page
    moments = {"do-moments": "on", "answers-moments": "1"}
    send(admin, "tasks", **moments, **{"style-moments": ["vqa", "plan"]})
    assert send(admin, "review").status_code == 303
    assert read_study(root / "arm.yaml").tasks["moments"].styles == ("vqa", "plan")
    page = admin.client.get("/admin/studies/arm/tasks").text
    assert 'name="style-moments" value="plan" checked' in page
    assert (
        'data-style="interjection"'
        not in admin.client.get("/admin/studies/arm/preview/moments").text
    )
    send(admin, "tasks", **moments, **{"style-moments": ["interjection", "vqa"]})
    send(admin, "review", confirm="on")
    assert read_study(root / "arm.yaml").tasks["moments"].styles == ()


def test_a_study_gets_reasons_against_episodes(admin: Member, root: Path) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    marks = {"do-mark": "on", "answers-mark": "3", "adoption-mark": "majority"}
    send(admin, "tasks", **TASKS, **marks)
    assert "\nThe robot hits something" in admin.client.get("/admin/studies/arm/texts").text
    send(admin, "texts", **TEXTS, reasons="It drops\r\n\r\nIt spills <b>tea</b>\r\n")
    page = admin.client.get("/admin/studies/arm/texts").text
    assert "It drops\nIt spills &lt;b&gt;tea&lt;/b&gt;</textarea>" in page
    assert "It spills &lt;b&gt;tea" in admin.client.get("/admin/studies/arm/preview/mark").text
    send(admin, "consent", consent=CONSENT)
    assert send(admin, "review").status_code == 303
    assert read_study(root / "arm.yaml").reasons == ("It drops", "It spills <b>tea</b>")


def test_a_study_gets_a_language(admin: Member, root: Path) -> None:
    usual = {"statement": STATEMENT, "label-thing": "Thing", "label-place": "Ecke"}
    made(admin, {**TEXTS, **usual, "locale": "de"})
    study = read_study(root / "arm.yaml")
    assert (study.locale, study.statement) == ("de", STATEMENT)
    page = admin.client.get("/admin/studies/arm/texts").text
    assert '<option value="de" lang="de" selected>Deutsch</option>' in page
    assert '<html lang="en"' in page
    address = "/admin/studies/arm/preview"
    told = admin.client.get(f"{address}/describe").text
    assert '<html lang="de" dir="ltr">' in told
    assert "Antwort prüfen" in told
    assert '"place": "Ecke", "robot": "das Boot", "thing": "Ding"' in told
    assert "Willkommen" in admin.client.get(f"{address}/welcome").text
    assert "Ansehen" in admin.client.get(f"{address}/tasks").text
    send(admin, "texts", **{**TEXTS, "locale": "fr"})
    assert "pages don&#39;t speak fr" in admin.client.get("/admin/studies/arm/review").text


def test_files_are_added_in_parts(admin: Member, root: Path) -> None:
    begun(admin)
    film = (root / "clips/push.mp4").read_bytes()
    headers = {"X-CSRFToken": admin.csrf, "Content-Type": "application/octet-stream"}

    def add(name: str, content: bytes, offset: int, size: int) -> Any:
        return admin.client.post(
            f"/admin/studies/arm/upload?file={name}&offset={offset}&size={size}",
            data=content,
            headers=headers,
        )

    assert add("push.mp4", film[:100], 0, len(film)).json == {"whole": False}
    assert add("push.mp4", film[50:], 50, len(film)).status_code == 422  # not its next part
    assert add("push.mp4", film[100:], 100, len(film)).json == {"whole": True}
    assert (root / "arm-videos/push.mp4").read_bytes() == film
    assert "1 video: push" in admin.client.get("/admin/studies/arm/videos").text
    for name in ("../push.mp4", "..%2Fx.mp4", ".x.mp4", "x.exe", "x.mp4%00"):
        assert add(name, film, 0, len(film)).status_code == 422, name
    told = add("my%20film.avi", film, 0, len(film)).json["error"]
    assert "ffmpeg -i 'my film.avi' -c:v libx264 -pix_fmt yuv420p 'my film.mp4'" in told
    assert add("long.mp4", b"x", 0, 2**40).status_code == 422
    bad = add("bad.mp4", b"no video", 0, 8)
    assert bad.status_code == 422
    assert "can't be read" in bad.json["error"]
    assert sorted(file.name for file in (root / "arm-videos").glob("*.mp4")) == ["push.mp4"]
    assert add("push.mp4", film, 0, len(film)).json["may_replace"]
    assert add("push.mp4&replace=yes", b"no video", 0, 8).status_code == 422
    assert (root / "arm-videos/push.mp4").read_bytes() == film  # the old one stays
    other = (root / "clips/lift.mp4").read_bytes()
    assert add("push.mp4&replace=yes", other, 0, len(other)).json == {"whole": True}
    assert (root / "arm-videos/push.mp4").read_bytes() == other


def coco(*names: str) -> bytes:
    """A COCO file with a box in each picture."""
    images = [
        {"id": n, "file_name": f"{name}.jpg", "width": WIDTH, "height": HEIGHT}
        for n, name in enumerate(names)
    ]
    boxes = [
        {"id": 30 + n, "image_id": n, "category_id": 1, "bbox": [5, 5, 20, 20]}
        for n in range(len(names))
    ]
    categories = [{"id": 1, "name": "red barrel"}]
    return json.dumps({"images": images, "annotations": boxes, "categories": categories}).encode()


def add_whole(admin: Member, name: str, content: bytes, **more: str) -> Any:
    about = urlencode({"file": name, "offset": 0, "size": len(content), **more})
    headers = {"X-CSRFToken": admin.csrf, "Content-Type": "application/octet-stream"}
    address = f"/admin/studies/arm/upload?{about}"
    return admin.client.post(address, data=content, headers=headers)


def test_an_added_file_is_put_to_use_and_can_be_used_otherwise(admin: Member, root: Path) -> None:
    begun(admin)
    for name in ("push", "lift"):
        add_whole(admin, f"{name}.mp4", (root / f"clips/{name}.mp4").read_bytes())
    add_whole(admin, "boxes.json", coco("push"))
    add_whole(admin, "told.csv", b"video,command\npush,Push it.\n")
    add_whole(admin, "other.json", coco("push", "lift"))
    page = admin.client.get("/admin/studies/arm/videos").text
    assert "1 thing in 1 of 2 videos" in page
    assert "1 without boxes" in page
    assert "1 command" in page
    assert admin.client.get("/admin/studies/arm/upload/lift.mp4").mimetype == "image/jpeg"
    page = admin.client.get("/admin/studies/arm/tasks").text
    for task in ("ground", "check"):
        assert re.search(f'name="do-{task}"[^>]* checked', page), task
    assert "<bdi>lift</bdi>" in page
    (picture,) = re.findall(r'src="([^"]+/video/\d/picture)"', page)
    assert admin.client.get(picture).mimetype == "image/jpeg"
    change = "/admin/studies/arm/upload/other.json"
    assert admin.post(change, action="commands").status_code == 422
    assert admin.post(change, action="things").status_code == 303
    assert "2 things in 2 of 2 videos" in admin.client.get("/admin/studies/arm/videos").text
    assert admin.post(change, action="delete").status_code == 303
    assert not (root / "arm-videos/other.json").exists()
    page = admin.client.get("/admin/studies/arm/review").text
    assert "the task ground asks about the things in videos" in page.lower()
    assert "/admin/studies/arm/tasks#f-tasks-ground" in page
    assert admin.post("/admin/studies/arm/upload/boxes.json", action="things").status_code == 303
    assert "to be put right" not in admin.client.get("/admin/studies/arm/review").text


def test_a_video_that_people_were_asked_about_stays(app: Flask, admin: Member, root: Path) -> None:
    begun(admin)
    for name in ("push", "lift"):
        add_whole(admin, f"{name}.mp4", (root / f"clips/{name}.mp4").read_bytes())
    made_in(admin, TEXTS, videos="arm-videos")
    worker = Browser(app, study="arm")
    worker.practise("describe")
    asked = worker.lease("describe", "arm").json["item"]
    worker.answer(asked, described("Push it."))
    about = row_in(app, select(Item.video).where(Item.id == asked))
    (free,) = {"push", "lift"} - {about}
    content = (root / "clips/wait.mp4").read_bytes()
    assert add_whole(admin, f"{about}.mp4", content, replace="yes").status_code == 409
    assert admin.post(f"/admin/studies/arm/upload/{about}.mp4", action="delete").status_code == 409
    assert admin.post(f"/admin/studies/arm/upload/{free}.mp4", action="delete").status_code == 303
    assert [f.name for f in (root / "arm-videos").glob("*.mp4")] == [f"{about}.mp4"]


def test_the_other_camera_that_people_saw_stays(app: Flask, admin: Member, root: Path) -> None:
    begun(admin)
    for name in ("push", "lift"):
        add_whole(admin, f"{name}.mp4", (root / f"clips/{name}.mp4").read_bytes())
    (root / "views.csv").write_text("video,video_2\narm-videos/push.mp4,arm-videos/lift.mp4\n")
    made_in(admin, TEXTS, videos="views.csv")
    assert "a camera of push" in admin.client.get("/admin/studies/arm/videos").text
    worker = Browser(app, study="arm")
    worker.practise("describe")
    worker.answer(worker.lease("describe", "arm").json["item"], described("Push it."))
    assert admin.post("/admin/studies/arm/upload/lift.mp4", action="delete").status_code == 409
    assert (root / "arm-videos/lift.mp4").exists()


@pytest.mark.parametrize("role", ["annotator", "adjudicator"])
def test_only_admins_make_studies(app: Flask, admin: Member, role: Role) -> None:
    made(admin)
    other = signed_in(app, "eve", role)
    for path in (
        "new",
        "arm/videos",
        "arm/texts",
        "arm/review",
        "arm/preview/tasks",
        "arm/video/0",
        "arm/video/0/draw",
        "arm/video/0/still",
    ):
        assert other.client.get(f"/admin/studies/{path}").status_code == 403, path
    for path in ("new", "arm/texts", "arm/review", "arm/discard", "arm/upload"):
        assert other.post(f"/admin/studies/{path}").status_code == 403, path
    for path, body in (("things", DRAWN), ("follow", FOLLOWED)):
        assert sent_json(other, f"arm/video/0/{path}", body).status_code == 403, path
        assert sent_json(other, f"arm/video/0/{path}", body, csrf="").status_code == 400, path


FOLLOWED: dict[str, Any] = {"start_s": 0, "outlines": [[[[2, 2], [9, 2], [9, 9], [2, 9]]]]}
DRAWN: dict[str, Any] = {"video": "lift", "state": "", "things": []}


def sent_json(member: Member, path: str, body: Any, csrf: str | None = None) -> Any:
    headers = {"X-CSRFToken": member.csrf if csrf is None else csrf}
    return member.client.post(f"/admin/studies/{path}", json=body, headers=headers)


def test_what_is_followed_is_near_the_picture(admin: Member) -> None:
    begun(admin)
    send(admin, "videos", videos="clips")
    assert sent_json(admin, "arm/video/0/follow", FOLLOWED).status_code == 200
    far = [[[[x, y] for x, y in ((2, 2), (1e12, 2), (1e12, 9), (2, 9))]]]
    for outlines in (far, [[far[0][0][:3]]], [[]], []):
        body = {**FOLLOWED, "outlines": outlines}
        assert sent_json(admin, "arm/video/0/follow", body).status_code == 400


def test_a_study_without_a_file_is_not_changed(app: Flask, admin: Member) -> None:
    made(admin)
    with engine_of(app).begin() as connection:
        connection.execute(Study.__table__.update().values(file=None))  # type: ignore[attr-defined]
    assert admin.client.get("/admin/studies/arm/texts").status_code == 422
