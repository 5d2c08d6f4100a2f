"""Training data of costs: made by an executor, and shared with other processes as a file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy import sparse

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import forget_old
from corpus_tools.runtime.parallel import Executor, WorkerDiedError, Workers, work_in_order
from corpus_tools.runtime.progress import OnProgress
from g3.errors import CorpusError, FormatError
from g3.features.feature_registry import FeatureSet
from g3.features.matrix import FeatureSpace
from g3.inference.training import search_sets, training_data
from g3.learning.factor_matrix import FactorMatrix
from g3.storage.array_file import Field, read_arrays, write_arrays
from g3.storage.cache_folder import cache_folder

Item = TypeVar("Item")
_PREFIX = ".examples-"
_NAMES = ("sets", "bases", "words")
_FIELDS = {
    **dict.fromkeys(_NAMES, Field("U")),
    "keys": Field("<i8"),
    "indices": Field("i"),
    "indptr": Field("i"),
    "correct": Field("|b1"),
    "scenario": Field("U"),
}


def data_of(
    corpora: Sequence[Corpus],
    *,
    sets: Sequence[FeatureSet] | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    on_progress: OnProgress | None = None,
) -> FactorMatrix:
    """Return the training data of costs, from several corpora.

    Parameters
    ----------
    sets
        Feature sets; those that models use by default if left out.
    executor
        Executor that makes the examples; the result doesn't depend on it.
    """
    annotations = [a for corpus in corpora for a in corpus.annotations]
    chosen = search_sets() if sets is None else sets
    if executor is None:
        return training_data(annotations, chosen, seed=seed, on_progress=on_progress)

    def each(function: Callable[[Item], FactorMatrix], tasks: Sequence[Item]) -> list[FactorMatrix]:
        def told(done: int) -> None:
            if on_progress:
                on_progress("trying actions", done, len(tasks))

        return work_in_order(function, tasks, executor, on_done=told)

    try:
        return training_data(annotations, chosen, seed=seed, each=each)
    except WorkerDiedError as error:
        raise CorpusError(f"examples to learn from can't be made: {error}") from error


@contextmanager
def shared(
    corpora: Sequence[Corpus],
    sets: Sequence[FeatureSet],
    *,
    seed: int,
    workers: Workers,
    on_progress: OnProgress | None,
) -> Iterator[tuple[Executor, Path]]:
    """Yield workers, and the file of training data of costs that they make together."""
    with Executor(workers) as executor:
        data = data_of(corpora, sets=sets, seed=seed, executor=executor, on_progress=on_progress)
        with written(data) as file:
            del data
            yield executor, file


def read_or_made(
    file: Path, corpora: Sequence[Corpus], sets: Sequence[FeatureSet], *, seed: int
) -> FactorMatrix:
    """Read a file; a cluster's worker that doesn't see it makes the same data again."""
    return read(file) if file.is_file() else data_of(corpora, sets=sets, seed=seed)


@contextmanager
def written(data: FactorMatrix) -> Iterator[Path]:
    """Write a file for other processes, for the duration of a block; :func:`read` reads it.

    It is in the cache, which the workers of a cluster may see, too.
    """
    cache = cache_folder()
    try:
        cache.mkdir(parents=True, exist_ok=True)
        forget_old(f"{_PREFIX}*")  # of processes that were killed
        folder = tempfile.TemporaryDirectory(prefix=_PREFIX, dir=cache)
        file = Path(folder.name) / "examples.npz"
        arrays = {
            **{name: np.array(getattr(data.space, name), dtype=np.str_) for name in _NAMES},
            "keys": data.space.keys,
            "indices": data.matrix.indices,
            "indptr": data.matrix.indptr,
            "correct": data.correct,
            "scenario": np.asarray(data.scenario, dtype=np.str_),
        }
        file.write_bytes(write_arrays(arrays, compressed=False))
    except OSError as error:
        raise CorpusError(
            f"examples to learn from can't be written in the cache: {error.strerror}",
            where=str(cache),
            fix="set XDG_CACHE_HOME to a folder that can be written to",
        ) from error
    with folder:
        yield file


def read(file: Path) -> FactorMatrix:
    """Read a file that another process has written."""
    found = read_arrays(file, _FIELDS, where=str(file), fix="start again", error=FormatError)
    sets, bases, words = (tuple(found[name].tolist()) for name in _NAMES)
    space = FeatureSpace(sets, bases, words, found["keys"])
    indices, indptr = found["indices"], found["indptr"]
    shape = (len(indptr) - 1, len(space))
    matrix = sparse.csr_array((np.ones(len(indices)), indices, indptr), shape=shape)
    return FactorMatrix(space, matrix, found["correct"], found["scenario"])
