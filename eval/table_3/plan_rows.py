"""The rows of Table 3: configurations and baselines on parts of the commands."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from corpus_tools.corpus.estimate import Estimate
from eval.statistics.comparison import Comparison
from eval.statistics.estimates import FloatArray
from eval.statistics.intervals import bootstrap, two_way
from eval.statistics.ratings import codes
from eval.table_3.baselines import BASELINES
from eval.table_3.judged_commands import SUBSETS, Facts, Subset
from eval.table_3.outcomes import Outcome
from eval.tables.comparison_report import compare_commands
from g3.errors import CorpusError
from g3.short_repr import short_repr

TOP = 30
"""Number of commands in the paper's top rows."""
MODELS = ("gold", "auto")
PAPERS_OWN = "paper"
"""The paper's own model: correspondence factors and the beam, without rules of ours."""
ALONE = ("random", *BASELINES)
"""Rows of every table, as baselines of a model."""
ROWS: tuple[tuple[str, str, int], ...] = (
    ("gold-top30", "gold", TOP),
    ("auto-top30", "auto", TOP),
    ("gold-all", "gold", 0),
    ("auto-all", "auto", 0),
)
"""Rows of models: name, configuration, and number of the most probable plans; 0 for all."""


def check_names(others: Sequence[str]) -> None:
    """Refuse names of further rows that other rows have."""
    taken = {*ALONE, PAPERS_OWN, *MODELS, *(name for name, *_ in ROWS)}
    for name in others:
        if name in taken:
            raise CorpusError(
                f"two rows of Table 3 are called {name}", fix="give each another name, each once"
            )
        taken.add(name)


Row: TypeAlias = dict[str, Any]


@short_repr
@dataclass(frozen=True, slots=True)
class Followed:
    """A command in a configuration, with shares over the headings followed.

    Its verdicts are by the names of `VERDICTS`, and NaN where one can't be given.
    """

    command: str
    scenario: str
    probability: float
    verdicts: Mapping[str, float]
    refused: float


VERDICTS: Mapping[str, Callable[[Outcome], float]] = {
    "precision": lambda o: float(o.correct),
    "by_words": lambda o: float("nan") if o.by_words is None else float(o.by_words),
    "theme": lambda o: float("nan") if o.theme is None else float(o.theme),
}
"""Verdicts on a plan. Each has columns for its share and for its two intervals."""
COMPARED = ("precision", "theme")
"""Verdicts by which configurations are compared."""
WHOLE = "precision"
PARTS = ("low", "high", "reason", "two_way_low", "two_way_high", "two_way_reason")
"""Further columns of a verdict, after its share."""


def columns(verdict: str) -> dict[str, str]:
    """Return the names of a verdict's columns, by their content."""
    own = "" if verdict == WHOLE else f"{verdict}_"
    return {"value": verdict, **{part: f"{own}{part}" for part in PARTS}}


def estimates_of(row: Mapping[str, Any], verdict: str) -> tuple[Estimate, Estimate]:
    """Return a row's share by a verdict: by worlds, and by other worlds and people."""
    value, *parts = (row[name] for name in columns(verdict).values())
    return Estimate(value, *parts[:3]), Estimate(value, *parts[3:])


COLUMNS = (
    "configuration",
    "perturbed",
    "subset",
    "judge",
    "n",
    *(name for verdict in VERDICTS for name in columns(verdict).values()),
    "chance",
    "refusals",
    "note",
)
"""Columns of a row, in the order of the CSV."""


def followed(outcomes: Sequence[Outcome]) -> list[Followed]:
    """Merge a command's outcomes in several headings, in the order of the commands."""
    by_command: dict[str, list[Outcome]] = defaultdict(list)
    for o in outcomes:
        by_command[o.command].append(o)
    return [
        Followed(
            name,
            own[0].scenario,
            float(np.mean([o.probability for o in own])),
            {
                verdict: float(np.mean([judge(o) for o in own]))
                for verdict, judge in VERDICTS.items()
            },
            float(np.mean([o.refused for o in own])),
        )
        for name, own in by_command.items()
    ]


def rows(
    outcomes: Mapping[str, Sequence[Outcome]],
    facts: Mapping[str, Facts],
    missing: Mapping[str, str],
    *,
    draws: int,
    seed: int,
    judge: str = "automatic",
) -> list[Row]:
    """Return a row for each configuration and part of the commands.

    Missing ones, which can't be run, have a row with the reason instead of figures.
    """
    by_configuration = {name: followed(own) for name, own in outcomes.items()}
    others = [n for n in {**outcomes, **missing} if n not in (*ALONE, *MODELS)]
    named = [*((name, name, 0) for name in (*ALONE, *others)), *ROWS]
    result = []
    for subset in SUBSETS:
        for name, of, top in named:
            if of not in by_configuration and of not in missing:
                continue
            own = [
                f
                for f in by_configuration.get(of, ())
                if facts.get(f.command, Facts()).is_in(subset)
            ]
            if top:
                own = sorted(own, key=lambda f: (-f.probability, f.command))[:top]
            row = _row(own, facts, draws=draws, seed=seed)
            about = {"configuration": name, "subset": subset, "judge": judge, "perturbed": ""}
            result.append({**about, **row, "note": missing.get(of, "")})
    return result


def _row(own: Sequence[Followed], facts: Mapping[str, Facts], *, draws: int, seed: int) -> Row:
    own_facts = [facts.get(f.command, Facts()) for f in own]
    row: Row = {"n": len(own)}
    for verdict in VERDICTS:
        judged = [i for i, f in enumerate(own) if not np.isnan(f.verdicts[verdict])]
        values = np.array([own[i].verdicts[verdict] for i in judged])
        worlds = [own[i].scenario for i in judged]
        people = [own_facts[i].person for i in judged]
        share, crossed = _intervals(values, worlds, people, draws=draws, seed=seed)
        estimates = (*share[:4], *crossed[1:4])
        row |= dict(zip(columns(verdict).values(), estimates, strict=True))
    chances = [k.chance for k in own_facts if not np.isnan(k.chance)]
    row["chance"] = float(np.mean(chances)) if chances else float("nan")
    refusals = float(sum(f.refused for f in own))
    row["refusals"] = round(refusals) if refusals.is_integer() else refusals
    return row


def _intervals(
    values: FloatArray, worlds: Sequence[str], people: Sequence[str], *, draws: int, seed: int
) -> tuple[Estimate, Estimate]:
    """Return the share by worlds, and by other worlds and people, if people are known."""
    rng = np.random.default_rng(seed)
    share = bootstrap(values, codes(worlds), rng=rng, draws=draws)
    if not all(people):
        return share, Estimate(share.value, reason=share.reason or "unknown people")
    return share, two_way(values, codes(worlds), codes(people))


@short_repr
@dataclass(frozen=True, slots=True)
class Compared:
    """Comparisons of one verdict on one part of the commands."""

    subset: Subset
    verdict: str
    comparisons: Sequence[Comparison]


def comparisons(
    outcomes: Mapping[str, Sequence[Outcome]],
    facts: Mapping[str, Facts],
    *,
    draws: int,
    seed: int,
) -> list[Compared]:
    """Compare all but the baselines with these and each other, on the commands of each part.

    Parts that are the same as another are left out. Holm's correction is for the comparisons of a
    part and verdict.
    """
    by_configuration = {name: followed(own) for name, own in outcomes.items()}
    scenarios = {f.command: f.scenario for own in by_configuration.values() for f in own}
    result = []
    seen: set[tuple[str, ...]] = set()
    for subset in SUBSETS:
        within = {name for name in scenarios if facts.get(name, Facts()).is_in(subset)}
        key = tuple(sorted(within))
        if not within or key in seen:
            continue
        seen.add(key)
        for verdict in COMPARED:
            shares = {
                name: {f.command: f.verdicts[verdict] for f in own if f.command in within}
                for name, own in by_configuration.items()
            }
            models = [name for name in shares if name not in ALONE]
            compared = compare_commands(
                {name: own for name, own in shares.items() if own},
                scenarios,
                seed=seed,
                draws=draws,
                including=models,
            )
            if compared and models:
                result.append(Compared(subset, verdict, compared))
    return result
