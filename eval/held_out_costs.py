"""Costs of groundings, learned from all scenarios but one."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy import sparse

from corpus_tools.bundled import cache_folder, forget_old
from corpus_tools.corpus.model import Corpus
from corpus_tools.parallel import Team, WorkerDiedError, work_in_order
from corpus_tools.progress import OnProgress
from g3.errors import CorpusError
from g3.features.matrix import FeatureSpace
from g3.features.registry import FeatureSet, select
from g3.inference.costs import Scorer
from g3.inference.training import Data, train_rows, training_data

Item = TypeVar("Item")
_PREFIX = ".examples-"


def learner(data: Data, *, l2: float = 1.0) -> Callable[[str], Scorer]:
    """What learns the costs from all scenarios but the one with a name.

    The last costs are kept, for scenarios in a row.
    """
    known = set(data.scenario)

    @functools.lru_cache(maxsize=1)
    def learned(left_out: str) -> Scorer:
        return Scorer(train_rows(data, np.flatnonzero(data.scenario != left_out), l2=l2))

    return lambda scenario: learned(scenario if scenario in known else "")


def data_of(
    corpora: Sequence[Corpus],
    *,
    sets: Sequence[FeatureSet] | None = None,
    seed: int = 0,
    team: Team | None = None,
    on_progress: OnProgress | None = None,
) -> Data:
    """What costs are learned from, of several corpora.

    Parameters
    ----------
    sets
        Feature sets; those that models use by default if left out.
    seed
        What negatives are drawn with.
    team
        Who makes the examples; what comes of it is the same for any.

    Raises
    ------
    CorpusError
        If processes of the team die of it.
    """
    annotations = [a for corpus in corpora for a in corpus.annotations]
    chosen = select() if sets is None else sets
    if team is None:
        return training_data(annotations, chosen, seed=seed, on_progress=on_progress)

    def each(function: Callable[[Item], Data], tasks: Sequence[Item]) -> list[Data]:
        def told(done: int) -> None:
            if on_progress:
                on_progress("trying actions", done, len(tasks))

        return work_in_order(function, tasks, team, on_done=told)

    try:
        return training_data(annotations, chosen, seed=seed, each=each)
    except WorkerDiedError as error:
        raise CorpusError(f"examples to learn from can't be made: {error}") from error


@contextmanager
def written(data: Data) -> Iterator[Path]:
    """A file for other processes, as long as they need it; :func:`read` reads it.

    It is in the cache, which the workers of a cluster may see, too.

    Raises
    ------
    CorpusError
        If nothing can be written there.
    """
    try:
        folder = _new_folder()
        file = Path(folder.name) / "examples.npz"
        np.savez(
            file,
            sets=np.array(data.space.sets, dtype=np.str_),
            bases=np.array(data.space.bases, dtype=np.str_),
            words=np.array(data.space.words, dtype=np.str_),
            keys=data.space.keys,
            indices=data.matrix.indices,
            indptr=data.matrix.indptr,
            correct=data.correct,
            scenario=data.scenario,
        )
    except OSError as error:
        raise CorpusError(
            f"examples to learn from can't be written in the cache: {error.strerror}",
            where=str(cache_folder()),
            fix="set XDG_CACHE_HOME to a folder that can be written to",
        ) from error
    with folder:
        yield file


def _new_folder() -> tempfile.TemporaryDirectory[str]:
    cache_folder().mkdir(parents=True, exist_ok=True)
    forget_old(f"{_PREFIX}*")  # of processes that were killed
    return tempfile.TemporaryDirectory(prefix=_PREFIX, dir=cache_folder())


def read(file: Path) -> Data:
    """Read what another process has written."""
    with np.load(file, allow_pickle=False) as found:
        sets, bases, words = (tuple(found[name].tolist()) for name in ("sets", "bases", "words"))
        space = FeatureSpace(sets, bases, words, found["keys"])
        indices, indptr = found["indices"], found["indptr"]
        shape = (len(indptr) - 1, len(space))
        matrix = sparse.csr_array((np.ones(len(indices)), indices, indptr), shape=shape)
        return Data(space, matrix, found["correct"], found["scenario"])
