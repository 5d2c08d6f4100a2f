"""What the platform has and the ledger doesn't is noted, and holds payments until a decision."""

from __future__ import annotations

import json
import re
import shutil
from collections import Counter
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import msgspec
import pytest
from flask import Flask
from sqlalchemy import select, update

from annotation_app.copies.backups import back_up
from annotation_app.copies.restoring import restore
from annotation_app.core.config import Config, open_instance
from annotation_app.core.key_file import KEY_FILE
from annotation_app.export.answer_tables import rows
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import AuditEntry, Item, LedgerEntry, Slot
from annotation_app.studies.study_file import Payment
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import described, engine_of, execute, rows_in
from tests.annotation_app.crowds.conftest import PAID as STUDY
from tests.annotation_app.crowds.crowd_worker import (
    BONUS,
    OPTIONS,
    PAID,
    CrowdWorker,
    Lab,
    external_url,
    take_part,
)
from tests.annotation_app.crowds.mturk.turkers import work, worker
from tests.annotation_app.crowds.prolific_stand_in import Prolific
from tests.annotation_app.crowds.stand_ins import MechanicalTurk

QUALITY = Decimal("0.50")
DAY_S = 86_400


@pytest.fixture
def rewarding(app: Flask, videos: Path) -> None:
    """The study pays a bonus for careful work."""
    with transaction(engine_of(app)) as session:
        study = msgspec.structs.replace(STUDY, payment=Payment(0.10, bonus=float(QUALITY)))
        put_study(session, study, rendered_videos(videos))


def restored(config: Config, archive: Path, folder: Path, endpoint: str, provider: str) -> Lab:
    restore(archive, folder, keys=config.instance / KEY_FILE)
    return Lab(replace(open_instance(folder), rate_limits=False), endpoint, provider)


def states_of(lab: Lab, *kinds: str) -> list[tuple[str, str]]:
    told = json.loads(lab.reconcile("--json").stdout)["ledger"]
    return [(entry["what"], entry["state"]) for entry in told if entry["what"] in kinds]


@pytest.mark.usefixtures("rewarding")
@pytest.mark.parametrize("arrives", ["before", "after"])
def test_a_restored_backup_pays_nobody_again_at_prolific(
    app: Flask, config: Config, lab: Lab, prolific: Prolific, tmp_path: Path, arrives: str
) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    archive = tmp_path / "backup.jsonl.gz"
    back_up(config, archive, None)
    assert lab.collect("--pay-bonus").exit_code == 0
    assert prolific.orders == [("sub1", QUALITY)]
    if arrives == "before":
        prolific.let_minutes_pass()

    address: str = prolific.address  # type: ignore[attr-defined]
    again = restored(config, archive, tmp_path / "restored", address, "prolific")
    for command in (again.collect("--pay-bonus"), again.publish(*OPTIONS)):
        assert "was restored from a backup" in str(command.exception)
        assert "--confirm-restored" in str(command.exception)
    assert "was restored from a backup" in again.reconcile().output
    assert "was restored from a backup" in again.collect("--dry-run").output
    assert prolific.orders == [("sub1", QUALITY)]

    prolific.let_minutes_pass()
    held = again.collect("--pay-bonus", "--confirm-restored")
    assert held.exit_code == 0, held.exception
    assert "found there" in held.output
    assert prolific.orders == [("sub1", QUALITY)]
    found = [("approve", "found there"), ("bonus", "found there")]
    assert states_of(again, "approve", "bonus") == found
    for options in (("--confirm-found",), ()):
        done = again.collect("--pay-bonus", *options)
        assert done.exit_code == 0, done.exception
    assert prolific.orders == [("sub1", QUALITY)]
    assert states_of(again, "approve", "bonus") == [("approve", "done"), ("bonus", "done")]


@pytest.mark.usefixtures("rewarding")
def test_a_restored_backup_pays_nobody_again_at_mechanical_turk(
    app: Flask, config: Config, mturk: MechanicalTurk, tmp_path: Path
) -> None:
    address: str = mturk.address  # type: ignore[attr-defined]
    lab = Lab(config, address)
    lab.publish(*OPTIONS)
    (hit,) = mturk.hits.values()
    one = worker(app, external_url(hit["Question"]), mturk)
    work(one)
    one.submit(mturk)
    archive = tmp_path / "backup.jsonl.gz"
    back_up(config, archive, None)
    assert lab.collect("--pay-bonus").exit_code == 0

    again = restored(config, archive, tmp_path / "restored", address, "mturk")
    assert "was restored" in str(again.collect("--pay-bonus").exception)
    for days in range(2):
        result = again.collect("--pay-bonus", *([] if days else ["--confirm-restored"]))
        assert result.exit_code == 0, result.exception
        mturk.let_a_day_pass()
    assert len(mturk.bonuses) == 1
    assert again.collect("--confirm-found").exit_code == 0
    assert again.collect("--pay-bonus").exit_code == 0
    assert len(mturk.bonuses) == 1
    assert mturk.calls.count("SendBonus") == 1
    assert states_of(again, "approve", "bonus") == [("approve", "done"), ("bonus", "done")]


def test_a_restore_is_in_the_audit_trail_and_confirmed_for_each_study_and_platform(
    app: Flask, config: Config, lab: Lab, prolific: Prolific, mturk: MechanicalTurk, tmp_path: Path
) -> None:
    lab.publish(*OPTIONS)
    archive = tmp_path / "backup.jsonl.gz"
    back_up(config, archive, None)
    address: str = prolific.address  # type: ignore[attr-defined]
    again = restored(config, archive, tmp_path / "restored", address, "prolific")
    turk = Lab(open_instance(tmp_path / "restored"), mturk.address, "mturk")  # type: ignore[attr-defined]
    assert again.collect("--confirm-restored").exit_code == 0
    assert again.collect().exit_code == 0
    assert "was restored" in str(turk.collect().exception)
    with opened(open_instance(tmp_path / "restored").database) as engine:
        actions = rows_in(engine, select(AuditEntry.action).order_by(AuditEntry.id))
    assert actions[-2:] == ["restored", "confirmed as complete"]


@pytest.mark.usefixtures("rewarding")
def test_an_older_copy_of_the_database_pays_nobody_again(
    app: Flask, config: Config, lab: Lab, prolific: Prolific, tmp_path: Path
) -> None:
    """Nothing shows that it was put there, but what was approved meanwhile."""
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    engine_of(app).dispose()
    shutil.copyfile(str(config.database), tmp_path / "older")
    lab.collect("--pay-bonus")
    shutil.copyfile(tmp_path / "older", str(config.database))
    for end in ("-wal", "-shm"):
        Path(f"{config.database}{end}").unlink(missing_ok=True)
    # The bonus hasn't arrived, so that the list doesn't show it.
    assert "held 0.50: sub1 approve 0.20 was found there" in lab.collect("--pay-bonus").output
    assert prolific.orders == [("sub1", QUALITY)]


def test_a_bonus_by_hand_holds_payments_until_somebody_decides(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    lab.publish(*OPTIONS)
    for number, name in enumerate(("p1", "p2"), start=1):
        take_part(app, prolific, name)
        lab.collect()
        prolific.submissions[f"sub{number}"]["bonus_payments"] = [50.0]
    wishes = (*BONUS, "--bonus", "sub2", "0.50", "For care")
    held = lab.collect(*wishes, "--json")
    assert held.exit_code == 0
    assert [deed["what"] for deed in json.loads(held.stdout)["deeds"]] == ["held", "held"]
    first, second = (entry["id"] for entry in json.loads(held.stdout)["found_there"])
    assert prolific.orders == []
    # One was the very bonus, the other one for something else.
    assert lab.collect("--confirm-paid", str(first), "--pay-again", str(second)).exit_code == 0
    for _ in range(2):
        assert lab.collect(*wishes).exit_code == 0
        prolific.let_minutes_pass()
    assert prolific.orders == [("sub2", Decimal("0.50"))]
    assert states_of(lab, "bonus") == [("bonus", "done")] * 3
    # A list that shows less for a moment lets nobody be paid again.
    prolific.submissions["sub1"]["bonus_payments"] = None
    for _ in range(2):
        assert lab.reconcile().exit_code == 0
        assert "1 call is in doubt" in str(lab.collect(*wishes).exception)
    prolific.submissions["sub1"]["bonus_payments"] = [50.0]
    assert lab.collect(*wishes).exit_code == 0
    assert len(prolific.orders) == 1


def test_what_was_approved_there_is_noted_and_holds_a_bonus(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    prolific.submissions["sub1"]["status"] = "APPROVED"
    assert "approve 0.20 was found there" in lab.collect(*BONUS).output
    (number,) = re.findall(r"found there: (\d+): approve", lab.reconcile().output)
    assert "pays no bonus" in str(lab.collect("--pay-again", number).exception)
    assert lab.collect(*BONUS, "--confirm-paid", number).exit_code == 0
    assert prolific.orders == PAID


def test_a_payment_that_fails_late_is_not_done(app: Flask, lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    lab.collect()
    prolific.freedoms.fails_late = 1
    assert lab.collect(*BONUS).exit_code == 0
    prolific.let_minutes_pass()
    assert lab.collect(*BONUS).exit_code == 0
    assert states_of(lab, "bonus") == [("bonus", "ordered")]
    execute(app, update(LedgerEntry).values(ended_at=LedgerEntry.ended_at - 3601))
    late = lab.collect(*BONUS)
    assert "accepted an hour ago, and it isn't listed" in late.output
    assert "1 call is in doubt" in str(late.exception)
    (number,) = re.findall(r"in doubt: (\d+): bonus 0.50", late.output)
    assert lab.collect("--pay-again", number).exit_code == 0
    prolific.let_minutes_pass()
    assert lab.collect(*BONUS).exit_code == 0
    assert states_of(lab, "bonus") == [("bonus", "done")]
    assert len(prolific.orders) == 2
    # What is listed no more is not done either.
    prolific.submissions["sub1"]["bonus_payments"] = []
    for _ in range(2):
        assert states_of(lab, "bonus") == [("bonus", "in doubt")]
    assert len(prolific.orders) == 2


def test_an_approval_that_lists_show_late_is_done(
    app: Flask, config: Config, mturk: MechanicalTurk
) -> None:
    """Its reply was lost, and the list still said that it was sent in."""
    lab = Lab(config, mturk.address)  # type: ignore[attr-defined]
    lab.publish(*OPTIONS)
    (hit,) = mturk.hits.values()
    one = worker(app, external_url(hit["Question"]), mturk)
    work(one)
    one.submit(mturk)
    lists = mturk.ListAssignmentsForHIT

    def as_before(request: dict[str, Any]) -> Any:
        reply = lists(request)
        assert reply is not None
        entries = [{**a, "AssignmentStatus": "Submitted"} for a in reply[1]["Assignments"]]
        return 200, {**reply[1], "Assignments": entries}

    mturk.ListAssignmentsForHIT = as_before  # type: ignore[method-assign]
    mturk.losses["ApproveAssignment"] = "cut"
    assert "1 call is in doubt" in str(lab.collect().exception)
    assert lab.collect().exit_code == 0
    assert states_of(lab, "approve") == [("approve", "done")]
    assert mturk.calls.count("ApproveAssignment") == 1
    # Approving once more is refused, and the assignment says why.
    approvals = update(LedgerEntry).where(LedgerEntry.what == "approve")
    execute(app, approvals.values(state="refused"))
    assert lab.collect().exit_code == 0
    assert states_of(lab, "approve") == [("approve", "done")]


def test_a_pilots_link_earns_no_reward_of_another_study_at_prolific(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    lab.publish("--task", "describe", "--items", "1", "--people", "4")
    lab.publish("--task", "describe", "--items", "3", "--people", "4")
    pilot, study = prolific.studies.values()
    arguments = prolific.begin("p1", study["id"])
    one = CrowdWorker(app, pilot["external_study_url"], arguments)
    one.do("describe", described())
    one.finish()
    prolific.submissions["sub1"]["status"] = "AWAITING REVIEW"
    result = lab.collect()
    assert "sub1: another offer (1 of 1)" in result.output
    assert prolific.submissions["sub1"]["status"] == "AWAITING REVIEW"
    assert lab.collect("--approve", "sub1").exit_code == 0
    assert prolific.submissions["sub1"]["status"] == "APPROVED"


def test_a_pilots_link_earns_no_reward_of_another_hit_at_mechanical_turk(
    app: Flask, config: Config, mturk: MechanicalTurk
) -> None:
    lab = Lab(config, mturk.address)  # type: ignore[attr-defined]
    lab.publish("--task", "describe", "--items", "3", "--people", "1")
    lab.publish("--task", "describe", "--items", "1", "--people", "1")
    hit, pilot = mturk.hits.values()
    arguments = mturk.accept("W1")
    assert arguments["hitId"] == hit["HITId"]
    one = CrowdWorker(app, external_url(pilot["Question"]), arguments)
    work(one, 1)
    one.submit(mturk)
    assert "another offer (1 of 1)" in lab.collect().output
    assert "ApproveAssignment" not in mturk.calls


@pytest.mark.parametrize("change", ["reward", "copy"])
def test_work_that_was_not_offered_from_here_is_shown_and_not_approved(
    app: Flask, lab: Lab, prolific: Prolific, change: str
) -> None:
    lab.publish(*OPTIONS)
    (study,) = prolific.studies.values()
    if change == "copy":  # somebody duplicates it at Prolific, with its label
        prolific.studies["copy"] = {**study, "id": "copy"}
        prolific._hidden["copy"] = 0
    else:
        study["reward"] = 2000
    arguments = prolific.begin("p1", "copy" if change == "copy" else study["id"])
    one = CrowdWorker(app, study["external_study_url"], arguments)
    for _ in range(2):
        one.do("describe", described())
    prolific.submissions["sub1"]["status"] = "AWAITING REVIEW"
    assert "sub1: another offer (2 of 2)" in lab.collect().output
    assert "approve" not in prolific.calls
    if change == "copy":
        (number,) = re.findall(r"found there: (\d+): publish 0.20", lab.reconcile().output)
        assert lab.collect("--confirm-paid", number).exit_code == 0
        assert prolific.submissions["sub1"]["status"] == "APPROVED"


def answers(app: Flask) -> Counter[tuple[str, bool]]:
    """Of the exported answers, whether the platform knows who gave them, and they are left out."""
    with reading(engine_of(app)) as session:
        exported = rows(session, find_study(session, "tests"), excluded=True)
        return Counter((row["platform"], row["excluded"]) for row in exported)


def open_slots(app: Flask) -> int:
    open_ = select(Slot).join(Item).where(Item.task == "describe", Slot.answered.is_(False))
    return len(rows_in(app, open_))


OTHERS: list[Any] = [
    {"id": "other1", "internal_name": None, "status": None, "reward": None},
    {"id": "other2"},
    {"id": "other3", "internal_name": 7, "reward": "much"},
    {"id": "other4", "internal_name": ["g3"], "total_available_places": {}},
    {"id": None, "internal_name": "g3 "},
    None,
    "text",
]


def test_other_peoples_records_break_no_command(app: Flask, lab: Lab, prolific: Prolific) -> None:
    prolific.freedoms.others = OTHERS
    assert lab.publish(*OPTIONS).exit_code == 0
    take_part(app, prolific, "p1")
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID
    assert lab.reconcile().exit_code == 0


@pytest.mark.parametrize("payments", ["many", {"a": 1}, [None], ["x"], 5, [float("nan")]])
def test_what_was_paid_must_be_readable_before_more_is_paid(
    app: Flask, lab: Lab, prolific: Prolific, payments: Any
) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    lab.collect()
    prolific.submissions["sub1"]["bonus_payments"] = payments
    assert "could not be looked up" in lab.collect(*BONUS).output
    assert prolific.orders == []


def test_people_whom_prolific_does_not_know_fill_nothing(
    app: Flask, lab: Lab, prolific: Prolific
) -> None:
    lab.publish(*OPTIONS)
    address = next(iter(prolific.studies.values()))["external_study_url"]
    take_part(app, prolific, "p1")
    for number in range(3):
        invented = {"PROLIFIC_PID": f"x{number}", "STUDY_ID": "study1", "SESSION_ID": f"s{number}"}
        one = CrowdWorker(app, address, invented)
        for _ in range(2):
            one.do("describe", described())
    shown = lab.reconcile().output
    assert "s0: unknown there (2 of 2)" in shown
    assert answers(app) == {("unknown", False): 6, ("known", False): 2}
    result = lab.collect("--pay-partial")
    assert result.exit_code == 0, result.exception
    assert "2 left out, for the platform doesn't know who came" in result.output
    assert answers(app) == {("unknown", True): 6, ("known", False): 2}
    assert open_slots(app) == 27 - 2
    # Prolific has been slow: it knows one of them after all.
    arguments = prolific.begin("x1")
    prolific.submissions["s1"] = prolific.submissions.pop(arguments["SESSION_ID"]) | {"id": "s1"}
    assert "2 count again" in lab.collect().output
    assert answers(app) == {("unknown", True): 4, ("known", False): 4}
    assert open_slots(app) == 27 - 4


def test_unknown_peoples_answers_can_be_kept(app: Flask, lab: Lab, prolific: Prolific) -> None:
    lab.publish(*OPTIONS)
    address = next(iter(prolific.studies.values()))["external_study_url"]
    one = CrowdWorker(app, address, {"PROLIFIC_PID": "x", "SESSION_ID": "s"})
    for _ in range(2):
        one.do("describe", described())
    lab.collect("--keep-unknown")
    assert answers(app) == {("unknown", False): 2}
