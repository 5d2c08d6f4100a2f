"""Training of the conditional random field over roles (:mod:`g3.language.parsing.role_model`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import sparse

from g3.groundings import FloatArray
from g3.language.parsing.role_model import (
    POSSIBLE,
    Chains,
    RoleModel,
    Scores,
    buckets,
    forward_pass,
    weigh,
)
from g3.language.parsing.word_features import Features, IdArray
from g3.language.parsing.word_roles import ROLES, Role
from g3.lbfgs import lbfgs

VECTOR_SCALE = 0.45
"""Standard deviation of the prior of the vectors' weights, beside that of the others."""

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


def train_roles(
    features: Features,
    roles: Sequence[Sequence[Role]],
    *,
    l2: float,
    least: int = 1,
    max_iterations: int = 100,
    scales: Sequence[float] | None = None,
    strange: BoolArray | None = None,
) -> RoleModel:
    """Fit a model by maximum likelihood with L-BFGS.

    Words of commands that were annotated by other conventions are explained by a second set of
    weights, added to the model's own and forgotten after training, so that the model learns what
    both conventions have in common (regularised multi-task learning, Evgeniou and Pontil, 2004).

    Parameters
    ----------
    features
        Of all words.
    roles
        The roles of each command's words.
    l2
        Strength of the regularisation.
    least
        How often a feature must occur to have a weight.
    max_iterations
        Steps after which to stop.
    scales
        Standard deviations of the priors of the weights, beside each other, for each of the
        columns of the roles' features; 1 if left out.
    strange
        Which words are of commands annotated by other conventions, shape (n,); none if left out.
    """
    chains = Chains([len(sequence) for sequence in roles])
    gold = np.array([ROLES.index(role) for sequence in roles for role in sequence], dtype=np.intp)
    before = np.concatenate([[len(ROLES)], gold[:-1]])
    before[chains.words[0]] = len(ROLES)
    n, r = len(gold), len(ROLES)
    keys, named = _matrix(features.roles, least)
    scale = _scale(features.roles, keys, scales)
    vectors = sparse.csr_array(VECTOR_SCALE * features.vectors.astype(float))
    own = sparse.csr_array(sparse.hstack([named @ sparse.diags_array(scale), vectors]))
    move_keys, own_moves = _matrix(features.moves, least)
    matrix, move_matrix = _twofold(own, strange), _twofold(own_moves, strange)
    observed = np.zeros((n, r))
    observed[np.arange(n), gold] = 1
    moved = np.zeros((n, r + 1, r))
    moved[np.arange(n), before, gold] = 1
    wanted = (matrix.T @ observed).ravel()
    move_wanted = (move_matrix.T @ moved.reshape(n, -1)).ravel()
    size = len(wanted)
    transposed, move_transposed = sparse.csr_array(matrix.T), sparse.csr_array(move_matrix.T)

    def objective(parameters: FloatArray) -> tuple[float, FloatArray]:
        scores = Scores(
            matrix @ parameters[:size].reshape(-1, r),
            (move_matrix @ parameters[size:].reshape(-1, (r + 1) * r)).reshape(n, r + 1, r)
            + POSSIBLE,
        )
        log_total, chance, move_chance = expectations(chains, scores)
        reached = float(scores.roles[np.arange(n), gold].sum())
        reached += float(scores.moves[np.arange(n), before, gold].sum())
        gradient = np.concatenate(
            [
                (transposed @ chance).ravel() - wanted,
                (move_transposed @ move_chance.reshape(n, -1)).ravel() - move_wanted,
            ]
        )
        value = log_total - reached + 0.5 * l2 * float(parameters @ parameters)
        return value, gradient + l2 * parameters

    start = np.zeros(size + len(move_wanted))
    found = lbfgs(objective, start, maxiter=max_iterations, maxcor=8, ftol=1e-7)
    weights = found[:size].reshape(-1, r)[: own.shape[1]]
    return RoleModel(
        weigh(keys, scale[:, None] * weights[: len(keys)]),
        weigh(move_keys, found[size:].reshape(-1, r + 1, r)[: own_moves.shape[1]]),
        (VECTOR_SCALE * weights[len(keys) :]).astype(np.float32),
    )


def _twofold(matrix: sparse.csr_array, strange: BoolArray | None) -> sparse.csr_array:
    """The columns of a matrix, and once more for strange rows."""
    if strange is None or not strange.any():
        return matrix
    again = sparse.diags_array(strange.astype(float)) @ matrix
    return sparse.csr_array(sparse.hstack([matrix, again]))


def _scale(ids: IdArray, keys: IntArray, scales: Sequence[float] | None) -> FloatArray:
    """The scale of each bucket: the largest of the columns that fall into it."""
    if scales is None:
        return np.ones(len(keys))
    scale = np.zeros(len(keys))
    for column, value in zip(buckets(ids).T, scales, strict=True):
        places = np.flatnonzero(np.isin(keys, column))
        scale[places] = np.maximum(scale[places], value)
    return scale


def _matrix(ids: IdArray, least: int) -> tuple[IntArray, sparse.csr_array]:
    """Which buckets occur often enough, and which of them each word has (words, f)."""
    found = buckets(ids)
    keys, counts = np.unique(found, return_counts=True)
    keys = keys[counts >= least]
    columns = np.searchsorted(keys, found)
    inside = (columns < len(keys)) & (keys[np.minimum(columns, len(keys) - 1)] == found)
    ends = np.concatenate([[0], np.cumsum(inside.sum(axis=1))])
    shape = (len(ids), len(keys))
    return keys, sparse.csr_array((np.ones(ends[-1]), columns[inside], ends), shape=shape)


def expectations(chains: Chains, scores: Scores) -> tuple[float, FloatArray, FloatArray]:
    """Log partition function, probabilities of roles (n, r) and of moves (n, r + 1, r)."""
    top = scores.roles.max(axis=1, keepdims=True)
    local = np.exp(scores.roles - top)
    moves = np.exp(scores.moves)
    forward, scale = forward_pass(chains, scores)
    backward = np.ones_like(local)
    move_chance = np.zeros_like(moves)
    for step in range(len(chains.words) - 1, 0, -1):
        words = chains.words[step]
        ahead = local[words] * backward[words] / scale[words, None]
        backward[words - 1] = np.matmul(moves[words, :-1], ahead[:, :, None])[:, :, 0]
        move_chance[words, :-1] = (
            moves[words, :-1] * forward[words - 1, :, None] * ahead[:, None, :]
        )
    chance = forward * backward
    if chains.words:
        move_chance[chains.words[0], -1] = chance[chains.words[0]]
    return float(top.sum() + np.log(scale).sum()), chance, move_chance
