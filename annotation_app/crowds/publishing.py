"""Offering a study's work. No offer is made twice, also when an answer is lost."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from urllib.parse import urlencode, urlsplit

from annotation_app.core.languages import gettext, speaking
from annotation_app.crowds.crowd_session import CrowdSession
from annotation_app.crowds.ledger import OPEN, Call, Entry, Ledger, one_at_a_time
from annotation_app.crowds.links import INVITATION
from annotation_app.crowds.participation import Offer, completion_code, sign_offer
from annotation_app.crowds.platform import LostReplyError, PlatformError, Posted, Posting
from annotation_app.crowds.reconciliation import CENT
from annotation_app.people.participants import invitation
from annotation_app.store.installation import now
from annotation_app.store.models import TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.task_registry import task_of
from g3.errors import FormatError

AGAIN = "--publish-again"


@dataclass(frozen=True, slots=True)
class Offers:
    """The ledger, as a platform sees it; see :class:`annotation_app.crowds.platform.Calls`."""

    ledger: Ledger

    def reference(self, key: str) -> str | None:
        """Return the platform's reference of an earlier call's result."""
        entry = self.ledger.find("publish", key)
        return None if entry is None else entry.reference

    def in_doubt(self) -> list[str]:
        """Return the calls of unknown outcome."""
        doubts = self.ledger.entries(*OPEN)
        return [entry.call.key for entry in doubts if entry.call.what == "publish"]

    def settle(self, key: str, reference: str | None) -> None:
        """Settle a call in doubt by the platform's record."""
        entry = self.ledger.find("publish", key)
        if entry is None or entry.state not in OPEN:
            return
        if reference is None:
            self.ledger.end(entry, "refused", f"{entry.problem}; the platform doesn't show it")
        else:
            self.ledger.refer(entry, reference)
            self.ledger.end(entry, "done")

    def make(
        self,
        key: str,
        about: str,
        call: Callable[[], str],
        *,
        reward: Decimal | None = None,
        token_lasts_s: float = 0.0,
    ) -> str:
        """Make a call, unless it is in doubt whether an earlier one was carried out."""
        entry = self.ledger.find("publish", key)
        repeats = None
        if entry is not None and entry.state in OPEN:
            if now() - entry.attempted_at < token_lasts_s:
                repeats = entry
            else:
                raise PlatformError(
                    f"whether this was offered before is in doubt (entry {entry.id}), and the "
                    "platform doesn't show it",
                    where=about,
                    fix="publish again in some minutes; if you see at the platform that it is "
                    f"not there, add {AGAIN} {entry.id}",
                )

        def do(claimed: Entry) -> str:
            made = call()
            self.ledger.refer(claimed, made)
            return made

        try:
            noted = Call("publish", key, amount=reward, reason=about)
            return self.ledger.carry_out(noted, do, repeats=repeats)
        except LostReplyError as error:
            raise LostReplyError(
                f"{error.what}; whether this was offered is in doubt",
                where=about,
                fix="publish again: that looks first, and offers nothing twice",
            ) from error


def offer_again(ledger: Ledger, numbers: tuple[int, ...]) -> None:
    """Note that somebody has seen that offers in doubt aren't there; an error if one isn't so."""
    known = {entry.id: entry for entry in ledger.entries("in doubt")}
    for number in numbers:
        entry = known.get(number)
        if entry is None or entry.call.what != "publish":
            raise FormatError(
                f"the ledger has no offer {number} in doubt",
                where=AGAIN,
                fix="`ct crowd reconcile` shows what is in doubt",
            )
    for number in dict.fromkeys(numbers):
        ledger.decide(known[number], "refused", "to be offered again")


def publish_posting(
    session: CrowdSession,
    *,
    url: str,
    task: TaskName | None,
    items: int,
    people: int,
    minutes: int,
    min_approval: int,
    min_approved: int,
    publish_again: tuple[int, ...] = (),
) -> Posted:
    """Offer work at a platform, as far as it isn't offered already.

    Parameters
    ----------
    publish_again
        Entries of the ledger in doubt that somebody has seen to be missing there.

    Raises
    ------
    FormatError
        If the study can't be offered so.
    PlatformError
        If the platform refuses, or it is unknown whether it has offered the work.
    """
    assert session.platform is not None  # noqa: S101 - only commands of platforms offer work
    study = restored(session.study.config)
    offer = _offer(session, study, task, items)
    if study.payment is None:
        raise FormatError(
            "the study doesn't say what is paid", where=study.name, fix="give it a payment"
        )
    with speaking(study.locale):
        description = gettext(task_of(offer.task).words.offer)
    posting = Posting(
        study_id=session.study.id,
        title=study.title,
        description=description,
        task=offer.task,
        items=items,
        people=people,
        reward=(Decimal(str(study.payment.amount)) * items).quantize(CENT),
        minutes=minutes,
        url=_address(session, url, offer, session.provider.load().query),
        code=completion_code(session.config.secret_key, offer),
        min_approval=min_approval,
        min_approved=min_approved,
    )
    with one_at_a_time(session.engine, session.study.id):
        session.ledger.doubt_what_stopped()
        session.check_current()
        offer_again(session.ledger, publish_again)
        posted = session.platform.post(posting, Offers(session.ledger))
        session.note("published", task=posting.task, people=posted.people, added=posted.added)
    return posted


def publish_links(
    session: CrowdSession, *, url: str, task: TaskName | None, items: int, people: int
) -> Iterator[str]:
    """Return the open link of a study, or new links for each invited person.

    An error if the study has no such task, or several links are wanted of one that is open.
    """
    study = restored(session.study.config)
    offer = _offer(session, study, task, items)
    if study.access == "open":
        if people > 1:
            raise FormatError(
                "the study is open: all people use the same link",
                where=study.name,
                fix="leave out --people, or give its file `access: invited`",
            )
        yield _address(session, url, offer, "")
        return
    for _ in range(people):
        name = secrets.token_hex(16)
        token = invitation(session.config.secret_key, session.study.id, name)
        yield _address(session, url, offer, urlencode({INVITATION: token}))


def _offer(session: CrowdSession, study: StudyConfig, task: TaskName | None, items: int) -> Offer:
    chosen = task or next(iter(study.tasks))
    if chosen not in study.tasks:
        raise FormatError(
            f"the study has no task {chosen}",
            where=study.name,
            fix=f"use one of {', '.join(study.tasks)}",
        )
    return Offer(session.study.id, chosen, items)


def _address(session: CrowdSession, url: str, offer: Offer, query: str) -> str:
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise FormatError(
            "this is no address", where=url, fix="give one such as https://lab.example.org"
        )
    token = sign_offer(session.config.secret_key, offer)
    address = f"{url.rstrip('/')}/crowd/{session.provider.name}/{token}"
    return f"{address}?{query}" if query else address
