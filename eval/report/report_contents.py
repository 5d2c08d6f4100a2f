"""Everything that a report shows, measured in one go."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from corpus_tools import __version__
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_validity import Validity, known_validity
from eval.report.gallery import Failed, Shown, examples, failures
from eval.report.plan_results import Plans, read_all_plans
from eval.report.reliability import Bin, bins
from eval.table_1 import held_out_predictions
from eval.table_1.correspondence import Row, table_rows
from eval.table_1.divided_examples import Choices
from eval.table_1.error_lists import ErrorList, error_lists
from eval.table_1.learning_curve import CurvePoint
from eval.table_2.rating_shares import Results, table_2
from g3.features.feature_registry import CATALOGUE_VERSION

STUDY_DRAWS = 10_000
EXAMPLES = 4
LIBRARIES = ("matplotlib", "numpy", "scipy")


@dataclass(frozen=True, slots=True)
class ReportChoices:
    """Inputs and settings of a report."""

    corpus: str
    """The corpus, measured with each scenario held out in turn."""
    plans: Sequence[Path] = ()
    """Files of ``ct eval --table 3 --format json``, one for each tested corpus."""
    videos: Path | None = None
    """Folder of ``ct render-videos`` for the corpus; None to show none."""
    study: str = ""
    """Name of the rating study for Table 2; the largest if empty."""
    negatives: str = "random"
    l2: float | None = None
    threshold: float = 0.5
    seed: int = 0
    draws: int = 2000
    top: int = 5
    """Phrases in each list of errors."""
    repeats: int = 5
    """Random orders of the commands for the learning curve; 0 for none."""


@dataclass(frozen=True, slots=True)
class Contents:
    """Contents of a report; results that weren't measured are None or empty."""

    table_1: Sequence[Row]
    metadata: dict[str, object]
    """Rows of Table 1, and their metadata."""
    reliability: Sequence[Bin]
    curve: Sequence[CurvePoint]
    repeats: int
    """The learning curve's points, and the number of random orders behind them."""
    errors: Sequence[ErrorList]
    """The lists of section 4.2."""
    table_2: Results | None
    validity: Validity | None
    plans: Sequence[Plans]
    shown: Sequence[Shown]
    failures: Sequence[Failed]
    """Ratings by people, the judge against them, Table 3 of each tested corpus with new worlds
    first, example videos, and wrong plans'."""
    provenance: dict[str, object]
    """Corpora, settings and versions behind the report."""
    commands: Sequence[str]
    """Commands that reproduce the figures."""


def gather(choices: ReportChoices, on_progress: OnProgress = no_progress) -> Contents:
    """Measure a report's contents; a CorpusError if corpus, plans or videos can't be used."""
    corpus = open_corpus(choices.corpus)
    plans = read_all_plans(choices.plans, corpus.hash)
    shown = examples(corpus, choices.videos, EXAMPLES) if choices.videos else []
    asked = Choices(
        corpus=choices.corpus,
        division="cv",
        negatives="hard" if choices.negatives == "hard" else "random",
        l2=choices.l2,
        threshold=choices.threshold,
        seed=choices.seed,
    )
    result = held_out_predictions.run(asked, on_progress)
    draws = {"seed": choices.seed, "draws": choices.draws}
    repeats = choices.repeats
    curve = held_out_predictions.learning_curve(asked, repeats, on_progress)[0] if repeats else ()
    ratings: dict[str, Any] = {"seed": choices.seed, "draws": STUDY_DRAWS, "study": choices.study}
    return Contents(
        table_rows(
            result.predictions,
            threshold=choices.threshold,
            seed=choices.seed,
            draws=choices.draws,
        ),
        {"table": 1, **result.metadata, "draws": choices.draws},
        bins(result.predictions, **draws),
        curve,
        repeats,
        error_lists(result.predictions, result.shown, k=choices.top, threshold=choices.threshold),
        table_2(corpus.judgments, **ratings) if corpus.judgments else None,
        known_validity([corpus], **draws),
        plans,
        shown,
        [one for own in plans for one in failures(own, EXAMPLES)][:EXAMPLES],
        {
            "corpus": corpus.name,
            "corpus_hash": corpus.hash,
            "source": corpus.source,
            "licence": corpus.licence,
            "models": "trained in this run, one for each scenario held out",
            "features": CATALOGUE_VERSION,
            "program": f"corpus-tools-g3 {__version__}",
            "python": platform.python_version(),
            "libraries": {name: version(name) for name in LIBRARIES},
            "seed": choices.seed,
            "draws": choices.draws,
            **{f"table_3, {own.name}": own.provenance for own in plans},
        },
        _commands(choices, has_ratings=bool(corpus.judgments)),
    )


def _commands(choices: ReportChoices, *, has_ratings: bool) -> list[str]:
    name, seed = choices.corpus, choices.seed
    common = f"--corpus {name} --seed {seed}"
    found = [
        f"ct eval --table 1 {common} --cv scenario --negatives {choices.negatives}",
        f"ct eval --errors {common} --cv scenario --top {choices.top}",
    ]
    if choices.repeats:
        repeats = f"--repeats {choices.repeats}"
        found.append(f"ct eval --learning-curve {common} --cv scenario {repeats} --out curve.svg")
    if has_ratings:
        found += [f"ct eval --table 2 {common}", f"ct eval --judge-validity {common}"]
    whole = [f"ct eval --report report --corpus {name} --seed {seed}"]
    for file in choices.plans:
        found.append(
            "ct eval --table 3 --judge automatic --train CORPUS --test CORPUS "
            f"--format json --out {file.name}"
        )
        whole.append(f"--plans {file.name}")
    if choices.videos:
        found.append(f"ct render-videos --corpus {name} --out {choices.videos.name}")
        whole.append(f"--videos {choices.videos.name}")
    return [*found, " ".join(whole)]
