"""Likelihood that a word denotes a label of the semantic map (section 3.3).

A measure takes words and labels and gives one number between 0 and 1 for each pair.
Measures are registered by name; the feature sets of :mod:`g3.features.sets.label_words` use them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cache, lru_cache
from itertools import pairwise, product

import numpy as np
import numpy.typing as npt
from rapidfuzz.distance import JaroWinkler
from rapidfuzz.process import cdist

from g3.errors import ModelError
from g3.groundings import FloatArray
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import FORMS, members, written
from g3.language.similarity.resources import tag_table, word_vectors, wordnet
from g3.language.similarity.wordnet import Score, WordNet, share_of_senses

Measure = Callable[[Sequence[str], Sequence[str]], FloatArray]

MEASURES: dict[str, Measure] = {}


def measure(name: str) -> Callable[[Measure], Measure]:
    """Register a measure: from w words and l labels to similarities (w, l) in [0, 1]."""

    def register(function: Measure) -> Measure:
        MEASURES[name] = function
        return function

    return register


@measure("exact")
def exact(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """1 where the lower-case forms are equal."""
    equal = [[float(w.lower() == label.lower()) for label in labels] for w in words]
    return np.array(equal).reshape(len(words), len(labels))


@measure("lemma")
def lemma(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """1 where the stems are equal: "tires" and "tire"."""
    return exact([normalise(w) for w in words], [normalise(label) for label in labels])


def labels_in(words: Sequence[str], labels: Sequence[str]) -> int:
    """Return the number of words that are in labels, whatever their form.

    >>> labels_in(["tires", "pallet", "left"], ["tire", "assembly pallet"])
    2
    """
    own = [word for label in labels for word in label.split()]
    return int(lemma(words, own).any(axis=1).sum()) if len(words) and own else 0


@measure("spelling")
def spelling(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Jaro-Winkler similarity of the stems: "palett" and "pallet"."""
    similarity: FloatArray = cdist(
        [normalise(w) for w in words],
        [normalise(label) for label in labels],
        scorer=JaroWinkler.similarity,
    ).astype(float)
    return similarity


@cache
def _synonyms() -> dict[str, frozenset[str]]:
    """Normal forms of words for each kind of thing in a warehouse."""
    return {kind: frozenset(map(normalise, written(row))) for kind, row in members("kind").items()}


@cache
def _kinds() -> dict[str, str]:
    """Labels of semantic maps, and the kind that each belongs to, or kinds, joined by "+"."""
    return {**{kind: kind for kind in _synonyms()}, **FORMS["kinds"]}


@cache
def _kinds_by_stem() -> dict[str, str]:
    return {normalise(label): kind.partition("+")[0] for label, kind in _kinds().items()}


_LOADS = ("tire", "pallet", "box")


@measure("domain")
def domain(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """1 where the word is a synonym of the label's kind in a small warehouse lexicon.

    By WordNet all people are persons: "the farmer".
    """
    kinds = [_kinds().get(label.lower(), "") for label in labels]
    synonyms = {"": frozenset[str](), **_synonyms()}
    known = [frozenset[str]().union(*(synonyms[k] for k in kind.split("+"))) for kind in kinds]
    person = [PERSON in kind.split("+") for kind in kinds]
    table = [
        [
            float(stem in own or (is_person and _is_person(word)))
            for own, is_person in zip(known, person, strict=True)
        ]
        for word, stem in zip(words, map(normalise, words), strict=True)
    ]
    return np.array(table).reshape(len(words), len(labels))


PERSON, MOSTLY_PEOPLE = "person", 0.85
"""A kind of thing; share of a noun's senses that must be people."""


@lru_cache(maxsize=4096)
def _is_person(word: str) -> bool:
    """Check that a noun names people by WordNet, and nothing else in a warehouse."""
    if len(word) < SHORTEST or normalise(word) in frozenset[str]().union(*_synonyms().values()):
        return False
    try:
        return share_of_senses(wordnet(), word.lower(), (PERSON,)) >= MOSTLY_PEOPLE
    except ModelError:
        return False


def is_another_kind(noun: str, label: str) -> bool:
    """Check that a noun is a label of things in a warehouse, but of others than some label.

    Not with words for loads: people say "box" and "pallet" of whatever is to be moved.

    >>> is_another_kind("trucks", "box"), is_another_kind("truck", "trailer")
    (True, False)
    >>> is_another_kind("lorry", "box"), is_another_kind("pallet", "barrel")
    (False, False)
    """
    own, other = (_kinds_by_stem().get(normalise(word)) for word in (noun, label))
    return None not in (own, other) and own not in {other, *_LOADS}


PHYSICAL_ENTITY = "physical_entity"
"""What labels of a semantic map are kinds of, and so the words for them."""

SHORTEST = 3
"""Shorter forms are function words, though WordNet has nouns like "a" and "in"."""


def _in_wordnet(score: Score, words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Similarity of the most similar senses that are physical entities."""
    net = wordnet()
    table = [[_between_words(net, score, w.lower(), x.lower()) for x in labels] for w in words]
    return np.array(table, dtype=float).reshape(len(words), len(labels))


@lru_cache(maxsize=65536)
def _between_words(net: WordNet, score: Score, word: str, label: str) -> float:
    pairs = product(_things(net, word), _things(net, label))
    return max((net.similarity(score, a, b) for a, b in pairs), default=0.0)


@lru_cache(maxsize=4096)
def _things(net: WordNet, word: str) -> tuple[int, ...]:
    """The senses of a word that are physical entities."""
    if len(word) < SHORTEST or concepts([normalise(word)]):
        return ()
    (top,) = net.senses[PHYSICAL_ENTITY]
    return tuple(s for s in net.synsets(word) if top in net.ancestors(s))


@measure("path")
def path(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """1 / (1 + steps between them in WordNet)."""
    return _in_wordnet("path", words, labels)


@measure("wup")
def wup(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Similarity of Wu and Palmer in WordNet: how deep what they have in common is."""
    return _in_wordnet("wup", words, labels)


@measure("lin")
def lin(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Similarity of Lin in WordNet: how much they have in common of what they say."""
    return _in_wordnet("lin", words, labels)


@measure("tag-npmi")
def tag_npmi(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Normalised mutual information of tags of the same images, negative as 0."""
    return tag_table().npmi(words, labels)


@measure("tag-given")
def tag_given(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Share of the images tagged with the word that have the label, too."""
    given: FloatArray = tag_table().conditional(labels, words).T
    return given


@measure("vector")
def vector(words: Sequence[str], labels: Sequence[str]) -> FloatArray:
    """Cosine of the vectors of words in a file that you have, negative as 0."""
    return word_vectors().cosine(words, labels)


def label_patterns(
    labels: npt.NDArray[np.bool_],
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.intp]]:
    """The sets of labels among rows (n, l) that differ, shape (m, l), and which each row has."""
    if not labels.size:
        return labels[:1], np.zeros(len(labels), dtype=np.intp)
    packed = np.packbits(labels, axis=1)
    # np.unique with an axis does the same in several times the time.
    whole = packed.view(f"V{packed.shape[1]}").ravel()
    _, first, row = np.unique(whole, return_index=True, return_inverse=True)
    return labels[first], row.reshape(-1)


def best_match(
    similarity: FloatArray,
    factor_words: Sequence[Sequence[int]],
    factor: npt.NDArray[np.intp],
    labels: npt.NDArray[np.bool_],
) -> FloatArray:
    """For each row the similarity of the closest pair of one of its words and labels.

    Parameters
    ----------
    similarity
        All words against all labels, shape (..., w, l).
    factor_words
        The words of each factor, as rows of `similarity`.
    factor
        Which factor each row has, shape (n,).
    labels
        Which labels each row has, shape (n, l).

    Returns
    -------
    FloatArray
        Shape (..., n); 0 for a row without words or labels.
    """
    patterns, pattern = label_patterns(labels)
    per_word = np.zeros((*similarity.shape[:-1], len(patterns)))
    for i, one in enumerate(patterns):
        per_word[..., i] = similarity[..., one].max(axis=-1, initial=0.0)
    lengths = np.array([len(w) for w in factor_words], dtype=np.intp)
    flat = np.array([word for words in factor_words for word in words], dtype=np.intp)
    per_factor = np.zeros((*similarity.shape[:-2], len(factor_words), len(patterns)))
    filled = np.flatnonzero(lengths)
    if len(filled):
        starts = (np.cumsum(lengths) - lengths)[filled]
        per_factor[..., filled, :] = np.maximum.reduceat(per_word[..., flat, :], starts, axis=-2)
    best: FloatArray = per_factor[..., factor, pattern]
    return best


def mean_match(
    measure: Measure,
    names: Sequence[Sequence[str]],
    labels: Sequence[str],
    patterns: npt.NDArray[np.bool_],
) -> FloatArray:
    """Return how well names fit sets of labels: the mean over words of the closest label.

    Words that are like no label at all are left out, and two neighbours that are known as
    one ("loading dock") count as one word.

    Parameters
    ----------
    measure
        The measure.
    names
        The words of f names.
    labels
        The l labels there are.
    patterns
        Sets of labels, shape (k, l).

    Returns
    -------
    FloatArray
        Shape (f, k); NaN for a name without known words.
    """
    forms = {form for words in names for form in (*words, *map(" ".join, pairwise(words)))}
    vocabulary = sorted(forms)
    similarity = measure(vocabulary, labels)
    row = {word: i for i, word in enumerate(vocabulary) if similarity[i].any()}
    closest = [similarity[:, pattern].max(axis=1, initial=0.0) for pattern in patterns]
    per_word = np.column_stack(closest) if len(patterns) else np.zeros((len(vocabulary), 0))
    different = {words: i for i, words in enumerate(dict.fromkeys(map(tuple, names)))}
    fits = np.full((len(different), len(patterns)), np.nan)
    for fit, words in zip(fits, different, strict=True):
        known = [row[unit] for unit in _units(words, row)]
        if known:
            fit[:] = per_word[known].mean(axis=0)
    return fits[[different[tuple(words)] for words in names]]


def _units(words: Sequence[str], known: Collection[str]) -> Iterator[str]:
    """The known words and pairs of words of a name, each word in at most one."""
    at = 0
    while at < len(words):
        pair = " ".join(words[at : at + 2])
        if at + 1 < len(words) and pair in known:
            yield pair
            at += 2
            continue
        if words[at] in known:
            yield words[at]
        at += 1
