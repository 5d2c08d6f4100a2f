"""What this machine has of what the toolkit needs, and how to get what is missing.

A check is a function without arguments that returns what it found, in a few words, or
raises a :class:`~g3.errors.CorpusError` that says what is missing. What you may do without,
it returns as a :class:`Remark`. Installed distributions
name theirs in the entry point group ``ct.checks``.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from corpus_tools.runtime.extras import asked_extra
from g3.errors import CorpusError

ENTRY_POINT_GROUP = "ct.checks"


@dataclass(frozen=True, slots=True)
class Remark:
    """What isn't there, and needn't be."""

    found: str
    fix: str


Check: TypeAlias = Callable[[], str | Remark]


@dataclass(frozen=True, slots=True)
class Finding:
    """What a check came to."""

    name: str
    ok: bool
    """Whether all that is needed is there."""
    found: str
    fix: str = ""
    """How to mend it, or how to get what isn't there and needn't be; else empty."""


def checks() -> dict[str, Check]:
    """The checks of all installed distributions by name, sorted."""
    points = importlib.metadata.entry_points(group=ENTRY_POINT_GROUP)
    return {point.name: _loaded(point) for point in sorted(points, key=lambda p: p.name)}


def diagnose(named: dict[str, Check], *, extras_needed: bool = True) -> Iterator[Finding]:
    """Run checks one by one, even if others fail.

    Parameters
    ----------
    extras_needed
        A check that fails for want of an extra that isn't installed fails; else that is a remark.
    """
    for name, check in named.items():
        try:
            found = check()
            if isinstance(found, Remark):
                yield Finding(name, True, found.found, found.fix)
            else:
                yield Finding(name, True, found)
        except CorpusError as error:
            wrong = f"{error.where}: {error.what}" if error.where else error.what
            remark = not extras_needed and asked_extra(error.fix) is not None
            yield Finding(
                name, remark, wrong, f"if you want it: {error.fix}" if remark else error.fix
            )
        except Exception as error:  # a broken library may raise anything
            reason = f"{type(error).__name__}: {error}"
            fix = "install the package again; if that doesn't help, please report this"
            yield Finding(name, False, reason, fix)


def _loaded(point: importlib.metadata.EntryPoint) -> Check:
    def check() -> str | Remark:
        found: str | Remark = point.load()()
        return found

    return check
