"""Training on shards: the objective is a sum over them, and no more than one is in memory.

Three passes read them. One finds the features, and which of their columns are equal. One packs what
training needs of each shard into a scratch folder. Each step of training sums over that.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import sparse

import g3.features  # noqa: F401  (fills the catalogue)
from corpus_tools.runtime.parallel import Executor, Workers, work_in_order
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.shards.shard_files import Manifest, read_shard
from g3.errors import FormatError
from g3.features.matrix import FeatureSpace, prior_scale, renumbered
from g3.groundings import FloatArray
from g3.learning import crf
from g3.learning.crf import MAX_ITERATIONS, Local, Problem, minimise
from g3.learning.grounding_model import GroundingModel
from g3.storage.array_file import Field, read_arrays, write_arrays
from g3.storage.system_errors import about

PARTS = 16
"""Number of parts in which shards are summed by any executor, so that sums never vary."""
TOLERANCE, LEAST_EXAMPLES = 1e-8, 10_000
"""Tolerance for the gradient of the mean over examples, and their least assumed number."""

File = tuple[Path, str]
"""A shard and the digest that it must have."""
Signatures = npt.NDArray[np.uint64]
_COLUMNS = "columns.npz"
_COLUMN_FIELDS = {
    "bases": Field("U"),
    "words": Field("U"),
    "keys": Field("<i8"),
    "column": Field("<i4"),
}


def fit_on_shards(
    model: GroundingModel,
    folder: Path,
    manifest: Manifest,
    *,
    workers: Workers,
    tolerance: float | None = None,
    on_progress: OnProgress = no_progress,
) -> GroundingModel:
    """Fit a model to all shards of a folder; the optimum is that of the same examples in memory.

    `workers` read the shards; the scratch folder is made in `folder`, so that those of a cluster
    see it. `tolerance`, and not the model's, is when to stop: when no component of the gradient
    exceeds it. By default it is 1e-4 up to ten thousand examples, as in memory, and as much more as
    there are more examples.
    """
    if tolerance is None:
        tolerance = TOLERANCE * max(manifest.examples, LEAST_EXAMPLES)
    files = [(folder.absolute() / shard.file, shard.digest) for shard in manifest.shards]
    with (
        tempfile.TemporaryDirectory(prefix=".training-", dir=folder.absolute()) as scratch,
        Executor(workers) as executor,
    ):

        def told(step: str, count: int) -> Callable[[int], None]:
            return lambda done: on_progress(step, done, count)

        numbered = list(enumerate(files))
        surveys = work_in_order(
            _survey,
            numbered,
            executor,
            on_done=told("finding features", len(files)),
        )
        space, signatures = _joined(surveys, manifest.sets)
        first, copy_of = _distinct(signatures, prior_scale(space))
        _write_columns(Path(scratch) / _COLUMNS, space, first)
        packed = work_in_order(
            partial(_pack, scratch=Path(scratch)),
            files,
            executor,
            on_done=told("packing", len(files)),
        )
        unit, size = crf.shrinking(copy_of, (model.l2 / prior_scale(space) ** 2)[first])
        parts = [tuple(enumerate(packed))[i::PARTS] for i in range(min(PARTS, len(packed)))]
        evaluations = 0

        def look(weights: FloatArray, least: float) -> Local:
            nonlocal evaluations
            evaluations += 1
            on_progress("training", evaluations, MAX_ITERATIONS)
            looking = partial(_look, weights=unit * weights, least=least)
            return _scaled(_sum(work_in_order(looking, parts, executor)), unit)

        fit = minimise(
            Problem(look, unit, manifest.examples / 4),
            tolerance=tolerance,
            optimizer=model.optimizer,
        )
    return model.with_weights(space, (fit / size)[copy_of])


@dataclass(frozen=True, slots=True)
class _Survey:
    """The features of a shard, and the signatures of their columns, shape (k, 2)."""

    space: FeatureSpace
    signatures: Signatures


def _survey(numbered: tuple[int, File]) -> _Survey:
    """Give each row two random numbers; a column's signature is the sum over its rows.

    Sums of numbers of 64 bits wrap around. Different columns have the same two with a
    probability of 2^-128, and the sums of all shards are those of the whole columns.
    """
    number, file = numbered
    shard = read_shard(*file)
    rng = np.random.default_rng(number)
    rows = rng.integers(0, 2**64, size=(len(shard.right), 2), dtype=np.uint64)
    ones = np.ones(len(shard.features), dtype=np.uint64)
    matrix = sparse.csr_array(
        (ones, shard.features, shard.offsets), shape=(len(rows), len(shard.keys))
    )
    signatures: Signatures = np.asarray(matrix.T @ rows)
    return _Survey(shard.space, signatures)


def _joined(surveys: Sequence[_Survey], sets: tuple[str, ...]) -> tuple[FeatureSpace, Signatures]:
    """Return the features of all shards, and the sums of their signatures, shape (k, 2)."""
    bases = tuple(sorted({name for s in surveys for name in s.space.bases}))
    words = tuple(sorted({name for s in surveys for name in s.space.words}))
    translated = [renumbered(survey.space, bases, words) for survey in surveys]
    keys = np.unique(np.concatenate(translated))
    total = np.zeros((len(keys), 2), dtype=np.uint64)
    for columns, survey in zip(translated, surveys, strict=True):
        total[np.searchsorted(keys, columns)] += survey.signatures
    return FeatureSpace(sets, bases, words, keys), total


def _distinct(
    signatures: Signatures, scale: FloatArray
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return first places of distinct pairs of a column and a prior, and the pair of each."""
    table = np.column_stack((signatures, scale.view(np.uint64)))
    _, first, copy_of = np.unique(table, axis=0, return_index=True, return_inverse=True)
    return first, copy_of.reshape(-1)


def _write_columns(path: Path, space: FeatureSpace, first: npt.NDArray[np.intp]) -> None:
    column = np.full(len(space), -1, dtype=np.int32)
    column[first] = np.arange(len(first))
    arrays = {
        "bases": np.array(space.bases, dtype=np.str_),
        "words": np.array(space.words, dtype=np.str_),
        "keys": space.keys,
        "column": column,
    }
    with about(path):
        path.write_bytes(write_arrays(arrays, compressed=False))


@lru_cache(maxsize=1)
def _read_columns(
    path: Path,
) -> tuple[list[str], list[str], npt.NDArray[np.int64], npt.NDArray[np.int32]]:
    arrays = read_arrays(
        path, _COLUMN_FIELDS, where=str(path), fix="train again", error=FormatError
    )
    return arrays["bases"].tolist(), arrays["words"].tolist(), arrays["keys"], arrays["column"]


def _pack(file: File, *, scratch: Path) -> Path:
    """Write the distinct columns of a shard as training wants them."""
    bases, words, keys, column = _read_columns(scratch / _COLUMNS)
    shard = read_shard(*file)
    columns = column[np.searchsorted(keys, renumbered(shard.space, bases, words))]
    column_of = columns[shard.features]
    kept = column_of >= 0
    before = np.concatenate(([0], np.cumsum(kept)))
    packed = scratch / f"{file[0].stem}.npy"
    with about(packed), packed.open("wb") as out:
        for array in (column_of[kept], before[shard.offsets].astype(np.int32)):
            np.save(out, array)
        for array in (shard.right, shard.wrong):
            np.save(out, array.astype(np.float64))
    return packed


def _look(numbered: Sequence[tuple[int, Path]], *, weights: FloatArray, least: float) -> Local:
    """Return the sum over some packed shards, without the units of their columns."""
    return _sum([_look_at(number, path, weights, least) for number, path in numbered])


def _look_at(number: int, path: Path, weights: FloatArray, least: float) -> Local:
    with path.open("rb") as file:
        features, offsets, right, wrong = (np.load(file) for _ in range(4))
    matrix = sparse.csr_array(
        (np.ones(len(features)), features, offsets), shape=(len(right), len(weights))
    )
    return crf.Likelihood(matrix, right, times=right + wrong, number=number)(weights, least)


def _sum(locals_: Sequence[Local]) -> Local:
    if len(locals_) == 1:
        return locals_[0]
    return Local(
        sum(part.value for part in locals_),
        np.sum([part.gradient for part in locals_], axis=0),
        sum(part.curvature for part in locals_),
        sparse.csr_array(sparse.vstack([part.rows for part in locals_])),
        np.concatenate([part.strengths for part in locals_]),
    )


def _scaled(local: Local, unit: FloatArray) -> Local:
    local.rows.data *= unit[local.rows.indices]
    return replace(local, gradient=unit * local.gradient)
