"""Table 3 from people's ratings of a study; the automatic judge's rows stand apart."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate
from eval.plan_study.study_pairs import Pair
from eval.plan_study.study_plans import CONFIGURATIONS, PlanRecord, top
from eval.statistics.comparison import Comparison
from eval.statistics.intervals import bootstrap, two_way
from eval.statistics.raters import majorities
from eval.statistics.ratings import agrees, codes, shown_pair
from eval.table_3.baselines import BASELINES, missing
from eval.table_3.outcomes import JudgedRow, judged_row
from eval.table_3.plan_rows import MODELS
from eval.tables.comparison_report import compare_commands
from g3.annotation import Judgment
from g3.errors import FormatError

ROWS = {
    "random": ("random", False),
    "gold-top30": ("gold", True),
    "auto-top30": ("auto", True),
    "gold-all": ("gold", False),
}
"""The rows of Table 3: each one's configuration, and whether only the most probable plans count."""
KNOWN = ("right", "wrong")


@dataclass(frozen=True, slots=True)
class RatedRow:
    """People's ratings of a configuration."""

    configuration: str
    share: Estimate
    """Judgments that agree, with whole scenarios resampled."""
    two_way: Estimate
    """Share for other scenarios and other raters."""
    majority: float
    """Share of the pairs on which more than half of the judgments agree."""
    judgments: int
    rated: int
    """Numbers of judgments, and of the pairs that they rate."""
    n: int
    """Number of pairs to rate."""


def by_people(
    pairs: Sequence[Pair],
    records: list[PlanRecord],
    judgments: Sequence[Judgment],
    *,
    seed: int,
    draws: int,
) -> list[RatedRow]:
    """Return the rows of people's ratings so far; unrated ones are left out."""
    check_ratings(pairs, judgments)
    scenarios = _scenarios(records)
    rows = []
    for name in (*ROWS, *KNOWN):
        which, only_top = ROWS.get(name, (name, False))
        best = {r.command for r in top(records, which)} if only_top else None
        own = [p for p in pairs if p.configuration == which and (best is None or p.command in best)]
        row = _rated(name, own, scenarios, judgments, rng=np.random.default_rng(seed), draws=draws)
        if row is not None:
            rows.append(row)
    return rows


def check_ratings(pairs: Sequence[Pair], judgments: Sequence[Judgment]) -> None:
    """Refuse ratings of other studies, and second ones by the same person, naming the row."""
    known = {p.key for p in pairs}
    seen: Counter[tuple[str, ...]] = Counter()
    for row, j in enumerate(judgments, start=1):
        key = shown_pair(j)
        where = f"judgments.jsonl: line {row}"
        if key not in known:
            raise FormatError(
                f"the study has no pair of {j.command!r} and the video {j.shown_video!r}",
                where=where,
                fix="give the ratings of this study",
            )
        mine = (*key, j.subject)
        seen[mine] += 1
        if j.subject and seen[mine] > 1:
            raise FormatError(
                "the same person has rated this pair before", where=where, fix="remove one"
            )


def by_judge(records: list[PlanRecord], *, seed: int, draws: int) -> list[JudgedRow]:
    """Return the same rows by the automatic judge, and those of baselines."""
    rows: list[JudgedRow] = []
    there = {r.configuration for r in records} | missing().keys()
    baselines = {name: (name, False) for name in BASELINES if name in there}
    for name, (which, only_top) in {**ROWS, **baselines}.items():
        own = top(records, which) if only_top else [r for r in records if r.configuration == which]
        correct, scenarios = [r.correct for r in own], [r.scenario for r in own]
        by_words = [r.by_words for r in own]
        rows.append(judged_row(name, correct, scenarios, by_words=by_words, draws=draws, seed=seed))
    return rows


def compare_people(
    pairs: Sequence[Pair],
    records: list[PlanRecord],
    judgments: Sequence[Judgment],
    *,
    seed: int,
    draws: int,
) -> list[Comparison]:
    """Compare configurations by people's ratings, on the commands rated in both."""
    of_pair = {p.key: p for p in pairs if p.is_plan}
    said: dict[str, dict[str, list[bool]]] = {name: {} for name in CONFIGURATIONS}
    for j in judgments:
        pair = of_pair.get(shown_pair(j))
        if pair is not None:
            said[pair.configuration].setdefault(pair.command, []).append(agrees(j))
    shares = {
        name: {command: float(np.mean(told)) for command, told in own.items()}
        for name, own in said.items()
    }
    return compare_commands(shares, _scenarios(records), seed=seed, draws=draws)


def compare_judge(records: list[PlanRecord], *, seed: int, draws: int) -> list[Comparison]:
    """Compare each model with each other configuration by the automatic judge."""
    shares = {
        name: {r.command: float(r.correct) for r in records if r.configuration == name}
        for name in (*CONFIGURATIONS, *BASELINES)
    }
    scenarios = _scenarios(records)
    return compare_commands(shares, scenarios, seed=seed, draws=draws, including=MODELS)


def _scenarios(records: list[PlanRecord]) -> dict[str, str]:
    return {r.command: r.scenario for r in records}


def _rated(
    name: str,
    pairs: Sequence[Pair],
    scenarios: Mapping[str, str],
    judgments: Sequence[Judgment],
    *,
    rng: np.random.Generator,
    draws: int,
) -> RatedRow | None:
    wanted = {p.key: p for p in pairs}
    mine = [(wanted[key], j) for j in judgments if (key := shown_pair(j)) in wanted]
    if not mine:
        return None
    said = np.array([agrees(j) for _, j in mine])
    pair = codes([(p.command, p.video) for p, _ in mine])
    place = codes([scenarios[p.command] for p, _ in mine])
    rater = codes([j.subject for _, j in mine])
    return RatedRow(
        name,
        bootstrap(said, place, rng=rng, draws=draws),
        two_way(said, place, rater),
        float(majorities(said, pair).mean()),
        len(mine),
        len(np.unique(pair)),
        len(pairs),
    )
