"""Messages for people about refused requests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from annotation_app.core.languages import N_
from g3.errors import FormatError

TO_SIGN_IN = N_(
    "You are not signed in, or were signed out. Sign in; nothing that you typed is lost."
)
TO_OPEN_AGAIN = N_(
    "Your browser isn't known here any more. Open the study's address again; "
    "what you typed is kept in this browser."
)
"""Advice for people who came without a login: they can't sign in."""


@dataclass(frozen=True, slots=True)
class FieldProblem:
    """A problem with a part of an answer, in plain words."""

    field: str
    message: str


class Refusal(Exception):  # noqa: N818 - it is no error, it is an answer
    """A request that can't be done as it is.

    Parameters
    ----------
    status
        Status of HTTP.
    message
        Message for the person.
    problems
        Problems of an answer, field by field.
    """

    def __init__(self, status: int, message: str, problems: Sequence[FieldProblem] = ()) -> None:
        self.status = status
        self.message = message
        self.problems = tuple(problems)
        super().__init__(message)

    def as_error(self, where: str) -> FormatError:
        """Return the refusal as a command-line error: the problem and its remedy."""
        what, _, fix = self.message.rstrip(".").partition(". ")
        return FormatError(what[:1].lower() + what[1:], where=where, fix=fix[:1].lower() + fix[1:])
