"""A linear-chain conditional random field over the roles of a command's words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray
from g3.language.parsing.word_features import Features, IdArray
from g3.language.parsing.word_roles import ROLES, Role
from g3.short_repr import short_repr

IntArray = npt.NDArray[np.intp]
ScoreArray = npt.NDArray[np.floating]
TABLE_BITS = 20
_TABLE_SHIFT = np.uint64(64 - TABLE_BITS)
_FORBIDDEN = -1e4


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Weights of hashed features.

    Parameters
    ----------
    keys
        Buckets of the features that have weights, ascending, shape (f,).
    values
        Their weights, shape (f + 1, ...); those of all other features, 0, come last.
    rows
        For each bucket the row of `values`, shape (2^TABLE_BITS,).
    """

    keys: IntArray
    values: npt.NDArray[np.float32]
    rows: npt.NDArray[np.int32]

    def total(self, ids: IdArray) -> ScoreArray:
        """The sum of the weights of each word's features (words, t), shape (words, ...)."""
        result = np.zeros((len(ids), *self.values.shape[1:]), dtype=np.float32)
        part = np.empty_like(result)
        for column in buckets(ids).T:  # far less memory than all columns at once
            rows = self.rows.take(column, mode="clip")
            result += self.values.take(rows, axis=0, out=part, mode="clip")
        return result


def weigh(keys: IntArray, values: FloatArray) -> Weights:
    """Weights of features, with the table by which they are found."""
    rows = np.full(1 << TABLE_BITS, len(keys), dtype=np.int32)
    rows[keys] = np.arange(len(keys))
    padded = np.concatenate([values, np.zeros((1, *values.shape[1:]))]).astype(np.float32)
    return Weights(keys, padded, rows)


def buckets(ids: IdArray) -> IntArray:
    """Where features stand in the table."""
    places: IntArray = (ids >> _TABLE_SHIFT).astype(np.intp)
    return places


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class RoleModel:
    """Weights of the field.

    Parameters
    ----------
    roles
        How much each feature of a word speaks for each role (..., r).
    moves
        How much it speaks for each role after each role (..., r + 1, r); the last of the
        roles before is the beginning.
    vectors
        How much each number of a word's vector speaks for each role (VECTOR, r).
    """

    roles: Weights
    moves: Weights
    vectors: ScoreArray


class Scores(NamedTuple):
    """What speaks for the roles of words (n, r) and for pairs of roles (n, r + 1, r)."""

    roles: ScoreArray
    moves: ScoreArray


def score(model: RoleModel, features: Features) -> Scores:
    """Score the roles of some words."""
    known = model.roles.total(features.roles) + features.vectors @ model.vectors
    return Scores(known, model.moves.total(features.moves) + _POSSIBLE)


def _possible() -> FloatArray:
    mask = np.zeros((len(ROLES) + 1, len(ROLES)))
    nouns = {ROLES.index(role) for role in ("noun", "subject", "noun-on")}
    for i in range(len(ROLES) + 1):
        if i not in nouns:
            mask[i, ROLES.index("noun-on")] = _FORBIDDEN
    mask[-1, [ROLES.index("event-on"), ROLES.index("relation-on")]] = _FORBIDDEN
    return mask


POSSIBLE = _possible()
"""0 for each pair of roles that can follow each other, else a large negative number."""
_POSSIBLE = POSSIBLE.astype(np.float32)


class Chains:
    """The words of commands by their place, so that many commands are passed through at once.

    `words[step]` are the words at one place of the commands that are so long, the longest first.
    """

    def __init__(self, lengths: Sequence[int]) -> None:
        sizes = np.asarray(lengths, dtype=np.intp)
        offsets = np.cumsum(sizes) - sizes
        order = np.argsort(-sizes, kind="stable")
        sizes, offsets = sizes[order], offsets[order]
        self.words = [
            offsets[: int((sizes > step).sum())] + step for step in range(sizes.max(initial=0))
        ]


# Decoding


def best_roles(scores: Scores, lengths: Sequence[int]) -> list[tuple[float, tuple[Role, ...]]]:
    """The most probable roles of each of some commands (Viterbi) and their probability.

    Parameters
    ----------
    scores
        Of all their words.
    lengths
        How many words each command has.
    """
    chains = Chains(lengths)
    back = np.zeros(scores.roles.shape, dtype=np.intp)
    best = np.zeros(scores.roles.shape)
    _, scale = forward_pass(chains, scores)
    for step, words in enumerate(chains.words):
        if step:
            options = best[words - 1][:, :, None] + scores.moves[words, :-1]
            back[words] = options.argmax(axis=1)
            state = options.max(axis=1)
        else:
            state = scores.moves[words, -1]
        best[words] = state + scores.roles[words]
    role = best.argmax(axis=1)
    for step in range(len(chains.words) - 1, 0, -1):
        words = chains.words[step]
        role[words - 1] = back[words, role[words]]
    named = [ROLES[r] for r in role.tolist()]
    log_scale = np.concatenate([[0.0], np.cumsum(np.log(scale) + scores.roles.max(axis=1))])
    found = []
    end = 0
    for length in lengths:
        start, end = end, end + length
        chance = 1.0
        if length:
            total = log_scale[end] - log_scale[start]
            chance = float(np.exp(min(best[end - 1].max() - total, 0.0)))
        found.append((chance, tuple(named[start:end])))
    return found


def forward_pass(chains: Chains, scores: Scores) -> tuple[FloatArray, FloatArray]:
    """Probabilities of roles given the words up to each one (n, r), and their scale (n,).

    The logarithm of the scale, plus the best score of a role for each word, adds up to the
    logarithm of the partition function.
    """
    local = np.exp(scores.roles - scores.roles.max(axis=1, keepdims=True))
    forward = np.zeros_like(local)
    scale = np.ones(len(local))
    for step, words in enumerate(chains.words):
        moves = np.exp(scores.moves[words])
        if step:
            state = np.matmul(forward[words - 1, None, :], moves[:, :-1])[:, 0]
        else:
            state = moves[:, -1]
        state = state * local[words]
        scale[words] = state.sum(axis=1)
        forward[words] = state / scale[words, None]
    return forward, scale


def likely_roles(scores: Scores, count: int) -> list[tuple[float, tuple[Role, ...]]]:
    """The most probable roles of one command with their probabilities, best first.

    Parameters
    ----------
    scores
        Of its words.
    count
        How many to find.
    """
    n, r = scores.roles.shape
    if not n:
        return [(1.0, ())]
    values = (scores.roles[0] + scores.moves[0, -1])[:, None]
    steps: list[tuple[IntArray, int]] = []
    for i in range(1, n):
        kept = values.shape[1]
        options = values.reshape(r * kept, 1) + np.repeat(scores.moves[i, :-1], kept, axis=0)
        order = np.argsort(-options, axis=0, kind="stable")[:count]
        steps.append((order, kept))
        values = np.take_along_axis(options, order, axis=0).T + scores.roles[i][:, None]
    flat = values.ravel()
    total = _log_total(scores)
    found = []
    for place in np.argsort(-flat, kind="stable")[:count].tolist():
        role, rank = divmod(place, values.shape[1])
        path = [role]
        for order, kept in reversed(steps):
            role, rank = divmod(int(order[rank, role]), kept)
            path.append(role)
        named = tuple([ROLES[i] for i in reversed(path)])
        found.append((float(np.exp(min(flat[place] - total, 0.0))), named))
    return found


def _log_total(scores: Scores) -> float:
    state = scores.roles[0] + scores.moves[0, -1]
    for row, moves in zip(scores.roles[1:], scores.moves[1:], strict=True):
        state = row + np.logaddexp.reduce(state[:, None] + moves[:-1], axis=0)
    return float(np.logaddexp.reduce(state))
