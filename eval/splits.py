"""Splits of examples into training and test sets.

A scenario's examples are never on both sides: its commands describe the same video.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.tables.json_text import read_text
from g3.errors import CorpusError
from g3.short_repr import short_repr
from g3.storage.text_lines import split_lines

IntArray: TypeAlias = npt.NDArray[np.intp]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """One division of examples.

    Parameters
    ----------
    name
        Names of the held-out scenarios.
    train, test
        Indices of the examples on each side.
    """

    name: str
    train: IntArray
    test: IntArray

    def __post_init__(self) -> None:
        for side, rows in (("train on", self.train), ("test on", self.test)):
            if not len(rows):
                raise CorpusError(
                    f"there are no examples to {side}",
                    where=f"split {self.name}",
                    fix="take a corpus with annotations of more scenarios, or another split",
                )


def leave_one_out(scenarios: Sequence[str]) -> tuple[Split, ...]:
    """Hold out each scenario in turn, so that every example is tested exactly once."""
    return tuple(hold_out(scenarios, [name]) for name in sorted(set(scenarios)))


def hold_out(scenarios: Sequence[str], held_out: Collection[str]) -> Split:
    """Test on some scenarios and train on the others."""
    chosen = set(held_out)
    tested = np.array([name in chosen for name in scenarios], dtype=bool)
    return Split(", ".join(sorted(chosen)), np.flatnonzero(~tested), np.flatnonzero(tested))


def read_scenarios(given: str, known: Collection[str]) -> tuple[str, ...]:
    """Read the scenarios named on the command line.

    Parameters
    ----------
    given
        Names with commas between, or a file with one name a line (empty lines and what
        follows a # are skipped).
    """
    names, where = _names(given, known)
    for name in sorted(set(names) - set(known)):
        raise CorpusError.unknown("scenario", name, sorted(known), where=where)
    if not names:
        fix = f"give one of {', '.join(sorted(known))}"
        raise CorpusError("no scenario is named", where=where, fix=fix)
    return tuple(sorted(set(names)))


def _names(given: str, known: Collection[str]) -> tuple[list[str], str]:
    listed = [name.strip() for name in given.split(",") if name.strip()]
    if set(listed) <= set(known) or not _is_file(given):
        return listed, "--test-scenarios"
    lines = split_lines(read_text(Path(given)))
    return [name for line in lines if (name := line.partition("#")[0].strip())], given


def _is_file(name: str) -> bool:
    try:
        return Path(name).is_file()
    except (OSError, ValueError):  # a list of names can be too long for a file's name
        return False
