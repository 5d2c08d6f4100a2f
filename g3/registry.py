"""Registries: members by name, to which other distributions can add their own.

The members of other distributions are visible to all, in worker processes as well: the module
of a registry calls :meth:`Registry.load_others` after it has added its own.
"""

from __future__ import annotations

import importlib.metadata
import logging
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from g3.errors import CorpusError

Member = TypeVar("Member")
Function = TypeVar("Function", bound=Callable[..., Any])


class Registry(Mapping[str, Member]):
    """Members by their names, in the order in which they were added.

    Parameters
    ----------
    kind
        Kind of the members, such as "grounder".
    group
        The entry point group in which other distributions name modules; importing one of these
        adds what it has. Empty if they can't.
    error
        Raised for a name that isn't known.
    see
        Page or command that shows the members, for people who gave such a name.
    """

    def __init__(
        self,
        kind: str,
        group: str = "",
        *,
        error: type[CorpusError] = CorpusError,
        see: str = "",
    ) -> None:
        self.kind, self.group = kind, group
        self._error, self._see = error, see
        self._members: dict[str, Member] = {}

    def __getitem__(self, name: str) -> Member:
        return self._members[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def add(self, member: Member, name: str = "") -> Member:
        """Add a member, by its own name if none is given.

        Raises
        ------
        ValueError
            If another member has the name.
        """
        name = name or str(getattr(member, "name"))  # noqa: B009 - members of any type
        if name in self._members:
            raise ValueError(f"the {self.kind} {name!r} is registered already")
        self._members[name] = member
        return member

    def adding(
        self, name: str, make: Callable[[str, Function], Member]
    ) -> Callable[[Function], Function]:
        """Return a decorator that adds a member made of a function and its docstring's first line.

        Raises
        ------
        ValueError
            When it decorates, if another member has the name.
        """

        def add(function: Function) -> Function:
            self.add(make(summary_of(function), function), name)
            return function

        return add

    def remove(self, name: str) -> None:
        """Take a member out again; nothing happens if there is none."""
        self._members.pop(name, None)

    def by_name(self) -> tuple[Member, ...]:
        """Return all members in the order of their names."""
        return tuple(self._members[name] for name in sorted(self._members))

    def known(self, name: str, where: str = "") -> Member:
        """Return the member with a name; the error for another name shows the nearest ones."""
        self.check((name,), where)
        return self._members[name]

    def check(self, names: Collection[str], where: str = "") -> None:
        """Refuse names that aren't known."""
        more = self._see
        if self.group and not more:
            more = f"or install a package that adds it by the entry point group {self.group}"
        for name in sorted(set(names) - set(self)):
            raise self._error.unknown(self.kind, name, sorted(self), where=where, more=more)

    def load_others(self) -> None:
        """Have other distributions add theirs."""
        load_extensions(self.group)


def load_extensions(group: str) -> None:
    """Import the modules that installed distributions name in an entry point group.

    One that can't be imported is noted in the log and stops no other.
    """
    for point in sorted(importlib.metadata.entry_points(group=group), key=lambda p: p.name):
        try:
            point.load()
        except Exception as error:  # whatever it is, the rest must go on working
            logging.getLogger(__name__).warning(
                "%s: the extension %s can't be loaded: %s: %s",
                group,
                point.name,
                type(error).__name__,
                error,
            )


def summary_of(function: Callable[..., Any]) -> str:
    """Return the first line of a function's docstring."""
    return (function.__doc__ or "").strip().split("\n")[0]


@contextmanager
def blaming(member: str, where: str) -> Iterator[None]:
    """Turn any exception of other people's code into an error that names its owner and place."""
    try:
        yield
    except CorpusError:
        raise
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        place = f"at line {at.lineno} of {at.filename}"
        raise CorpusError(
            f"{member} fails: {type(error).__name__}: {error}, {place}",
            where=where,
            fix="correct it, or uninstall it",
        ) from error
