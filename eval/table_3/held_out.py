"""Held-out scenarios: costs, parsers and probabilities that haven't seen the tested one.

An executor makes their training data, which are shared with other processes as a file.
"""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy import sparse
from scipy.special import expit

from corpus_tools.corpus.annotated_trees import Annotated, annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import forget_old
from corpus_tools.runtime.parallel import Executor, WorkerDiedError, Workers, work_in_order
from corpus_tools.runtime.progress import OnProgress
from eval.splits import leave_one_out
from eval.statistics.estimates import BoolArray
from eval.table_3.outcomes import Outcome
from g3.errors import CorpusError, FormatError
from g3.features.feature_registry import FeatureSet
from g3.features.matrix import FeatureSpace
from g3.inference.calibration import fit_curve
from g3.inference.problem.costs import Scorer
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.language.parsing.sdc_parser import SDCParser
from g3.language.parsing.training.parser_training import prepare
from g3.learning.factor_matrix import FactorMatrix
from g3.learning.grounding_model import GroundingModel
from g3.learning.load_choice import LoadChoice, LoadChooser
from g3.storage.array_file import Field, read_arrays, write_arrays
from g3.storage.cache_folder import cache_folder

Fitted = TypeVar("Fitted")

FEWEST = 3
"""Smallest number of scenarios for calibration; with fewer, probabilities stay as they are."""


def fitted_without(
    fit: Callable[[BoolArray], Fitted], scenarios: Sequence[str]
) -> Callable[[str], Fitted]:
    """Return a function that fits a model to all scenarios but the named one.

    The last model is kept, for scenarios in a row.

    Parameters
    ----------
    fit
        Fits a model to the rows that are true.
    scenarios
        The scenario of each row.
    """
    of_row, names = np.array(scenarios, dtype=np.str_), set(scenarios)

    @functools.lru_cache(maxsize=1)
    def fitted(left_out: str) -> Fitted:
        return fit(of_row != left_out)

    return lambda scenario: fitted(scenario if scenario in names else "")


def costs_without(
    factors: FactorMatrix, choices: Sequence[LoadChoice] = (), *, l2: float = 1.0
) -> Callable[[str], Scorer]:
    """Return a function that learns costs from annotations of all scenarios but one."""

    def fit(rows: BoolArray) -> GroundingModel:
        return GroundingModel(l2=l2, tolerance=TOLERANCE).fit(factors[rows])

    def fit_loads(rows: BoolArray) -> LoadChooser:
        return LoadChooser.fit([c for c, used in zip(choices, rows, strict=True) if used])

    model_of = fitted_without(fit, factors.scenario.tolist())
    if not choices:
        return lambda scenario: Scorer(model_of(scenario))
    chooser_of = fitted_without(fit_loads, [choice.scenario for choice in choices])

    def costs(scenario: str) -> Scorer:
        model = model_of(scenario)
        known = GroundingModel(l2=l2, tolerance=TOLERANCE)
        return Scorer(known.with_weights(model.space_, model.weights_, chooser_of(scenario)))

    return costs


def trees_without(corpora: Sequence[Corpus]) -> Callable[[str], list[Annotated]]:
    """Return a function that lists the commands with trees of all scenarios but one.

    They are those of the first corpus that has any then, since corpora have conventions of their
    own.
    """
    trees = [annotated_trees(corpus) for corpus in corpora if corpus.annotations]

    def without(scenario: str) -> list[Annotated]:
        left = ([one for one in own if one.command.scenario != scenario] for own in trees)
        return next(filter(None, left), [])

    return without


def parser_without(corpora: Sequence[Corpus]) -> Callable[[str], SDCParser]:
    """Return a function that learns to parse from all scenarios but one.

    As with ``ct train parser`` the first corpus says how trees are made, and the others teach as
    far as they agree. A corpus without annotations teaches
    nothing here, but one must have some.
    """
    annotated = [corpus for corpus in corpora if corpus.annotations] or corpora[:1]
    trees = [annotated_trees(corpus) for corpus in annotated]
    number = np.repeat(np.arange(len(trees)), [len(part) for part in trees])
    scenarios = [item.command.scenario for part in trees for item in part]
    lessons = functools.cache(lambda: [lesson for part in trees for lesson in prepare(part)])

    def fit(rows: BoolArray) -> SDCParser:
        kept = np.flatnonzero(rows)
        first = number[kept] == number[kept[:1]]  # of what is left, should a corpus be gone
        own, others = ([lessons()[i] for i in part] for part in (kept[first], kept[~first]))
        seen = sorted({scenarios[i] for i in kept})
        return SDCParser(card={"scenarios": seen}).fit(own, others=others)

    return fitted_without(fit, scenarios)


def calibrated(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Calibrate outcomes' probabilities by curves that have not seen their scenarios.

    The bundled curve was fitted to plans for the paper's commands, so on these commands it is
    overconfident. Here the slopes for a scenario's plans are fitted to the plans of all
    others. Fitting the intercept so, too, would bias it against scenarios that go well. A curve
    that has seen neither of two scenarios has one intercept for both, so all have one: the mean
    of the held-out intercepts.

    Those that have no evidence keep their probability, and so do all if no plan or every plan is
    right.
    """
    own = [o for o in outcomes if o.evidence]
    scenarios = [o.scenario for o in own]
    correct = np.array([o.correct for o in own], dtype=bool)
    if len(set(scenarios)) < FEWEST or correct.all() or not correct.any():
        return list(outcomes)
    seen = np.array([o.evidence for o in own])
    odds = np.zeros(len(own))
    intercepts = []
    for split in leave_one_out(scenarios):
        intercept, *slopes = fit_curve(seen[split.train], correct[split.train])
        odds[split.test] = seen[split.test, 1:] @ slopes
        intercepts.append(intercept)
    given = iter(expit(odds + np.mean(intercepts)).tolist())
    return [replace(o, probability=next(given)) if o.evidence else o for o in outcomes]


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
    result = read_arrays(file, _FIELDS, where=str(file), fix="start again", error=FormatError)
    sets, bases, words = (tuple(result[name].tolist()) for name in _NAMES)
    space = FeatureSpace(sets, bases, words, result["keys"])
    indices, indptr = result["indices"], result["indptr"]
    shape = (len(indptr) - 1, len(space))
    matrix = sparse.csr_array((np.ones(len(indices)), indices, indptr), shape=shape)
    return FactorMatrix(space, matrix, result["correct"], result["scenario"])
