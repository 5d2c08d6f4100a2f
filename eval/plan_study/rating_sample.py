"""Samples of plans for people to rate, to check the automatic judge."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from eval.plan_study.study_plans import FIRST, PlanRecord
from eval.plan_study.study_settings import Settings
from eval.statistics.estimates import FloatArray, IntArray
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
        return kind_of(self, FIRST)


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
            run = f"{record.command}-{record.script.digest}".replace("/", "-")
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
    found, left = {}, most
    for number, (kind, size) in enumerate(sizes.items()):
        found[kind] = min(size, left - (0 if number else kept))
        left -= found[kind]
    return found


def draw(plans: Sequence[DistinctPlan], kinds: Sequence[str], most: int, seed: int) -> Sample:
    """Draw plans of some kinds, balanced over scenarios and configurations.

    Of two :data:`KINDS`, the second gets only :data:`RESERVED` of the pairs while there are enough
    plans of the first. `most` is the largest number of plans, 0 for all.
    """
    rng = np.random.default_rng(seed)
    of_kind = {kind: [p for p in plans if p.kind == kind] for kind in kinds}
    chance: dict[str, float] = {}
    counts = quotas({kind: len(own) for kind, own in of_kind.items()}, most)
    for kind, count in counts.items():
        own = of_kind[kind]
        cells = sorted({_cell(p) for p in own})
        shuffled = rng.random(len(cells))
        # What is left over is spread over configurations, at random over their scenarios.
        order = sorted(range(len(cells)), key=lambda i: (cells[i][0], shuffled[i]))
        number = {cells[i]: place for place, i in enumerate(order)}
        codes = np.array([number[_cell(p)] for p in own], dtype=np.int64)
        drawn, chances = balanced_sample(codes, count, rng)
        chance |= {own[i].run: float(chances[i]) for i in drawn}
    return Sample(seed, FIRST, dict(sorted(chance.items())))


def sampled(folder: Path, plans: Sequence[DistinctPlan], settings: Settings) -> Sample:
    """Return the sample of a folder, which is drawn once."""
    path = folder / SAMPLE
    if not path.exists():
        found = draw(plans, settings.plans, settings.pairs, settings.seed)
        write_bytes(path, msgspec.json.format(msgspec.json.encode(found)) + b"\n")
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
