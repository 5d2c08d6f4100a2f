"""A study with answers, disputes, people and drafts, which `make_screenshots` takes pictures of."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import open_instance
from annotation_app.crowds.participation import Offer, sign_offer
from annotation_app.people.account_links import invite
from annotation_app.people.api_tokens import make_token
from annotation_app.serving.factory import create_app
from annotation_app.serving.server import prepare
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Answer, Item
from annotation_app.studies.study_file import KnownCommand, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.study_setup.study_drafts import StudyDraft, keep_draft
from annotation_app.tasks.exported_groundings import shown_groundings
from annotation_app.tasks.task_registry import task_names, task_of
from annotation_app.trying.attempt_queue import attempts
from corpus_tools.importers.authored.bundled import open_corpus
from g3.annotation import Annotation
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import to_json
from tests.annotation_app.browser import Browser, described, installation_of
from tests.annotation_app.signing_in import Member, signed_in

SCENARIOS = (
    "hall_put_tires_in_storage", "court_take_tires_to_issue", "dock_put_boxes_on_trailer",
)  # fmt: skip
NAME = "forklift"
STUDY = StudyConfig(
    name=NAME,
    title="Commands for a robot forklift",
    watching="flagged",  # programs play no videos
    tasks={
        "describe": TaskConfig(answers=3, practice=False),
        "segment": TaskConfig(answers=2, practice=False),
        "ground": TaskConfig(answers=2, practice=False),
        "check": TaskConfig(practice=False),
        "rate": TaskConfig(answers=5, practice=False),
        "subtasks": TaskConfig(practice=False),
        "mark": TaskConfig(answers=2, practice=False),
    },
    known_commands=(KnownCommand("Wait here.", SCENARIOS[0], SCENARIOS[1]),),
)


MOST = {"segment": 4, "ground": 2}
"""Largest number of items that one person does: some are left for the pictures."""


@dataclass(frozen=True)
class Example:
    """An app that is filled.

    Parameters
    ----------
    app
        The app.
    cookies
        Cookies of several people's browsers; None of a stranger's.
    words
        Words in addresses: those of the app's rules, and some of `make_screenshots`.
    """

    app: Flask
    cookies: dict[str, str | None]
    words: dict[str, str]


@contextmanager
def example(folder: Path, films: Path) -> Iterator[Example]:
    """Fill an app in an empty folder.

    Parameters
    ----------
    films
        The videos of `SCENARIOS`, as ``ct render-videos`` makes them.
    """
    studies = folder / "studies"
    studies.mkdir()
    config = replace(open_instance(folder / "instance"), rate_limits=False, studies=studies)
    prepare(config)
    with opened(config.database) as engine:
        app = create_app(config, engine)
        with transaction(engine) as session:
            videos = rendered_videos(films, SCENARIOS)
            put = put_study(session, STUDY, videos, studies / f"{NAME}.yaml")
            study = put.id
        people = [Browser(app, study=NAME) for _ in range(5)]
        _answer(app, people)
        admin = signed_in(app, "ada", "admin")
        Member(app, "grace", "adjudicator")
        annotator = Member(app, "alan", "annotator")
        with transaction(engine) as session:
            token = invite(session, "annotator", actor="ada")
            make_token(session, "robot-lab", 30, actor="ada")
        draft = {
            "name": "arm",
            "title": "Commands for an arm",
            "robot": "robot arm",
            "videos": str(_clips(studies, films)),
            "tasks": {"describe": {}, "segment": {}, "rate": {}},
        }
        keep_draft(studies, StudyDraft("arm", studies / "arm.yaml"), draft)
        offer = sign_offer(config.secret_key, Offer(study, "rate", 5))
        crowd = app.test_client()
        crowd.get(f"/crowd/links/{offer}")
        clients = {"crowd": crowd, "admin": admin.client, "typist": people[0].client}
        clients["worker"] = Browser(app, study=NAME).client
        cookies = {name: client.get_cookie("session") for name, client in clients.items()}
        words = {
            "<study_name>": NAME,
            "<person_id>": annotator.person.id,
            "<provider_name>": "mturk",
            "<name>": "arm",
            "<int:number>": "0",
            "<page>": "describe",
            "<setup>": token,
            "<offer>": offer,
            **_disputed(app),
        }
        yield Example(app, {**{n: c.value for n, c in cookies.items() if c}, "": None}, words)
        with app.app_context():
            attempts().stop()


def _clips(studies: Path, films: Path) -> Path:
    folder = studies / "clips"
    folder.mkdir()
    for name in SCENARIOS:
        (folder / f"{name}.mp4").write_bytes((films / name / "video.mp4").read_bytes())
    return folder


def _answer(app: Flask, people: list[Browser]) -> None:
    """Have people do what comes, as the bundled corpus's annotators did, and two of them err."""
    known = [a for a in open_corpus("warehouse").annotations if a.source == "positive"]
    by_text = {(a.command.scenario, a.command.text): a for a in known}
    for number, person in enumerate(people[:2]):
        while (page := _taken(person, "describe")) is not None:
            scenario = _item(app, page).payload["video"]
            texts = [text for of, text in by_text if of == scenario]
            _send(person, page, described(texts[number]))
    for task, workers in (("segment", people[:2]), ("ground", people[2:4])):
        for person, errs in zip(workers, (False, True), strict=True):
            for number in range(MOST[task]):
                page = _taken(person, task)
                if page is not None:
                    item = _item(app, page)
                    about = by_text[item.payload["video"], item.payload["text"]]
                    _send(person, page, _body(app, item, about, errs=errs and number == 0))
    _rate(people)


def _rate(people: list[Browser]) -> None:
    """Have them rate, and one of them report a problem."""
    for person, rating in zip(people, (5, 4, 4, 2, 5), strict=True):
        for _ in range(4):
            page = _taken(person, "rate")
            if page is not None:
                _send(person, page, {"rating": rating})
    page = _taken(people[4], "check")
    if page is not None:
        note = {"uuid": str(uuid.uuid4()), "reason": "The video doesn't play."}
        for way in ("flag", "skip"):
            people[4].send("POST", f"/api/items/{page['item']}/{way}", note)


def _taken(person: Browser, task: str) -> dict[str, Any] | None:
    reply = person.lease(task, NAME)
    return reply.json if reply.status_code == 200 else None


def _send(person: Browser, page: dict[str, Any], body: dict[str, Any]) -> None:
    if "sdcs" not in body:
        body = body | person.watched(page)
    reply = person.answer(page["item"], body)
    if reply.status_code != 200:
        raise RuntimeError(reply.text)


def _item(app: Flask, page: dict[str, Any]) -> Item:
    with reading(installation_of(app).engine) as session:
        return session.get_one(Item, page["item"])


def _body(app: Flask, item: Item, about: Annotation, *, errs: bool) -> dict[str, Any]:
    if item.task == "segment":
        sdcs = about.sdcs
        if errs:  # somebody leaves out what the last clause says of a thing
            last = sdcs[-1]
            sdcs = (*sdcs[:-1], SDC(last.type, figure=last.figure, relation=last.relation))
        return {"sdcs": to_json(sdcs)}
    kept = {"groundings": shown_groundings(about), "trims": {}}
    installed = installation_of(app)
    sent_form = task_of("ground").sent_form
    assert sent_form is not None  # noqa: S101 - its answers name things
    with reading(installed.engine) as session:
        body = dict(sent_form(session, item, kept, installed.salt))
    if errs:  # and takes one thing for another
        groundings = list(body["groundings"].values())
        body["groundings"] = dict(zip(body["groundings"], groundings[::-1], strict=True))
    return body


def _disputed(app: Flask) -> dict[str, str]:
    with reading(installation_of(app).engine) as session:
        answers = list(session.scalars(select(Answer).order_by(Answer.id)))
        found = {f"<{answer.task} item>": answer.item_id for answer in reversed(answers)}
        found |= {f"<{answer.task} answer>": str(answer.id) for answer in reversed(answers)}
    return found


def tasks() -> tuple[str, ...]:
    """Return the names of the study's tasks."""
    return tuple(name for name in task_names() if name in STUDY.tasks)
