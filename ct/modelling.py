"""Models: learning from a corpus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, overload

from ct.argument_checks import one_of, positive, several
from ct.corpus_access import AnyCorpus, load

if TYPE_CHECKING:
    from g3.language.parsing.sdc_parser import SDCParser
    from g3.learning.grounding_model import GroundingModel


@overload
def train(
    corpus: AnyCorpus,
    to: Literal["match", "follow"] = ...,
    *,
    l2: float | None = ...,
    negatives: Literal["random", "hard"] = ...,
    ablate: Sequence[str] = ...,
    plus: Sequence[str] = ...,
    seed: int = ...,
) -> GroundingModel: ...
@overload
def train(corpus: AnyCorpus, to: Literal["parse"], *, l2: float | None = ...) -> SDCParser: ...
def train(
    corpus: AnyCorpus,
    to: Literal["match", "follow", "parse"] = "match",
    *,
    l2: float | None = None,
    negatives: Literal["random", "hard"] = "random",
    ablate: Sequence[str] = (),
    plus: Sequence[str] = (),
    seed: int = 0,
) -> GroundingModel | SDCParser:
    """Train a model on a corpus. Its ``save(path)`` keeps it, for the command line too.

    Parameters
    ----------
    corpus
        Corpus to learn from.
    to
        Purpose of the model. ``match``: to predict matches between clauses and groundings (Table
        1), as ``ct train g3`` does. ``follow``: to follow commands; it learns from the alternatives
        in each scene, which takes minutes. ``parse``: to parse commands, as ``ct train parser``
        does.
    l2
        Strength of the regularisation, above 0.
    negatives, ablate, plus, seed
        For ``match`` only: the kind of negatives, feature sets to leave out and to add (``ct
        features list``), and the random seed of hard negatives.

    Raises
    ------
    CorpusError
        If there is nothing to learn from, or an argument is none of those above.
    """
    one_of("to", to, ("match", "follow", "parse"))
    one_of("negatives", negatives, ("random", "hard"))
    positive("l2", l2)
    loaded = load(corpus)
    if to == "parse":
        from corpus_tools.learning.trained import parser_from

        return parser_from([loaded], l2)
    from g3.learning.grounding_model import DEFAULT_L2

    strength = DEFAULT_L2 if l2 is None else l2
    if to == "follow":
        from corpus_tools.following.bundled_grounder import following_model

        return following_model(loaded, l2=strength)
    from corpus_tools.corpus.labelled_corpus import Options
    from corpus_tools.learning.trained import from_corpus

    options = Options(negatives, seed, several(ablate), several(plus))
    return from_corpus(loaded, strength, options).model
