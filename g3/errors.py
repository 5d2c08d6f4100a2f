"""The one family of errors that people see: what is wrong, where, and how to fix it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import TypeVar

Error = TypeVar("Error", bound="CorpusError")
MOST_NAMES = 40
"""An error lists so many names at most."""


class CorpusError(Exception):
    """Bad input, with what its owner needs to correct it.

    Parameters
    ----------
    what
        What is wrong, one sentence without a final full stop.
    where
        Where it is: file, record and field, as far as they are known.
    fix
        What to do about it.
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
        """The error for a name that isn't known; the parameters are those of `unknown_name`."""
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


class ManyError(FormatError):
    """Several errors, each on a line of its own.

    Parameters
    ----------
    errors
        What is wrong, in the order in which it is shown.
    """

    def __init__(self, errors: Sequence[CorpusError]) -> None:
        self.errors = tuple(errors)
        super().__init__("\n".join((f"{len(errors)} things are wrong:", *map(str, errors))))


def unknown_name(
    kind: str, name: object, known: Iterable[object], more: str = ""
) -> tuple[str, str]:
    """What is wrong with a name that isn't known, and what to do: one form for all such errors.

    Parameters
    ----------
    kind
        What it should name, such as "layout".
    known
        The names there are, in the order in which they are shown.
    more
        What else can be done.

    Returns
    -------
    what, fix
        As :class:`CorpusError` takes them. The nearest name comes first.
    """
    values = {str(value): value for value in known}
    names, near = list(values), get_close_matches(str(name), values, 1)
    fixes = [f"did you mean {values[near[0]]!r}?"] if near else []
    if names:
        cut = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        fixes.append(f"give one of {', '.join(names[:MOST_NAMES])}{cut}")
    fix = " ".join(fixes) or "there are none"
    return f"there is no {kind} {name!r}", f"{fix}; {more}" if more else fix
