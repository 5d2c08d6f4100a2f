"""Offers of work in the ledger: none is made twice, also when an answer is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from annotation_app.crowds.ledger import OPEN, Call, Entry, Ledger
from annotation_app.crowds.platform import LostReplyError, PlatformError
from annotation_app.store.installation import now
from g3.errors import FormatError

AGAIN = "--publish-again"


@dataclass(frozen=True, slots=True)
class Offers:
    """The ledger, as a platform sees it; see :class:`annotation_app.crowds.platform.Calls`."""

    ledger: Ledger

    def reference(self, key: str) -> str | None:
        """What an earlier call made, as the platform calls it."""
        entry = self.ledger.find("publish", key)
        return None if entry is None else entry.reference

    def in_doubt(self) -> list[str]:
        """The calls of which nobody knows whether they were carried out."""
        doubts = self.ledger.entries(*OPEN)
        return [entry.call.key for entry in doubts if entry.call.what == "publish"]

    def settle(self, key: str, reference: str | None) -> None:
        """Say what the platform shows of a call in doubt."""
        entry = self.ledger.find("publish", key)
        if entry is None or entry.state not in OPEN:
            return
        if reference is None:
            self.ledger.end(entry, "refused", f"{entry.problem}; the platform doesn't show it")
        else:
            self.ledger.refer(entry, reference)
            self.ledger.end(entry, "done")

    def make(
        self, key: str, about: str, call: Callable[[], str], *, token_lasts_s: float = 0.0
    ) -> str:
        """Make a call, unless it is in doubt whether an earlier one was carried out.

        Raises
        ------
        PlatformError
            If it is in doubt, or was refused.
        """
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
            return self.ledger.carry_out(Call("publish", key, reason=about), do, repeats=repeats)
        except LostReplyError as error:
            raise LostReplyError(
                f"{error.what}; whether this was offered is in doubt",
                where=about,
                fix="publish again: that looks first, and offers nothing twice",
            ) from error


def offer_again(ledger: Ledger, numbers: tuple[int, ...]) -> None:
    """Note that somebody has seen that offers in doubt aren't at the platform.

    Raises
    ------
    FormatError
        If there is no such offer in doubt.
    """
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
