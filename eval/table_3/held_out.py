"""Held-out scenarios: costs, extractors and probabilities that haven't seen the tested one."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy.special import expit

from corpus_tools.corpus.annotated_trees import annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from eval.splits import leave_one_out
from eval.statistics.estimates import BoolArray
from eval.table_3.outcomes import Outcome
from g3.inference.calibration import fit_curve
from g3.inference.problem.costs import Scorer
from g3.inference.training import TOLERANCE
from g3.language.parsing.extractor import SDCExtractor
from g3.language.parsing.training.extractor_training import prepare
from g3.learning.factor_matrix import FactorMatrix
from g3.learning.grounding_model import GroundingModel
from g3.learning.load_choice import LoadChoice, LoadChooser

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
    of_row, known = np.array(scenarios, dtype=np.str_), set(scenarios)

    @functools.lru_cache(maxsize=1)
    def fitted(left_out: str) -> Fitted:
        return fit(of_row != left_out)

    return lambda scenario: fitted(scenario if scenario in known else "")


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


def extractor_without(corpora: Sequence[Corpus]) -> Callable[[str], SDCExtractor]:
    """Return a function that learns to extract trees from all scenarios but one.

    The bundled extractor has learned from the bundled corpus and from the paper's. So it must not
    be used where commands of these are tested. As with ``ct train sdc`` the first corpus says how
    trees are made, and the others teach as far as they agree. A corpus without annotations teaches
    nothing here, but one must have some.
    """
    annotated = [corpus for corpus in corpora if corpus.annotations] or corpora[:1]
    trees = [annotated_trees(corpus) for corpus in annotated]
    number = np.repeat(np.arange(len(trees)), [len(part) for part in trees])
    scenarios = [item.command.scenario for part in trees for item in part]
    lessons = functools.cache(lambda: [lesson for part in trees for lesson in prepare(part)])

    def fit(rows: BoolArray) -> SDCExtractor:
        kept = np.flatnonzero(rows)
        first = number[kept] == number[kept[:1]]  # of what is left, should a corpus be gone
        own, others = ([lessons()[i] for i in part] for part in (kept[first], kept[~first]))
        seen = sorted({scenarios[i] for i in kept})
        return SDCExtractor(card={"scenarios": seen}).fit(own, others=others)

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
