"""From the text of a command to its SDC trees (section 3.1).

spaCy finds words, parts of speech and dependencies (:mod:`g3.language.pipeline`); a
conditional random field gives each word its role (:mod:`g3.language.role_model`); the roles
say how the tree is put together (:mod:`g3.language.assembly`), but for the nouns that
modifiers modify, which are chosen last (:mod:`g3.language.attachment`). Both choices are
learned from annotated trees and have probabilities, so there is a list of the best trees.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, islice
from math import prod
from typing import NamedTuple

from g3.language.assembly import Clause, assemble
from g3.language.attachment import AttachmentModel, probabilities
from g3.language.pipeline import Analysis, analyse
from g3.language.role_model import RoleModel, Scores, best_roles, likely_roles, score
from g3.language.roles import Role
from g3.language.word_features import features
from g3.sdc import SDC

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


@dataclass(frozen=True, slots=True, eq=False)
class Extractor:
    """What is learned from annotated trees.

    Parameters
    ----------
    roles
        Gives words their roles.
    attachments
        Gives modifiers their nouns.
    card
        What it was trained on, for people.
    """

    roles: RoleModel
    attachments: AttachmentModel
    card: Mapping[str, object] = field(default_factory=dict)


def extract(extractor: Extractor, texts: Iterable[str], *, n_best: int = 1) -> Iterator[Parse]:
    """Extract the trees of commands, one after the other.

    Parameters
    ----------
    extractor
        The model.
    texts
        Commands.
    n_best
        How many trees to give for each, at most.
    """
    analyses = analyse(texts)
    while batch := list(islice(analyses, BATCH)):
        yield from extract_analysed(extractor, batch, n_best=n_best)


def extract_analysed(
    extractor: Extractor, commands: Sequence[Analysis], *, n_best: int = 1
) -> list[Parse]:
    """Extract the trees of analysed commands."""
    scores = score(extractor.roles, features(commands))
    lengths = [len(command.lower) for command in commands]
    if n_best == 1:
        found = best_roles(scores, lengths)
        return [_parse(extractor, c, *roles) for c, roles in zip(commands, found, strict=True)]
    parses = []
    end = 0
    for command, length in zip(commands, lengths, strict=True):
        own = Scores(*(part[end : end + length] for part in scores))
        parses.append(_parse_n_best(extractor, command, own, n_best))
        end += length
    return parses


def _parse(
    extractor: Extractor, command: Analysis, probability: float, roles: Sequence[Role]
) -> Parse:
    def choose(modifier: int, nouns: Sequence[Clause]) -> int:
        nonlocal probability
        chances = probabilities(extractor.attachments, command, modifier, nouns)
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


def _parse_n_best(extractor: Extractor, command: Analysis, scores: Scores, n_best: int) -> Parse:
    found: dict[tuple[SDC, ...], float] = {}
    for chance, roles in likely_roles(scores, n_best * WIDTH):
        if len(found) >= n_best and chance <= sorted(found.values())[-n_best]:
            break  # what follows is less probable still
        for sdcs, share in islice(_attached(extractor, command, roles), n_best):
            if sdcs:
                found[sdcs] = max(found.get(sdcs, 0.0), chance * share)
    best = sorted(found.items(), key=lambda item: -item[1])[:n_best]
    return _noted(command, tuple(Tree(*item) for item in best))


def _attached(
    extractor: Extractor, command: Analysis, roles: Sequence[Role]
) -> Iterator[tuple[tuple[SDC, ...], float]]:
    """The trees that roles allow and their probabilities given the roles, best first."""

    def build(forced: tuple[int, ...]) -> tuple[tuple[SDC, ...], list[int], list[list[float]]]:
        taken: list[int] = []
        chances: list[list[float]] = []

        def choose(modifier: int, nouns: Sequence[Clause]) -> int:
            chance = probabilities(extractor.attachments, command, modifier, nouns)
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
