"""A lexicon that is learned: how much likelier a word makes it that a label was meant.

It learns from texts that were about one of several things, with what it was: from annotated
OBJECTs, or from what was done alone. Each word, and each two words in a row, is counted with the
labels of the right thing. What chance gives is what the labels' shares in the same corpus give: so
a corpus with two labels tells little of a third. A term that was hardly
seen is as telling as it is like a label.
"""

from __future__ import annotations

import hashlib
import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from g3.errors import FormatError, ModelError
from g3.groundings import FloatArray
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS
from g3.language.similarity import static_embeddings
from g3.language.similarity.resources import wordnet, wordnet_identity
from g3.language.similarity.word_similarity import MEASURES
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes

SCHEMA_VERSION = 1
PSEUDO_COUNT = 0.3
"""So often each word is taken to have been seen with each label besides."""
LEAST_ALIKE = 0.3
"""Cosine from which a word may be like a label."""
BACK_OFF = 2.0
"""How many nats likeness 1 above `LEAST_ALIKE` is worth to a word that was never seen."""
SHORTEST = 3
"""Shorter words aren't counted."""
MEND = "make it again with 'ct similarity learn'"


@short_repr
@dataclass(frozen=True, slots=True)
class Naming:
    """A text that was about one kind of thing.

    Parameters
    ----------
    words
        The text, in lower case, without punctuation.
    name
        Labels of what was meant, with blanks between.
    corpus
        The corpus that it is from.
    weight
        How much it counts.
    """

    words: Sequence[str]
    name: str
    corpus: str = ""
    weight: float = 1.0


class NamingCounts(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Counts of one corpus.

    Parameters
    ----------
    names
        How many texts were about each name.
    words
        How many texts had each word.
    together
        How many texts about a name had a word, by word and name.
    """

    names: dict[str, float]
    words: dict[str, float]
    together: dict[str, dict[str, float]]


class Term(NamedTuple):
    """A word of a text or two in a row: where it begins, its normal form, and as it is written."""

    place: int
    form: str
    written: str


def terms(words: Sequence[str]) -> list[Term]:
    """A text's words that may name something, and each two of them in a row.

    >>> [term.form for term in terms(["lift", "the", "red", "chairs"])]
    ['red', 'chair', 'red chair']
    """
    return list(_terms(tuple(words)))


@lru_cache(maxsize=4096)
def _terms(words: tuple[str, ...]) -> tuple[Term, ...]:
    known = [
        Term(i, form, word)
        for i, word in enumerate(words)
        if len(word) >= SHORTEST and (form := normalise(word)) not in WORDS["naming_nothing"]
    ]
    pairs = [(a, b) for a, b in pairwise(known) if b.place == a.place + 1]
    joined = [Term(a.place, f"{a.form} {b.form}", f"{a.written} {b.written}") for a, b in pairs]
    return (*known, *joined)


def term_of(words: str) -> Term:
    """A word, or two with a blank between, as a term."""
    own = words.lower().split()
    return Term(0, " ".join(map(normalise, own)), " ".join(own))


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Lexicon:
    """Likelihood ratios of names given words.

    Parameters
    ----------
    corpora
        What was counted, by corpus.
    """

    corpora: Mapping[str, NamingCounts]
    _known: dict[tuple[str, str, str], float] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def learn(cls, namings: Iterable[Naming]) -> Lexicon:
        """Count words with names."""
        of_corpus: dict[str, list[Naming]] = defaultdict(list)
        for naming in namings:
            of_corpus[naming.corpus].append(naming)
        return cls({name: _counted(own) for name, own in sorted(of_corpus.items())})

    @property
    def names(self) -> tuple[str, ...]:
        """All names that something was called by its labels."""
        return tuple(sorted({name for own in self.corpora.values() for name in own.names}))

    @property
    def words(self) -> tuple[str, ...]:
        """All words and pairs of words that were counted."""
        return tuple(sorted({word for own in self.corpora.values() for word in own.words}))

    def count(self, term: Term) -> float:
        """Return the number of texts that had a term."""
        return sum(own.words.get(term.form, 0.0) for own in self.corpora.values())

    def log_odds(self, term: Term, name: str) -> float:
        """Log p(name | term) / p(name): 0 for what tells nothing.

        The oftener a term was counted, the less it matters how alike it and the name are.

        Parameters
        ----------
        term
            One of `terms`.
        name
            Labels with blanks between.
        """
        key = term.form, term.written, name
        if key not in self._known:
            self._known[key] = self._log_odds(term, name)
        return self._known[key]

    def _log_odds(self, term: Term, name: str) -> float:
        seen = expected = 0.0
        for own in self.corpora.values():
            if count := own.words.get(term.form, 0.0):
                seen += own.together[term.form].get(name, 0.0)
                expected += count * own.names.get(name, 0.0) / sum(own.names.values())
        alike = max(0.0, likeness(term.written, name) - LEAST_ALIKE)
        prior = PSEUDO_COUNT * math.exp(BACK_OFF * alike)
        return math.log((seen + prior) / (expected + PSEUDO_COUNT))

    def table(self, text: Sequence[Term], names: Sequence[str]) -> FloatArray:
        """Log-odds of terms and names, shape (terms, names)."""
        odds = [[self.log_odds(term, name) for name in names] for term in text]
        return np.array(odds, dtype=float).reshape(len(text), len(names))

    def save(self, path: Path) -> None:
        """Write it as JSON; the same lexicon gives the same bytes."""
        content = _File(SCHEMA_VERSION, dict(self.corpora))
        content = msgspec.structs.replace(content, digest=_digest(content))
        write_bytes(path, msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")

    @classmethod
    def load(cls, path: Path) -> Lexicon:
        """Read what `save` wrote.

        Raises
        ------
        FormatError
            If it is missing or damaged.
        """
        try:
            content = msgspec.json.decode(regular_file.read_bytes(path), type=_File)
        except OSError as error:
            raise FormatError(
                f"the lexicon can't be read: {error.strerror}", where=str(path), fix=MEND
            ) from error
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise FormatError(f"it is no lexicon: {error}", where=str(path), fix=MEND) from error
        if content.schema_version != SCHEMA_VERSION:
            raise FormatError(
                f"its version is {content.schema_version}, this program reads {SCHEMA_VERSION}",
                where=f"{path}: schema_version",
                fix=MEND,
            )
        if content.digest != _digest(content):
            raise FormatError(
                "the content is not what was written: its digest differs",
                where=f"{path}: digest",
                fix=MEND,
            )
        return cls(content.corpora)


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    schema_version: int
    corpora: dict[str, NamingCounts]
    digest: str = ""


def _digest(content: _File) -> str:
    rest = msgspec.structs.replace(content, digest="")
    return f"sha256:{hashlib.sha256(msgspec.json.encode(rest, order='sorted')).hexdigest()}"


def _counted(namings: Sequence[Naming]) -> NamingCounts:
    names: dict[str, float] = defaultdict(float)
    words: dict[str, float] = defaultdict(float)
    together: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    for naming in namings:
        names[naming.name] += naming.weight
        for term in dict.fromkeys(term.form for term in terms(naming.words)):
            words[term] += naming.weight
            together[term][naming.name] += naming.weight
    return NamingCounts(dict(names), dict(words), {term: dict(of) for term, of in together.items()})


def likeness_identity() -> str:
    """Return an identity of the way in which likeness is measured here."""
    measured = static_embeddings.identity() if static_embeddings.is_installed() else "form"
    try:
        return f"{measured}, WordNet {wordnet_identity()}"
    except ModelError:
        return measured


@lru_cache(maxsize=65536)
def likeness(words: str, name: str) -> float:
    """Return the likeness of a word or two to one label of a name or all of it, from 0 to 1.

    By embeddings where they are installed, else by form and WordNet.
    """
    if not static_embeddings.is_installed():
        return _by_form_and_wordnet(words.split(), name.split())
    own = np.array(static_embeddings.vectors(_in_the_singular(words)))
    others = np.array(static_embeddings.vectors([name, *name.split()]))
    return float(np.clip(others @ own.T, 0.0, 1.0).max())


def _in_the_singular(words: str) -> list[str]:
    """A word or two, and what they are in the singular where WordNet knows that.

    Vectors of plurals are less like labels: "fridges" than "fridge" to "refrigerator".
    """
    try:
        lemmas = wordnet().lemmas(words.rpartition(" ")[2])
    except ModelError:
        return [words]
    first = words[: words.rfind(" ") + 1]
    return list(dict.fromkeys([words, *(first + lemma for lemma in lemmas)]))


def _by_form_and_wordnet(words: Sequence[str], labels: Sequence[str]) -> float:
    form = MEASURES["lemma"](words, labels)
    try:
        near = np.maximum(form, MEASURES["lin"](words, labels))
    except ModelError:
        near = form
    return float(near.max(initial=0.0))
