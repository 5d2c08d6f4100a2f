"""The page on which people try commands."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import flask
import msgspec
from flask import Blueprint, Response, send_file
from flask.typing import ResponseReturnValue

from annotation_app.core.problems import Refusal
from annotation_app.core.sent_text import clean_text
from annotation_app.pages.entrance import may_try
from annotation_app.people.browser_sessions import current_person, unknown
from annotation_app.store.database import reading
from annotation_app.store.installation import installation
from annotation_app.store.models import Person
from annotation_app.trying.attempt import TREE, VIDEO, Asked, Shown
from annotation_app.trying.attempt_queue import attempts
from annotation_app.trying.start_scene import PICTURE, scenario_state, scenarios, scene_of
from annotation_app.web.api import json_reply, read_request
from annotation_app.web.limits import limited, tries
from annotation_app.web.who_asks import sign_in_page

LONGEST_COMMAND = 500
FILES = {TREE: "image/svg+xml", VIDEO: "video/mp4"}

blueprint = Blueprint("trying", __name__)


Name: TypeAlias = Annotated[str, msgspec.Meta(max_length=200)]
Node: TypeAlias = Annotated[str, msgspec.Meta(pattern="^[0-9]{1,3}$")]


class TryRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command, the scenario to follow it in, and its clauses' meanings after a question.

    With `insist` it is done with what there is, where something is missing. No video is made any
    more of the attempt that it `leaves`.
    """

    scenario: Name
    text: Annotated[str, msgspec.Meta(max_length=LONGEST_COMMAND)]
    answers: Annotated[dict[Node, Name], msgspec.Meta(max_length=20)] = {}
    insist: bool = False
    leaves: Name = ""


@blueprint.get("/try")
def page() -> ResponseReturnValue:
    """Show the page for typing a command."""
    person = _visitor()
    if not may_try(person):
        return sign_in_page()
    return flask.render_template(
        "try.html", person=person, scenarios=sorted(scenarios()), longest=LONGEST_COMMAND
    )


@blueprint.post("/api/try")
@limited(tries)
def try_() -> ResponseReturnValue:
    """Try a command."""
    _require()
    request = read_request(TryRequest)
    text = clean_text(request.text)
    if not any(character.isalnum() for character in text):
        raise Refusal(422, "Type what the robot is to do.")
    if request.scenario not in scenarios():
        raise Refusal(422, "There is no such scenario. Choose another one.")
    answers = {int(node): thing for node, thing in request.answers.items()}
    attempts().leave(request.leaves)
    name = attempts().submit(Asked(request.scenario, text, answers, request.insist))
    return flask.jsonify({"id": name})


@blueprint.get("/api/try/<name>")
def tried(name: str) -> Response:
    """Return the progress of an attempt."""
    return json_reply(_found(name))


@blueprint.get("/api/try/scenes/<scenario>")
def scene(scenario: str) -> Response:
    """Return a scenario's world, which people see before they type; 202 until it has a picture."""
    _require_scenario(scenario)
    found = attempts().scene(scenario)
    if found is None:
        return json_reply(scene_of(scenario_state(scenario), None), 202)
    return json_reply(found)


@blueprint.get("/try/scenes/<scenario>")
def picture(scenario: str) -> Response:
    """Return the picture of a scenario's world."""
    _require_scenario(scenario)
    path = attempts().scene_folder(scenario) / PICTURE
    if not path.is_file():
        raise Refusal(404, "There is no picture.")
    return send_file(path, mimetype="image/png", conditional=True, max_age=3600)


def _require_scenario(scenario: str) -> None:
    _require()
    if scenario not in scenarios():
        raise Refusal(404, "There is no such scenario.")


@blueprint.get("/try/<name>/<file>")
def file(name: str, file: str) -> Response:
    """Return a file that an attempt has made."""
    _found(name)
    path = attempts().folder / name / file
    if file not in FILES or not path.is_file():
        raise Refusal(404, "There is no such file.")
    return send_file(path, mimetype=FILES[file], conditional=True, max_age=3600)


def _visitor() -> Person | None:
    with reading(installation().engine) as session:
        return current_person(session)


def _require() -> None:
    person = _visitor()
    if may_try(person):
        return
    if person is None:
        raise unknown("annotator")
    raise Refusal(403, "This is for people with a login.")


def _found(name: str) -> Shown:
    _require()
    found = attempts().state(name)
    if found is None:
        raise Refusal(404, "There is no such attempt; it may have been too long ago.")
    return found
