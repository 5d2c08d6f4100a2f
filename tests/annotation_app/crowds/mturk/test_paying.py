from __future__ import annotations

import json
import re
from pathlib import Path

import msgspec
import pytest
from flask import Flask
from sqlalchemy import update

from annotation_app.core.config import Config
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, transaction
from annotation_app.store.models import LedgerEntry
from annotation_app.studies.study_file import Payment
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from tests.annotation_app.browser import described, engine_of, execute
from tests.annotation_app.crowds.conftest import PAID
from tests.annotation_app.crowds.crowd_worker import CrowdWorker, Lab, external_url
from tests.annotation_app.crowds.mturk.turkers import (
    DAY_S,
    grow_old,
    ledger,
    participations,
    work,
    worker,
)
from tests.annotation_app.crowds.stand_ins import Loss, MechanicalTurk


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_from_accepting_to_being_paid(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    one = worker(app, address, mturk)
    one.do("describe", described())
    assert "1 of 2" in one.finish()
    one.do("describe", described("Wait."))
    # The next item gives way to the page that tells the platform.
    assert one.client.get("/s/tests/describe").headers["Location"] == "/crowd/finish"
    (mine,) = participations(app)
    assert mine.received_at is not None
    assert mine.confirmed_at is None

    one.submit(mturk)
    result = lab.collect()
    assert result.exit_code == 0, result.output
    assert f"approve 0.20: {mine.assignment}" in result.output
    assert mturk.status(mine.assignment) == "Approved"
    (mine,) = participations(app)
    assert mine.confirmed_at is not None
    assert ("approve", mine.assignment, "done") in ledger(app)

    again = lab.collect()
    assert again.exit_code == 0
    assert "1 settled" in again.output
    assert mturk.calls.count("ApproveAssignment") == 1


def test_one_that_never_reached_the_platform_stops_no_other(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    """psiTurk #390."""
    lost, good, refused = (worker(app, address, mturk, f"W{i}") for i in range(3))
    for one in (lost, good, refused):
        work(one)
        one.finish()
    good.submit(mturk)
    refused.submit(mturk)
    first, second, third = (p.assignment for p in participations(app))
    # Between the platform's list and the approval somebody rejects one by hand.
    approve = mturk.ApproveAssignment

    def rejected_meanwhile(request: dict[str, str]) -> tuple[int, dict[str, str]]:
        if request["AssignmentId"] == third:
            mturk.assignments[third]["AssignmentStatus"] = "Rejected"
        return approve(request)

    mturk.ApproveAssignment = rejected_meanwhile  # type: ignore[method-assign]
    result = lab.collect()
    assert result.exit_code != 0
    assert "1 of 2 could not be done" in str(result.exception)
    assert f"approve 0.20: {third} Mechanical Turk: " in result.output
    assert f"{first}: not confirmed (2 of 2, 0.20 due)" in result.output
    assert mturk.status(second) == "Approved"
    states = [(p.received_at is not None, p.confirmed_at is not None) for p in participations(app)]
    assert states == [(True, False), (True, True), (True, True)]

    # It arrives after all.
    lost.submit(mturk)
    assert lab.collect().exit_code == 0
    assert mturk.status(first) == "Approved"


def test_the_service_takes_its_open_hits_up_again(
    app: Flask, config: Config, lab: Lab, address: str, mturk: MechanicalTurk, videos: Path
) -> None:
    """Mephisto #685: nothing about HITs is lost with a process."""
    arguments = mturk.accept("W1")
    one = CrowdWorker(app, address, arguments)
    one.do("describe", described())
    cookies = one.client.get_cookie("session")
    engine_of(app).dispose()

    engine = open_database(config.database)
    restarted = create_app(config, engine)
    again = CrowdWorker(restarted, address, arguments)
    assert cookies is not None
    assert "1 of 2" in again.finish()
    again.do("describe", described("Wait."))
    again.submit(mturk)
    newcomer = worker(restarted, address, mturk, "W2")
    work(newcomer)
    newcomer.submit(mturk)
    assert lab.publish("--task", "describe", "--items", "2", "--people", "5").exit_code == 0
    assert len(mturk.hits) == 1
    assert lab.collect().exit_code == 0
    assert {mturk.status(p.assignment) for p in participations(restarted)} == {"Approved"}
    engine.dispose()


def test_what_was_left_incomplete_is_paid_in_part_and_once(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    """Mephisto #642: half of the assignments left incomplete."""
    gave_up = worker(app, address, mturk, "W1")
    work(gave_up, 1)
    stranger = worker(app, address, mturk, "W2")
    work(stranger, 1)
    given_up, of_stranger = (p.assignment for p in participations(app))

    # They may still go on.
    assert "partial" not in lab.collect("--pay-partial").output
    assert f"{given_up}: working (1 of 2, 0.10 due)" in lab.reconcile().output

    grow_old(app)
    back = worker(app, address, mturk, "W1")
    work(back)
    back.submit(mturk)
    result = lab.collect("--pay-partial")
    # The platform can pay those only who have sent something in.
    assert f"partial payment 0.10: {given_up}" in result.output
    assert f"partial payment 0.10: {of_stranger} the platform has nothing" in result.output
    assert result.exit_code != 0
    (bonus,) = mturk.bonuses
    assert (bonus["BonusAmount"], bonus["WorkerId"]) == ("0.10", "W1")
    assert lab.collect("--pay-partial").exit_code != 0
    assert len(mturk.bonuses) == 1


def a_bonus(assignment: str) -> tuple[str, ...]:
    return ("--bonus", assignment, "0.50", "For care")


def test_bonuses_are_paid_once(lab: Lab, sent: str, mturk: MechanicalTurk) -> None:
    bonus = a_bonus(sent)
    mturk.losses = {"SendBonus": "unavailable"}
    for _ in range(3):
        result = lab.collect(*bonus)
        assert result.exit_code == 0, result.output
    assert [b["BonusAmount"] for b in mturk.bonuses] == ["0.50"]
    assert lab.collect("--bonus", sent, "0.10", "For more").exit_code == 0
    assert len(mturk.bonuses) == 2


def test_flagged_workers_wait_and_get_no_bonus(
    app: Flask, config: Config, lab: Lab, mturk: MechanicalTurk, videos: Path
) -> None:
    with transaction(engine_of(app)) as session:
        paid = msgspec.structs.replace(PAID, payment=Payment(0.10, bonus=0.25))
        put_study(session, paid, rendered_videos(videos))
    lab.publish("--task", "describe", "--items", "3", "--people", "2")
    (hit,) = mturk.hits.values()
    good, copier = (worker(app, external_url(hit["Question"]), mturk, f"W{i}") for i in range(2))
    for number in range(3):
        good.do("describe", described(f"Command {number}."))
        copier.do("describe", described("go"))
    good.submit(mturk)
    copier.submit(mturk)
    first, second = (p.assignment for p in participations(app))
    result = lab.collect("--hold-flagged", "--pay-bonus")
    assert result.exit_code == 0, result.output
    assert f"held: {second}" in result.output
    assert [mturk.status(a) for a in (first, second)] == ["Approved", "Submitted"]
    lab.collect("--approve", second, "--pay-bonus")
    assert mturk.status(second) == "Approved"
    assert [(b["AssignmentId"], b["BonusAmount"]) for b in mturk.bonuses] == [(first, "0.25")]


def test_a_study_without_a_bonus_pays_none(app: Flask, lab: Lab, address: str) -> None:
    assert "the study has no bonus" in str(lab.collect("--pay-bonus").exception)


@pytest.mark.parametrize("amount", ["nan", "-1", "much", "1e9", "0"])
def test_amounts_are_money(app: Flask, lab: Lab, address: str, amount: str) -> None:
    result = lab.collect("--bonus", "A1", amount, "why")
    assert "no amount of money" in str(result.exception)


def test_what_was_sent_in_without_work_waits_for_a_decision(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    idle, half = (worker(app, address, mturk, f"W{i}") for i in range(2))
    work(half, 1)
    first, second = (p.assignment for p in participations(app))
    never_came = mturk.accept("W9")["assignmentId"]
    for assignment in (first, second, never_came):
        mturk.external_submit({"assignmentId": [assignment], "x": ["y"]})
    result = lab.collect()
    assert f"{first}: nothing received (0 of 2)" in result.output
    assert f"{second}: incomplete (1 of 2)" in result.output
    assert f"{never_came}: unknown here" in result.output
    assert "ApproveAssignment" not in mturk.calls

    decided = lab.collect("--reject", first, "There was no work.", "--approve", second)
    assert decided.exit_code == 0, decided.output
    assert [mturk.status(a) for a in (first, second)] == ["Rejected", "Approved"]
    del idle


def test_another_workers_submission_is_not_approved(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    arguments = mturk.accept("W1")
    thief = CrowdWorker(app, address, {**arguments, "workerId": "W2"})
    work(thief)
    mturk.external_submit({"assignmentId": [arguments["assignmentId"]], "x": ["y"]})
    assert f"{arguments['assignmentId']}: another worker" in lab.collect().output
    assert "ApproveAssignment" not in mturk.calls


def test_answers_count_for_one_assignment(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    """A worker who accepts two assignments at once does the work of two."""
    one = worker(app, address, mturk)
    one.open(address, mturk.accept("W1"))
    work(one, 3)
    lab.reconcile()
    assert [p.received_at is not None for p in participations(app)] == [False, True]


def test_somebody_without_anything_left_has_done_their_part(
    app: Flask, lab: Lab, mturk: MechanicalTurk
) -> None:
    lab.publish("--task", "describe", "--items", "10", "--people", "1")
    (hit,) = mturk.hits.values()
    one = worker(app, external_url(hit["Question"]), mturk)
    work(one, 3)
    assert "nothing" in one.finish()
    one.submit(mturk)
    assert lab.collect().exit_code == 0
    (mine,) = participations(app)
    assert mturk.status(mine.assignment) == "Approved"


def test_a_dry_run_changes_nothing(lab: Lab, sent: str, mturk: MechanicalTurk) -> None:
    assert "1 ready" in lab.collect("--dry-run").output
    assert "ApproveAssignment" not in mturk.calls


@pytest.mark.parametrize("loss", ["unavailable", "cut", "never came"])
def test_a_lost_answer_pays_once_within_the_same_day(
    lab: Lab, sent: str, mturk: MechanicalTurk, loss: Loss
) -> None:
    assert lab.collect().exit_code == 0
    mturk.losses["SendBonus"] = loss
    for _ in range(2):
        result = lab.collect(*a_bonus(sent))
        assert result.exit_code == 0, result.exception
    assert len(mturk.bonuses) == 1
    # What is listed isn't paid again; what isn't listed is, with the same token.
    assert mturk.calls.count("SendBonus") == (2 if loss == "never came" else 1)


def test_the_platform_refuses_a_token_that_it_knows(
    lab: Lab, sent: str, mturk: MechanicalTurk
) -> None:
    mturk.losses["SendBonus"] = "cut"
    listed = mturk.ListBonusPayments
    mturk.ListBonusPayments = lambda _: (200, {"BonusPayments": []})  # type: ignore[method-assign]
    bonus = a_bonus(sent)
    assert "1 call is in doubt" in str(lab.collect(*bonus).exception)
    assert "1 call is in doubt" in str(lab.collect(*bonus).exception)
    assert mturk.calls.count("SendBonus") == 3
    mturk.ListBonusPayments = listed  # type: ignore[method-assign]
    assert lab.collect(*bonus).exit_code == 0
    assert len(mturk.bonuses) == 1


def test_after_a_day_somebody_decides(
    app: Flask, lab: Lab, sent: str, mturk: MechanicalTurk
) -> None:
    bonus, send = a_bonus(sent), mturk.SendBonus
    mturk.SendBonus = lambda _: (503, {})  # type: ignore[method-assign]
    assert "1 call is in doubt" in str(lab.collect(*bonus).exception)
    mturk.SendBonus = send  # type: ignore[method-assign]
    mturk.let_a_day_pass()
    execute(app, update(LedgerEntry).values(attempted_at=LedgerEntry.attempted_at - DAY_S))
    assert "1 call is in doubt" in str(lab.collect(*bonus).exception)
    assert mturk.bonuses == []
    (number,) = re.findall(r"in doubt: (\d+): bonus 0.50", lab.reconcile().output)
    assert lab.collect("--pay-again", number).exit_code == 0
    assert len(mturk.bonuses) == 1


@pytest.mark.parametrize("loss", ["unavailable", "cut", "never came"])
def test_an_approval_is_sent_once_and_looked_at(
    app: Flask, lab: Lab, sent: str, mturk: MechanicalTurk, loss: Loss
) -> None:
    mturk.losses["ApproveAssignment"] = loss
    assert "1 call is in doubt" in str(lab.collect().exception)
    assert mturk.calls.count("ApproveAssignment") == 1
    assert lab.collect().exit_code == 0
    assert mturk.status(sent) == "Approved"
    assert ("approve", sent, "done") in ledger(app)


def test_the_sandbox_has_books_of_its_own(
    app: Flask, lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    assert json.loads(lab.reconcile("--json").stdout)["ledger"] == []
    (entry,) = json.loads(lab.reconcile("--sandbox", "--json").stdout)["ledger"]
    assert (entry["what"], entry["reason"]) == ("publish", "5 assignments at 0.20")
