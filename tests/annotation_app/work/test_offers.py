"""What a program suggests, who sees it, and what is kept of that with the answers."""

from __future__ import annotations

import csv
import io
from functools import partial

import pytest
from flask import Flask
from msgspec.structs import replace
from sqlalchemy import update

from annotation_app.dashboard.consensus import agreement
from annotation_app.dashboard.workers import workers
from annotation_app.store.database import reading
from annotation_app.store.models import Answer
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.work.answer_flags import UNREAD, WATCHED_LONGER, answer_flags
from annotation_app.work.handing_out import find_study
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, engine_of, execute, exported
from tests.annotation_app.conftest import study_of
from tests.annotation_app.work import suggesting
from tests.annotation_app.work.suggesting import of, rows

SUGGESTED = to_json(
    parse_brackets(
        "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the tires), r = by, l = OBJ(f = the truck)))",
        command=COMMAND,
    )
)
OTHER = to_json(parse_brackets("EVENT(r = Pick up, l = OBJ(f = the tires))", command=COMMAND))


@pytest.fixture
def study() -> StudyConfig:
    return study_of(segment=TaskConfig(answers=3, practice=False))


put = partial(suggesting.put, suggestion=SUGGESTED)
"""Commands with a suggestion of their own, as an imported corpus has them."""


def test_answers_tell_what_became_of_the_suggestion(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    for sent in (SUGGESTED, OTHER):
        person = Browser(app)
        page = person.take("segment")
        assert page["payload"]["suggestion"] == SUGGESTED
        assert person.answer(page["item"], {"sdcs": sent}).status_code == 200
    # of the suggestion's four named clauses one is like one of the two that were sent: 2 / (4 + 2)
    assert [of(row) for row in rows(app)] == [("shown", True, 1.0), ("shown", False, 0.333)]
    first, second = csv.DictReader(io.StringIO(exported(app, "csv").decode()))
    assert (first["unchanged"], first["flags"]) == (
        "True", "unchanged suggestion, sent before it could be read"
    )  # fmt: skip
    assert (second["unchanged"], second["likeness"], second["flags"]) == ("False", "0.333", "")


def test_a_study_can_do_without_suggestions(app: Flask, study: StudyConfig) -> None:
    put(app, study, "off")
    person = Browser(app)
    page = person.take("segment")
    assert page["payload"]["suggestion"] is None
    person.answer(page["item"], {"sdcs": SUGGESTED})
    assert [of(row) for row in rows(app)] == [("off", None, None)]


@pytest.mark.parametrize(("least", "state"), [(0.0, "shown"), (1.0, "unsure")])
def test_suggestions_are_shown_from_a_probability_on(
    app: Flask, study: StudyConfig, least: float, state: str
) -> None:
    config = replace(study.tasks["segment"], suggestions_from=least)
    suggesting.put(app, replace(study, tasks={"segment": config}), "on")
    person = Browser(app)
    page = person.take("segment")
    assert (page["payload"]["suggestion"] is not None) == (state == "shown")
    person.answer(page["item"], {"sdcs": OTHER})
    ((found, _, likeness),) = map(of, rows(app))
    assert found == state
    assert likeness < 1, "also where nobody saw it"
    reader = Browser(app, "adjudicator")
    (use,) = reader.client.get("/api/dashboard/studies/tests/suggestions").json["data"]
    counts = {"shown": (1, 1, 0), "unsure": (0, 0, 1)}[state]
    assert (use["shown"], use["changed"], use["unsure"]) == counts
    overview = reader.client.get("/dashboard/tests").text
    assert ("people changed 1 of the 1 suggestions" in overview) == (state == "shown")


def test_a_sure_suggestion_is_shown_without_a_word_of_the_study(
    app: Flask, study: StudyConfig
) -> None:
    suggesting.put(app, study, "on", text="Put the pallet on the truck")
    assert Browser(app).take("segment")["payload"]["suggestion"]


def test_half_of_the_items_have_theirs_for_everybody(app: Flask, study: StudyConfig) -> None:
    put(app, study, "half", items=40)
    seen: list[dict[str, bool]] = []
    for person in (Browser(app), Browser(app)):
        mine = {}
        for _ in range(40):
            page = person.take("segment")
            mine[page["item"]] = page["payload"]["suggestion"] is not None
            person.answer(page["item"], {"sdcs": OTHER})
        seen.append(mine)
    assert seen[0] == seen[1]
    assert 10 <= sum(seen[0].values()) <= 30
    states = {row["item"]: row["suggestion"] for row in rows(app)}
    assert states == {item: "shown" if was else "withheld" for item, was in seen[0].items()}
    assert {row["likeness"] for row in rows(app)} == {0.333}, "also where nobody saw it"


def test_what_somebody_saw_stays_though_the_file_changes(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    person = Browser(app)
    page = person.take("segment")
    put(app, study, "off", items=0)
    again = person.client.get(f"/api/items/{page['item']}").json
    assert again["payload"]["suggestion"] == SUGGESTED
    person.answer(page["item"], {"sdcs": SUGGESTED})
    assert [of(row) for row in rows(app)] == [("shown", True, 1.0)]


def test_agreement_is_told_apart(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    for sent in (SUGGESTED, SUGGESTED, OTHER):
        Browser(app).do("segment", {"sdcs": sent})
    with reading(engine_of(app)) as session:
        found = agreement(session, find_study(session, "tests").id)
    trees = {a.answers: (a.value, a.units) for a in found if a.measure.startswith("tree")}
    assert trees["all"] == (None, 3)  # too few items for a figure
    assert trees["without untouched suggestions"] == (None, 0)
    assert trees["no suggestion seen"] == (None, 0)


def test_answers_from_before_have_no_provenance(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    Browser(app).do("segment", {"sdcs": SUGGESTED})
    execute(app, update(Answer).values(provenance=None))
    assert [of(row) for row in rows(app)] == [("", None, None)]
    with reading(engine_of(app)) as session:
        agreement(session, find_study(session, "tests").id)


def test_people_who_send_unread_suggestions_are_flagged(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on", items=3)
    hasty, slow = Browser(app), Browser(app)
    for person in (hasty, slow):
        for _ in range(3):
            person.do("segment", {"sdcs": SUGGESTED})
    execute(app, update(Answer).where(Answer.person_id == slow.person.id).values(seconds=30.0))
    with reading(engine_of(app)) as session:
        found = workers(session, find_study(session, "tests").id)
    reasons = {worker.person_id: worker.reasons for worker in found}
    assert reasons[slow.person.id] == ()
    assert reasons[hasty.person.id] == (f"{UNREAD}: 3 times",)


@pytest.mark.parametrize(
    ("watched", "seconds", "flags"),
    [
        ({"watched_s": 22.8}, 7.7, [WATCHED_LONGER]),
        ({"watched_s": 9.6}, 7.7, []),
        ({"watched_s": 22.8}, None, []),
        ({"watched_s": 7.0}, 60.0, []),
        ({"watched_s": 22.8, "speed": 3}, 7.7, []),
        ({"watched_s": 22.8, "speed": 2}, 7.7, [WATCHED_LONGER]),
        ({"watched_s": 54.0, "speed": 4}, 13.0, []),
        ({"watched_s": 54.0, "speed": 4}, 12.5, [WATCHED_LONGER]),
    ],
)
def test_nobody_can_watch_longer_than_the_item_was_there(
    watched: dict[str, float], seconds: float | None, flags: list[str]
) -> None:
    assert list(answer_flags({}, watched, None, seconds)) == flags
