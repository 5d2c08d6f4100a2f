"""Interface of a crowd platform for a study."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Literal, Protocol, TypeAlias

from annotation_app.store.models import Participation, TaskName
from g3.errors import CorpusError

Standing: TypeAlias = Literal["working", "submitted", "approved", "rejected", "returned"]
"""Platform's status of an assignment: a worker has it, has sent it in, the requester has approved
or rejected it, or the worker gave it back or ran out of time."""


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
    """Description of the study, as the title; workers read both."""
    task: TaskName
    items: int
    """Number of items of the task in an assignment."""
    people: int
    """Total number of assignments, including existing ones."""
    reward: Decimal
    """Reward for an assignment, in units of the platform's currency."""
    minutes: int
    """Expected duration of an assignment, in minutes."""
    url: str
    """Address where workers arrive."""
    code: str
    """Code that the platform takes as a proof that the work was done."""
    min_approval: int = 0
    """Percentage of somebody's earlier work, for anybody, that was approved; 0 for no matter."""
    min_approved: int = 0
    """Least number of approved assignments."""

    @property
    def label(self) -> str:
        """Label by which the platform finds this work again."""
        return f"{label_prefix(self.study_id)}{self.task} {self.items}"


@dataclass(frozen=True, slots=True)
class Posted:
    """Work at the platform: its id or ids, and the address where people can look at it."""

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
    """Reward for its approval; None if the platform doesn't report it."""


@dataclass(frozen=True, slots=True)
class Offered:
    """Work as a platform offers it: a study there, or a HIT."""

    id: str
    label: str
    """Label at the platform, which anybody with the account may change."""
    reward: Decimal | None
    """Reward for an assignment; None if the platform doesn't report it."""


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
        """Return the platform's reference of an earlier call's result."""

    def in_doubt(self) -> Sequence[str]:
        """Return the calls of unknown outcome."""

    def settle(self, key: str, reference: str | None) -> None:
        """Settle a call in doubt by the platform's record.

        Parameters
        ----------
        reference
            Id of the result; None if the platform shows that the call was not carried out.
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
            Description of the offer, for people.
        call
            Returns the platform's id of the result.
        reward
            Reward for an assignment of the offer.
        token_lasts_s
            Time for which the platform recognises a repeated call by its token, in seconds.
        """


class Platform(Protocol):
    """A platform that answers requests, with credentials.

    All methods raise :class:`PlatformError` if surely nothing was done, and
    :class:`LostReplyError` if the outcome is unknown. They never repeat a call by themselves that
    offers, approves, rejects or pays.
    """

    realm: str
    """Realm of names: ``sandbox`` where that is a platform by itself."""
    token_lasts_s: float
    """Time in seconds within which a bonus sent again by the same reference is paid only once.

    0 where that would pay twice.
    """
    lists_all: bool
    """True if the platform also lists assignments still in progress."""

    def post(self, posting: Posting, calls: Calls) -> Posted:
        """Offer work, as far as it isn't offered already."""

    def offered(self, study_id: str, ids: Collection[str]) -> Sequence[Offered]:
        """Return all work that has a label of a study, or one of the ids."""

    def submissions(self, work: Offered) -> Iterator[Submission]:
        """Return all assignments of some work."""

    def standing(self, submission: Submission) -> Standing:
        """Return the platform's current status of one assignment."""

    def approve(self, submission: Submission) -> None:
        """Accept and pay an assignment that was sent in."""

    def reject(self, submission: Submission, reason: str) -> None:
        """Refuse an assignment that was sent in."""

    def prepare(self, submission: Submission, bonus: Bonus) -> str:
        """Return a reference for a bonus. Nothing is paid."""

    def pay(self, submission: Submission, bonus: Bonus, reference: str) -> None:
        """Pay a prepared bonus."""

    def paid(self, submission: Submission) -> Sequence[Decimal]:
        """Return the amounts of all bonuses that the platform reports as paid for an assignment."""

    def close(self) -> None:
        """Close the connections."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """A worker who arrives from a platform."""

    provider: str
    """Provider of the id."""
    person: str | None
    """The platform's id of the worker; None is anybody, and somebody new without a cookie."""
    assignment: str | None
    """The platform's id of the assignment; None with `person`."""
    is_preview: bool = False
    """True if the visitor only previews the work."""
    submit_to: str = ""
    """Address to which the platform wants the finished assignment sent."""


@dataclass(frozen=True, slots=True)
class Ending:
    """Form or link with which a worker completes an assignment at the platform."""

    address: str = ""
    """Address to open, or to send `fields` to; empty if the code is all."""
    fields: Mapping[str, str] | None = None
    """Fields to send as a form; None for a plain link."""


Entrance: TypeAlias = Callable[[Mapping[str, str], str], Arrival]
"""Reader of a worker's arrival, from an address's arguments and the study's id. Raises
:class:`annotation_app.core.problems.Refusal`."""

Exit: TypeAlias = Callable[[Participation, str], Ending]
"""Exit of a worker whose work was received, with a completion code."""


class Connect(Protocol):
    """Connection to a platform."""

    def __call__(self, *, sandbox: bool, endpoint: str | None) -> Platform:
        """Sign in with credentials from the environment."""


@dataclass(frozen=True, slots=True)
class Gateway:
    """Functions of a provider."""

    enter: Entrance
    leave: Exit
    connect: Connect | None = None
    """Connection to the provider; None for links, which have none."""
    query: str = field(default="")
    """Query added to the address where workers arrive."""


def label_prefix(study_id: str) -> str:
    """Return the prefix of the labels of a study's postings."""
    return f"g3 {study_id} "
