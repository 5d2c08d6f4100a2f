"""Modules of other distributions that add to a registry.

A registry that others may add to has an entry point group, and loads it after its own members:
whoever sees the registry sees the others' members too, in worker processes as well. Each entry
point names a module; importing it registers what it has.
"""

from __future__ import annotations

import importlib.metadata
import logging
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from g3.errors import CorpusError

Member = TypeVar("Member")
Function = TypeVar("Function", bound=Callable[..., Any])


def load_extensions(group: str) -> None:
    """Import the modules that installed distributions name in an entry point group.

    One that can't be imported is told in the log and stops no other.
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


def add_member(known: dict[str, Member], name: str, member: Member, *, kind: str) -> None:
    """Add a member to a registry.

    Parameters
    ----------
    kind
        What the members are, such as "grounder".

    Raises
    ------
    ValueError
        If another member has the name.
    """
    if name in known:
        raise ValueError(f"the {kind} {name!r} is registered already")
    known[name] = member


def registering(
    known: dict[str, Member], name: str, make: Callable[[str, Function], Member], *, kind: str
) -> Callable[[Function], Function]:
    """A decorator that adds to a registry what is made of a function and its first line of docs.

    Raises
    ------
    ValueError
        When it decorates, if another member has the name.
    """

    def register(function: Function) -> Function:
        add_member(known, name, make(summary_of(function), function), kind=kind)
        return function

    return register


def summary_of(function: Callable[..., Any]) -> str:
    """The first line of a function's docstring."""
    return (function.__doc__ or "").strip().split("\n")[0]


def member_named(name: str, known: Mapping[str, Member], *, kind: str, group: str) -> Member:
    """A member of a registry by its name.

    Parameters
    ----------
    kind
        What the members are, such as "grounder".
    group
        The entry point group in which other distributions add theirs.

    Raises
    ------
    CorpusError
        If there is none.
    """
    if name not in known:
        there = ", ".join(sorted(known))
        fix = f"give one of {there}; or install" if there else "install"
        raise CorpusError(
            f"there is no {kind} {name!r}",
            fix=f"{fix} a package that adds it by the entry point group {group}",
        )
    return known[name]


@contextmanager
def blaming(member: str, where: str) -> Iterator[None]:
    """Have whatever other people's code raises say whose it is, and where.

    Raises
    ------
    CorpusError
        If the code raises anything.
    """
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
