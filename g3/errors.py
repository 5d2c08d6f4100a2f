"""The one family of errors that people see: what is wrong, where, and how to fix it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

Error = TypeVar("Error", bound="CorpusError")
MOST_NAMES = 12
"""Largest number of names that an error lists in full."""
MOST_NEAR = 3
"""Largest number of names that an error suggests."""
LEAST_ALIKE = 60.0
"""Smallest similarity of near names, of 100."""
LESS_ALIKE = 15.0
"""Largest difference in similarity between the nearest name and others that are suggested."""
LEAST_PART = 4
"""Least letters of a given name for which others may contain it."""
PART_SHARE = 0.9
"""Similarity, of 1, of a name that contains the given one."""


class CorpusError(Exception):
    """Bad input, with what its owner needs to correct it.

    Parameters
    ----------
    what
        The problem, one sentence without a final full stop.
    where
        Place of the problem: file, record and field, as far as they are known.
    fix
        Remedy for the problem.
    """

    def __init__(self, what: str, *, where: str = "", fix: str = "") -> None:
        self.what = what
        self.where = where
        self.fix = fix
        super().__init__(str(self))

    @classmethod
    def unknown(
        cls: type[Error],
        kind: str,
        name: object,
        known: Iterable[object],
        *,
        where: str = "",
        more: str = "",
    ) -> Error:
        """Return the error for an unknown name; the parameters are those of `unknown_name`."""
        what, fix = unknown_name(kind, name, known, more)
        return cls(what, where=where, fix=fix)

    def __str__(self) -> str:
        where = f"{self.where}: " if self.where else ""
        fix = f" ({self.fix})" if self.fix else ""
        return f"{where}{self.what}{fix}"


class SDCError(CorpusError):
    """An SDC tree that can't be read or isn't well formed."""


class FormatError(CorpusError):
    """A file or a record that doesn't have the form it should have."""


class ModelError(CorpusError):
    """A model that can't be loaded or doesn't fit what it is used with."""


class AnswerError(CorpusError):
    """Answer that picks out none of a question's options."""


class ManyError(FormatError):
    """Several errors, each on a line of its own.

    Parameters
    ----------
    errors
        The problems, in the order in which they are shown.
    """

    def __init__(self, errors: Sequence[CorpusError]) -> None:
        self.errors = tuple(errors)
        super().__init__("\n".join((f"{len(errors)} things are wrong:", *map(str, errors))))


def unknown_name(
    kind: str, name: object, known: Iterable[object], more: str = ""
) -> tuple[str, str]:
    """Return the problem and the fix for an unknown name: one form for all such errors.

    Parameters
    ----------
    kind
        Kind of thing that it should name, such as "layout".
    known
        The names there are, in the order in which they are shown.
    more
        Another remedy, such as the command that lists all names.

    Returns
    -------
    what, fix
        As :class:`CorpusError` takes them: the nearest names, and all of them where they are few.
    """
    values = {str(value): value for value in known}
    names, near = list(values), nearest(str(name), values)
    fixes = []
    if near:
        *others, last = (repr(values[one]) for one in near)
        fixes.append(f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?")
    if len(names) > len(near) and (len(names) <= MOST_NAMES or not (near or more)):
        cut = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        fixes.append(f"give one of {', '.join(names[:MOST_NAMES])}{cut}")
    fix = " ".join(fixes) or ("" if names else "there are none")
    if more:
        fix += f"{'' if not fix else ' ' if fix.endswith('?') else '; '}{more}"
    return f"there is no {kind} {name!r}", fix


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Return the known names that a mistyped one may stand for, the nearest first.

    A name is near if few letters differ, or if it contains what was given.

    >>> nearest("evl", ["eval", "train", "import"])
    ['eval']
    """
    from rapidfuzz import fuzz  # noqa: PLC0415 - only errors need it

    def alike(other: str) -> float:
        whole = fuzz.ratio(name.lower(), other.lower())
        if len(name) < LEAST_PART or len(other) < len(name):
            return whole
        return max(whole, PART_SHARE * fuzz.partial_ratio(name.lower(), other.lower()))

    score = {other: alike(other) for other in known}
    least = max(LEAST_ALIKE, max(score.values(), default=0.0) - LESS_ALIKE)
    near = sorted((o for o in score if score[o] >= least), key=lambda o: -score[o])
    return near[:MOST_NEAR]
