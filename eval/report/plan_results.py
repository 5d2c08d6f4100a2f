"""Table 3 as ``ct eval`` has written it: by the automatic judge, and of a study by people too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.judging.judge_registry import AUTOMATIC
from eval.statistics.estimates import FEWEST_CLUSTERS
from eval.statistics.intervals import bootstrap, wilson
from eval.statistics.ratings import codes
from eval.table_1.correspondence import Predictions
from eval.table_3 import outcomes
from eval.table_3.plan_report import TITLES
from eval.table_3.plan_rows import ALONE
from g3.errors import FormatError
from g3.storage import regular_file

BINS = 10


@dataclass(frozen=True, slots=True)
class Bin:
    """Examples with about the same stated probability."""

    stated: float
    """Their mean probability."""
    true: float
    """Share of them that is correct."""
    low: float
    high: float
    """Bounds of its 95% interval with whole commands resampled; NaN where there is a reason."""
    n: int
    reason: Reason = ""


def bins(predictions: Predictions, *, seed: int, draws: int) -> tuple[Bin, ...]:
    """Return the reliability diagram of predicted correspondences, in bins of equal width."""
    rng = np.random.default_rng(seed)
    place = np.minimum((predictions.probability * BINS).astype(int), BINS - 1)
    result = []
    for i in np.unique(place):
        in_bin = place == i
        commands = codes(predictions.command[in_bin].tolist())
        share = bootstrap(predictions.label[in_bin], commands, rng=rng, draws=draws)
        stated = float(predictions.probability[in_bin].mean())
        result.append(Bin(stated, *share[:3], int(in_bin.sum()), share.reason))
    return tuple(result)


def calibration_error(bins: Sequence[Bin]) -> Estimate:
    """Return the expected calibration error: the mean gap of stated and observed.

    It has no interval.
    """
    n = sum(b.n for b in bins)
    if not n:
        return undefined("no data")
    return Estimate(sum(b.n * abs(b.stated - b.true) for b in bins) / n)


WHOLE = "all"
"""Name of the whole of the commands, in tables without parts."""
MADE_BY = "make one with `ct eval table3 --json --out FILE`, or `end-to-end` without --plans"


class PlanRow(msgspec.Struct, frozen=True):
    """A row of a configuration, or of a baseline, on a part of the commands."""

    configuration: str
    precision: float | None
    low: float | None
    high: float | None
    n: int
    reason: str = ""
    judge: str = "automatic"
    by_words: float | None = None
    by_words_low: float | None = None
    by_words_high: float | None = None
    by_words_reason: str = ""
    subset: str = WHOLE
    theme: float | None = None
    theme_low: float | None = None
    theme_high: float | None = None
    theme_reason: str = ""
    chance: float | None = None
    refusals: float | None = None
    note: str = ""


class JudgedPlan(msgspec.Struct, frozen=True):
    """The automatic judge's verdict on a plan for a command."""

    command: str
    probability: float
    correct: int
    reason: str
    text: str = ""
    run: str = ""


class Compared(msgspec.Struct, frozen=True):
    """Two configurations on the commands that both have."""

    one: str
    other: str
    n: int
    difference: float
    low: float | None
    high: float | None
    p: float
    adjusted_p: float
    effect: float
    reason: str = ""
    subset: str = WHOLE
    verdict: str = "precision"


class AutomaticRows(msgspec.Struct, frozen=True):
    """The rows of a study by the automatic judge."""

    rows: list[PlanRow]
    comparisons: list[Compared] = []
    judge_validity: dict[str, Any] | None = None


class PlanFile(msgspec.Struct, frozen=True):
    """The file of ``table3``, with rows, or of ``end-to-end``, with rows by people and judge.

    All other entries are provenance.
    """

    train: list[str] = []
    test: str = ""
    test_scenarios: list[str] = []
    is_authored: bool = False
    rows: list[PlanRow] = []
    automatic: AutomaticRows | None = None
    people: list[PlanRow] | None = None
    comparisons: list[Compared] = []
    people_compared: list[Compared] = []
    study: str = ""
    judge_validity: dict[str, Any] | None = None
    commands: dict[str, list[JudgedPlan]] = {}
    reliability: list[outcomes.Bin] = []
    expected_calibration_error: float | None = None
    object_grounding_top1: float | None = None


SHOWN = {*PlanFile.__struct_fields__} - {"train", "test", "test_scenarios"}
"""Entries of the file that a report shows; the rest is provenance."""


@dataclass(frozen=True, slots=True)
class Plans:
    """Table 3, its plans, and how they were made."""

    name: str
    """Name of the file, without its folder and suffix."""
    file: PlanFile
    """Content of the file; its rows, comparisons and validity are those of the automatic judge."""
    reliability: Sequence[Bin]
    """Reliability of the plans' probabilities; the intervals assume independent plans."""
    document: Mapping[str, Any]
    """The whole file."""

    @property
    def is_new(self) -> bool:
        """True if the tested corpus is none of the training corpora."""
        return bool(self.file.train) and self.file.test not in self.file.train

    @property
    def provenance(self) -> dict[str, Any]:
        """Entries of the file that a report doesn't show."""
        return {key: value for key, value in self.document.items() if key not in SHOWN}

    @property
    def has_paper(self) -> bool:
        """True if the tested corpus is like the paper's: typed by people, with clauses."""
        return not self.file.is_authored and any(
            row.configuration.startswith("gold")
            for row in (*self.file.rows, *(self.file.people or ()))
        )

    def part(self, subset: str) -> list[PlanRow]:
        """Return the judge's rows of a part of the commands."""
        return [row for row in self.file.rows if row.subset == subset]

    def parts(self) -> dict[str, list[PlanRow]]:
        """Return the judge's rows by part; a part equal to the whole is left out."""
        sizes = {subset: max((r.n for r in self.part(subset)), default=0) for subset in TITLES}
        return {
            subset: self.part(subset)
            for subset in TITLES
            if subset == WHOLE or 0 < sizes[subset] < sizes[WHOLE]
        }

    def compared_on(self, subset: str) -> list[Compared]:
        """Return the judge's comparisons on a part of the commands."""
        return [c for c in self.file.comparisons if c.subset == subset]

    def wrong(self) -> list[JudgedPlan]:
        """Return the wrong plans, the most probable first.

        They are of annotated clauses, or of extracted ones where there are no annotations.
        """
        plans = self.file.commands.get("gold") or self.file.commands.get("auto", [])
        result = [plan for plan in plans if not plan.correct]
        return sorted(result, key=lambda plan: (-plan.probability, plan.command))


def read_all_plans(paths: Sequence[Path], corpus_hash: str) -> list[Plans]:
    """Read Table 3 of several corpora, those without training commands first."""
    names = [path.stem for path in paths]
    if len({*names}) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise FormatError(f"two files of plans are called {twice}", fix="give one another name")
    result = [read_plans(path) for path in paths]
    return sorted(result, key=lambda plans: (not plans.is_new, plans.file.test == corpus_hash))


def read_plans(path: Path) -> Plans:
    """Read the output of ``ct eval table3 --format json``.

    A FormatError means that the file can't be read or holds something else, has no baselines, or is
    by another judge than the automatic one.
    """
    try:
        text = regular_file.read_bytes(path)
        document = msgspec.json.decode(text, type=dict[str, Any])
        if "planned" in document:
            raise ValueError("it is the result of a rating set")
        result = msgspec.json.decode(text, type=PlanFile)
    except OSError as error:
        raise FormatError(f"it can't be read: {error.strerror}", where=str(path)) from error
    except (msgspec.MsgspecError, ValueError) as error:
        raise FormatError(f"this is no Table 3: {error}", where=str(path), fix=MADE_BY) from error
    if result.automatic:
        result = msgspec.structs.replace(result, **msgspec.structs.asdict(result.automatic))
    if not result.rows:
        raise FormatError("this is no Table 3: it has no rows", where=str(path), fix=MADE_BY)
    again = partial(FormatError, where=str(path), fix=f"run it again: {MADE_BY}")
    lacking = [name for name in ALONE if name not in {row.configuration for row in result.rows}]
    if lacking:
        raise again(
            f"this Table 3 has no rows of {', '.join(lacking)}, and a report shows no model "
            "without what it has to beat"
        )
    judges = {row.judge for row in result.rows} - {AUTOMATIC}
    if judges:
        raise again(
            f"this Table 3 is by the judge {min(judges)}, and a report shows the automatic judge's"
        )
    bins = [_with_interval(b) for b in result.reliability]
    return Plans(path.stem, result, bins, document)


def _with_interval(plans: outcomes.Bin) -> Bin:
    """Return a bin with Wilson's interval; without one, where there are too few plans."""
    stated, correct, n = plans["stated"], plans["correct"], plans["n"]
    share = wilson(round(correct * n), n)
    if n < FEWEST_CLUSTERS:
        share = Estimate(share.value, reason="few clusters")
    return Bin(stated, correct, share.low, share.high, n, share.reason)
