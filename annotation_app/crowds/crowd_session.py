"""A study at a platform, as the command line works with it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from hashlib import sha256
from pathlib import Path

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config, existing_instance
from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.crowds.comparison import (
    Comparison,
    Deed,
    compare_offers,
    is_open,
    terms_offered,
)
from annotation_app.crowds.crowd_registry import Provider
from annotation_app.crowds.decisions import Decisions, check_decisions, decide
from annotation_app.crowds.ledger import Ledger, moment, one_at_a_time
from annotation_app.crowds.platform import Bonus, Platform, PlatformError, Submission
from annotation_app.crowds.reconciliation import CENT, Finding, reconcile
from annotation_app.crowds.settlement import Wishes, settle
from annotation_app.dashboard.workers import flagged_people
from annotation_app.export.corpus_export import find_only_study
from annotation_app.people.participants import platform_knowledge, subject_of
from annotation_app.store.audit import COMMAND_LINE, note
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.installation import now
from annotation_app.store.models import Answer, Person, Remark, Study
from annotation_app.store.salt import installation_salt
from annotation_app.store.schema import check_current
from annotation_app.studies.study_file import restored
from annotation_app.work.reviewing import exclude, restore
from g3.errors import CorpusError, FormatError

MOST = Decimal(1000)
"""Larger bonuses are slips of the finger."""
UNDECIDED = Decisions()


@dataclass(frozen=True, slots=True)
class CrowdSession:
    """A study, where it is kept, and the platform that it is offered at."""

    config: Config
    engine: Engine
    provider: Provider
    study: Study
    platform: Platform | None

    def submissions(self, *, take_in: bool) -> list[Submission]:
        """Return the platform's assignments of the study's work.

        `take_in` notes in the ledger the platform's work that wasn't offered from here.
        """
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        offered = self.platform.offered(self.study.id, terms_offered(self.ledger).keys())
        if take_in:
            compare_offers(self.ledger, offered)
        return [one for work in offered for one in self.platform.submissions(work)]

    def findings(self, there: Iterable[Submission]) -> list[Finding]:
        """Return the state of each assignment on both sides."""
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        return reconcile(
            self.engine,
            self.study,
            self.provider.name,
            there,
            terms=terms_offered(self.ledger),
            lists_all=self.platform.lists_all,
            salt=installation_salt(self.engine, self.config),
            now=time.time(),
        )

    @property
    def ledger(self) -> Ledger:
        """Calls made at the platform."""
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        name = f"{self.provider.name} {self.platform.realm}".rstrip()
        return Ledger(self.engine, self.study.id, name)

    def check_current(self) -> None:
        """Check that the database isn't a restored one that nobody has confirmed as complete.

        Raises
        ------
        CorpusError
            If it is.
        """
        line = self.restored_line()
        if line:
            raise CorpusError(
                line,
                where=self.study.name,
                fix="look at it with `ct crowd reconcile`; when all payments from before the "
                "restore have arrived there, run `ct crowd collect` with --confirm-restored",
            )

    def restored_line(self) -> str:
        """Return the notice of a restored database; empty if none was restored."""
        at = self.ledger.restored_at()
        if at is None:
            return ""
        return (
            f"this database was restored from a backup at {moment(at)}: what was offered, approved "
            "or paid after the backup may be missing in the ledger"
        )

    def compare(self) -> tuple[list[Deed], list[Finding]]:
        """Compare all of the platform's record with the ledger. Nothing is approved or paid."""
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        with one_at_a_time(self.engine, self.study.id):
            self.ledger.doubt_what_stopped()
            there = self.submissions(take_in=True)
            findings = self.findings(there)
            comparison = Comparison(self.ledger, self.platform)
            deeds = list(_compared(comparison, there, findings, everything=True))
            return deeds, self.findings(there)

    def settle(self, wishes: Wishes, decisions: Decisions = UNDECIDED) -> list[Deed]:
        """Compare the platform's record with the ledger; then approve, reject and pay.

        Raises
        ------
        FormatError
            If a decision is about a call that isn't in doubt.
        CorpusError
            If the database was restored, and nobody has confirmed that its ledger is complete.
        """
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        with one_at_a_time(self.engine, self.study.id):
            ledger, started = self.ledger, time.time()
            ledger.doubt_what_stopped()
            check_decisions(ledger, decisions)
            if not decisions.current:
                self.check_current()
            there = self.submissions(take_in=True)
            by_assignment = {one.assignment: one for one in there}
            comparison = Comparison(ledger, self.platform)
            everything = ledger.restored_at() is not None
            findings = self.findings(there)
            deeds = list(_compared(comparison, there, findings, everything=everything))
            if decisions.current:
                ledger.confirm_current()
            deeds += decide(ledger, self.platform, by_assignment, decisions)
            # What was found out and decided may change what is due.
            deeds += settle(comparison, self.findings(there), wishes)
            new = [e for e in ledger.entries() if is_open(e) and e.attempted_at >= started]
            paid = {entry.call.assignment for entry in new}
            again = Comparison(ledger, self.platform)
            deeds += _payments(again, [one for one in there if one.assignment in paid], findings)
            if wishes.leave_out_unknown:
                deeds += leave_out(self.engine, self.study, self.provider.name)
            if deeds:
                counts = Counter(deed.what for deed in deeds if not deed.problem)
                self.note("collected", **{str(what): count for what, count in counts.items()})
        return deeds

    def note(self, action: str, **details: str | float) -> None:
        """Note in the audit trail what was done at the platform."""
        platform = self.ledger.provider
        with transaction(self.engine) as session:
            note(session, COMMAND_LINE, action, self.study.name, platform=platform, **details)


def _compared(
    comparison: Comparison,
    there: Sequence[Submission],
    findings: Sequence[Finding],
    *,
    everything: bool,
) -> Iterator[Deed]:
    """Compare what was approved and rejected, and payments: all, or those that aren't settled."""
    yield from comparison.standings(there, {f.assignment: f.participation_id for f in findings})
    open_ = {e.call.assignment for e in comparison.ledger.entries() if is_open(e)}
    chosen = [one for one in there if everything or one.assignment in open_]
    yield from _payments(comparison, chosen, findings)


def _payments(
    comparison: Comparison, there: Iterable[Submission], findings: Sequence[Finding]
) -> Iterator[Deed]:
    here = {finding.assignment: finding.participation_id for finding in findings}
    for one in there:
        try:
            yield from comparison.payments(one, here.get(one.assignment))
        except PlatformError as error:
            yield Deed(one.assignment, "bonus", f"what was paid could not be looked up: {error}")


@contextmanager
def open_session(
    provider: Provider,
    study_name: str,
    *,
    instance: Path,
    database: str | None,
    sandbox: bool = False,
    endpoint: str | None = None,
) -> Iterator[CrowdSession]:
    """Yield a study and its platform, signed in; an error if a credential is missing."""
    config = existing_instance(instance, database)
    with ExitStack() as stack:
        engine = stack.enter_context(opened(config.database))
        check_current(engine)
        with reading(engine) as session:
            study = find_only_study(session, study_name)
        connect = provider.load().connect
        platform = None if connect is None else connect(sandbox=sandbox, endpoint=endpoint)
        if platform is not None:
            stack.enter_context(closing(platform))
        yield CrowdSession(config, engine, provider, study, platform)


def read_wishes(
    session: CrowdSession,
    *,
    no_approve: bool,
    approve: tuple[str, ...],
    reject: tuple[tuple[str, str], ...],
    bonus: tuple[tuple[str, str, str], ...],
    hold_flagged: bool,
    pay_bonus: bool,
    pay_partial: bool,
    keep_unknown: bool,
) -> Wishes:
    """Read settlement options; an error if an amount isn't one, or the study has no bonus."""
    with reading(session.engine, one_state=True) as reader:
        flagged = frozenset(flagged_people(reader, session.study.id))
    return Wishes(
        approve=not no_approve,
        approve_also=frozenset(approve),
        flagged=flagged,
        hold_flagged=hold_flagged,
        quality_bonus=_quality_bonus(session.study) if pay_bonus else None,
        reject=dict(reject),
        bonuses=[(assignment, _bonus(amount, reason)) for assignment, amount, reason in bonus],
        pay_partial=pay_partial,
        leave_out_unknown=not keep_unknown,
    )


def _quality_bonus(study: Study) -> Bonus:
    payment = restored(study.config).payment
    if payment is None or not payment.bonus:
        raise FormatError(
            "the study has no bonus", where=study.name, fix="give its payment a bonus"
        )
    return Bonus("quality", Decimal(str(payment.bonus)).quantize(CENT), "For careful work")


def _bonus(amount: str, reason: str) -> Bonus:
    try:
        value = Decimal(amount).quantize(CENT)
    except InvalidOperation:
        value = Decimal(0)
    if not (value.is_finite() and 0 < value <= MOST):
        raise FormatError(
            "the bonus is no amount of money", where=amount, fix="give one such as 0.50"
        )
    # The same bonus given again is the same one.
    key = sha256(f"{value} {reason}".encode()).hexdigest()[:12]
    return Bonus(key, value, reason)


REASON = "The platform doesn't know this person."


def leave_out(engine: Engine, study: Study, provider: str) -> Iterator[Deed]:
    """Leave out what unknown people answered, and take back what of it is known now."""
    with transaction(engine) as session:
        knowledge = platform_knowledge(session, study.id)
        wanted = select(Person).where(Person.id.in_(knowledge), Person.provider == provider)
        for person in session.scalars(wanted.order_by(Person.id)).all():
            if knowledge[person.id] == "unknown":
                count = sum(
                    _leave_out(session, study, a) for a in _answers_of(session, study, person)
                )
                note = f"{count} left out, for the platform doesn't know who came"
            else:
                left = [a for a in _answers_of(session, study, person) if _was_left_out(session, a)]
                for answer in left:
                    restore(session, study, answer, _actor(session), now=now())
                count = len(left)
                note = f"{count} count again, for the platform knows who came"
            if count:
                yield Deed(f"of {subject_of(person)}:", "answers", note=note)


def _answers_of(session: Session, study: Study, person: Person) -> Sequence[Answer]:
    wanted = select(Answer).where(Answer.study_id == study.id, Answer.person_id == person.id)
    return session.scalars(wanted.order_by(Answer.id)).all()


def _leave_out(session: Session, study: Study, answer: Answer) -> bool:
    if answer.excluded:
        return False
    program = _actor(session)
    try:
        exclude(session, study, answer, program, REASON, again=True, now=now())
    except Refusal:  # nobody else is asked this
        exclude(session, study, answer, program, REASON, now=now())
    return True


def _was_left_out(session: Session, answer: Answer) -> bool:
    """Check that this program left an answer out, and that nobody has changed it since."""
    if not answer.excluded:
        return False
    wanted = select(Remark).where(Remark.answer_id == answer.id, Remark.kind != "commented")
    last = session.scalars(wanted.order_by(Remark.id.desc())).first()
    return last is not None and last.text == REASON


def _actor(session: Session) -> Person:
    """Return the actor's name where the program leaves answers out."""
    wanted = select(Person).where(
        Person.provider == COMMAND_LINE, Person.external_hash == COMMAND_LINE
    )
    found = session.scalars(wanted).first()
    if found is None:
        found = Person(
            id=new_id(),
            role="worker",
            provider=COMMAND_LINE,
            external_hash=COMMAND_LINE,
            profile={},
            created_at=now(),
        )
        session.add(found)
        session.flush()
    return found
