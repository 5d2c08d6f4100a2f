"""The one family of errors that people see: what is wrong, where, and how to fix it."""

from __future__ import annotations

from collections.abc import Sequence


class CorpusError(Exception):
    """Bad input, told so that its owner can mend it.

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
        What is wrong, in the order in which it is told.
    """

    def __init__(self, errors: Sequence[CorpusError]) -> None:
        self.errors = tuple(errors)
        super().__init__("\n".join((f"{len(errors)} things are wrong:", *map(str, errors))))
