"""Evidence that a noun names any of the things that there are, from words and labels alone.

A noun names a thing surely by its form, if it is spelt alike, is a known synonym, is more general
than a label ("vehicle"), or was learned for such things. Else only how alike it is to the labels
speaks for it, and less than `least_alike` is too little.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import product

from g3.errors import ModelError
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS
from g3.language.similarity import static_embeddings
from g3.language.similarity.learned_lexicon import SHORTEST, Lexicon, likeness, term_of
from g3.language.similarity.resources import wordnet
from g3.language.similarity.word_similarity import MEASURES, PHYSICAL_ENTITY, is_another_kind
from g3.language.similarity.wordnet import WordNet, share_of_senses

Labels = tuple[str, ...]

SPELT_ALIKE = 0.9
"""Jaro-Winkler similarity from which a noun is a label, misspelt."""
LEAST_WITH_VECTORS, LEAST_BY_WORDNET = 0.316, 0.42
"""Least likeness to a label, with embeddings and by WordNet alone. Chosen for at most 5 % false
alarms on the commands of each of three corpora (``benchmarks.absent_things``)."""
MATERIAL = ("whole", "matter")
"""What can be seen to be there or not: things and stuff, but no distances, turns or seconds."""
MOSTLY = 0.5
"""Share of a noun's senses that must be material."""
RARE = 0.15
"""What is a smaller share of a word's uses isn't meant."""
SENSES = 3
"""So many senses of a label count, the most frequent first."""


def least_alike() -> float:
    """Nouns that are less like every label name nothing that there is."""
    return LEAST_WITH_VECTORS if static_embeddings.is_installed() else LEAST_BY_WORDNET


@lru_cache(maxsize=4096)
def may_be_absent(noun: str) -> bool:
    """Check that a noun is one of which it can be told that it isn't there.

    Never without WordNet, for words that it doesn't have, and for generic ones.

    >>> may_be_absent("elephant"), may_be_absent("things"), may_be_absent("degrees")
    (True, False, False)
    """
    if len(noun) < SHORTEST or normalise(noun) in WORDS["never_absent"]:
        return False
    try:
        return share_of_senses(wordnet(), noun, MATERIAL) >= MOSTLY
    except ModelError:
        return False


def best_naming(noun: str, things: Iterable[Labels], lexicon: Lexicon | None = None) -> float:
    """Return how well a noun names the thing that it names best.

    Parameters
    ----------
    noun
        In lower case.
    things
        The labels of each thing, or the name of a place.
    lexicon
        What was learned of words and labels.

    Returns
    -------
    float
        1 if it surely names one, else how alike it is to a label, from 0 to 1; 0 without things.
    """
    known = list(dict.fromkeys(things))
    if any(
        is_called(noun, labels)
        or _is_more_general(noun, labels)
        or _was_learned(noun, labels, lexicon)
        for labels in known
    ):
        return 1.0
    return max((_likeness(noun, labels) for labels in known), default=0.0)


@lru_cache(maxsize=65536)
def is_called(noun: str, labels: Labels) -> bool:
    """Check that a noun is one of some labels, spelt alike, or a known synonym."""
    words = [word for label in labels for word in label.lower().split()]
    forms = [noun], words
    if MEASURES["spelling"](*forms).max(initial=0.0) >= SPELT_ALIKE:
        return True
    return bool(MEASURES["domain"](*forms).max(initial=0.0))


@lru_cache(maxsize=65536)
def _is_more_general(noun: str, labels: Labels) -> bool:
    """Check that one of some labels is a kind of what a noun names: a truck is a vehicle."""
    words = [word for label in labels for word in label.lower().split()]
    try:
        net = wordnet()
    except ModelError:
        return False
    (top,) = net.senses[PHYSICAL_ENTITY]
    own = {sense for sense in net.synsets(noun) if top in net.ancestors(sense)}
    return any(
        own & net.ancestors(sense).keys() for word in words for sense in net.synsets(word)[:SENSES]
    )


@lru_cache(maxsize=65536)
def _likeness(noun: str, labels: Labels) -> float:
    """Return the likeness of a noun and labels: by WordNet, and with embeddings the mean of both.

    Vectors of rare words are noisy, and WordNet has wide classes: where both agree they are right.
    A noun that is itself a label of another kind says of nothing else: a truck is no box.
    """
    words = [word for label in labels for word in label.lower().split()]
    if any(is_another_kind(noun, word) for word in words):
        return 0.0
    near = _lin(noun, words)
    if not static_embeddings.is_installed():
        return near
    return (near + likeness(noun, " ".join(words))) / 2


def _lin(noun: str, words: Sequence[str]) -> float:
    """Similarity of Lin in WordNet, of what is usually meant by a noun and by labels."""
    try:
        net = wordnet()
    except ModelError:
        return 0.0
    pairs = product(_usual(net, noun), (s for word in words for s in _usual(net, word)))
    return max((net.similarity("lin", a, b) for a, b in pairs), default=0.0)


@lru_cache(maxsize=4096)
def _usual(net: WordNet, word: str) -> tuple[int, ...]:
    """The senses of a word that are things and are meant often enough: no dog is a fellow."""
    (top,) = net.senses[PHYSICAL_ENTITY]
    count = {s: 1 + net.frequency.get(s, 0) for s in net.synsets(word)}
    total = sum(count.values())
    return tuple(s for s, n in count.items() if n >= RARE * total and top in net.ancestors(s))


def _was_learned(noun: str, labels: Labels, lexicon: Lexicon | None) -> bool:
    if lexicon is None:
        return False
    term, name = term_of(noun), " ".join(labels)
    counts = (own.together.get(term.form, {}) for own in lexicon.corpora.values())
    return any(name in of for of in counts) and lexicon.log_odds(term, name) > 0
