"""Things that a text rules out: "hands off the crate", "all but the crate".

Trees lose more negations than nouns, and a lost one has the robot do what was forbidden. So words
that rule something out are looked for in the text itself, whatever its tree has made of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from g3.language.discourse.negation import is_negation
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare
from g3.language.lexicon.tables import WORDS, members
from g3.language.lexicon.verb_classes import VERBS, word_class
from g3.sdc.clauses import Span

CUES = tuple(
    (re.compile(rf"(?:^|(?<= )){row.pattern}(?= |$)"), row.where) for row in members("cue").values()
)
"""Patterns of words that rule something out, with the side on which its noun stands. What a word
negates ("don't", "never", "not") is ruled out, too, by :func:`exclusions` itself."""


def exclusions(tokens: Sequence[Span]) -> Iterator[tuple[Span, ...]]:
    """Yield the nouns that a text rules out, each with the words before it.

    Parameters
    ----------
    tokens
        The words and punctuation marks of a text.

    Examples
    --------
    >>> from g3.language.parsing.words import cut
    >>> text = "Don't you dare lift the crate. Everything but the tires goes on the truck."
    >>> [" ".join(word.text for word in noun) for noun in exclusions(cut(text).spans)]
    ['the crate', 'the tires']
    """
    said = [bare(token.text) or token.text for token in tokens]
    starts = [0]
    for word in said:
        starts.append(starts[-1] + len(word) + 1)
    text = " ".join(said)
    found = [_negated(said, at) for at in range(len(said))]
    for pattern, where in CUES:
        for match in pattern.finditer(text):
            first = starts.index(match.start())
            after = next(i for i, start in enumerate(starts) if start > match.end() - 1)
            if not _is_turned_round(said, first):
                found.append(_after(said, after) if where == "after" else _before(said, first))
    return (tuple(tokens[i] for i in noun) for noun in found if noun)


def _is_turned_round(said: Sequence[str], at: int) -> bool:
    """Check that what is excepted is wanted: "don't touch anything but the crate"."""
    start = max((i for i in range(at) if said[i] in WORDS["breaks"]), default=-1) + 1
    before = said[start:at]
    return (
        any(is_negation(word) or word in WORDS["nothing"] for word in before)
        and "but" not in before
    )


def _negated(said: Sequence[str], at: int) -> list[int]:
    """Return the words that a negation at a place rules out."""
    if not is_negation(said[at]) or said[at] in WORDS["negating_nouns"]:
        return []
    if at and said[at - 1] in WORDS["class/relative"] | WORDS["doubting"]:
        return []
    verb = at + 1
    while verb < len(said) and said[verb] in WORDS["negation_leads"]:
        verb += 1
    lead = said[at + 1 : verb]
    if verb == len(said) or not WORDS["negated_anyway"].isdisjoint((*lead, said[verb])):
        return []
    if "be" in lead:
        return _before(said, at)
    if _is_verb(said[verb]) or said[verb] in WORDS["touching"]:
        verb += 1
        while verb < len(said) and said[verb] in WORDS["with_verb"]:
            verb += 1
    return _after(said, verb)


def _is_verb(word: str) -> bool:
    return not VERBS.isdisjoint(word_class(word).split("+"))


def _ends(word: str) -> bool:
    """Check that a word belongs to no noun before or behind it."""
    return word in WORDS["breaks"] or word in WORDS["class/relative"] - WORDS["demonstratives"]


def _after(said: Sequence[str], start: int) -> list[int]:
    """Return the words from a place on that belong to a noun."""
    found: list[int] = []
    for i in range(start, len(said)):
        word = said[i]
        verb = found and _is_verb(word) and not concepts((word,)) & SIDES
        begins = found and word in WORDS["articles"]
        if _ends(word) or word in WORDS["place_prepositions"] or verb or begins:
            break
        found.append(i)
    return found


def _before(said: Sequence[str], end: int) -> list[int]:
    """Return the words before a place that belong to a noun and what tells more of it."""
    while end and said[end - 1] in WORDS["subject_links"]:
        end -= 1
    first = end
    while first and not _ends(said[first - 1]):
        first -= 1
    return list(range(first, end))
