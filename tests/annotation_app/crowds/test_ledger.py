"""One program alone makes a call, whoever else tries to."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from decimal import Decimal
from threading import Barrier

import pytest
from flask import Flask

from annotation_app.crowds.ledger import Call, Entry, InDoubtError, Ledger, What
from annotation_app.crowds.platform import LostReplyError, PlatformError
from annotation_app.store.database import reading
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import engine_of

BONUS = Call("bonus", "A1 key", "A1", amount=Decimal("0.50"), reason="For care")
PROGRAMS = 8


@pytest.fixture
def ledger(app: Flask) -> Ledger:
    engine = engine_of(app)
    with reading(engine) as session:
        return Ledger(engine, find_study(session, "tests").id, "prolific")


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
@pytest.mark.parametrize("earlier", ["none", "refused", "in doubt"])
def test_many_programs_pay_once(ledger: Ledger, earlier: str) -> None:
    """Without any other lock."""
    doubted = prepare(ledger, earlier)
    made: list[float] = []
    barrier = Barrier(PROGRAMS)

    def do(_: Entry) -> None:
        made.append(time.time())
        time.sleep(0.05)

    def pay(number: int) -> str:
        barrier.wait()
        time.sleep(0.02 * number)  # some come while it is paid, and some after that
        try:
            ledger.carry_out(BONUS, do, instead_of=doubted)
        except InDoubtError:
            return "refused"
        return "paid"

    with ThreadPoolExecutor(PROGRAMS) as pool:
        outcomes = list(pool.map(pay, range(PROGRAMS)))
    assert outcomes.count("paid") == len(made) == 1
    (entry,) = ledger.entries()
    assert (entry.state, entry.call) == ("ordered", BONUS)


@pytest.mark.parametrize("what", ["approve", "reject", "publish"])
def test_what_pays_no_bonus_is_done_again_where_the_platform_says_so(
    ledger: Ledger, what: What
) -> None:
    call = replace(BONUS, what=what)
    for _ in range(2):
        ledger.carry_out(call, lambda _: None)
    (entry,) = ledger.entries("done")
    assert entry.call == call


def test_a_call_that_knows_no_better_keeps_the_doubt(ledger: Ledger) -> None:
    """A platform may refuse a token because it knows it."""
    doubted = prepare(ledger, "in doubt")

    def refuse(_: Entry) -> None:
        raise PlatformError("this token was used")

    with pytest.raises(PlatformError):
        ledger.carry_out(BONUS, refuse, repeats=doubted)
    (entry,) = ledger.entries("in doubt")
    assert entry.problem == "this token was used"
    assert doubted is not None
    assert entry.attempted_at == doubted.attempted_at


def test_a_stopped_program_leaves_a_doubt(ledger: Ledger) -> None:
    def stop(_: Entry) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ledger.carry_out(BONUS, stop)
    assert [entry.state for entry in ledger.entries()] == ["attempted"]
    ledger.doubt_what_stopped()
    assert [entry.state for entry in ledger.entries()] == ["in doubt"]
    with pytest.raises(InDoubtError):
        ledger.carry_out(BONUS, lambda _: None)


def prepare(ledger: Ledger, earlier: str) -> Entry | None:
    """Try the call before, if it is to have been tried."""
    errors = {"refused": PlatformError("no"), "in doubt": LostReplyError("no answer")}
    if earlier not in errors:
        return None

    def fail(_: Entry) -> None:
        raise errors[earlier]

    with pytest.raises(PlatformError):
        ledger.carry_out(BONUS, fail)
    (entry,) = ledger.entries()
    return entry if earlier == "in doubt" else None
