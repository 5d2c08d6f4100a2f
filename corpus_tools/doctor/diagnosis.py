"""Check of this machine for the toolkit's needs, with the fix of each missing one.

A check is a function without arguments that returns its result in a few words, or raises
a :class:`~g3.errors.CorpusError` that names the missing thing. A missing optional thing is
returned as a :class:`Remark`. Installed distributions register theirs in the entry point
group ``ct.checks``.
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
    """Result about a missing thing that is optional."""

    found: str
    fix: str


Check: TypeAlias = Callable[[], str | Remark]


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of a check."""

    name: str
    ok: bool
    """True if everything needed is there."""
    found: str
    fix: str = ""
    """Instruction for a repair or the installation of an optional thing; else empty."""


def checks() -> dict[str, Check]:
    """Return the checks of all installed distributions by name, sorted."""
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
            outcome = check()
            if isinstance(outcome, Remark):
                yield Finding(name, True, outcome.found, outcome.fix)
            else:
                yield Finding(name, True, outcome)
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
        outcome: str | Remark = point.load()()
        return outcome

    return check
