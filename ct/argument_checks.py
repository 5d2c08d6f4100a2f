"""Checks of the front door's arguments, before anything takes minutes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from g3.errors import CorpusError, unknown_name


def one_of(name: str, given: object, known: Iterable[object]) -> None:
    """Refuse a value that is none of the known values.

    Parameters
    ----------
    name
        Name of the argument.
    given
        Value of the argument.
    known
        Allowed values.
    """
    values = list(known)
    if given not in values:
        _, fix = unknown_name(name, given, values)
        raise CorpusError(f"{name} can't be {given!r}", fix=fix)


def positive(name: str, given: float | None) -> None:
    """Refuse a value that isn't a number above 0; None stands for the default."""
    is_number = isinstance(given, (int, float)) and not isinstance(given, bool)
    if given is not None and not (is_number and given > 0):
        raise CorpusError(f"{name} can't be {given!r}", fix="give a number above 0")


def a_kind_of(name: str, given: object, kinds: tuple[type, ...], fix: str) -> None:
    """Refuse a value of another type; `fix` names an allowed value."""
    if not isinstance(given, kinds):
        raise CorpusError(f"{name} can't be of the type {type(given).__name__}", fix=fix)


def known_options(given: Iterable[str], known: Collection[str], where: str) -> None:
    """Refuse unknown options."""
    for name in given:
        if name not in known:
            raise CorpusError.unknown("option", name, sorted(known), where=where)


def several(names: Any) -> tuple[Any, ...]:
    """Split names given as a list, or as one text with commas, as on the command line.

    What is neither a text nor a list is alone.
    """
    parts = names.split(",") if isinstance(names, str) else names
    parts = parts if isinstance(parts, Iterable) else (parts,)
    return tuple(part.strip() if isinstance(part, str) else part for part in parts)
