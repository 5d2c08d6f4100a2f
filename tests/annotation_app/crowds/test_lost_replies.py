"""Prolific's answers are lost: nothing is ordered twice, and somebody is asked."""

from __future__ import annotations

import json
import re
from decimal import Decimal
from typing import get_args

import httpx
import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.crowds import prolific_client
from annotation_app.crowds.platform import Bonus, LostReplyError, PlatformError, Submission
from annotation_app.people.participants import subject_of
from annotation_app.store.models import AuditEntry, LedgerEntry, Person
from tests.annotation_app.browser import described, rows_in
from tests.annotation_app.crowds.crowd_worker import BONUS, OPTIONS, PAID, Lab, take_part
from tests.annotation_app.crowds.prolific_stand_in import Prolific
from tests.annotation_app.crowds.stand_ins import LATE_S, Loss

CARRIED_OUT: tuple[Loss, ...] = ("unavailable", "cut", "slow")


@pytest.fixture(autouse=True)
def impatient(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers that are to come late come too late; others have all their time."""
    call = getattr(request.node, "callspec", None)
    if call is not None and call.params.get("loss") == "slow":
        monkeypatch.setattr(prolific_client, "TIMEOUT_S", LATE_S / 2)


@pytest.fixture
def sent(app: Flask, lab: Lab, prolific: Prolific) -> str:
    """An assignment that was approved."""
    assert lab.publish(*OPTIONS).exit_code == 0
    take_part(app, prolific, "5f0private")
    assert lab.collect().exit_code == 0
    return "sub1"


def entries(app: Flask) -> list[LedgerEntry]:
    return rows_in(app, select(LedgerEntry).order_by(LedgerEntry.id))


def states(app: Flask, what: str) -> list[str]:
    return [entry.state for entry in entries(app) if entry.what == what]


def doubtful_id(app: Flask) -> str:
    (found,) = (entry.id for entry in entries(app) if entry.state == "in doubt")
    return str(found)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
@pytest.mark.parametrize("loss", CARRIED_OUT)
def test_a_bonus_whose_answer_was_lost_is_paid_once(
    app: Flask, lab: Lab, prolific: Prolific, sent: str, loss: Loss
) -> None:
    prolific.losses["pay"] = loss
    first = lab.collect(*BONUS)
    assert "1 call is in doubt" in str(first.exception)
    assert "--confirm-paid ID" in str(first.exception)
    (person,) = rows_in(app, select(Person).where(Person.provider == "prolific"))
    shown = rf"in doubt: {doubtful_id(app)}: bonus 0.50, assignment sub1, "
    assert re.search(rf"{shown}person {subject_of(person)}, \d{{4}}-.*: Prolific: ", first.output)
    assert "private" not in first.output

    # Prolific pays in some minutes, so that looking at once says nothing.
    for _ in range(2):
        again = lab.collect(*BONUS)
        assert "1 call is in doubt" in str(again.exception)
    assert lab.collect("--dry-run").exception is not None
    assert prolific.orders == PAID
    prolific.let_minutes_pass()
    later = lab.collect(*BONUS)
    assert later.exit_code == 0, later.exception
    assert re.search(r"bonus 0.50: sub1 payment \d+ was paid", later.output)
    assert states(app, "bonus") == ["done"]
    assert prolific.orders == PAID


def test_what_never_came_is_paid_again_when_somebody_says_so(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    prolific.losses["pay"] = "never came"
    lab.collect(*BONUS)
    prolific.let_minutes_pass()
    assert "1 call is in doubt" in str(lab.collect(*BONUS).exception)
    assert prolific.orders == []
    decided = lab.collect("--pay-again", doubtful_id(app))
    assert decided.exit_code == 0, decided.exception
    assert "bonus 0.50: sub1 paid again" in decided.output
    assert prolific.orders == PAID
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID
    assert decisions(app) == ["paid again"]


def test_paying_again_can_be_in_doubt_too(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    prolific.losses["pay"] = "never came"
    lab.collect(*BONUS)
    prolific.losses["pay"] = "cut"
    assert "1 call is in doubt" in str(lab.collect("--pay-again", doubtful_id(app)).exception)
    prolific.let_minutes_pass()
    # Between looking and deciding it has arrived.
    late = lab.collect("--pay-again", doubtful_id(app))
    assert "carried out before" in late.output
    assert late.exception is not None
    assert lab.collect().exit_code == 0
    assert prolific.orders == PAID


def test_what_somebody_has_seen_is_confirmed(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    prolific.losses["pay"] = "cut"
    lab.collect(*BONUS)
    confirmed = lab.collect("--confirm-paid", doubtful_id(app), "--json")
    assert confirmed.exit_code == 0, confirmed.exception
    assert json.loads(confirmed.stdout)["in_doubt"] == []
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID
    assert decisions(app) == ["confirmed as paid"]


def test_decisions_are_about_what_is_in_doubt(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    lab.collect(*BONUS)
    prolific.let_minutes_pass()
    lab.collect()
    for option in ("--confirm-paid", "--pay-again"):
        assert "has no entry 99" in str(lab.collect(option, "99").exception)
        (done,) = (entry.id for entry in entries(app) if entry.what == "bonus")
        assert f"entry {done} is not in doubt but done" in str(
            lab.collect(option, str(done)).exception
        )
        assert lab.collect("--dry-run", option, str(done)).exit_code == 2
    both = lab.collect("--confirm-paid", str(done), "--pay-again", str(done))
    assert "can't be confirmed and paid again" in str(both.exception)
    assert prolific.orders == PAID
    assert decisions(app) == []


def test_a_refused_bonus_can_be_given_again(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    for operation in ("set up", "pay"):
        prolific.losses[operation] = "too many"
        assert "1 of 1 could not be done" in str(lab.collect(*BONUS).exception)
        assert states(app, "bonus") == ["refused"]
    # Setting a bonus up costs nothing, so that nothing is in doubt.
    prolific.losses["set up"] = "cut"
    assert "nothing had been ordered yet" in lab.collect(*BONUS).output
    assert states(app, "bonus") == ["refused"]
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID


def test_equal_amounts_are_never_under_way_together(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    other = ("--bonus", "sub1", "0.50", "For speed")
    prolific.losses["pay"] = "cut"
    result = lab.collect(*BONUS, *other)
    assert "of the same amount by the same assignment is in doubt" in result.output
    assert len(prolific.orders) == 1
    prolific.let_minutes_pass()
    assert lab.collect(*other).exit_code == 0
    prolific.losses["pay"] = "never came"
    # The second isn't listed yet, nor is the third: it is not taken for the second.
    lab.collect("--bonus", "sub1", "0.50", "For the long command")
    prolific.let_minutes_pass()
    assert "1 call is in doubt" in str(lab.collect().exception)
    assert lab.collect("--pay-again", doubtful_id(app)).exit_code == 0
    assert prolific.orders == PAID * 3


@pytest.mark.parametrize("loss", [*CARRIED_OUT, "never came"])
def test_an_approval_is_as_prolific_says(
    app: Flask, lab: Lab, prolific: Prolific, sent: str, loss: Loss
) -> None:
    take_part(app, prolific, "p2")
    prolific.losses["approve"] = loss
    assert "1 call is in doubt" in str(lab.collect().exception)
    assert lab.collect().exit_code == 0
    assert prolific.submissions["sub2"]["status"] == "APPROVED"
    assert states(app, "approve") == ["done", "done"]
    # It is done again only where Prolific has said that it was not done.
    assert prolific.calls.count("approve") == (3 if loss == "never came" else 2)


def test_who_was_to_be_rejected_is_not_approved_by_itself(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    take_part(app, prolific, "p2")
    prolific.losses["reject"] = "never came"
    assert lab.collect("--reject", "sub2", "Typed at random. " * 8).exception is not None
    assert "held: sub2 it was to be rejected" in lab.collect().output
    assert prolific.submissions["sub2"]["status"] == "AWAITING REVIEW"
    assert lab.collect("--approve", "sub2").exit_code == 0
    assert prolific.submissions["sub2"]["status"] == "APPROVED"


def test_who_was_paid_in_part_is_not_paid_wholly_by_itself(
    app: Flask, lab: Lab, prolific: Prolific, sent: str
) -> None:
    two = take_part(app, prolific, "p2", done=1)
    prolific.submissions["sub2"]["status"] = "RETURNED"
    prolific.losses["pay"] = "cut"
    lab.collect("--pay-partial")
    lab.collect("--pay-partial")
    assert prolific.orders == [("sub2", Decimal("0.10"))]
    two.do("describe", described("Go on."))
    prolific.submissions["sub2"]["status"] = "AWAITING REVIEW"
    assert "held: sub2 a part of it was paid before" in lab.collect().output
    assert prolific.submissions["sub2"]["status"] == "AWAITING REVIEW"


@pytest.mark.parametrize("loss", CARRIED_OUT)
def test_a_study_is_made_once_though_lists_show_it_late(
    app: Flask, lab: Lab, prolific: Prolific, loss: Loss
) -> None:
    prolific.unlisted, prolific.losses = 2, {"make study": loss}
    assert "in doubt" in str(lab.publish(*OPTIONS).exception)
    number = doubtful_id(app)
    assert f"--publish-again {number}" in str(lab.publish(*OPTIONS).exception)
    assert "whether some work was offered is in doubt" in str(lab.collect().exception)
    assert "--publish-again" in str(lab.collect("--pay-again", number).exception)
    # Lists show it now, so that the decision comes too late.
    assert lab.publish(*OPTIONS, "--publish-again", number).exit_code == 0
    (study,) = prolific.studies.values()
    assert study["status"] == "ACTIVE"
    assert lab.collect().exit_code == 0


def test_a_study_that_never_came_is_made_when_somebody_says_so(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    prolific.losses = {"make study": "never came"}
    for _ in range(3):
        assert lab.publish(*OPTIONS).exception is not None
    assert prolific.studies == {}
    assert "no offer 99 in doubt" in str(lab.publish(*OPTIONS, "--publish-again", "99").exception)
    assert lab.publish(*OPTIONS, "--publish-again", doubtful_id(app)).exit_code == 0
    assert len(prolific.studies) == 1
    assert decisions(app) == ["to be offered again"]


def test_a_new_study_is_known_before_lists_show_it(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    prolific.unlisted = 3
    assert lab.publish(*OPTIONS).exit_code == 0
    assert "0 assignments added, 4 in all" in lab.publish(*OPTIONS).output
    prolific.studies.clear()  # somebody deletes it
    assert "4 assignments added, 4 in all" in lab.publish(*OPTIONS).output


@pytest.mark.parametrize("operation", ["publish", "add places", "test-study"])
@pytest.mark.parametrize("loss", [*CARRIED_OUT, "never came"])
def test_changes_of_a_study_are_looked_at_and_made(
    app: Flask, lab: Lab, prolific: Prolific, operation: str, loss: Loss
) -> None:
    sandbox = ["--sandbox"] if operation == "test-study" else []
    if operation != "publish":
        assert lab.publish(*OPTIONS, *sandbox).exit_code == 0
    prolific.losses = {operation: loss}
    more = (*OPTIONS[:-1], "6", *sandbox)
    assert "in doubt" in str(lab.publish(*more).exception)
    assert lab.publish(*more).exit_code == 0
    (study,) = prolific.studies.values()
    assert study["total_available_places"] == 6
    assert study["status"] == ("UNPUBLISHED" if sandbox else "ACTIVE")
    assert "in doubt" not in states(app, "publish")


def test_the_ledger_is_shown(app: Flask, lab: Lab, prolific: Prolific, sent: str) -> None:
    prolific.losses["pay"] = "cut"
    lab.collect(*BONUS, "--bonus", "sub1", "0.20", "For speed")
    shown = lab.reconcile().output
    for line in ("1 approve done, 0.20 in all", "1 bonus in doubt, 0.50", "1 bonus ordered, 0.20"):
        assert line in shown
    told = json.loads(lab.reconcile("--json").stdout)["ledger"]
    assert [(e["what"], e["state"], e["amount"]) for e in told[-3:]] == [
        ("approve", "done", "0.20"),
        ("bonus", "in doubt", "0.50"),
        ("bonus", "ordered", "0.20"),
    ]
    assert {e["assignment"] for e in told[-3:]} == {"sub1"}
    assert "private" not in f"{shown}{told}"


REQUEST = httpx.Request("POST", "https://prolific.test")
UNSENT = (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout, httpx.ProxyError)
SENT = (httpx.ReadTimeout, httpx.WriteTimeout, httpx.ReadError, httpx.RemoteProtocolError)


@pytest.mark.parametrize("error", [*UNSENT, *SENT])
def test_what_the_network_says_of_an_order(error: type[httpx.RequestError]) -> None:
    def fail(request: httpx.Request) -> httpx.Response:
        raise error("no", request=request)

    raised = order(fail)
    assert isinstance(raised, LostReplyError) == (error in SENT)


@pytest.mark.parametrize(
    ("reply", "is_lost"),
    [
        *((httpx.Response(status), False) for status in (301, 400, 401, 404, 409, 429)),
        *((httpx.Response(status), True) for status in (408, 500, 502, 503, 504, 520)),
        (httpx.Response(200, text="<html>Sign in to the hotel's network"), True),
    ],
)
def test_what_an_answer_says_of_an_order(reply: httpx.Response, is_lost: bool) -> None:
    assert isinstance(order(lambda _: reply), LostReplyError) == is_lost


def order(answer: object) -> PlatformError:
    transport = httpx.MockTransport(answer)  # type: ignore[arg-type]
    with httpx.Client(base_url="https://prolific.test", transport=transport) as client:
        platform = prolific_client.Prolific(client, project="", sandbox=False)
        submission = Submission("sub1", "p1", "study1", "approved")
        bonus = Bonus("key", Decimal("0.50"), "For care")
        with pytest.raises(PlatformError) as raised:
            platform.pay(submission, bonus, "bulk1")
        with pytest.raises(PlatformError) as looked:
            platform.paid(submission)
    # What only looks is never in doubt.
    assert not isinstance(looked.value, LostReplyError)
    return raised.value


def decisions(app: Flask) -> list[str]:
    rows = rows_in(app, select(AuditEntry).order_by(AuditEntry.id))
    return [row.action for row in rows if "entry" in row.details]


def test_every_loss_is_tried() -> None:
    assert {*CARRIED_OUT, "never came", "too many"} == set(get_args(Loss))
