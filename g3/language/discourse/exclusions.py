"""Things that a text rules out: "hands off the crate", "all but the crate".

Trees lose more negations than nouns, and a lost one has the robot do what was forbidden. So words
that rule something out are looked for in the text itself, whatever its tree has made of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Literal

from g3.language.discourse.negation import is_negation
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare
from g3.language.lexicon.verb_classes import word_class
from g3.language.lexicon.word_sets import (
    DEMONSTRATIVES,
    NOTHING,
    PLACE_PREPOSITIONS,
    RELATIVE,
    SENTENCE_ENDS,
    SIDES,
    VERBS,
    words,
)
from g3.sdc.clauses import Span

Where = Literal["after", "before"]
"""Place of the noun of what is ruled out."""

CUES: tuple[tuple[str, Where, str], ...] = (
    ("hands off", "after", "hands off the crate"),
    ("keep off", "after", "keep off the crate"),
    ("keep [a-z' ]+ off", "after", "keep your forks off the crate"),
    ("keep clear of", "after", "keep clear of the crate"),
    ("keep away from", "after", "keep away from the crate"),
    ("stay off", "after", "stay off the crate"),
    ("stay clear of", "after", "stay clear of the crate"),
    ("steer clear of", "after", "steer clear of the crate"),
    ("(?:nobody|no one) [a-z]+", "after", "nobody touches the crate"),
    ("(?:in|under) no [a-z]+ [a-z]+", "after", "under no circumstances move the crate"),
    ("(?:in|under) no [a-z]+ (?:is|are)", "after", "in no event is the crate to be moved"),
    ("except(?: for)?", "after", "all except the crate"),
    ("excepting", "after", "all excepting the crate"),
    ("excluding", "after", "all excluding the crate"),
    ("(?:with )?(?:the )?exception of", "after", "all with the exception of the crate"),
    ("apart from", "after", "all apart from the crate"),
    ("aside from", "after", "all aside from the crate"),
    ("other than", "after", "everything other than the crate"),
    ("(?:all|everything) but", "after", "everything but the crate"),
    ("leave out", "after", "leave out the crate"),
    ("skip", "after", "skip the crate"),
    ("(?:is|are|'s|'re) off limits", "before", "the crate is off limits"),
    ("(?:is|are) off - limits", "before", "the crate is off-limits"),
    ("(?:is|are|'s|'re) reserved", "before", "the crate is reserved"),
    ("(?:is|are) to (?:stay|remain)", "before", "the crate is to stay where it is"),
    ("(?:must|shall|should|can|has to|have to) (?:stay|remain)", "before", "the crate must stay"),
    (
        "(?:stay|remain)s?(?= (?:where|put|there|here|behind|[.;!,]|$))",
        "before",
        "the crate stays put",
    ),
    ("which (?:stay|remain)s?", "before", "all but the far ones, which stay"),
)
"""Words that rule something out, where its noun stands, and an example. What is negated by a word
("don't", "never", "not") is ruled out, too, by :func:`exclusions` itself."""
_CUES = tuple((re.compile(rf"(?:^|(?<= )){cue}(?= |$)"), where) for cue, where, _ in CUES)
_WANTED = words(
    "only just forget hesitate leave left leaving neglect fail miss mind yet stop wait worry why "
    "drop dropped lower let"
)
"""Words whose negation rules nothing out: "don't forget the crate", "not only"."""
_LEAD = words("you dare ever want to try go be have even please anyone anybody even think about of")
"""Words between a negation and its verb."""
_SUBJECT = words(
    "is are was were 's 're must shall should may can could will would has have to do does ought "
    "definitely also please really just all both"
)
"""Words between a noun and what is said of it."""
_BREAKS = SENTENCE_ENDS | {"(", ")", ":", ","} | words("but then and or so")
"""Words and punctuation marks between clauses, or between nouns."""
_NEGATING_NOUNS = words("no neither nor")
"""Negations of nouns, and answers: "no, the crate"."""
_DOUBTING = words("if why or")
"""Before a negation these rule nothing out: "why don't you lift the crate"."""


_TOUCHING = words(
    "touch touching handle handling bother disturb moving lifting taking picking near"
)
"""Verbs of what is done to a load, and "near", besides those of `VERBS`."""
_WITH_VERB = words("up with near off away on any of to")
"""Words between such a verb and its noun."""


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
    for pattern, where in _CUES:
        for match in pattern.finditer(text):
            first = starts.index(match.start())
            after = next(i for i, start in enumerate(starts) if start > match.end() - 1)
            if not _is_turned_round(said, first):
                found.append(_after(said, after) if where == "after" else _before(said, first))
    return (tuple(tokens[i] for i in noun) for noun in found if noun)


def _is_turned_round(said: Sequence[str], at: int) -> bool:
    """Check that what is excepted is wanted: "don't touch anything but the crate"."""
    start = max((i for i in range(at) if said[i] in _BREAKS), default=-1) + 1
    before = said[start:at]
    return any(is_negation(word) or word in NOTHING for word in before) and "but" not in before


def _negated(said: Sequence[str], at: int) -> list[int]:
    """Return the words that a negation at a place rules out."""
    if not is_negation(said[at]) or said[at] in _NEGATING_NOUNS:
        return []
    if at and said[at - 1] in RELATIVE | _DOUBTING:
        return []
    verb = at + 1
    while verb < len(said) and said[verb] in _LEAD:
        verb += 1
    lead = said[at + 1 : verb]
    if verb == len(said) or not _WANTED.isdisjoint((*lead, said[verb])):
        return []
    if "be" in lead:
        return _before(said, at)
    if _is_verb(said[verb]) or said[verb] in _TOUCHING:
        verb += 1
        while verb < len(said) and said[verb] in _WITH_VERB:
            verb += 1
    return _after(said, verb)


def _is_verb(word: str) -> bool:
    return not VERBS.isdisjoint(word_class(word).split("+"))


def _ends(word: str) -> bool:
    """Check that a word belongs to no noun before or behind it."""
    return word in _BREAKS or word in RELATIVE - DEMONSTRATIVES


def _after(said: Sequence[str], start: int) -> list[int]:
    """Return the words from a place on that belong to a noun."""
    found: list[int] = []
    for i in range(start, len(said)):
        word = said[i]
        verb = found and _is_verb(word) and not concepts((word,)) & SIDES
        if _ends(word) or word in PLACE_PREPOSITIONS or verb:
            break
        found.append(i)
    return found


def _before(said: Sequence[str], end: int) -> list[int]:
    """Return the words before a place that belong to a noun and what tells more of it."""
    while end and said[end - 1] in _SUBJECT:
        end -= 1
    first = end
    while first and not _ends(said[first - 1]):
        first -= 1
    return list(range(first, end))
