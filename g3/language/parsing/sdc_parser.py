"""From the text of a command to its SDC trees (section 3.1).

A small transformer gives each word a vector (:mod:`g3.language.parsing.encoder`). A biaffine model
chooses the word that it hangs from and the label of that arc
(:mod:`g3.language.parsing.arc_model`). Arcs are trees in another form
(:mod:`g3.language.parsing.clause_arcs`). All of it is learned from annotated trees, and has
probabilities, so there is a list of the best trees.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import resources
from itertools import islice, tee
from pathlib import Path
from typing import TYPE_CHECKING

from g3.errors import ModelError
from g3.estimator import Estimator, read_bytes
from g3.language.parsing.arc_decoding import likely_arcs
from g3.language.parsing.arc_model import ArcModel, Float32Array, log_probabilities
from g3.language.parsing.clause_arcs import build_trees
from g3.language.parsing.encoder import Encoder
from g3.language.parsing.one_thread import one_thread
from g3.language.parsing.parser_file import from_bytes, to_bytes
from g3.language.parsing.trees import Parse, Tree, with_trees
from g3.language.parsing.words import Words, cut
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    from g3.language.parsing.training.parser_training import Lesson, TreeOf

DEFAULT_L2 = 0.01
DEFAULT = "parser.npz"
"""The bundled parser's file."""
TEMPERATURE = 1.0
"""Divisor of the scores, so that a tree's probability is the share of such trees that are right."""
WIDTH = 4
"""Sets of arcs that are looked at for each tree: several can give the same one."""


@short_repr
@dataclass(eq=False)
class SDCParser(Estimator):
    """A parser that learns from annotated trees how commands are divided into clauses.

    It begins with what the bundled parser knows.

    Parameters
    ----------
    l2
        Strength of the pull towards the bundled parser's weights.
    layers
        How many of the encoder's last layers learn, too. None for all of them from
        :data:`g3.language.parsing.training.parser_training.ENOUGH` commands on, and 0 below.
    card
        Notes on the training for its file, besides those that `fit` adds.

    Attributes
    ----------
    arcs_
        Weights of the arcs between words.
    encoder_
        The encoder.
    card_
        Notes on the training, for people.
    """

    l2: float = DEFAULT_L2
    layers: int | None = None
    card: Mapping[str, object] | None = None
    arcs_: ArcModel = field(init=False, repr=False)
    encoder_: Encoder = field(init=False, repr=False)
    card_: Mapping[str, object] = field(init=False, repr=False)

    def fit(
        self,
        X: Sequence[TreeOf | Lesson | str],
        y: Sequence[tuple[SDC, ...]] | None = None,
        *,
        others: Sequence[TreeOf | Lesson] = (),
    ) -> SDCParser:
        """Learn from annotated trees.

        Parameters
        ----------
        X
            Commands with their trees, maybe encoded already
            (:func:`g3.language.parsing.training.parser_training.prepare`); or their texts.
        y
            The trees of texts.
        others
            Commands whose annotators had other habits; they teach as far as they agree.

        Raises
        ------
        CorpusError
            If there is nothing to learn from, or texts come without as many trees.
        """
        from g3.language.parsing.training.parser_training import learned, prepare  # noqa: PLC0415

        taught = with_trees(X, y)
        with one_thread():
            self.arcs_, self.encoder_ = learned(
                prepare(taught),
                prepare(others),
                start=default_parser().arcs_,
                layers=self.layers,
                l2=self.l2,
            )
        self.card_ = {**(self.card or {}), "l2": self.l2, "layers": self.layers}
        return self

    def predict(self, X: Iterable[str | Words]) -> list[tuple[SDC, ...]]:
        """Return the clauses of each command's most probable tree; none where there is none."""
        return [parse.sdcs for parse in self.predict_proba(X)]

    def predict_proba(self, X: Iterable[str | Words], *, n_best: int = 1) -> Iterator[Parse]:
        """Yield the most probable trees of commands with their probabilities.

        Parameters
        ----------
        X
            Commands, maybe cut into words already; many at once are faster.
        n_best
            How many trees to give for each, at most.
        """
        if isinstance(X, (str, Words)):
            raise ModelError("X is one command", fix="give a list of commands: predict([command])")
        commands = (cut(one) if isinstance(one, str) else one for one in X)
        yield from parse_words(self.encoder_, self.arcs_, commands, n_best=n_best)

    def score(
        self, X: Sequence[TreeOf | Lesson | str], y: Sequence[tuple[SDC, ...]] | None = None
    ) -> float:
        """Return the share of commands whose best tree is the annotated one.

        Parameters
        ----------
        X, y
            As :meth:`fit` takes them.
        """
        from g3.language.parsing.training.parser_training import prepare  # noqa: PLC0415

        lessons = prepare(with_trees(X, y))
        trees = self.predict([lesson.command for lesson in lessons])
        right = [one == lesson.sdcs for one, lesson in zip(trees, lessons, strict=True)]
        return sum(right) / len(right)

    def save(self, path: Path | str) -> None:
        """Write it to a file; the same parser gives the same bytes.

        Nothing is written of the words of the commands.

        Raises
        ------
        FormatError
            If there is no such folder.
        """
        write_bytes(Path(path), to_bytes(self.arcs_, self.card_, self.encoder_))

    @classmethod
    def load(cls, path: Path | str) -> SDCParser:
        """Read what `save` wrote.

        Raises
        ------
        ModelError
            If it is missing or damaged, or was trained with another encoder.
        """
        content = read_bytes(Path(path), fix="give what 'ct train parser --out' wrote")
        arcs, card, encoder = from_bytes(content, where=str(path))
        layers = card.get("layers")
        parser = cls(l2=card.get("l2", DEFAULT_L2), layers=layers, card=card)
        parser.arcs_, parser.card_, parser.encoder_ = arcs, card, encoder
        return parser


@lru_cache(maxsize=1)
def default_parser() -> SDCParser:
    """Return the bundled parser, read once."""
    with resources.as_file(resources.files("g3.language.parsing") / DEFAULT) as file:
        return SDCParser.load(file)


def parse_words(
    encoder: Encoder, arcs: ArcModel, commands: Iterable[Words], *, n_best: int = 1
) -> Iterator[Parse]:
    """Yield the most probable trees of commands by a given encoder and choice of arcs."""
    first, second = tee(commands)
    for command, vectors in zip(first, encoder.encode_all(second), strict=True):
        yield _parse(arcs, command, vectors, n_best)


def _parse(model: ArcModel, command: Words, vectors: Float32Array, n_best: int) -> Parse:
    found: dict[tuple[SDC, ...], float] = {}
    if len(vectors):
        scores = log_probabilities(model, vectors, TEMPERATURE)
        likely = likely_arcs(scores, model.labels)
        for probability, arcs in islice(likely, WIDTH * n_best if n_best > 1 else 1):
            sdcs = build_trees(arcs, command.spans)
            if sdcs:
                found.setdefault(sdcs, probability)
    best = sorted(found.items(), key=lambda item: -item[1])[:n_best]
    note = command.note
    if not command.spans:
        note = note or "the text has no words"
    elif not best:
        note = "no clause was found in the text"
    return Parse(command.text, tuple([Tree(*item) for item in best]), note)
