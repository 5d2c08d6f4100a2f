"""Tables that say little or nothing: every estimator gives a figure that exists, or a reason."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import eval as package
from corpus_tools.corpus import rater_agreement
from corpus_tools.corpus.estimate import REASONS, Estimate
from corpus_tools.corpus.rater_agreement import dawid_skene, fleiss_kappa, krippendorff_alpha
from eval.judging.judge_validity import agreement, cohens_kappa
from eval.parsing import sdc_scores
from eval.plan_study.rating_sample import Sample, agreements, half_widths
from eval.report.plan_results import bins, calibration_error
from eval.statistics import comparison, estimates, intervals, ordinal, power, ratings
from eval.statistics.estimates import resampled_sums
from eval.statistics.intervals import crossed
from eval.table_1.correspondence import ROW_TYPES, Predictions, table_rows
from eval.table_1.given_predictions import compare_predictions
from eval.table_2 import power_plans
from eval.table_2.rating_shares import table_2
from eval.table_3 import outcomes, plan_rows
from eval.table_3.judged_commands import Facts
from eval.table_3.outcomes import Outcome
from eval.tables.comparison_report import compare_commands
from g3.annotation import RATINGS, Judgment
from g3.errors import CorpusError
from tests.eval.plan_study.made_plans import plans_of

DRAWS = 60


class Table(NamedTuple):
    """Ratings of pairs, each of shape (n,)."""

    rating: np.ndarray
    original: np.ndarray
    pair: np.ndarray
    video: np.ndarray
    rater: np.ndarray

    @property
    def agrees(self) -> np.ndarray:
        return self.rating >= 4


def table(rating, original=None, pair=None, video=None, rater=None):
    """A table of lists; what isn't given differs from row to row, and the videos are own ones."""
    n = len(rating)
    whole = [np.arange(n) if x is None else np.array(x, dtype=np.int64) for x in (pair, video)]
    who = np.arange(n) if rater is None else np.array(rater, dtype=np.int64)
    own = np.ones(n, bool) if original is None else np.array(original, dtype=bool)
    return Table(np.array(rating, dtype=np.int64), own, *whole, who)


HALF = [True] * 6 + [False] * 6
IN_THREES = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
IN_TURN = [0, 1, 2] * 4
DEGENERATE = {
    "no rows": table([]),
    "one row": table([4]),
    "two rows that differ": table([1, 5], [True, False]),
    "constant": table([3] * 12, HALF, IN_THREES, IN_THREES, IN_TURN),
    "all agree": table([5] * 12, HALF, IN_THREES, IN_THREES, IN_TURN),
    "all disagree": table([1] * 12, HALF, IN_THREES, IN_THREES, IN_TURN),
    "one rater": table([1, 2, 5, 4] * 3, HALF, rater=[0] * 12),
    "one rater who always says three": table([3] * 12, HALF, rater=[0] * 12),
    "one item": table([1, 5, 4] * 4, pair=[0] * 12, video=[0] * 12),
    "two items with the same ratings": table(
        [4, 2] * 2, None, [0, 0, 1, 1], [0, 0, 1, 1], [0, 1] * 2
    ),
    "raters who all agree": table(
        [1] * 3 + [4] * 3 + [2] * 3 + [5] * 3, HALF, IN_THREES, IN_THREES, IN_TURN
    ),
    "separated": table([5, 4] * 3 + [1, 2] * 3, HALF, IN_THREES, IN_THREES, IN_TURN),
    "quasi-separated": table([5, 3] * 3 + [1, 3] * 3, HALF, IN_THREES, IN_THREES, IN_TURN),
    "separated in many videos": table(
        [5, 4] * 12 + [1, 2] * 12, [True] * 24 + [False] * 24, None, list(range(12)) * 4,
        [0, 1, 2] * 16,
    ),
    "nothing is rated twice": table([1, 5, 4, 2] * 3, HALF),
    "each rater has a video": table([1, 5, 4] * 4, HALF, IN_THREES, IN_THREES, IN_THREES),
    "one class": table([1, 5, 4] * 4, [False] * 12, IN_THREES, IN_THREES, IN_TURN),
    "raters cancel": table(
        [1, 5, 5, 1], [True, True, False, False], None, [0, 0, 1, 1], [0, 1, 0, 1]
    ),
    "a large cluster": table([1, 5] + [4] * 30, [True, False] * 16, None, [0, 1] + [2] * 30),
    "one differs": table([5] * 39 + [1], [True] * 40, None, list(range(20)) * 2, [0, 1] * 20),
}  # fmt: skip


@st.composite
def drawn_tables(draw):
    """Small tables with few values, so that most are degenerate in some way."""
    n = draw(st.integers(0, 14))

    def column(most):
        return draw(st.lists(st.integers(0, draw(st.integers(0, most))), min_size=n, max_size=n))

    rating = [1 + value for value in column(4)]
    original = [value > 0 for value in column(1)]
    if draw(st.booleans()):  # separated, but for what the points at the middle say
        rating = [(3 if own else 1) + r % 3 for own, r in zip(original, rating, strict=True)]
    return table(rating, original, column(5), column(13), column(4))


def rng():
    return np.random.default_rng(0)


def judgments(t):
    return [
        Judgment(
            f"{i}",
            f"c{t.pair[i]}",
            f"v{t.video[i]}",
            f"v{t.video[i] if t.original[i] else t.video[i] + 1}",
            RATINGS[t.rating[i] - 1],
            f"r{t.rater[i]}",
            "s",
        )
        for i in range(len(t.rating))
    ]


def predictions(t):
    names = np.array(ROW_TYPES)[t.rater % 4] if len(t.rater) else np.array([], dtype=np.str_)
    where = t.video.astype(np.str_)
    return Predictions(names, t.original, (t.rating - 1) / 4, t.pair.astype(np.str_), where)


def shares(t):
    """Two configurations; the other one has no figure of some commands."""
    first = np.where(t.original, (t.rating - 1) / 4, np.nan)
    return {"one": first, "other": np.where(t.rating > 1, t.agrees.astype(float), np.nan)}


def followed(t):
    return [
        Outcome(
            f"c{i}", f"s{t.video[i]}", "Go.", (t.rating[i] - 1) / 4, bool(t.original[i]), "",
            objects=int(t.rater[i]), objects_right=int(t.rater[i] > 1),
            by_words=[None, True, False][t.pair[i] % 3], theme=[True, None][t.rater[i] % 2],
        )
        for i in range(len(t.rating))
    ]  # fmt: skip


def facts(t):
    return {
        f"c{i}": Facts(person=f"p{t.rater[i]}" if t.rater[i] else "") for i in range(len(t.pair))
    }


def by_name(t):
    own = {name: {f"c{i}": float(v) for i, v in enumerate(s)} for name, s in shares(t).items()}
    return own, {f"c{i}": f"s{t.video[i]}" for i in range(len(t.video))}


def rated_plans(t):
    plans = plans_of(["right" if own else "wrong" for own in t.original])
    some = [plan for i, plan in enumerate(plans) if t.rater[i] != 1]
    sample = Sample(0, "log", {plan.run: 0.5 for plan in some})
    people = {plan.run: bool(t.agrees[i]) for i, plan in enumerate(plans) if t.rater[i] == 0}
    return plans, sample, {run: said for run, said in people.items() if run in sample.chance}


def resampled(counts):
    return resampled_sums(counts, rng=rng(), draws=DRAWS)


def counts(t):
    clusters = int(t.video.max(initial=-1)) + 1
    return estimates.confusion(
        t.original, t.agrees, cluster=t.video, group=t.rater % 2, shape=(clusters, 2)
    )


def share_of(t):
    return float(t.agrees.mean()) if len(t.rating) else np.nan


def units(t):
    return [t.rating[t.pair == pair].tolist() for pair in np.unique(t.pair)]


def numbered(index):
    return np.unique(index, return_inverse=True)[1]


def a_plan(t):
    correlation = intervals.intraclass_correlation(t.agrees, t.pair)
    plan = power.plan_interval(0.05, share=share_of(t), judges=3, correlation=correlation.value)
    return plan, share_of(t), correlation.value


def simulated(t):
    plan, share, correlation = a_plan(t)
    if not isinstance(plan, power.Plan):
        return plan
    return power.simulated_half_width(
        plan, share=share, correlation=correlation, rng=rng(), studies=50
    )


def separate_link(t):
    return ordinal.cumulative_link(t.rating, t.original[:, None].astype(float), t.video)


TRIED = {
    "comparison.clustered_mcnemar": lambda t: comparison.clustered_mcnemar(
        t.agrees.astype(float) - t.original, t.video
    ),
    "comparison.cohens_h": lambda t: comparison.cohens_h(
        1.0 * t.agrees.all(), np.mean([1.0, *t.original])
    ),
    "comparison.compare_all": lambda t: comparison.compare_all(
        shares(t), t.video, rng=rng(), draws=DRAWS
    ),
    "comparison.holm": lambda t: comparison.holm((t.rating - 1) / 4),
    "comparison_report.compare_commands": lambda t: compare_commands(
        *by_name(t), seed=0, draws=DRAWS
    ),
    "correspondence.table_rows": lambda t: table_rows(predictions(t), draws=DRAWS),
    "intervals.crossed": lambda t: crossed(t.agrees, t.video, t.rater),
    "estimates.bounded": lambda t: estimates.bounded(
        share_of(t), *np.quantile([0.0, *t.rating], (0, 1)) / 4
    )
    if len(t.rating)
    else estimates.bounded(np.nan, np.nan, np.inf),
    "estimates.cluster_bootstrap": lambda t: estimates.cluster_bootstrap(
        counts(t), estimates.figures, rng=rng(), draws=DRAWS
    ),
    "estimates.percentiles": lambda t: estimates.percentiles(
        share_of(t), np.where(t.original, t.rating / 5, np.nan), len(t.rating)
    ),
    "given_predictions.compare_predictions": lambda t: compare_predictions(
        {"one": predictions(t), "other": predictions(t._replace(rating=t.rating[::-1]))},
        threshold=0.5, draws=DRAWS, seed=0,
    ),
    "intervals.bootstrap": lambda t: intervals.bootstrap(t.agrees, t.video, rng=rng(), draws=DRAWS),
    "intervals.clopper_pearson": lambda t: intervals.clopper_pearson(
        int(t.agrees.sum()), len(t.rating)
    ),
    "intervals.gee": lambda t: intervals.gee(t.agrees, t.video),
    "intervals.intraclass_correlation": lambda t: intervals.intraclass_correlation(
        t.agrees, t.pair
    ),
    "intervals.two_way": lambda t: intervals.two_way(t.agrees, t.video, t.rater),
    "intervals.wilson": lambda t: intervals.wilson(int(t.agrees.sum()), len(t.rating)),
    "judge_validity.agreement": lambda t: agreement(
        t.agrees.tolist(), t.original.tolist(), numbered(t.video), resampled
    ),
    "ordinal.cliffs_delta": lambda t: ordinal.cliffs_delta(
        t.rating[t.original], t.rating[~t.original]
    ),
    "ordinal.cumulative_link": lambda t: [
        (found, found.odds_ratio())
        for found in (
            separate_link(t),
            ordinal.cumulative_link(t.rating, np.column_stack([t.original, t.rater]).astype(float)),
        )
    ],
    "ordinal.no_link": lambda t: ordinal.no_link("no data", len(t.rating)),
    "outcomes.grounding_accuracy": lambda t: outcomes.grounding_accuracy(followed(t)),
    "outcomes.reliability": lambda t: outcomes.reliability(followed(t)),
    "outcomes.risk_coverage": lambda t: outcomes.risk_coverage(followed(t)),
    "plan_rows.comparisons": lambda t: plan_rows.comparisons(
        {"auto": followed(t), "random": followed(t._replace(original=~t.original))}, facts(t),
        draws=DRAWS, seed=0,
    ),
    "plan_rows.estimates_of": lambda t: [
        plan_rows.estimates_of(row, verdict)
        for row in plan_rows.rows({"auto": followed(t)}, facts(t), {}, draws=DRAWS, seed=0)
        for verdict in plan_rows.VERDICTS
    ],
    "rating_sample.agreements": lambda t: agreements(*rated_plans(t), "log", seed=0, draws=DRAWS),
    "power.design_effect": lambda t: power.design_effect(3, (len(t.rating) % 5) / 4),
    "power.judgments_for_difference": lambda t: power.judgments_for_difference(
        1.0 * t.agrees.any(), 0.5
    ),
    "power.plan_interval": lambda t: a_plan(t)[0],
    "power.own_shares": lambda t: power.own_shares(
        1.0 * t.agrees.any(), [0.0, 1e-300, 0.5, 1 - 1e-12, 1.0][len(t.rating) % 5], (50,), rng()
    ),
    "power.simulated_half_width": simulated,
    "power_plans.assumptions": lambda t: [
        power_plans.assumptions(judgments(t)),
        power_plans.plans(0.05, *power_plans.assumptions(judgments(t)), seed=0),
    ],
    "rater_agreement.dawid_skene": lambda t: [
        dawid_skene(numbered(t.pair), numbered(t.rater), t.agrees.astype(np.int64), classes)
        .share(np.unique(numbered(t.pair)), 0)
        for classes in (None, 2, 3)
    ],
    "rater_agreement.fleiss_kappa": lambda t: fleiss_kappa(units(t)),
    "rater_agreement.krippendorff_alpha": lambda t: [
        krippendorff_alpha(units(t), level) for level in ("nominal", "ordinal", "interval")
    ],
    "ratings.majorities": lambda t: ratings.majorities(t.agrees, t.pair),
    "rating_sample.half_widths": lambda t: half_widths(*rated_plans(t)[:2], rng(), studies=50),
    "rating_shares.table_2": lambda t: table_2(judgments(t), seed=0, draws=DRAWS),
    "plan_results.calibration_error": lambda t: [
        (found, calibration_error(found)) for found in [bins(predictions(t), seed=0, draws=DRAWS)]
    ],
    "judge_validity.cohens_kappa": lambda t: np.nan_to_num(
        cohens_kappa(np.histogram2d(t.agrees * 1.0, t.original * 1.0, bins=2)[0])
    ),
    "sdc_scores.Counts": lambda t: [
        getattr(sdc_scores.Counts(0, int(t.agrees.sum()), len(t.rating)), name)
        for name in ("precision", "recall", "f")
    ],
}  # fmt: skip
"""Estimators by module and name, and how each takes a table."""
ELSEWHERE = {
    "estimates.beside": "the paper's figures",
    "ratings.judged_by": "words",
    "estimates.confusion": "counts",
    "estimates.figures": "NaN by definition; tests/eval/statistics/test_estimates.py",
    "estimates.ratio": "NaN by definition",
    "formats.estimate_of": "reads a record",
    "held_out_predictions.learning_curve": "needs a corpus",
    "judge_validity.judge_validity": "needs a corpus",
    "judge_validity.known_validity": "needs a corpus",
    "intervals.fitted": "runs the models above",
    "plan_report.table": "rows of plan_rows",
    "whole_study.by_judge": "rows of plan_rows",
    "plan_results.read_all_plans": "reads files",
    "plan_results.read_plans": "reads files",
    "plan_rows.rows": "read by plan_rows.estimates_of",
    "rating_set.finish": "needs a study",
    "ratings.agrees": "a judgment's answer",
    "ratings.check_judgments": "refuses judgments",
    "ratings.codes": "numbers",
    "ratings.of_study": "some judgments",
    "ratings.ratings_of": "judgments as arrays",
    "ratings.repeated": "a count",
    "ratings.shown_pair": "a key",
    "report_contents.gather": "needs a corpus",
    "estimates.resampled_sums": "sums",
    "sdc_scores.compare": "counts, see sdc_scores.Counts",
    "whole_study.by_people": "needs a study",
    "whole_study.compare_judge": "needs a study",
    "whole_study.compare_people": "needs a study",
    "sdc_scores.run": "needs a corpus",
    "whole_study.go_on": "needs a study",
}
"""Functions that return estimates, or stand beside them, and why no table is tried on them."""


@cache
def estimators():
    """Functions of `eval` that return estimates, or what holds some, and all of its statistics."""
    names = [
        m.name for m in pkgutil.walk_packages(package.__path__, "eval.") if ".cli" not in m.name
    ]
    modules = [*map(importlib.import_module, names), rater_agreement]
    holders, annotations = {"Estimate", "EstimateArray", "CurvePoint"}, {}
    for module in modules:
        for name, found in vars(module).items():
            if inspect.isclass(found) and found.__module__ == module.__name__:
                annotations[name] = " ".join(
                    map(str, vars(found).get("__annotations__", {}).values())
                )
    while new := {n for n, a in annotations.items() if mentions(a, holders)} - holders:
        holders |= new
    return {
        f"{module.__name__.rpartition('.')[2]}.{name}"
        for module in modules
        for name, found in vars(module).items()
        if inspect.isfunction(found)
        and found.__module__ == module.__name__
        and not name.startswith("_")
        and (
            module.__name__.startswith("eval.statistics.")
            or mentions(str(found.__annotations__.get("return", "")), holders)
        )
    }


def mentions(annotation, names):
    return not names.isdisjoint(re.findall(r"\w+", annotation))


def test_every_estimator_is_tried():
    """A new one must be put into one of the two lists."""
    assert estimators() - TRIED.keys() - ELSEWHERE.keys() == set()
    listed = (TRIED.keys() | ELSEWHERE.keys()) - {
        "judge_validity.cohens_kappa",
        "rater_agreement.dawid_skene",
        "sdc_scores.Counts",
    }
    assert listed - estimators() == set()


def checked(found: object, reason: str = "") -> Iterator[str]:
    """What is wrong with a result: figures without a reason that aren't numbers, and bad bounds."""
    if isinstance(found, Estimate):
        yield from of_estimate(found)
    elif is_dataclass(found) and not isinstance(found, type):
        given = {field.name: getattr(found, field.name) for field in fields(found)}
        inside = next((one.reason for one in given.get("coefficients", ())), "")
        yield from checked(given, inside or reason)
    elif isinstance(found, Mapping):
        for name, value in found.items():
            why = found.get(f"{name}_reason") or found.get("reason") or reason
            yield from checked(value, str(why))
    elif isinstance(found, (list, tuple)) or getattr(found, "dtype", None) == np.object_:
        for one in found:
            yield from checked(one, reason)
    elif found is not None and not isinstance(found, str):
        numbers = np.asarray(found, dtype=np.float64)
        if not reason and not np.isfinite(numbers).all():
            yield f"not finite: {found}"


def of_estimate(found: Estimate) -> Iterator[str]:
    bounds = np.array([found.low, found.high])
    if found.reason and found.reason not in REASONS:
        yield f"no reason: {found}"
    if not found.is_known and not found.reason:
        yield f"neither figure nor reason: {found}"
    if np.isinf(found[:3]).any() or np.isnan(bounds).any() != np.isnan(bounds).all():
        yield f"not finite: {found}"
    if found.has_interval and (found.reason or not found.low <= found.value <= found.high):
        yield f"no interval: {found}"


def tried(name: str, t: Table) -> None:
    with suppress(CorpusError):  # an input that is refused by name
        assert list(checked(TRIED[name](t))) == []


@pytest.mark.parametrize("shape", DEGENERATE)
@pytest.mark.parametrize("name", sorted(TRIED))
def test_degenerate_tables_have_a_figure_or_a_reason(name, shape):
    tried(name, DEGENERATE[shape])


@pytest.mark.parametrize("name", sorted(TRIED))
def test_any_small_table_has_a_figure_or_a_reason(name):
    @settings(max_examples=10 if "crossed" in name or "cumulative" in name else 30)
    @given(drawn_tables())
    def of_table(t):
        tried(name, t)

    of_table()


def test_what_is_wrong_is_found():
    """The check itself, on results as they must not be."""
    nan, inf = float("nan"), float("inf")
    for wrong in (Estimate(nan), Estimate(1.0, 0.5, inf), Estimate(1.0, 2.0, 3.0), nan, [inf]):
        assert list(checked(wrong))
    assert list(checked({"p": nan})) == ["not finite: nan"]
    assert list(checked({"p": nan, "p_reason": "no data"})) == []
