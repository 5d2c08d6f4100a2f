"""From the text of a command to its SDC trees (section 3.1).

spaCy finds words, parts of speech and dependencies (:mod:`g3.language.parsing.spacy_pipeline`); a
conditional random field gives each word its role (:mod:`g3.language.parsing.role_model`); the roles
say how the tree is put together (:mod:`g3.language.parsing.tree_assembly`), but for the nouns that
modifiers modify, which are chosen last (:mod:`g3.language.parsing.attachment`). Both choices are
learned from annotated trees and have probabilities, so there is a list of the best trees.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import resources
from itertools import count, islice
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from g3 import html_view
from g3.data_frames import data_frame
from g3.errors import ModelError
from g3.estimator import Estimator, read_bytes
from g3.language.parsing.attachment import AttachmentModel, probabilities
from g3.language.parsing.extractor_file import from_bytes, to_bytes
from g3.language.parsing.role_model import RoleModel, Scores, best_roles, likely_roles, score
from g3.language.parsing.spacy_pipeline import Analysis, analysed
from g3.language.parsing.tree_assembly import Clause, assemble
from g3.language.parsing.word_features import features
from g3.language.parsing.word_roles import Role
from g3.sdc import sdc_drawing
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import format_brackets
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    import pandas as pd

    from g3.language.parsing.training.extractor_training import Lesson, TreeOf

DEFAULT_L2 = 1.2
DEFAULT = "english.npz"
"""The bundled extractor's file."""
BATCH = 256
"""How many commands are worked on at once."""
WIDTH = 2
"""How many more role sequences than trees are looked at: several can give the same tree."""


class Tree(NamedTuple):
    """One way to read a command.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    probability
        How probable the model takes this reading to be.
    """

    sdcs: tuple[SDC, ...]
    probability: float


@short_repr
@dataclass(frozen=True, slots=True)
class Parse:
    """What was extracted from a command.

    Parameters
    ----------
    text
        The command.
    trees
        The most probable trees, the best first; empty if there are none.
    note
        Why there is no tree, or what isn't in it; empty if all went well.
    """

    text: str
    trees: tuple[Tree, ...]
    note: str = ""

    @property
    def sdcs(self) -> tuple[SDC, ...]:
        """The clauses of the best tree."""
        return self.trees[0].sdcs if self.trees else ()

    def __len__(self) -> int:
        """How many trees there are."""
        return len(self.trees)

    def __iter__(self) -> Iterator[Tree]:
        """The trees, the best first."""
        return iter(self.trees)

    def __getitem__(self, which: int) -> Tree:
        """A tree by its rank, from 0."""
        return self.trees[which]

    def to_pandas(self) -> pd.DataFrame:
        """A row for each tree: its probability, and its clauses in brackets."""
        return data_frame(
            {"probability": p, "clauses": " ".join(format_brackets(sdcs).split())}
            for sdcs, p in self.trees
        )

    def _repr_html_(self) -> str:
        """The command with its trees drawn, the best first."""
        drawn = [
            html_view.paragraph(f"probability {tree.probability:.2f}")
            + sdc_drawing.to_svg(tree.sdcs)
            for tree in self.trees
        ]
        return "\n".join([html_view.heading(self.text, self.note), *drawn])


@short_repr
@dataclass(eq=False)
class SDCExtractor(Estimator):
    """Learns from annotated trees how commands are divided into clauses.

    Parameters
    ----------
    l2
        Strength of the regularisation.
    card
        What its file says of the training, besides what `fit` adds.

    Attributes
    ----------
    roles_
        Gives words their roles.
    attachments_
        Gives modifiers their nouns.
    card_
        What it was trained on, for people.
    """

    l2: float = DEFAULT_L2
    card: Mapping[str, object] = field(default_factory=dict)
    roles_: RoleModel = field(init=False, repr=False)
    attachments_: AttachmentModel = field(init=False, repr=False)
    card_: Mapping[str, object] = field(init=False, repr=False)

    def fit(
        self,
        X: Sequence[TreeOf | Lesson | str],
        y: Sequence[tuple[SDC, ...]] | None = None,
        *,
        others: Sequence[TreeOf | Lesson] = (),
    ) -> SDCExtractor:
        """Learn from annotated trees, and from those written for all.

        The latter are in :mod:`g3.language.parsing.training.lessons`.

        Parameters
        ----------
        X
            Commands with their trees, maybe analysed already
            (:func:`g3.language.parsing.training.extractor_training.prepare`); or their texts.
        y
            The trees of texts.
        others
            What to learn from besides, as far as it agrees: annotators of another corpus have
            other habits.

        Raises
        ------
        CorpusError
            If there is nothing to learn from, or texts come without as many trees.
        """
        # Optimisers are slow to import, and who only extracts needs none.
        from g3.language.parsing.training.extractor_training import learned, prepare, recipe  # noqa: PLC0415

        taught = _taught(X, y)
        self.roles_, self.attachments_ = learned(prepare(taught), prepare(others), l2=self.l2)
        self.card_ = {**self.card, "l2": self.l2, "recipe": recipe()}
        return self

    def predict(self, X: Iterable[str | Analysis]) -> list[tuple[SDC, ...]]:
        """The top-level clauses of each command's most probable tree; none where there is none."""
        return [parse.sdcs for parse in self.predict_proba(X)]

    def predict_proba(self, X: Iterable[str | Analysis], *, n_best: int = 1) -> Iterator[Parse]:
        """The most probable trees of commands with their probabilities, one after the other.

        Parameters
        ----------
        X
            Commands, maybe analysed already; many at once are faster.
        n_best
            How many trees to give for each, at most.
        """
        if isinstance(X, (str, Analysis)):
            raise ModelError("X is one command", fix="give a list of commands: predict([command])")
        analyses = analysed(X)
        while batch := list(islice(analyses, BATCH)):
            yield from self._parses(batch, n_best)

    def _parses(self, commands: Sequence[Analysis], n_best: int) -> Iterator[Parse]:
        scores = score(self.roles_, features(commands))
        lengths = [len(command.lower) for command in commands]
        if n_best == 1:
            found = best_roles(scores, lengths)
            for command, roles in zip(commands, found, strict=True):
                yield _parse(self.attachments_, command, *roles)
            return
        end = 0
        for command, length in zip(commands, lengths, strict=True):
            own = Scores(*(part[end : end + length] for part in scores))
            yield _parse_n_best(self.attachments_, command, own, n_best)
            end += length

    def save(self, path: Path | str) -> None:
        """Write it to a file; the same extractor gives the same bytes.

        Features are hashed: of the words of the commands nothing is written.

        Raises
        ------
        FormatError
            If there is no such folder.
        """
        write_bytes(Path(path), to_bytes(self.roles_, self.attachments_, self.card_))

    @classmethod
    def load(cls, path: Path | str) -> SDCExtractor:
        """Read what `save` wrote.

        Raises
        ------
        ModelError
            If it is missing or damaged, or was written for other roles or features than there are.
        """
        content = read_bytes(Path(path), fix="give what 'ct train sdc --out' wrote")
        roles, attachments, card = from_bytes(content, where=str(path))
        found = cls(l2=card.get("l2", DEFAULT_L2), card=card)
        found.roles_, found.attachments_, found.card_ = roles, attachments, card
        return found


@lru_cache(maxsize=1)
def default_extractor() -> SDCExtractor:
    """The bundled extractor."""
    with resources.as_file(resources.files("g3.language.parsing") / DEFAULT) as file:
        return SDCExtractor.load(file)


def _taught(
    X: Sequence[TreeOf | Lesson | str], y: Sequence[tuple[SDC, ...]] | None
) -> Sequence[Any]:
    """Commands with their trees; ModelError for texts without."""
    if isinstance(X, str):
        raise ModelError("X is one command", fix="give a list of commands, and their trees as y")
    if y is None:
        if any(isinstance(one, str) for one in X):
            raise ModelError(
                "the commands have no trees to learn from", fix="give these as y: fit(texts, trees)"
            )
        return X
    if len(X) != len(y):
        raise ModelError(
            f"there are {len(X)} commands and {len(y)} trees", fix="give a tree for each command"
        )
    return list(zip(X, y, strict=True))


def _parse(
    model: AttachmentModel, command: Analysis, probability: float, roles: Sequence[Role]
) -> Parse:
    def choose(modifier: int, nouns: Sequence[Clause]) -> int:
        nonlocal probability
        chances = probabilities(model, command, modifier, nouns)
        best = max(chances)
        probability *= best
        return chances.index(best)

    sdcs = assemble(roles, command.spans, command.lower, choose)
    return _noted(command, (Tree(sdcs, probability),) if sdcs else ())


def _noted(command: Analysis, trees: tuple[Tree, ...]) -> Parse:
    note = command.note
    if not command.spans:
        note = command.note or "the text has no words"
    elif not trees:
        note = "no clause was found in the text"
    return Parse(command.text, trees, note)


def _parse_n_best(model: AttachmentModel, command: Analysis, scores: Scores, n_best: int) -> Parse:
    found: dict[tuple[SDC, ...], float] = {}
    for chance, roles in likely_roles(scores, n_best * WIDTH):
        if len(found) >= n_best and chance <= sorted(found.values())[-n_best]:
            break  # what follows is less probable still
        for sdcs, share in islice(_attached(model, command, roles), n_best):
            if sdcs:
                found[sdcs] = max(found.get(sdcs, 0.0), chance * share)
    best = sorted(found.items(), key=lambda item: -item[1])[:n_best]
    return _noted(command, tuple(Tree(*item) for item in best))


def _attached(
    model: AttachmentModel, command: Analysis, roles: Sequence[Role]
) -> Iterator[tuple[tuple[SDC, ...], float]]:
    """The trees that roles allow and their probabilities given the roles, best first."""

    def build(forced: tuple[int, ...]) -> tuple[tuple[SDC, ...], list[int], list[list[float]]]:
        taken: list[int] = []
        chances: list[list[float]] = []

        def choose(modifier: int, nouns: Sequence[Clause]) -> int:
            chance = probabilities(model, command, modifier, nouns)
            number = len(taken)
            best = chance.index(max(chance))
            taken.append(forced[number] if number < len(forced) else best)
            chances.append(chance)
            return taken[-1]

        return assemble(roles, command.spans, command.lower, choose), taken, chances

    order = count()
    heap: list[tuple[float, int, tuple[int, ...]]] = [(-1.0, next(order), ())]
    while heap:
        _, _, forced = heapq.heappop(heap)
        sdcs, taken, chances = build(forced)
        yield sdcs, prod(chance[choice] for choice, chance in zip(taken, chances, strict=True))
        prefix = 1.0
        for place, (choice, chance) in enumerate(zip(taken, chances, strict=True)):
            if place >= len(forced):
                for other in set(range(len(chance))) - {choice}:
                    # No tree that begins with these choices is more probable than they are.
                    bound = -prefix * chance[other]
                    heapq.heappush(heap, (bound, next(order), (*taken[:place], other)))
            prefix *= chance[choice]
