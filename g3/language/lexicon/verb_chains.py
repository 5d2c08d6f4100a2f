"""The verb of a clause that says what to do: "lift" of "get ready to lift".

Verbs that say whether, when or that something is done are closed classes: they lead on to another
verb. That other verb's class (:mod:`g3.language.lexicon.verb_classes`) says what it asks for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import COUNTS, FORMS, WORDS
from g3.language.lexicon.verb_classes import VERBS, word_class
from g3.short_repr import short_repr

_NO_VERBS = ("way", "side", "measure")


@short_repr
@dataclass(frozen=True, slots=True)
class Verb:
    """The verb of a clause that says what to do.

    Parameters
    ----------
    start
        Where it stands among the words of the clause's relation; what is before leads on to it.
    classes
        Its classes, of :data:`g3.language.lexicon.verb_classes.VERBS`, and those of verbs joined to
        it: "pick up and place". None if it is of no known class.
    leads_on
        Whether it says nothing by itself: "go", "use", "want".
    is_open
        Whether it is a verb whose class isn't known: it may ask for anything.
    """

    start: int
    classes: frozenset[str]
    leads_on: bool
    is_open: bool


@lru_cache(maxsize=65536)
def verb_of(words: tuple[str, ...]) -> Verb:
    """Find the verb that says what to do.

    Parameters
    ----------
    words
        The words of an EVENT's relation, bare.

    Examples
    --------
    >>> verb = verb_of(("get", "ready", "to", "place"))
    >>> verb.start, sorted(verb.classes)
    (3, ['placing'])
    >>> verb_of(("blick",)).is_open
    True
    """
    start = _first(words)
    while (after := _led_to(words, start)) is not None:
        start = after
    own = words[start:]
    head = own[0] if own else ""
    alone = head in FORMS["irregular"] and start == _first(words)  # "held crate" asks for nothing
    classes = frozenset() if alone else _phrasal(own) or _classes(own)
    leads_on = _leads_on(head) and not _phrasal(own)
    is_open = not classes and _is_open(head)
    return Verb(start, classes, leads_on, is_open)


def is_verb(word: str) -> bool:
    """Check that a word is a verb that is known, by its class or as one that leads on to another.

    >>> is_verb("lift"), is_verb("must"), is_verb("truck"), is_verb("blick")
    (True, True, False, False)
    """
    verb = verb_of((word,))
    return bool(verb.classes) or verb.leads_on


def _is_open(head: str) -> bool:
    stem = normalise(head)
    leads = stem in WORDS["leading"] and stem not in WORDS["asking"]
    closed = leads or stem in WORDS["regarding"]
    other = (
        word_class(head)
        or head in WORDS["not_imperative"]
        or head in WORDS["linking"]
        or _is_aside(head)
    )
    return head.replace("-", "").isalpha() and not (closed or other)


def _first(words: Sequence[str]) -> int:
    """The first word that could be a verb: not "please", "now", "carefully", "to"."""
    for i, word in enumerate(words):
        leads = word in WORDS["linking"] or word in WORDS["not_imperative"]
        followed = i + 1 < len(words) and _may_be_verb(words[i + 1])
        if not (_is_aside(word) or (leads and followed and not _leads_on(word))):
            return i
    return 0


def _is_aside(word: str) -> bool:
    polite = {"polite", "negating", "exactly"} & set(word_class(word).split("+"))
    contracted = word.endswith(("n't", "n’t")) or word in WORDS["beside_verbs"]
    return bool(polite) or contracted or word in WORDS["interjections"] or _is_manner(word)


def _is_manner(word: str) -> bool:
    return word.endswith("ly") and not _verb_classes(word)


def _led_to(words: Sequence[str], start: int) -> int | None:
    """Return the place of the verb that another one leads on to; None if it leads to none."""
    if start >= len(words):
        return None
    linked, light = "", _leads_on(words[start])
    for i in range(start + 1, len(words)):
        word = words[i]
        if linked in ("to", "by", "and") and light and _may_be_verb(word):
            return i
        if _is_plain_verb(word) and (light or linked == "to"):
            return i
        if light and word.endswith("ing") and len(word) > 5:
            return i
        if word in WORDS["linking"]:
            linked = word
        elif not (_is_aside(word) or word in WORDS["articles"]):
            linked = ""
    return None


def _leads_on(word: str) -> bool:
    return normalise(word) in WORDS["leading"]


def _may_be_verb(word: str) -> bool:
    """Check that a word after "to" may be a verb that isn't known."""
    if (
        _is_aside(word)
        or word in WORDS["linking"]
        or word in COUNTS["cardinals"]
        or word[0:1].isdigit()
    ):
        return False
    return _leads_on(word) or bool(_verb_classes(word)) or _is_open(word)


def _is_plain_verb(word: str) -> bool:
    """Check that a word behind another verb is a verb itself, not a way: "go back"."""
    return bool(_verb_classes(word)) and not set(_NO_VERBS) & set(word_class(word).split("+"))


def _verb_classes(word: str) -> frozenset[str]:
    for known in (word_class(word), word_class(normalise(word)), FORMS["nominals"].get(word, "")):
        if found := VERBS.intersection(known.split("+")):
            return found
    return frozenset()


def _classes(words: Sequence[str]) -> frozenset[str]:
    """Classes of the verb that words begin with, and of verbs that are joined to it by "and"."""
    found = _verb_classes(words[0]) if words else frozenset()
    joined = [b for a, b in pairwise(words) if a in ("and", "then", "&")]
    return found.union(*map(_verb_classes, joined))


def _phrasal(words: Sequence[str]) -> frozenset[str]:
    """Classes of a verb with a particle that changes what it says: "let down"."""
    if not words:
        return frozenset()
    head, phrases = normalise(words[0]), FORMS["phrasal_verbs"]
    classes = next((c for p in words[1:] if (c := phrases.get(f"{head} {p}"))), None)
    return frozenset(classes.split("+") if classes else ())
