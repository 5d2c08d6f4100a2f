"""Samples of plans for people to rate: how to draw them, and what they say of the judge."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.judging.judge_validity import cohens_kappa, confusion
from eval.plan_study.study_plans import (
    ANSWERS,
    CONFIGURATIONS,
    LOG,
    PlanRecord,
    Settings,
    script_digest,
)
from eval.statistics.estimates import (
    FEWEST_CLUSTERS,
    FloatArray,
    IntArray,
    percentiles,
    ratio,
    resampled_sums,
)
from eval.statistics.power import own_shares
from eval.statistics.ratings import codes
from g3.storage.atomic_file import write_bytes

SAMPLE = "sample.json"
WRONG, RIGHT = KINDS = ("wrong", "right")
RESERVED = 0.25
"""Share of the pairs that isn't for the first kind: without right plans nobody can show the judge's
precision, nor its kappa."""


@dataclass(frozen=True, slots=True)
class DistinctPlan:
    """A plan for a command, once however many configurations made it."""

    run: str
    """Name of its run and of its video, which doesn't show its configuration."""
    record: PlanRecord
    """The plan as the first of its configurations has it."""
    configurations: tuple[str, ...]

    @property
    def kind(self) -> str:
        """``wrong`` or ``right``, by the judge's first verdict."""
        return kind_of(self, LOG)


class Sample(msgspec.Struct, frozen=True):
    """The plans drawn."""

    seed: int
    judge: str
    """The verdict that plans were drawn by."""
    chance: dict[str, float]
    """Inclusion probability of each drawn plan, by its run."""


def kind_of(plan: DistinctPlan, verdict: str) -> str:
    """Return ``wrong`` or ``right``, by one of the judge's verdicts."""
    return RIGHT if plan.record.verdicts[verdict] else WRONG


def distinct_plans(records: Iterable[PlanRecord]) -> list[DistinctPlan]:
    """Return all plans; those with the same script for the same command are one."""
    by_run: dict[str, list[PlanRecord]] = {}
    for record in records:
        if record.script is not None:
            run = f"{record.command}-{script_digest(record.script)}".replace("/", "-")
            by_run.setdefault(run, []).append(record)
    return [
        DistinctPlan(run, same[0], tuple(sorted({r.configuration for r in same})))
        for run, same in sorted(by_run.items())
    ]


def quotas(sizes: Mapping[str, int], most: int) -> dict[str, int]:
    """Return the number of plans to draw of each kind.

    `sizes` are the numbers of plans of each kind, in order of priority; `most` is the largest
    number to draw, 0 for all.
    """
    if not most:
        return dict(sizes)
    others = sum(sizes.values()) - next(iter(sizes.values()))
    kept = min(others, max(int(RESERVED * most), int(most > 1)))
    result, left = {}, most
    for number, (kind, size) in enumerate(sizes.items()):
        result[kind] = min(size, left - (0 if number else kept))
        left -= result[kind]
    return result


def draw(plans: Sequence[DistinctPlan], kinds: Sequence[str], most: int, seed: int) -> Sample:
    """Draw plans of some kinds, balanced over scenarios and configurations.

    Of two :data:`KINDS`, the second gets only :data:`RESERVED` of the pairs while there are enough
    plans of the first. `most` is the largest number of plans, 0 for all.
    """
    rng = np.random.default_rng(seed)
    of_kind = {kind: [p for p in plans if p.kind == kind] for kind in kinds}
    chance: dict[str, float] = {}
    counts = quotas({kind: len(drawable) for kind, drawable in of_kind.items()}, most)
    for kind, count in counts.items():
        drawable = of_kind[kind]
        cells = sorted({_cell(p) for p in drawable})
        shuffled = rng.random(len(cells))
        # What is left over is spread over configurations, at random over their scenarios.
        order = sorted(range(len(cells)), key=lambda i: (cells[i][0], shuffled[i]))
        number = {cells[i]: place for place, i in enumerate(order)}
        codes = np.array([number[_cell(p)] for p in drawable], dtype=np.int64)
        drawn, chances = balanced_sample(codes, count, rng)
        chance |= {drawable[i].run: float(chances[i]) for i in drawn}
    return Sample(seed, LOG, dict(sorted(chance.items())))


def sampled(folder: Path, plans: Sequence[DistinctPlan], settings: Settings) -> Sample:
    """Return the sample of a folder, which is drawn once."""
    path = folder / SAMPLE
    if not path.exists():
        result = draw(plans, settings.plans, settings.pairs, settings.seed)
        write_bytes(path, msgspec.json.format(msgspec.json.encode(result)) + b"\n")
    return msgspec.json.decode(path.read_bytes(), type=Sample)


def _cell(plan: DistinctPlan) -> tuple[tuple[str, ...], str]:
    return plan.configurations, plan.record.scenario


def balanced_sample(
    cell: IntArray, size: int, rng: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """Draw as evenly from all cells as their sizes allow.

    Every cell gives the same number, or all that it has. The remainder is less than one item for
    each cell that has more. It is drawn from these cells systematically, which spreads it over
    their order and gives each the same chance (W. G. Cochran, Sampling Techniques, 1977, chapter
    8). Weights of one over the chance make up for the balance (D. G. Horvitz and D. J. Thompson,
    J. Am. Stat. Assoc. 47, 1952), also where a cell gives nothing.

    Cells are numbered from 0 without gaps, shape (n,); fewer items than `size` may exist. Indices
    of the items drawn ascend, and the chance is that of each item, shape (n,).
    """
    if size <= 0 or len(cell) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(len(cell))
    sizes = np.bincount(cell)
    each = max(k for k in range(sizes.max() + 1) if np.minimum(sizes, k).sum() <= size)
    taken = np.minimum(sizes, each)
    larger = np.flatnonzero(sizes > each)
    rest = min(size, len(cell)) - int(taken.sum())
    chance = taken / sizes
    if rest:
        chance[larger] += rest / len(larger) / sizes[larger]
        steps = (rng.random() + np.arange(rest)) * len(larger) / rest
        taken[larger[steps.astype(np.int64)]] += 1
    drawn = [
        rng.choice(np.flatnonzero(cell == number), int(count), replace=False)
        for number, count in enumerate(taken)
    ]
    return np.sort(np.concatenate(drawn)), chance[cell]


FIGURES = ("kappa", "precision", "recall", "precision_of_wrong", "same", "people_right")
"""Order of the last axis of :func:`figures`."""
ALL = "all"


@dataclass(frozen=True, slots=True)
class PlanAgreement:
    """The judge against the majority of people on the plans of a configuration, or on all."""

    configuration: str
    """Its name, or ``all``, where a plan of several configurations counts once."""
    plans: int
    """Number of plans, rated or not."""
    rated: int
    counts: Mapping[str, int]
    """Rated plans by the answers of people and of the judge, as ``people_yes_judge_no``."""
    figures: Mapping[str, Estimate]
    """Figures of all plans, by :data:`FIGURES`, with whole scenarios resampled. Precision: share of
    the plans accepted by the judge that people accept. Recall: share of the plans accepted by
    people that the judge accepts."""


def figures(counts: FloatArray) -> FloatArray:
    """Return figures of all plans from weighted counts of rated ones.

    The plans that the judge calls right, and those that it calls wrong, count as many as there
    are. The rated ones only show how people divide them.

    `counts` have shape (..., 3, 2). The last axis is the judge's verdict, wrong or right; the rows
    are the weights of plans that people call wrong, of those that they call right, and the number
    of plans. Figures have shape (..., 6), in the order of :data:`FIGURES`; NaN where the rated
    plans don't determine them.
    """
    rated, there = counts[..., :2, :], counts[..., 2, :]
    shares = ratio(rated, rated.sum(axis=-2, keepdims=True))
    table = np.where(there[..., None, :] > 0, shares * there[..., None, :], 0.0)
    (no_no, no_yes), (yes_no, yes_yes) = (
        (table[..., row, 0], table[..., row, 1]) for row in (0, 1)
    )
    total = there.sum(axis=-1)
    return np.stack(
        [
            cohens_kappa(table),
            ratio(yes_yes, no_yes + yes_yes),
            ratio(yes_yes, yes_no + yes_yes),
            ratio(no_no, no_no + yes_no),
            ratio(no_no + yes_yes, total),
            ratio(yes_no + yes_yes, total),
        ],
        axis=-1,
    )


def agreements(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    people: Mapping[str, bool],
    verdict: str,
    *,
    seed: int,
    draws: int,
) -> list[PlanAgreement]:
    """Return a row for all plans, and one for each configuration.

    `plans` are all, rated or not; `people` has the majority verdict on each rated plan, by its run;
    `verdict` is the judge's verdict to compare.
    """
    rows = []
    for name in (ALL, *CONFIGURATIONS):
        configured = [p for p in plans if name in (ALL, *p.configurations)]
        if not configured:
            continue
        scenario = codes([p.record.scenario for p in configured])
        counts = np.zeros((scenario.max() + 1, 3, 2))
        verdicts = [int(kind_of(p, verdict) == RIGHT) for p in configured]
        rated = []
        for plan, place, judge in zip(configured, scenario, verdicts, strict=True):
            counts[place, 2, judge] += 1
            if plan.run in people:
                yes = people[plan.run]
                counts[place, int(yes), judge] += 1 / sample.chance[plan.run]
                rated.append((yes, bool(judge)))
        raw = confusion([yes for yes, _ in rated], [judge for _, judge in rated])
        values = figures(counts.sum(axis=0))
        # The same seed for each row, so that all are of the same scenarios.
        rng = np.random.default_rng(seed)
        drawn = figures(resampled_sums(counts, rng=rng, draws=draws))
        bounded = {
            figure: percentiles(float(values[i]), drawn[:, i], len(counts), _missing(figure, raw))
            for i, figure in enumerate(FIGURES)
        }
        rows.append(PlanAgreement(name, len(configured), len(rated), raw, bounded))
    return rows


def _missing(figure: str, rated: Mapping[str, int]) -> Reason:
    if not sum(rated.values()):
        return "no data"
    return "all alike" if figure == "kappa" else "empty class"


def tells_of_all(plans: Sequence[DistinctPlan], sample: Sample) -> bool:
    """Check that every kind was drawn, which verdicts after the first need."""
    return {p.kind for p in plans} == {p.kind for p in plans if p.run in sample.chance}


ASSUMED = {WRONG: 0.15, RIGHT: 0.85}
"""Share of the plans that most people call right, by the judge's verdict.

Of the AAAI-11 corpus's pairs it is .04 and .89 (`ct eval judge-validity`), but plans are nearer
misses than videos of other scenarios.
"""
CORRELATION = 0.1
"""Correlation between plans of a scenario; .11 between the pairs of a video there that the judge
refuses."""
ANSWER_S = 10.0
"""Time to read the command and to answer, in seconds, without the video."""
STUDIES = 2000


@dataclass(frozen=True, slots=True)
class Planned:
    """A rating set as planned."""

    plans: Mapping[str, int]
    """Number of plans by the judge's verdict, each once."""
    without: int
    """Number of commands in a configuration without a plan."""
    stopped: int
    """Number of drawn plans that physics stopped; nobody rates them."""
    pairs: Mapping[str, int]
    """Number of rated plans, by the judge's verdict."""
    configurations: Mapping[str, Mapping[str, int]]
    """Number of rated plans by configuration and verdict; a plan of two counts in both."""
    scenarios: int
    raters: int
    seconds_each: float
    """Mean duration of a pair, in seconds."""
    minutes: float
    """Duration of all pairs for one person, in minutes."""
    half_widths: Mapping[str, float]
    """Expected half widths of the figures' 95 % intervals; NaN where there will be none."""
    unknown: Mapping[str, Reason]
    """Reasons for missing half widths, by figure."""

    @property
    def total(self) -> int:
        """Number of pairs."""
        return sum(self.pairs.values())


def planned(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    seconds: Sequence[float],
    *,
    without: int,
    stopped: int,
    seed: int,
) -> Planned:
    """Plan a sample, with the numbers of commands without a plan and of plans physics stopped."""
    chosen = [p for p in plans if p.run in sample.chance]
    whole = float(sum(seconds)) + ANSWER_S * len(chosen)
    widths = half_widths(plans, sample, np.random.default_rng(seed))
    return Planned(
        _by_kind(plans),
        without,
        stopped,
        _by_kind(chosen),
        {c: _by_kind([p for p in chosen if c in p.configurations]) for c in CONFIGURATIONS},
        len({p.record.scenario for p in chosen}),
        ANSWERS,
        whole / max(len(chosen), 1),
        whole / 60,
        {name: width.value for name, width in widths.items()},
        {name: width.reason for name, width in widths.items() if width.reason},
    )


def half_widths(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    rng: np.random.Generator,
    *,
    shares: Mapping[str, float] = ASSUMED,
    correlation: float = CORRELATION,
    studies: int = STUDIES,
) -> dict[str, Estimate]:
    """Half widths that the figures' 95 % intervals have in simulated studies, without intervals.

    As :func:`eval.statistics.power.simulated_half_width` does for a share. Each scenario's own
    shares are drawn from beta distributions with the given correlation, the majority of each
    pair from those. The half width is that of the middle of the studies' figures.

    `shares` are the part of the plans that most people call right, by the judge's verdict; the
    correlation is between plans of a scenario, of the same verdict.
    """
    chosen = [p for p in plans if p.run in sample.chance]
    if not chosen:
        return dict.fromkeys(FIGURES, undefined("no data"))
    kinds = np.array([KINDS.index(p.kind) for p in chosen])
    place = codes([p.record.scenario for p in chosen])
    weight = 1 / np.array([sample.chance[p.run] for p in chosen])
    share = np.array([shares[kind] for kind in KINDS])
    own = own_shares(share, correlation, (studies, int(place.max()) + 1, len(KINDS)), rng)
    people = rng.random((studies, len(chosen))) < own[:, place, kinds]
    of_kind = weight[:, None] * (kinds[:, None] == np.arange(len(KINDS)))
    yes = people @ of_kind
    there = [_by_kind(plans)[kind] for kind in KINDS]
    counts = np.stack([of_kind.sum(axis=0) - yes, yes, np.broadcast_to(there, yes.shape)], axis=-2)
    return {
        name: _half_width(drawn) for name, drawn in zip(FIGURES, figures(counts).T, strict=True)
    }


def _half_width(drawn: FloatArray) -> Estimate:
    defined = drawn[np.isfinite(drawn)]
    middle = float(np.median(defined)) if len(defined) else np.nan
    result = percentiles(middle, drawn, FEWEST_CLUSTERS)
    return result._replace(value=(result.high - result.low) / 2, low=np.nan, high=np.nan)


def _by_kind(plans: Sequence[DistinctPlan]) -> dict[str, int]:
    return {kind: sum(p.kind == kind for p in plans) for kind in KINDS}
