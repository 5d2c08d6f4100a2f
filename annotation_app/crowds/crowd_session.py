"""A study at a platform, as the command line works with it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from hashlib import sha256
from pathlib import Path

from sqlalchemy import Engine

from annotation_app.core.config import Config, existing_instance
from annotation_app.crowds.crowd_registry import Provider
from annotation_app.crowds.doubts import decide, read_decisions, resolve
from annotation_app.crowds.ledger import Ledger, one_at_a_time
from annotation_app.crowds.platform import Bonus, Platform
from annotation_app.crowds.reconciliation import CENT, Finding, reconcile
from annotation_app.crowds.settlement import Deed, Wishes, settle
from annotation_app.dashboard.workers import flagged_people
from annotation_app.export.corpus_export import find_only_study
from annotation_app.store.audit import COMMAND_LINE, note
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Study
from annotation_app.store.salt import installation_salt
from annotation_app.store.schema import check_current
from annotation_app.studies.study_file import restored
from g3.errors import FormatError

MOST = Decimal(1000)
"""Larger bonuses are slips of the finger."""


@dataclass(frozen=True, slots=True)
class CrowdSession:
    """A study, where it is kept, and the platform that it is offered at."""

    config: Config
    engine: Engine
    provider: Provider
    study: Study
    platform: Platform | None

    def findings(self) -> list[Finding]:
        """How each assignment stands here and there."""
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        there = list(self.platform.submissions(self.study.id))
        return reconcile(
            self.engine,
            self.study,
            self.provider.name,
            there,
            salt=installation_salt(self.engine, self.config),
            now=time.time(),
        )

    @property
    def ledger(self) -> Ledger:
        """What was done at the platform."""
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        name = f"{self.provider.name} {self.platform.realm}".rstrip()
        return Ledger(self.engine, self.study.id, name)

    def settle(
        self, wishes: Wishes, confirm_paid: tuple[int, ...] = (), pay_again: tuple[int, ...] = ()
    ) -> list[Deed]:
        """Look at what is in doubt; then approve, reject and pay.

        `confirm_paid` and `pay_again` are entries of the ledger in doubt that somebody has decided
        about; a FormatError says if there are no such entries.
        """
        assert self.platform is not None  # noqa: S101 - only commands of platforms ask this
        with one_at_a_time(self.engine, self.study.id):
            self.ledger.doubt_what_stopped()
            decisions = read_decisions(self.ledger, confirm_paid, pay_again)
            there = {f.assignment: f.submission for f in self.findings() if f.submission}
            deeds = [
                *resolve(self.ledger, self.platform, there),
                *decide(self.ledger, self.platform, there, decisions),
            ]
            # What was found out may change what is due.
            deeds += settle(self.ledger, self.platform, self.findings(), wishes)
            if deeds:
                counts = Counter(deed.what for deed in deeds if not deed.problem)
                self.note("collected", **{str(what): count for what, count in counts.items()})
        return deeds

    def note(self, action: str, **details: str | float) -> None:
        """Note in the audit trail what was done at the platform."""
        platform = self.ledger.provider
        with transaction(self.engine) as session:
            note(session, COMMAND_LINE, action, self.study.name, platform=platform, **details)


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
    """A study, and the platform with the environment's credentials; an error if one is missing."""
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
) -> Wishes:
    """What somebody wants done; an error if an amount isn't one, or the study has no bonus."""
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
