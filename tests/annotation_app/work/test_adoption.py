"""From a video to a corpus that trains, through the JSON interface."""

from __future__ import annotations

import pytest
from flask import Flask

from annotation_app.export.corpus_export import export_corpus
from annotation_app.store.database import reading
from annotation_app.work.handing_out import find_study
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, described, engine_of

TREE = "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the tires), r = by, l = OBJ(f = the truck)))"
SDCS = to_json(parse_brackets(TREE, command=COMMAND))

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


def grounded(page: dict, *, cant_tell: tuple[int, ...] = ()) -> dict:
    """Each clause is grounded to the first object of the map."""
    first = page["payload"]["map"]["objects"][0]["id"]
    groundings = {
        str(c["node"]): {"objects": [], "cant_tell": True}
        if c["node"] in cant_tell
        else {"objects": [first], "places": []}
        for c in page["payload"]["clauses"]
        if c["type"] in ("OBJECT", "PLACE")
    }
    return {"groundings": groundings, "trims": {}}


def test_answers_become_a_corpus(app: Flask) -> None:
    author, other = Browser(app), Browser(app)
    assert author.do("describe", described())["state"] == "accepted"

    page = author.take("segment")
    assert page["payload"]["command"] == COMMAND
    assert page["payload"]["words"][0] == {"start": 0, "text": "Pick"}
    author.answer(page["item"], {"sdcs": SDCS})

    page = author.take("ground")
    phrases = [(c["type"], c["phrase"]) for c in page["payload"]["clauses"]]
    assert phrases == [
        ("OBJECT", "the tires"),
        ("OBJECT", "the truck"),
        ("OBJECT", "the tires by the truck"),
        ("EVENT", "Pick up the tires by the truck"),
    ]
    answer = grounded(page, cant_tell=(4,))
    answer["trims"] = {"0": [0.2, 0.4]}
    assert author.answer(page["item"], answer).status_code == 200

    page = author.take("check")
    clauses = page["payload"]["clauses"]
    assert {c["node"] for c in clauses} == {0, 2, 3}
    verdicts = {str(c["node"]): c["node"] == 3 for c in clauses}
    assert author.answer(page["item"], {"verdicts": verdicts}).status_code == 200

    assert author.lease("rate").json["reason"] in ("done", "nothing to do")
    ratings = [other.do("rate", {"rating": 5, "watched_s": 1.0}) for _ in range(3)]
    assert all(r["state"] == "accepted" for r in ratings)

    with reading(engine_of(app)) as session:
        corpus = export_corpus(session, find_study(session, "tests"))
    positive, random = corpus.annotations
    assert positive.source == "positive"
    assert positive.correct == (True, None, True, True, None)
    agent = positive.groundings[0][0]
    assert agent.trajectory.t[[0, -1]].tolist() == [
        positive.context.agent.trajectory.t[0] + 0.2,
        positive.context.agent.trajectory.t[0] + 0.4,
    ]
    assert positive.groundings[2][0] in positive.context.objects
    assert random.source == "random"
    assert random.correct == (False, None, False, True, None)
    assert random.groundings[0][0].trajectory != agent.trajectory
    assert {j.rating for j in corpus.judgments} == {"SA"}
    assert {j.command for j in corpus.judgments} == {COMMAND}
    clocks = sorted(c.agent.trajectory.t[0] for c in corpus.contexts.values())
    assert clocks == [0.0, 10_000.0, 20_000.0]
