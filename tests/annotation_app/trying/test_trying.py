"""Trying commands: who may, what is refused, and what comes of a process that dies."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from flask import Flask

from annotation_app.serving.factory import create_app
from annotation_app.trying import attempt as attempt_module
from annotation_app.trying import attempt_queue as queue
from annotation_app.trying.attempt import (
    Asked,
    Shown,
    film,
    plan,
    prepare,
    read_state,
    write_state,
)
from annotation_app.trying.attempt_queue import FOLDER, Attempts
from annotation_app.trying.attempt_queue import attempts as running_attempts
from annotation_app.trying.start_scene import PICTURE, read_scene
from g3.inference.grounder import Grounder
from g3.inference.problem.costs import RandomCost
from tests.annotation_app.browser import Browser, engine_of, installation_of
from tests.g3.inference.constant_cost import ConstantCost

SCENARIO = "dock_pick_up_tires"
AISLES = "aisles_drive_past_person"
COMMAND = {"scenario": SCENARIO, "text": "Pick up the tires."}


@pytest.fixture
def open_app(app: Flask) -> Flask:
    """An app in which anybody may try commands."""
    config = replace(installation_of(app).config, open_trying=True)
    return create_app(config, engine_of(app))


@pytest.fixture
def attempts(tmp_path: Path) -> Iterator[Attempts]:
    made = Attempts(tmp_path, None)
    yield made
    made.close()


@pytest.mark.parametrize(
    ("role", "status"), [("worker", 403), ("annotator", 422), ("adjudicator", 422)]
)
def test_people_with_a_login_may_try_commands(app: Flask, role: Any, status: int) -> None:
    person = Browser(app, role)
    assert person.client.get("/try").status_code == (302 if status == 403 else 200)
    assert ("/try" in person.client.get("/").text) == (status != 403)
    empty = {**COMMAND, "text": " . "}
    assert person.send("POST", "/api/try", empty).status_code == status


def test_strangers_are_asked_to_sign_in_but_not_in_the_demo(app: Flask, open_app: Flask) -> None:
    stranger = app.test_client()
    assert stranger.get("/try").location == "/login?next=/try"
    assert stranger.get("/api/try/0").status_code == 401
    page = open_app.test_client().get("/try")
    assert page.status_code == 200
    assert SCENARIO in page.text


def test_the_map_is_there_before_the_picture(app: Flask, open_app: Flask) -> None:
    client = open_app.test_client()
    reply = client.get(f"/api/try/scenes/{SCENARIO}")
    assert reply.status_code == 202
    scene = reply.json
    assert (scene["width"], scene["height"]) == (0, 0)
    assert {"tires-1", "boxes-1"} <= {thing["id"] for thing in scene["things"]}
    robot = next(thing for thing in scene["things"] if thing["is_robot"])
    x, y = zip(*robot["footprint"], strict=True)
    # The robot is in the middle of the map, and its heading goes up.
    assert max(y) - min(y) > max(x) - min(x)
    assert abs(sum(x)) < 0.1
    assert all(place["name"] and len(place["footprint"]) > 2 for place in scene["places"])
    assert client.get(f"/try/scenes/{SCENARIO}").status_code == 404  # until it is rendered
    assert client.get("/api/try/scenes/nothing").status_code == 404
    assert app.test_client().get(f"/api/try/scenes/{SCENARIO}").status_code == 401
    with open_app.app_context():
        running_attempts().stop()


def test_a_scene_has_outlines_and_a_place_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grounders: dict[Path | None, Grounder] = {tmp_path: Grounder(RandomCost(1))}
    monkeypatch.setattr(attempt_module, "_grounders", grounders)
    prepare(tmp_path / "scene", AISLES)
    scene = read_scene(tmp_path / "scene")
    assert scene is not None
    assert (tmp_path / "scene" / PICTURE).stat().st_size > 10_000
    seen = {thing.id for thing in scene.things if thing.outlines}
    assert {"boxes-1", "barrel-1", "forklift"} <= seen
    names = [place.name for place in scene.places]
    assert names == ["storage A", "storage B", "charging station"]
    (inside,) = (p.outline for p in scene.places if p.name == "storage A")
    assert all(0 <= x <= scene.width and 0 <= y <= scene.height for x, y in inside)
    folder = tmp_path / "one"
    folder.mkdir()
    write_state(folder, Shown(Asked(AISLES, "Put the boxes down beside the barrel.", insist=True)))
    plan(folder, tmp_path)
    shown = read_state(folder)
    assert shown is not None
    assert shown.plan is not None
    for clause in shown.plan.clauses:
        words = [candidate.words for candidate in clause.candidates]
        assert sum(c.probability for c in clause.candidates) == pytest.approx(1, abs=1e-3)
        assert not any("(" in word for word in words if word.startswith("a place"))
    keys = [key for c in shown.plan.clauses for one in c.candidates for key in one.things]
    places = {key for key in keys if key.startswith("place ")}
    assert places == {f"place {n}" for n in range(len(shown.plan.places))}


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"text": "\u200f!"}, "Type what the robot is to do"),
        ({"scenario": "../../etc/passwd"}, "no such scenario"),
        ({"text": "go " * 1000}, "can't be read"),
        ({"answers": {"x": "boxes-1"}}, "can't be read"),
    ],
)
def test_what_cannot_be_tried_is_refused(open_app: Flask, wrong: dict[str, Any], told: str) -> None:
    response = Browser(open_app).send("POST", "/api/try", {**COMMAND, **wrong})
    assert response.status_code in (400, 422)
    assert told in response.json["error"]


@pytest.mark.parametrize("name", ["0" * 24, "..", "x", "ü" * 24, "0" * 5000])
def test_nobody_sees_what_is_no_attempt(open_app: Flask, name: str) -> None:
    client = open_app.test_client()
    assert client.get(f"/api/try/{name}").status_code == 404
    assert client.get(f"/try/{name}/state.json").status_code == 404


def test_only_pictures_of_an_attempt_are_sent(open_app: Flask) -> None:
    folder = installation_of(open_app).config.instance / FOLDER / ("a" * 24)
    folder.mkdir(parents=True)
    write_state(folder, Shown(Asked(SCENARIO, "<b>Go</b>")))
    (folder / "tree.svg").write_text("<svg/>")
    client = open_app.test_client()
    assert client.get(f"/api/try/{folder.name}").json["asked"]["text"] == "<b>Go</b>"
    with client.get(f"/try/{folder.name}/tree.svg") as picture:
        assert picture.mimetype == "image/svg+xml"
    for name in ("state.json", "video.mp4"):
        assert client.get(f"/try/{folder.name}/{name}").status_code == 404


def test_what_is_not_there_is_told_and_can_be_insisted_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grounders: dict[Path | None, Grounder] = {tmp_path: Grounder(RandomCost(1))}
    monkeypatch.setattr(attempt_module, "_grounders", grounders)
    folder = tmp_path / "one"
    folder.mkdir()
    write_state(folder, Shown(Asked(SCENARIO, "Lift the elephant.")))
    plan(folder, tmp_path)
    shown = read_state(folder)
    assert shown is not None
    assert (shown.phase, shown.problem) == ("done", "")
    assert shown.plan is not None
    assert (shown.plan.missing, shown.plan.steps) == (["elephant"], [])
    assert shown.plan.note.startswith("I see no elephant here. There are: ")


def test_a_question_is_answered_in_words_or_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grounders: dict[Path | None, Grounder] = {tmp_path: Grounder(ConstantCost())}
    monkeypatch.setattr(attempt_module, "_grounders", grounders)

    def shown_after(answers: dict[int, str]) -> Shown:
        write_state(tmp_path, Shown(Asked(SCENARIO, "Go to the trailer.", answers)))
        plan(tmp_path, tmp_path)
        shown = read_state(tmp_path)
        assert shown is not None
        assert shown.plan is not None
        return shown

    first = shown_after({})
    assert first.plan is not None
    assert len(first.plan.options) > 1
    neither = shown_after({first.plan.node: "neither"})
    assert neither.plan is not None
    assert "none of these" in neither.plan.note
    unclear = shown_after({first.plan.node: "blue sky"})
    assert "doesn't pick out one" in unclear.problem
    assert unclear.plan is not None
    assert unclear.plan.options == first.plan.options
    assert not unclear.has_video


def test_what_the_forks_cannot_reach_is_said_and_nothing_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grounders: dict[Path | None, Grounder] = {tmp_path: Grounder(RandomCost(1))}
    monkeypatch.setattr(attempt_module, "_grounders", grounders)
    folder = tmp_path / "one"
    folder.mkdir()
    write_state(folder, Shown(Asked("yard_put_tires_on_truck", "Pick up the boxes.", insist=True)))
    actions = plan(folder, tmp_path)
    assert actions is not None
    film(folder, actions)
    shown = read_state(folder)
    assert shown is not None
    assert shown.plan is not None
    assert shown.plan.steps == ["pick up boxes-1"]
    assert shown.phase == "done"
    assert "can't be carried out" in shown.problem
    assert "over truck-1" in shown.problem
    assert not shown.has_video
    assert not (folder / "video.mp4").exists()


@pytest.mark.parametrize(("insist", "status"), [(True, 429), ("yes", 422)])
def test_insisting_is_yes_or_no(
    open_app: Flask, insist: Any, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(queue, "LONGEST_QUEUE", 0)
    response = Browser(open_app).send("POST", "/api/try", {**COMMAND, "insist": insist})
    assert response.status_code in (status, 400 if status == 422 else status)


def test_few_wait_at_a_time(open_app: Flask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "LONGEST_QUEUE", 0)
    response = Browser(open_app).send("POST", "/api/try", COMMAND)
    assert response.status_code == 429
    assert "Others are trying" in response.json["error"]


def test_a_process_that_dies_is_told_of_and_replaced(attempts: Attempts) -> None:
    for _ in range(2):
        before = set(multiprocessing.active_children())
        name = attempts.submit(Asked(SCENARIO, "Pick up the tires."))
        for process in set(multiprocessing.active_children()) - before:
            process.kill()
        end = time.monotonic() + 60
        while not (shown := attempts.state(name)) or not shown.problem:
            assert time.monotonic() < end
            time.sleep(0.05)
        assert shown.phase == "done"
        assert "Try again" in shown.problem


def test_attempts_are_forgotten_after_a_day(
    attempts: Attempts, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = attempts.folder / ("b" * 24)
    folder.mkdir(parents=True)
    monkeypatch.setattr(queue, "KEPT_S", -1.0)
    attempts._forget()
    assert not folder.exists()
