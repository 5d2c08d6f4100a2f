"""What a crowd platform does for a study."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Literal, Protocol, TypeAlias

from annotation_app.store.crowd_models import Participation
from annotation_app.store.models import TaskName
from g3.errors import CorpusError

Standing: TypeAlias = Literal["working", "submitted", "approved", "rejected", "returned"]
"""What a platform says of an assignment: a worker has it, has sent it in, the requester has
approved or rejected it, or the worker gave it back or ran out of time."""


class PlatformError(CorpusError):
    """A request that a platform refused, or that surely never reached it: nothing was done."""


class LostReplyError(PlatformError):
    """A request that was sent and not answered. Nobody knows whether it was carried out."""


@dataclass(frozen=True, slots=True)
class Posting:
    """Work that is offered at a platform: so many items of a task, to so many people."""

    study_id: str
    title: str
    description: str
    """Of the study, as the title; workers read both."""
    task: TaskName
    items: int
    """How many items of the task an assignment asks for."""
    people: int
    """How many assignments there are to be, also those that there are already."""
    reward: Decimal
    """For an assignment, in units of the platform's currency."""
    minutes: int
    """How long an assignment is expected to take."""
    url: str
    """Where workers come in."""
    code: str
    """What the platform takes as a proof that the work was done."""
    min_approval: int = 0
    """Percentage of somebody's earlier work, for anybody, that was approved; 0 for no matter."""
    min_approved: int = 0
    """How much of it, in assignments."""

    @property
    def label(self) -> str:
        """What this work is found again by at the platform."""
        return f"{label_prefix(self.study_id)}{self.task} {self.items}"


@dataclass(frozen=True, slots=True)
class Posted:
    """What there is at the platform: its id or ids, and where people can look at it."""

    ids: tuple[str, ...]
    people: int
    added: int
    address: str


@dataclass(frozen=True, slots=True)
class Submission:
    """An assignment as a platform knows it."""

    assignment: str
    person: str
    """The platform's id of the worker. Never stored, only compared by its hash."""
    group: str
    """The HIT or study that it belongs to."""
    standing: Standing
    reward: Decimal | None = None
    """What its approval pays; None if the platform doesn't say."""


@dataclass(frozen=True, slots=True)
class Offered:
    """Work as a platform offers it: a study there, or a HIT."""

    id: str
    label: str
    """What the platform has as its label, which anybody with the account may change."""
    reward: Decimal | None
    """For an assignment; None if the platform doesn't say."""


@dataclass(frozen=True, slots=True)
class Bonus:
    """A payment beyond the reward. `key` distinguishes the bonuses of an assignment."""

    key: str
    amount: Decimal
    reason: str


class Calls(Protocol):
    """The ledger, as a platform uses it to offer work: each call is noted before it is made.

    `key` distinguishes a study's calls.
    """

    def reference(self, key: str) -> str | None:
        """What an earlier call made, as the platform calls it."""

    def in_doubt(self) -> Sequence[str]:
        """The calls of which nobody knows whether they were carried out."""

    def settle(self, key: str, reference: str | None) -> None:
        """Say what the platform shows of a call in doubt.

        Parameters
        ----------
        reference
            What was made; None if the platform shows that the call was not carried out.
        """

    def make(
        self,
        key: str,
        about: str,
        call: Callable[[], str],
        *,
        reward: Decimal | None = None,
        token_lasts_s: float = 0.0,
    ) -> str:
        """Make a call, unless it is in doubt whether an earlier one was carried out.

        Parameters
        ----------
        about
            What it offers, for people.
        call
            Gives the platform's id of what was made.
        reward
            For an assignment of what is made.
        token_lasts_s
            How long the platform knows a repeated call by its token.
        """


class Platform(Protocol):
    """A platform that can be asked, with credentials.

    All methods raise :class:`PlatformError` if surely nothing was done, and
    :class:`LostReplyError` if nobody knows. They never repeat a call by themselves that offers,
    approves, rejects or pays.
    """

    realm: str
    """Distinguishes what has the same name: ``sandbox`` where that is a platform by itself."""
    token_lasts_s: float
    """How long a bonus can be paid again by the same reference without being paid twice.

    0 where that would pay twice.
    """
    lists_all: bool
    """Whether the platform also lists assignments on which somebody is still at work."""

    def post(self, posting: Posting, calls: Calls) -> Posted:
        """Offer work, as far as it isn't offered already."""

    def offered(self, study_id: str, ids: Collection[str]) -> Sequence[Offered]:
        """All work that has a label of a study, or one of the ids."""

    def submissions(self, work: Offered) -> Iterator[Submission]:
        """All assignments of some work."""

    def standing(self, submission: Submission) -> Standing:
        """What the platform says now of one assignment."""

    def approve(self, submission: Submission) -> None:
        """Accept and pay an assignment that was sent in."""

    def reject(self, submission: Submission, reason: str) -> None:
        """Refuse an assignment that was sent in."""

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """A reference for a bonus. Nothing is paid."""

    def pay(self, submission: Submission, bonus: Bonus, reference: str) -> None:
        """Pay a prepared bonus."""

    def paid(self, submission: Submission) -> Sequence[Decimal]:
        """The amounts of all bonuses that the platform says it has paid for an assignment."""

    def close(self) -> None:
        """Close the connections."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """Somebody who comes in from a platform."""

    provider: str
    """Whose id it is."""
    person: str | None
    """The platform's id of the worker; None is anybody, and somebody new without a cookie."""
    assignment: str | None
    """The platform's id of the assignment; None with `person`."""
    is_preview: bool = False
    """Whether they only look at what the work is like."""
    submit_to: str = ""
    """Where the platform wants the assignment sent at the end."""


@dataclass(frozen=True, slots=True)
class Ending:
    """How a worker completes an assignment at the platform."""

    address: str = ""
    """Where to go, or to send `fields`; empty if the code is all."""
    fields: Mapping[str, str] | None = None
    """Sent as a form. None for a plain link."""


Entrance: TypeAlias = Callable[[Mapping[str, str], str], Arrival]
"""Reads who comes in, from an address's arguments and the study's id. Raises
:class:`annotation_app.core.problems.Refusal`."""

Exit: TypeAlias = Callable[[Participation, str], Ending]
"""Where a worker goes whose work was received, with a completion code."""


class Connect(Protocol):
    """Opens a platform."""

    def __call__(self, *, sandbox: bool, endpoint: str | None) -> Platform:
        """Sign in with credentials from the environment."""


@dataclass(frozen=True, slots=True)
class Gateway:
    """All that a provider does."""

    enter: Entrance
    leave: Exit
    connect: Connect | None = None
    """None where there is nothing to ask: links."""
    query: str = field(default="")
    """What is added to the address at which workers come in."""


def label_prefix(study_id: str) -> str:
    """How the labels of a study's postings begin."""
    return f"g3 {study_id} "
