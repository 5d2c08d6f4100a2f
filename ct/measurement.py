"""Training of models, and the tables of the paper that measure them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal, overload

from ct.argument_checks import known_options, one_of, positive, several
from ct.corpus_access import AnyCorpus, load

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.tables.formats import ResultTable
    from g3.language.parsing.sdc_parser import SDCParser
    from g3.learning.grounding_model import GroundingModel

DRAWS = {1: 2000, 2: 10_000, 3: 2000}
"""Resamples for the intervals of each table, as the command line has them."""
BUNDLED = {1: "warehouse", 2: "warehouse-simulated-ratings", 3: "warehouse"}
"""Corpora that are measured where none is given."""
OPTIONS = {
    1: ("negatives", "test_negatives", "ablate", "plus", "l2", "threshold"),
    2: ("study", "models"),
    3: ("ablate", "l2", "headings", "perturb", "parses", "most", "grounder", "parser", "judge"),
}
"""Further options of each table."""
LISTS = ("ablate", "plus", "headings", "perturb", "grounder", "parser")
"""Those that are several names."""


@overload
def train(
    corpus: AnyCorpus,
    to: Literal["match", "follow"] = ...,
    *,
    l2: float | None = ...,
    negatives: Literal["random", "hard"] = ...,
    ablate: Sequence[str] = ...,
    plus: Sequence[str] = ...,
    seed: int = ...,
) -> GroundingModel: ...
@overload
def train(corpus: AnyCorpus, to: Literal["parse"], *, l2: float | None = ...) -> SDCParser: ...
def train(
    corpus: AnyCorpus,
    to: Literal["match", "follow", "parse"] = "match",
    *,
    l2: float | None = None,
    negatives: Literal["random", "hard"] = "random",
    ablate: Sequence[str] = (),
    plus: Sequence[str] = (),
    seed: int = 0,
) -> GroundingModel | SDCParser:
    """Train a model on a corpus. Its ``save(path)`` keeps it, for the command line too.

    Parameters
    ----------
    corpus
        Corpus to learn from.
    to
        Purpose of the model. ``match``: to predict matches between clauses and groundings (Table
        1), as ``ct train g3`` does. ``follow``: to follow commands; it learns from the alternatives
        in each scene, which takes minutes. ``parse``: to parse commands, as ``ct train parser``
        does.
    l2
        Strength of the regularisation, above 0.
    negatives, ablate, plus, seed
        For ``match`` only: the kind of negatives, feature sets to leave out and to add (``ct
        features list``), and the random seed of hard negatives.

    Raises
    ------
    CorpusError
        If there is nothing to learn from, or an argument is none of those above.
    """
    one_of("to", to, ("match", "follow", "parse"))
    one_of("negatives", negatives, ("random", "hard"))
    positive("l2", l2)
    loaded = load(corpus)
    if to == "parse":
        from corpus_tools.learning.trained import parser_from

        return parser_from([loaded], l2)
    from g3.learning.grounding_model import DEFAULT_L2

    strength = DEFAULT_L2 if l2 is None else l2
    if to == "follow":
        from corpus_tools.following.bundled_grounder import following_model

        return following_model(loaded, l2=strength)
    from corpus_tools.corpus.labelled_corpus import Options
    from corpus_tools.learning.trained import from_corpus

    options = Options(negatives, seed, several(ablate), several(plus))
    return from_corpus(loaded, strength, options).model


def evaluate(
    corpus: AnyCorpus | None = None,
    *,
    table: Literal[1, 2, 3] = 1,
    train: AnyCorpus | GroundingModel | None = None,
    seed: int = 0,
    draws: int | None = None,
    jobs: int = 1,
    **options: Any,
) -> ResultTable:
    """Measure a table of the paper on a corpus, as ``ct eval`` does.

    Parameters
    ----------
    corpus
        Corpus to test on; left out, the bundled one, for Table 2 with simulated ratings.
    table
        1: accuracy of a model's predictions of matches between clauses and groundings. 2: share of
        people's judgments that a video shows a command. 3: share of correct plans, by the automatic
        judge.
    train
        Training data. For Table 1 a corpus, or a model of :func:`ct.train`; left out, each
        scenario is held out in turn. For Table 3 a corpus; left out, the other scenarios.
    seed, draws
        Random seed; number of resamples for the intervals.
    jobs
        Number of processes.
    options
        Further options of ``ct eval --table N``, with underscores: ``negatives``,
        ``test_negatives``, ``ablate``, ``plus``, ``l2``, ``threshold`` of Table 1; ``study``,
        ``models`` of Table 2; ``ablate``, ``l2``, ``headings``, ``perturb``, ``parses``, ``most``,
        ``grounder``, ``parser``, ``judge`` of Table 3. A grounder is a name of ``@grounder``, or a
        ``PlanGrounder``; there may be several, each in a row.

    Returns
    -------
    ResultTable
        It prints as the command does. ``rows`` and ``to_pandas()`` have the figures.

    Raises
    ------
    CorpusError
        If the corpus has nothing to test on, or shares scenarios with the training data.

    Examples
    --------
    >>> print(ct.evaluate("warehouse", table=1))
    """
    from corpus_tools.runtime.parallel import Workers

    measure: dict[int, Callable[..., ResultTable]] = {1: _table_1, 2: _table_2, 3: _table_3}
    one_of("table", table, measure)
    positive("draws", draws)
    positive("jobs", jobs)
    known_options(options, OPTIONS[table], f"Table {table}")
    positive("l2", options.get("l2"))
    options = {k: several(v) if k in LISTS else v for k, v in options.items()}
    given: dict[str, Any] = {"seed": seed, "draws": draws or DRAWS[table], "workers": Workers(jobs)}
    with (
        _folder_of(BUNDLED[table] if corpus is None else corpus) as tested,
        _folder_of(train) as learned,
    ):
        return measure[table](tested, learned, **given, **options)


@contextmanager
def _folder_of(thing: AnyCorpus | GroundingModel | None) -> Iterator[str]:
    """Yield a name that processes can open; a corpus in memory is written to a folder."""
    from corpus_tools.corpus.corpus_model import Corpus

    if thing is None or isinstance(thing, (str, Path)):
        yield str(thing or "")
        return
    with TemporaryDirectory(prefix="ct-") as folder:
        if isinstance(thing, Corpus):
            path = Path(folder) / (Path(thing.name).name or "corpus")
            thing.save(path)
        else:
            path = Path(folder) / "model.npz"
            thing.save(path)
        yield str(path)


def _table_1(
    corpus: str, train: str, *, seed: int, draws: int, workers: Workers, **options: Any
) -> ResultTable:
    from corpus_tools.runtime.parallel import Executor
    from eval.table_1 import held_out_predictions
    from eval.table_1.correspondence import table_rows
    from eval.table_1.correspondence_table import render
    from eval.table_1.divided_examples import Choices

    source: dict[str, Any] = {"corpus": corpus, "division": "cv"}
    if train:
        is_model = train.endswith((".npz", ".json"))
        source = {"test": corpus, **({"model": Path(train)} if is_model else {"train": train})}
    choices = Choices(**source, seed=seed, **options)
    result = held_out_predictions.run(choices)
    with Executor(workers) as executor:
        rows = table_rows(
            result.predictions,
            threshold=choices.threshold,
            draws=draws,
            seed=seed,
            executor=executor,
        )
    metadata = {"table": 1, **result.metadata, "draws": draws}
    return _table("Table 1", lambda form: render(rows, form, metadata))


def _table_2(
    corpus: str, _train: str, *, seed: int, draws: int, workers: Workers, **options: Any
) -> ResultTable:
    from corpus_tools.runtime.parallel import Executor
    from eval.statistics.ratings import check_judgments
    from eval.table_2.rating_shares import table_2
    from eval.table_2.rating_table import render

    rated = load(corpus)
    check_judgments(rated.judgments, {command.video for command in rated.commands.values()})
    with Executor(workers) as executor:
        results = table_2(rated.judgments, seed=seed, draws=draws, executor=executor, **options)
    metadata: dict[str, object] = {
        "table": 2,
        "corpus": rated.name,
        "is_authored": rated.is_authored,
        "seed": seed,
        "draws": draws,
    }
    return _table("Table 2", lambda form: render(results, form, metadata))


def _table_3(
    corpus: str, train: str, *, seed: int, draws: int, workers: Workers, **options: Any
) -> ResultTable:
    from eval.judging.judge_registry import judge_named
    from eval.table_3.baselines import BASELINES
    from eval.table_3.end_to_end import run
    from eval.table_3.grounder_registry import grounder_named
    from eval.table_3.plan_report import with_judge

    names = (corpus, *(train or corpus).split(","))
    named = (one for one in options.pop("grounder", ()) if one not in BASELINES)  # these are there
    grounders = [grounder_named(one) if isinstance(one, str) else one for one in named]
    options |= {"grounders": grounders, "parsers": options.pop("parser", ())}
    if isinstance(options.get("judge"), str):
        options["judge"] = judge_named(options["judge"])
    result = run(train or corpus, corpus, seed=seed, workers=workers, **options)
    corpora = (load(name) for name in names)
    return _table("Table 3", with_judge(result, corpora, draws=draws, seed=seed))


def learning_curve(
    corpus: AnyCorpus | None = None,
    *,
    train: AnyCorpus | None = None,
    repeats: int = 5,
    seed: int = 0,
    **options: Any,
) -> ResultTable:
    """Measure the test error of Table 1's model by the size of training (section 4.2).

    Parameters
    ----------
    corpus
        Corpus to test on; left out, the bundled one.
    train
        Corpus to learn from; left out, each scenario is held out in turn.
    repeats
        Number of random orders of the commands.
    seed
        Random seed.
    options
        Further options of Table 1, as :func:`evaluate` takes them.

    Returns
    -------
    ResultTable
        A row for each type and size: the mean ``error``, its least and its greatest value.

    Examples
    --------
    >>> ct.learning_curve("warehouse").to_pandas()
    """
    from eval.table_1 import held_out_predictions
    from eval.table_1.divided_examples import Choices
    from eval.table_1.learning_curve import render

    positive("repeats", repeats)
    known_options(options, OPTIONS[1], "Table 1")
    options = {k: several(v) if k in LISTS else v for k, v in options.items()}
    tested = BUNDLED[1] if corpus is None else corpus
    with _folder_of(tested) as test, _folder_of(train) as learned:
        source: dict[str, Any]
        source = {"test": test, "train": learned} if train is not None else {"corpus": test}
        choices = Choices(**source, division="cv", seed=seed, **options)
        points, metadata = held_out_predictions.learning_curve(choices, repeats)
    return _table("The learning curve", lambda form: render(points, form, metadata))


def _table(title: str, render: Any) -> ResultTable:
    from eval.tables.formats import ResultTable

    return ResultTable(title, render)
