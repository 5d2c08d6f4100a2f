from __future__ import annotations

import json
from decimal import Decimal
from urllib.parse import urlsplit

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.store.models import Participation, Person
from tests.annotation_app.browser import described, rows_in
from tests.annotation_app.crowds.crowd_worker import BONUS, OPTIONS, PAID, Lab, take_part
from tests.annotation_app.crowds.prolific_stand_in import Prolific


def test_a_study_is_published_once(lab: Lab, prolific: Prolific) -> None:
    assert "4 assignments added, 4 in all" in lab.publish(*OPTIONS).output
    (study,) = prolific.studies.values()
    assert study["status"] == "ACTIVE"
    assert study["reward"] == 20
    assert "PROLIFIC_PID={{%PROLIFIC_PID%}}" in study["external_study_url"]
    assert "0 assignments added" in lab.publish(*OPTIONS).output
    assert "2 assignments added, 6 in all" in lab.publish(*OPTIONS[:-1], "6").output
    assert len(prolific.studies) == 1


def test_who_may_take_part(lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS, "--min-approval", "95")
    assert prolific.studies["study1"]["filters"] == [
        {"filter_id": "approval_rate", "selected_range": {"lower": 95, "upper": 100}}
    ]


def test_the_sandbox_publishes_nothing(lab: Lab, prolific: Prolific) -> None:
    result = lab.publish(*OPTIONS, "--sandbox")
    assert "https://app.prolific.com/t/study1" in result.output
    assert prolific.studies["study1"]["status"] == "UNPUBLISHED"
    assert prolific.test_runs == ["study1"]


def test_from_coming_in_to_being_paid(app: Flask, lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS)
    one = take_part(app, prolific, "5f0private", done=1)
    one.do("describe", described())
    (study,) = prolific.studies.values()
    (completion,) = study["completion_codes"]
    page = one.finish()
    assert f"https://app.prolific.com/submissions/complete?cc={completion['code']}" in page

    # The work is here, and Prolific has not been told.
    assert "sub1: not confirmed" in lab.reconcile().output
    prolific.submissions["sub1"]["status"] = "AWAITING REVIEW"
    told = json.loads(lab.collect(*BONUS, "--json").stdout)
    deeds = [(deed["what"], deed["amount"], deed["problem"]) for deed in told["deeds"]]
    assert deeds == [("approve", "0.20", ""), ("bonus", "0.50", "")]
    assert prolific.submissions["sub1"]["status"] == "APPROVED"
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID
    told = lab.reconcile("--json").stdout
    (finding,) = json.loads(told)["assignments"]
    assert (finding["assignment"], finding["state"]) == ("sub1", "settled")
    assert "private" not in told
    (person,) = rows_in(app, select(Person).where(Person.provider == "prolific"))
    (mine,) = rows_in(app, select(Participation))
    assert "private" not in f"{person.external_hash}{mine.assignment}{mine.outcome}"


def test_who_gives_back_is_paid_for_their_part(app: Flask, lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1", done=1)
    prolific.submissions["sub1"]["status"] = "RETURNED"
    for _ in range(2):
        assert lab.collect("--pay-partial").exit_code == 0
    assert prolific.orders == [("sub1", Decimal("0.10"))]


def test_a_rejection_says_why(app: Flask, lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1", done=0)
    prolific.submissions["sub1"]["status"] = "AWAITING REVIEW"
    short = lab.collect("--reject", "sub1", "no")
    assert "at least 100 characters" in short.output
    assert short.exit_code != 0
    assert lab.collect("--reject", "sub1", "There is no work. " * 8).exit_code == 0
    assert prolific.submissions["sub1"]["status"] == "REJECTED"


@pytest.mark.parametrize(
    "arguments", [{}, {"PROLIFIC_PID": "p"}, {"PROLIFIC_PID": "p", "SESSION_ID": "<b>"}]
)
def test_ids_must_be_there(
    app: Flask, lab: Lab, prolific: Prolific, arguments: dict[str, str]
) -> None:
    lab.publish(*OPTIONS)
    (study,) = prolific.studies.values()
    path = urlsplit(study["external_study_url"]).path
    assert app.test_client().get(path, query_string=arguments).status_code == 400


def test_a_wrong_token_is_named(app: Flask, lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PROLIFIC_TOKEN", "wrong")
    result = lab.publish(*OPTIONS)
    assert "check PROLIFIC_TOKEN" in str(result.exception)
    monkeypatch.delenv("PROLIFIC_TOKEN")
    assert "there is no token" in str(lab.publish(*OPTIONS).exception)
