"""Table 3: plans inferred for commands of held-out scenarios, and whether they are right.

The verdicts are the automatic judge's (:mod:`eval.judge`), not people's as in section 4.3, and
every row says so.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.bundled import open_corpus
from corpus_tools.corpus.model import Corpus
from corpus_tools.progress import OnProgress
from eval.judge import judge
from g3.annotation import Annotation
from g3.features.registry import select
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.costs import Cost, RandomCost, Scorer
from g3.inference.grounder import Grounder, Result, object_ids
from g3.inference.things import Tree
from g3.inference.training import train_rows, training_data
from g3.language.parser import parse_many
from g3.sdc import SDC

TOP = 30
"""How many commands the paper's top rows have."""
BINS = 10
"""Bins of the reliability diagram."""

Row = dict[str, str | float | int]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one command in one configuration.

    Parameters
    ----------
    command, scenario, text
        The command.
    probability
        Of its plan; 0 where there is none.
    correct
        The judge's verdict.
    reason
        Why it is wrong; empty if it isn't.
    objects, objects_right
        How many OBJECTs are annotated, and how many of them are grounded as annotated.
    """

    command: str
    scenario: str
    text: str
    probability: float
    correct: bool
    reason: str
    objects: int = 0
    objects_right: int = 0


@dataclass(frozen=True, slots=True)
class EndToEnd:
    """The outcomes of all commands by configuration: ``random``, ``gold`` and ``auto``."""

    outcomes: Mapping[str, Sequence[Outcome]]
    metadata: Mapping[str, object]


def run(
    train: str,
    test: str,
    *,
    configurations: Iterable[str] = ("random", "gold", "auto"),
    l2: float = 1.0,
    seed: int = 0,
    on_progress: OnProgress | None = None,
) -> EndToEnd:
    """Train, infer plans for the commands of the test corpus, and judge them.

    Parameters
    ----------
    train
        The corpora to learn from, with commas between. Scenarios with the name of the one that
        is tested are always left out.
    test
        The corpus to test on.
    configurations
        Which to run.
    """
    known = [open_corpus(name) for name in train.split(",")]
    tested = open_corpus(test)
    cost_without = learner(known, l2=l2, seed=seed, on_progress=on_progress)
    chosen = annotated_commands(tested)
    trees = dict(zip(chosen, parse_many(a.command.text for a in chosen.values()), strict=True))
    names = sorted({a.command.scenario for a in chosen.values()})
    found: dict[str, list[Outcome]] = {name: [] for name in configurations}
    for number, name in enumerate(names):
        if on_progress:
            on_progress(f"following commands of {name}", number, len(names))
        learned = cost_without(name)
        for annotation in (a for a in chosen.values() if a.command.scenario == name):
            for which, outcomes in found.items():
                cost: Cost = RandomCost(seed) if which == "random" else learned
                sdcs = trees[annotation.command.id].sdcs if which == "auto" else annotation.sdcs
                outcomes.append(outcome(annotation, sdcs, Grounder(cost)))
    metadata = {
        "table": 3,
        "judge": "automatic",
        "protocol": "each scenario held out in turn",
        "train": [c.hash for c in known],
        "test": tested.hash,
        "test_scenarios": names,
        "l2": l2,
        "seed": seed,
    }
    return EndToEnd(found, metadata)


def learner(
    corpora: Sequence[Corpus],
    *,
    l2: float = 1.0,
    seed: int = 0,
    on_progress: OnProgress | None = None,
) -> Callable[[str], Scorer]:
    """What learns the costs from all scenarios but the one with a name.

    The last costs are kept, for scenarios in a row.
    """
    annotations = [a for corpus in corpora for a in corpus.annotations]
    data = training_data(annotations, select(), seed=seed, on_progress=on_progress)
    known = set(data.scenario)

    @functools.lru_cache(maxsize=1)
    def learned(left_out: str) -> Scorer:
        return Scorer(train_rows(data, np.flatnonzero(data.scenario != left_out), l2=l2))

    return lambda scenario: learned(scenario if scenario in known else "")


def annotated_commands(corpus: Corpus) -> dict[str, Annotation]:
    """The first positive annotation of each command, by the command's id."""
    found: dict[str, Annotation] = {}
    for annotation in corpus.annotations:
        if annotation.source == "positive":
            found.setdefault(annotation.command.id, annotation)
    return found


def outcome(annotation: Annotation, sdcs: Sequence[SDC], grounder: Grounder) -> Outcome:
    """Follow a command in its own scenario and judge the plan, however improbable it is."""
    result = grounder.follow(sdcs, annotation.context, least=0.0)
    own = annotation.command
    plan = result.plan
    if plan is None:
        return Outcome(own.id, own.scenario, own.text, 0.0, False, result.note)
    verdict = judge(annotation.context, plan.state)
    right, total = _objects(annotation, result) if sdcs is annotation.sdcs else (0, 0)
    return Outcome(
        own.id,
        own.scenario,
        own.text,
        plan.probability,
        verdict.correct,
        verdict.reason,
        total,
        right,
    )


def _objects(annotation: Annotation, result: Result) -> tuple[int, int]:
    """How many annotated OBJECTs are grounded as annotated, and how many there are."""
    given = {g.node: object_ids(g.group) for g in result.plans[0].groundings}
    right = total = 0
    for node, sdc in enumerate(Tree(annotation.sdcs).nodes):
        groundings = annotation.groundings[node]
        if sdc.type != "OBJECT" or not all(isinstance(g, PhysicalObject) for g in groundings):
            continue
        if groundings and annotation.correct[node]:
            total += 1
            right += set(given.get(node, ())) == set(object_ids(groundings))
    return right, total


def table(result: EndToEnd, *, draws: int = 2000, seed: int = 0) -> list[Row]:
    """The rows of Table 3."""
    rows: list[Row] = []
    for name, of, top in (
        ("random", "random", 0),
        ("gold-top30", "gold", TOP),
        ("auto-top30", "auto", TOP),
        ("gold-all", "gold", 0),
        ("auto-all", "auto", 0),
    ):
        if of not in result.outcomes:
            continue
        outcomes = sorted(result.outcomes[of], key=lambda o: (-o.probability, o.command))
        outcomes = outcomes[: top or len(outcomes)]
        correct = np.array([o.correct for o in outcomes], dtype=float)
        low, high = interval(correct, [o.scenario for o in outcomes], draws=draws, seed=seed)
        rows.append(
            {
                "configuration": name,
                "judge": "automatic",
                "precision": float(correct.mean()),
                "low": low,
                "high": high,
                "n": len(outcomes),
            }
        )
    return rows


def interval(
    correct: FloatArray, scenario: Sequence[str], *, draws: int, seed: int
) -> tuple[float, float]:
    """95% interval of a mean by resampling scenarios, whose commands share a log."""
    names, index = np.unique(np.array(scenario), return_inverse=True)
    total = np.bincount(index, correct, len(names))
    count = np.bincount(index, minlength=len(names))
    rng = np.random.default_rng(seed)
    picked = rng.integers(len(names), size=(draws, len(names)))
    means = total[picked].sum(axis=1) / count[picked].sum(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return float(low), float(high)


def grounding_accuracy(outcomes: Sequence[Outcome]) -> float:
    """Share of the annotated OBJECTs that are grounded as annotated in the best plan."""
    total = sum(o.objects for o in outcomes)
    return sum(o.objects_right for o in outcomes) / max(total, 1)


def reliability(outcomes: Sequence[Outcome]) -> tuple[float, list[Row]]:
    """Expected calibration error of the plans' probabilities, and the reliability diagram."""
    given = np.array([o.probability for o in outcomes])
    correct = np.array([o.correct for o in outcomes], dtype=float)
    place = np.minimum((given * BINS).astype(int), BINS - 1)
    rows: list[Row] = []
    error = 0.0
    for i in np.unique(place):
        own = place == i
        stated, true = float(given[own].mean()), float(correct[own].mean())
        error += float(own.mean()) * abs(stated - true)
        rows.append({"stated": stated, "correct": true, "n": int(own.sum())})
    return error, rows
