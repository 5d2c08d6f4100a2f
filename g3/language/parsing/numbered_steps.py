"""Steps that people number: "1. drive to the truck 2. lift the crate"."""

from __future__ import annotations

from collections.abc import Sequence

Token = tuple[int, int, str]
"""Where a word of a text begins and ends, and how it is read."""

STEP = "step"
_AFTER_NUMBER = (".", ")", ":")


def without_numbers(tokens: Sequence[Token]) -> list[Token]:
    """Words of a text without the numbers of its steps; what a number begins is a sentence.

    Steps are numbered only if the text begins with the first one's number, and each number comes
    after the one before. Of "lift pallet 2. 2. wait" the second 2 is the step's.

    >>> words = "1 . go to the truck step 2 : lift crate 7".split()
    >>> [word for _, _, word in without_numbers([(0, 0, word) for word in words])]
    ['go', 'to', 'the', 'truck', '.', 'lift', 'crate', '7']
    """
    found: list[Token] = []
    at, number = 0, 1
    while at < len(tokens):
        size = _size(tokens, at, number) if number > 1 or not at else 0
        if size and _size(tokens, at + size, number):
            size = 0
        if not size:
            found.append(tokens[at])
        elif found:
            start, end, _ = tokens[at + size - 1]
            found.append((start, end, "."))
        at += size or 1
        number += bool(size)
    return found


def _size(tokens: Sequence[Token], at: int, number: int) -> int:
    """How many words from one on are the number of a step; 0 if none is."""
    words = [word for _, _, word in tokens[at : at + 3]]
    begins = int(words[:1] == [STEP])
    told = words[begins : begins + 2]
    ends = len(told) == 2 and told[0] == str(number) and told[1] in _AFTER_NUMBER
    return begins + 2 if ends else 0
