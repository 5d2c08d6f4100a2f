"""Finding the words of SDC fields in the command they came from.

People write the words of a clause, not their offsets. The words of one field stand in
the command in the order in which they are written; they may have gaps ("Put ... down").
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from g3.errors import SDCError
from g3.lengths import check_length
from g3.sdc.clauses import Span


class FieldWord(NamedTuple):
    """A word of a field.

    Parameters
    ----------
    start
        Its position in the command, if that is known.
    where
        Its source, for error messages.
    """

    text: str
    start: int | None = None
    where: str = ""


class _Placement(NamedTuple):
    """A way to place the first words of a field; the least one is the best."""

    overlaps: int
    inside_words: int
    gaps: int
    away: int
    starts: tuple[int, ...]


def align_words(
    fields: Iterable[Sequence[FieldWord]], command: str
) -> tuple[tuple[Span, ...], ...]:
    """Place the words of each field in a command.

    A field's words keep their order. Of all such placements, it takes that which shares the
    fewest words with the fields before it. Among ties the fewest split words of the command win,
    then the fewest gaps, then what is nearest to the field before it: of a repeated word, a clause
    has the copy beside its other words. The leftmost placement comes last.

    Parameters
    ----------
    fields
        The words of every field of a command's clauses. Words whose position is known
        keep it, and no other field takes it if it can help it.

    Raises
    ------
    SDCError
        If the command doesn't hold a field's words in their order, or is longer than
        :data:`g3.lengths.MAX_CHARACTERS`.
    """
    check_length(command, where="the command", error=SDCError)
    fields = [tuple(words) for words in fields]
    taken: set[int] = set()
    for word in (w for words in fields for w in words):
        if word.start is None:
            continue
        if not command.startswith(word.text, word.start):
            raise SDCError(
                f"the command doesn't have the word {word.text!r} at position {word.start}",
                where=word.where,
                fix=f"the command is {command!r}",
            )
        taken.update(range(word.start, word.start + len(word.text)))
    placed = []
    beside: tuple[Span, ...] = ()
    for words in fields:
        starts = _place_field(words, command, taken, beside)
        spans = tuple(Span(start, w.text) for start, w in zip(starts, words, strict=True))
        taken.update(i for span in spans for i in range(span.start, span.end))
        placed.append(spans)
        beside = spans or beside
    return tuple(placed)


def _place_field(
    words: Sequence[FieldWord], command: str, taken: set[int], beside: Sequence[Span]
) -> tuple[int, ...]:
    if all(word.start is not None for word in words):
        return tuple(word.start for word in words if word.start is not None)
    best = [_Placement(0, 0, 0, 0, ())]
    end_of = 0
    for word in words:
        best = _extend(best, end_of, word, command, taken, beside=beside)
        end_of = len(word.text)
    return min(best).starts


def _extend(
    placements: list[_Placement],
    length: int,
    word: FieldWord,
    command: str,
    taken: set[int],
    *,
    beside: Sequence[Span],
) -> list[_Placement]:
    """Place one more word: the best placement for each of its occurrences.

    ``length`` is that of the last word placed. Of the placements that end before an occurrence
    it is the least or, because it leaves no gap, that which ends where the white space before
    the occurrence begins.
    """
    matches = re.finditer(f"(?={re.escape(word.text)})", command)
    occurrences = [match.start() for match in matches] if word.start is None else [word.start]
    ends = [before.starts[-1] + length if before.starts else 0 for before in placements]
    at_end = dict(zip(ends, placements, strict=True))
    extended = []
    least: _Placement | None = None
    seen = 0
    for start in occurrences:
        while seen < len(ends) and ends[seen] <= start:
            least = placements[seen] if least is None else min(least, placements[seen])
            seen += 1
        if least is None:
            continue
        stop = start + len(word.text)
        overlaps = word.start is None and not taken.isdisjoint(range(start, stop))
        inside = _joins(command, start) or _joins(command, stop)
        adjacent = at_end.get(len(command[:start].rstrip()))
        options = [(least, bool(least.starts))]
        if adjacent is not None:
            options.append((adjacent, False))
        extended.append(
            min(
                _Placement(
                    before.overlaps + overlaps,
                    before.inside_words + inside,
                    before.gaps + gap,
                    before.away if before.starts else _away(start, beside),
                    (*before.starts, start),
                )
                for before, gap in options
            )
        )
    if not extended:
        problem = (
            f"the word {word.text!r} doesn't stand after the words before it in the field"
            if occurrences
            else f"the word {word.text!r} is not in the command"
        )
        raise SDCError(problem, where=word.where, fix=f"the command is {command!r}")
    return extended


def _away(start: int, beside: Sequence[Span]) -> int:
    """Return the distance of a word to the nearest of some others, in characters."""
    if not beside:
        return start
    return min(start - w.end if start >= w.end else abs(w.start - start) for w in beside)


def _joins(command: str, offset: int) -> bool:
    """Check that an offset stands between two letters or digits, inside a word."""
    return 0 < offset < len(command) and (
        command[offset - 1].isalnum() and command[offset].isalnum()
    )
