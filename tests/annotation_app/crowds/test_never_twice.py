"""Answers are lost and programs killed at every point: nobody is paid twice, nobody forgotten.

``MONEY_EXAMPLES`` is how many histories are tried for each platform; the checks try few.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from decimal import Decimal
from itertools import count
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
import pytest
from click.testing import Result
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import select, update

from annotation_app.copies.backups import back_up
from annotation_app.copies.restoring import restore
from annotation_app.core.config import Config, open_instance
from annotation_app.core.key_file import KEY_FILE
from annotation_app.crowds import mturk_client as mturk_module
from annotation_app.crowds import prolific_client as prolific_module
from annotation_app.crowds.ledger import CURRENT
from annotation_app.serving.factory import create_app
from annotation_app.store.audit import RESTORED
from annotation_app.store.database import open_database
from annotation_app.store.models import Answer, AuditEntry, LedgerEntry, Participation
from annotation_app.studies.study_file import Payment, StudyConfig
from tests.annotation_app.browser import described, execute, rows_in
from tests.annotation_app.crowds.conftest import PAID
from tests.annotation_app.crowds.crowd_worker import CrowdWorker, Lab
from tests.annotation_app.crowds.trouble import (
    AT_COMMIT,
    KINDS,
    Killed,
    Kind,
    Target,
    Trouble,
)
from tests.annotation_app.crowds.truth import AtMechanicalTurk, AtProlific, Payments

EXAMPLES = int(os.environ.get("MONEY_EXAMPLES", "12"))
STUDY = msgspec.structs.replace(PAID, payment=Payment(0.10, bonus=0.25))
MOST_PEOPLE, MOST_WORKERS, MOST_INVENTED, MOST_RESTORES = 12, 4, 2, 2
QUALITY, PART = Decimal("0.25"), Decimal("0.10")
BONUSES = (("0.50", "For care"), ("0.50", "For speed"), ("0.25", "For the long command"))
DAY_S = 86_400

Wrong: TypeAlias = tuple[Kind, Target, int]
COLLECTING: tuple[Target, ...] = ("pay", "pay", "pay", "approve", "set up")


def troubles(targets: tuple[Target, ...]) -> st.SearchStrategy[Wrong]:
    """What goes wrong, mostly with the first call of a sort."""
    kinds = [kind for kind in KINDS if kind != AT_COMMIT]
    ats = st.sampled_from((0, 0, 0, 1))
    calls = st.tuples(st.sampled_from(kinds), st.sampled_from(targets), ats)
    commits = st.tuples(st.just(AT_COMMIT), st.just(targets[0]), st.integers(0, 15))
    return st.one_of(calls, calls, calls, commits)


class History(RuleBasedStateMachine):
    """A lab that offers, collects and pays, while answers are lost and programs killed."""

    at: Callable[[Trouble], AtProlific | AtMechanicalTurk]
    folders: Iterator[Path]
    template: Path
    install: Callable[[Any], None]

    def __init__(self) -> None:
        super().__init__()
        self.trouble = Trouble()
        self.world = type(self).at(self.trouble)
        type(self).install(self.world)
        config = open_instance(next(type(self).folders))
        shutil.copyfile(type(self).template, config.database)
        self._open(config)
        self.asked_for = 0
        self.wished: Payments = Counter()
        """What is to be paid in the end."""
        self.options: dict[tuple[str, ...], None] = {}
        self.ready: set[str] = set()
        self.sent: list[str] = []
        self.workers = self.invented = self.restores = 0

    def _open(self, config: Config) -> None:
        self.config = replace(config, rate_limits=False)
        self.engine = open_database(config.database)
        self.app = create_app(self.config, self.engine)
        self.lab = Lab(self.config, "https://platform.test", self.world.name)

    @initialize(
        people=st.integers(MOST_WORKERS, MOST_PEOPLE),
        trouble=troubles(("offer",)),
        page=st.sampled_from((None, 1, 2, 5)),
        is_endless=st.booleans(),
    )
    def begin(self, people: int, trouble: Wrong, page: int | None, is_endless: bool) -> None:
        self.world.list_in_pages(page, is_endless=is_endless)
        self.publish(people, trouble)
        self._offer_it_all()
        self.take_part(2)
        self.take_part(2)

    @rule(people=st.integers(MOST_WORKERS, MOST_PEOPLE), trouble=troubles(("offer",)))
    def publish(self, people: int, trouble: Wrong) -> None:
        self.asked_for = max(self.asked_for, people)
        self._run(self._publish, trouble)

    @precondition(lambda self: self.workers < MOST_WORKERS)
    @rule(done=st.integers(1, 2))
    def take_part(self, done: int) -> None:
        address = self.world.address()
        assert address is not None
        self.workers += 1
        arguments = self.world.arrive(f"W{self.workers}")
        assignment = self.world.assignment_of(arguments)
        worker = CrowdWorker(self.app, address, arguments)
        for _ in range(done):
            worker.do("describe", described())
        if done == 2:
            self.world.send_in(worker, assignment)
            self.ready.add(assignment)
            self.sent.append(assignment)
        elif self.world.give_back(assignment):
            self.wished[assignment, PART] += 1

    @rule(
        which=st.integers(0, MOST_WORKERS),
        bonus=st.sampled_from(BONUSES),
        trouble=troubles(COLLECTING),
    )
    def give_a_bonus(self, which: int, bonus: tuple[str, str], trouble: Wrong) -> None:
        assignment = self.sent[which % len(self.sent)]
        wish = ("--bonus", assignment, *bonus)
        if wish not in self.options:
            self.wished[assignment, Decimal(bonus[0])] += 1
        self.options[wish] = None
        self._run(lambda: self._collect(*wish), trouble)

    @rule(trouble=troubles(COLLECTING))
    def collect(self, trouble: Wrong) -> None:
        self._run(lambda: self._collect("--pay-bonus", "--pay-partial"), trouble)

    @rule()
    def let_time_pass(self) -> None:
        self._let_time_pass()

    @precondition(lambda self: self.invented < MOST_INVENTED)
    @rule(done=st.integers(1, 2))
    def come_with_an_invented_id(self, done: int) -> None:
        address = self.world.address()
        assert address is not None
        self.invented += 1
        worker = CrowdWorker(self.app, address, self.world.invent(f"invented{self.invented}"))
        for _ in range(done):
            worker.do("describe", described())

    @rule(orders=st.integers(1, 2))
    def let_orders_fail_late(self, orders: int) -> None:
        self.world.fail_late(orders)

    @precondition(lambda self: self.restores < MOST_RESTORES)
    @rule(trouble=troubles(COLLECTING), bonus=st.sampled_from(BONUSES))
    def lose_what_was_done_last(self, trouble: Wrong, bonus: tuple[str, str]) -> None:
        """A backup is taken, work is paid, and the backup is restored."""
        self.restores += 1
        folder = next(type(self).folders)
        archive = folder.with_suffix(".backup")
        back_up(self.config, archive, None)
        self._run(lambda: self._collect("--pay-bonus", "--pay-partial"), trouble)
        self.give_a_bonus(self.restores, bonus, trouble)
        self.engine.dispose()
        restore(archive, folder, keys=self.config.instance / KEY_FILE)
        self._open(open_instance(folder))
        assert self._is_restored()

    @precondition(lambda self: self._decisions())
    @rule(trouble=troubles(COLLECTING))
    def decide(self, trouble: Wrong) -> None:
        decisions = self._decisions()
        self._run(lambda: self._collect(*decisions), trouble)

    @invariant()
    def nobody_is_paid_twice(self) -> None:
        allowed = self.wished + Counter({(a, QUALITY): 1 for a in self.ready})
        assert self.world.paid() <= allowed

    @invariant()
    def nothing_is_offered_twice(self) -> None:
        assert self.world.offered() <= self.asked_for

    @invariant()
    def the_ledger_is_right(self) -> None:
        if self._is_restored():
            return
        done = self._booked("done", "found there")
        open_ = self._booked("in doubt", "attempted", "ordered", "confirmed")
        assert done <= self.world.paid() <= done + open_

    @invariant()
    def nobody_is_approved_who_has_not_done_all(self) -> None:
        assert self.world.approved() <= self.ready

    def teardown(self) -> None:
        try:
            self._end_well()
        finally:
            self.engine.dispose()

    def _end_well(self) -> None:
        """Nothing goes wrong any more, and somebody decides what is in doubt."""
        self.world.fail_late(0)
        self._let_time_pass()
        self._collect(*self._decisions())
        self._offer_it_all()
        wishes = [option for wish in self.options for option in wish]
        for _ in range(6):
            self._let_time_pass()
            self._collect(*self._decisions())
            result = self._collect("--pay-bonus", "--pay-partial", *wishes)
            waiting = self._booked("in doubt", "attempted", "ordered", "found there")
            if result.exit_code == 0 and not waiting and not self._entries("found there"):
                break
        assert result.exit_code == 0, (result.output, result.exception)
        assert self.lab.reconcile().exit_code == 0
        assert self.world.approved() == self.ready
        self.wished.update({(assignment, QUALITY): 1 for assignment in self.ready})
        assert self.world.paid() == self.wished == self._booked("done")
        assert not self._booked("in doubt", "attempted", "ordered", "confirmed", "found there")
        if self.world.client.lists_all:
            assert self._answers_of_invented() == {True}

    def _offer_it_all(self) -> None:
        for _ in range(4):
            if self._publish().exit_code == 0:
                break
            self._let_time_pass()
        assert self.world.offered() == self.asked_for
        assert self.world.is_published()

    def _run(self, command: Callable[[], object], trouble: Wrong) -> None:
        with self.trouble.happens(*trouble), suppress(Killed):
            command()

    def _publish(self) -> Result:
        options = ("--task", "describe", "--items", "2", "--people", str(self.asked_for))
        return self._checked(self.lab.publish(*options, *self._to_offer_again()))

    def _to_offer_again(self) -> Iterator[str]:
        """What isn't there, as somebody sees who looks at the platform."""
        for entry in self._entries("in doubt"):
            if entry.what == "publish" and not self.world.has(entry.key):
                yield from ("--publish-again", str(entry.id))

    def _collect(self, *options: str) -> Result:
        return self._checked(self.lab.collect(*options))

    def _checked(self, result: Result) -> Result:
        """Whatever goes wrong is told in one line: no other exception comes out."""
        known = ("PlatformError", "LostReplyError", "InDoubtError", "CorpusError", "FormatError")
        name = type(result.exception).__name__
        assert result.exception is None or name in known, result.exception
        return result

    def _answers_of_invented(self) -> set[bool]:
        """Whether what people sent whom the platform doesn't know is left out."""
        wanted = (
            select(Answer.excluded)
            .join(Participation, Participation.person_id == Answer.person_id)
            .where(
                Participation.assignment.startswith("invented"),
                Participation.received_at.is_not(None),
            )
        )
        return {True, *rows_in(self.engine, wanted)}

    def _is_restored(self) -> bool:
        actions = select(AuditEntry.action).order_by(AuditEntry.id.desc())
        told = [a for a in rows_in(self.engine, actions) if a in (RESTORED, CURRENT)]
        return told[:1] == [RESTORED]

    def _decisions(self) -> list[str]:
        """What somebody decides who knows what the platform was ordered to pay.

        They wait until what was ordered before a restore has arrived.
        """
        accounted = self._booked("done", "found there", "ordered", "confirmed")
        decisions, paid = [], self.world.paid()
        if self._is_restored():
            return ["--confirm-restored"] if self.world.has_arrived() else []
        if self._entries("found there"):
            decisions.append("--confirm-found")
        for entry in self._entries("in doubt"):
            if entry.what in ("bonus", "partial payment"):
                which = entry.assignment, Decimal(entry.amount)
                was_paid = paid[which] > accounted[which]
                decisions += ["--confirm-paid" if was_paid else "--pay-again", str(entry.id)]
        return decisions

    def _let_time_pass(self) -> None:
        self.world.let_time_pass()
        earlier = {
            LedgerEntry.attempted_at: LedgerEntry.attempted_at - DAY_S,
            LedgerEntry.ended_at: LedgerEntry.ended_at - DAY_S,
        }
        execute(self.engine, update(LedgerEntry).values(earlier))

    def _entries(self, *states: str) -> list[LedgerEntry]:
        return rows_in(self.engine, select(LedgerEntry).where(LedgerEntry.state.in_(states)))

    def _booked(self, *states: str) -> Payments:
        return Counter(
            (entry.assignment, Decimal(entry.amount))
            for entry in self._entries(*states)
            if entry.what in ("bonus", "partial payment")
        )


@pytest.mark.slow
@pytest.mark.parametrize("at", [AtProlific, AtMechanicalTurk])
def test_nobody_is_paid_twice_and_nobody_forgotten(
    at: Any,
    templates: Callable[[StudyConfig, str | None], str | Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def install(world: AtProlific | AtMechanicalTurk) -> None:
        module, name = {
            "prolific": (prolific_module, "open_prolific"),
            "mturk": (mturk_module, "open_mturk"),
        }[world.name]
        monkeypatch.setattr(module, name, lambda **_: Reused(world.client))

    here = {
        "at": staticmethod(at),
        "folders": (tmp_path / str(number) for number in count()),
        "template": Path(templates(STUDY, None)),
        "install": staticmethod(install),
    }
    run_state_machine_as_test(
        type("HistoryHere", (History,), here),
        settings=settings(
            max_examples=EXAMPLES,
            stateful_step_count=10,
            phases=(Phase.generate,),  # to make a failing history short would take minutes
        ),
    )


class Reused:
    """A platform whose connections aren't closed with each command."""

    def __init__(self, platform: Any) -> None:
        self._platform = platform

    def __getattr__(self, name: str) -> Any:
        return getattr(self._platform, name)

    def close(self) -> None:
        pass
