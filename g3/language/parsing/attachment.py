"""Which noun a modifier modifies: a choice among the nouns before it, learned from trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import exp

from g3.language.lexicon.verb_classes import word_class
from g3.language.parsing.role_model import TABLE_BITS
from g3.language.parsing.spacy_pipeline import Analysis
from g3.language.parsing.tree_assembly import Clause
from g3.language.parsing.word_features import PRIME, string_id
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class AttachmentModel:
    """Weights of a log-linear choice, by the feature's bucket."""

    weights: Mapping[int, float] = field(default_factory=dict)


def probabilities(
    model: AttachmentModel, command: Analysis, modifier: int, nouns: Sequence[Clause]
) -> list[float]:
    """How probable it is that a modifier modifies each of some nouns, the nearest first."""
    weights = model.weights
    scores = [
        sum([weights.get(bucket, 0.0) for bucket in buckets])
        for buckets in choice_features(command, modifier, nouns)
    ]
    top = max(scores)
    odds = [exp(score - top) for score in scores]
    total = sum(odds)
    return [value / total for value in odds]


def choice_features(
    command: Analysis, modifier: int, nouns: Sequence[Clause]
) -> list[tuple[int, ...]]:
    """The buckets of the features of each choice.

    Parameters
    ----------
    command
        The command.
    modifier
        The word that begins the modifier.
    nouns
        What it could modify, the nearest first.
    """
    lower = command.lower
    word = lower[modifier]
    phrase = " ".join(lower[modifier : modifier + 3])
    head = int(command.head[modifier])
    found: list[tuple[int, ...]] = []
    ahead = word_class(lower[min(modifier + 2, len(lower) - 1)])
    inner = ""
    for number, noun in enumerate(nouns):
        rank = min(number, 2)
        link = " ".join([lower[i] for i in noun.relation[:2]]) if number else ""
        words = leaf(noun).words
        name = lower[words[-1]] if words else ""
        parsed = head in words
        found.append(
            (
                *_of_rank(rank, word, phrase, ahead),
                *_of_link(rank, link, inner, word, phrase),
                *_of_noun(rank, name, word, parsed, bool(noun.relation)),
            )
        )
        inner = " ".join([lower[i] for i in noun.relation[:2]])
    return found


@lru_cache(maxsize=65536)
def _of_rank(rank: int, word: str, phrase: str, ahead: str) -> tuple[int, ...]:
    return _buckets(
        f"rank {rank}",
        f"rank {rank} word {word}",
        f"rank {rank} phrase {phrase}",
        f"rank {rank} class {ahead}",
    )


@lru_cache(maxsize=65536)
def _of_link(rank: int, link: str, inner: str, word: str, phrase: str) -> tuple[int, ...]:
    return _buckets(
        f"link {link}",
        f"link {link} word {word}",
        f"link {link} phrase {phrase}",
        f"inner {inner} rank {rank}",
    )


@lru_cache(maxsize=65536)
def _of_noun(rank: int, name: str, word: str, parsed: bool, modified: bool) -> tuple[int, ...]:
    return _buckets(
        f"noun {name}",
        f"noun {name} word {word}",
        f"noun {name} of {rank}",
        f"parsed {parsed}",
        f"parsed {parsed} word {word}",
        f"modified {modified} rank {rank}",
    )


def _buckets(*names: str) -> tuple[int, ...]:
    """Where features stand in the table: numbers, from which no word can be read."""
    return tuple(
        (string_id(name) * PRIME & 0xFFFFFFFFFFFFFFFF) >> (64 - TABLE_BITS) for name in names
    )


def leaf(noun: Clause) -> Clause:
    """The innermost figure of a noun."""
    while noun.f:
        noun = noun.f[0]
    return noun
