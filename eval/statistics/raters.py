"""Joint answers of a pair's raters: majorities, and raters weighted by their errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.estimates import BoolArray, FloatArray, IntArray
from g3.short_repr import short_repr

TOLERANCE = 1e-8
MOST_STEPS = 2000
FEWEST_RATERS = 3
"""Smallest number of raters whose answers can show their errors."""
TINY = float(np.finfo(np.float64).tiny)


def majorities(agrees: BoolArray, pair: IntArray) -> BoolArray:
    """Return for each pair whether more than half of its judgments agree, in order."""
    _, index = np.unique(pair, return_inverse=True)
    found: BoolArray = 2 * np.bincount(index, weights=agrees) > np.bincount(index)
    return found


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class DawidSkene:
    """A model of raters' individual errors."""

    prevalence: FloatArray
    """Frequency of each true class, shape (classes,)."""
    answers: FloatArray
    """Probability of each rater's answers for each true class, shape (raters, true classes, given
    classes); NaN where nothing is known."""
    posterior: FloatArray
    """Probability of each class for each item, shape (items, classes)."""
    log_likelihood: FloatArray
    """Log-likelihood after each step, which never decreases."""
    reason: Reason = ""
    """Reason for which the model can't show raters' errors; empty if it can."""

    def share(self, of: IntArray, is_class: int) -> Estimate:
        """Return the share of some items that are probably of a class, without an interval."""
        if self.reason or len(of) == 0:
            return undefined(self.reason or "no data")
        return Estimate(float((self.posterior[of, is_class] > 0.5).mean()))


def dawid_skene(
    item: IntArray, rater: IntArray, given: IntArray, classes: int | None = None
) -> DawidSkene:
    """Estimate true classes and raters' errors together by expectation maximisation.

    A. P. Dawid and A. M. Skene, Applied Statistics 28 (1979). It begins with each item's shares
    of answers, as they do.

    Of each answer there are an item, a rater and the class that was given: numbers from 0 without
    gaps, shape (n,). The number of classes defaults to the greatest given class plus one.

    With fewer than three raters, or where nothing was judged twice, errors can't be separated from
    true classes: the posteriors are the shares of answers then, and `reason` has the reason.
    """
    items, raters = int(item.max(initial=-1)) + 1, int(rater.max(initial=-1)) + 1
    k = classes or int(given.max(initial=-1)) + 1
    if items == 0:
        none = np.zeros((0, k))
        return DawidSkene(
            np.full(k, np.nan), np.zeros((0, k, k)), none, np.zeros(0), reason="no data"
        )
    # An answer adds the column of its rater and class to the sums of its item.
    column = rater * k + given
    counts = np.zeros((items, raters * k))
    np.add.at(counts, (item, column), 1.0)
    posterior = counts.reshape(items, raters, k).sum(axis=1)
    posterior /= posterior.sum(axis=1, keepdims=True)
    trace: list[float] = []
    reason: Reason
    while True:
        prevalence = posterior.mean(axis=0)
        answers = (posterior.T @ counts).reshape(k, raters, k)
        totals = answers.sum(axis=2, keepdims=True)
        answers = np.divide(answers, totals, out=np.full_like(answers, np.nan), where=totals > 0)
        # A rater who never gave an answer may give it all the same, though hardly ever.
        logs = np.log(np.maximum(np.nan_to_num(answers), TINY)).reshape(k, raters * k)
        joint = counts @ logs.T + np.log(np.maximum(prevalence, TINY))
        top = joint.max(axis=1, keepdims=True)
        total = top + np.log(np.exp(joint - top).sum(axis=1, keepdims=True))
        posterior = np.exp(joint - total)
        trace.append(float(total.sum()))
        if len(trace) > 1 and abs(trace[-1] - trace[-2]) <= TOLERANCE * abs(trace[-1]):
            reason = _unidentified(item, rater)
            break
        if len(trace) == MOST_STEPS:
            reason = "no convergence"
            break
    return DawidSkene(prevalence, answers.transpose(1, 0, 2), posterior, np.array(trace), reason)


def _unidentified(item: IntArray, rater: IntArray) -> Reason:
    pairs = np.unique(np.column_stack([item, rater]), axis=0)
    if np.bincount(pairs[:, 0]).max() < 2:
        return "no overlap"
    return "few raters" if len(np.unique(rater)) < FEWEST_RATERS else ""
