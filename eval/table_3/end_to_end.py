"""Table 3: plans inferred for commands of held-out scenarios, and whether they are right.

The verdicts are the automatic judge's (:mod:`eval.judging.judge`), not people's as in section 4.3,
and every row says so.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Team, Workers
from corpus_tools.runtime.progress import OnProgress
from eval.judging.deeds import planned
from eval.judging.judge import judge
from eval.judging.words_judge import judge_by_words
from eval.table_3.held_out import calibrated, costs_without, extractor_without
from eval.table_3.outcomes import JudgedRow, Outcome, judged_row
from eval.table_3.search_examples import data_of, read, written
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.features.feature_registry import FeatureSet, select
from g3.groundings import PhysicalObject
from g3.inference.grounder import Grounder, Result, object_ids
from g3.inference.potentials.potential_registry import Ablation, ablation
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, RandomCost, Scorer
from g3.language.parsing.extractor import SDCExtractor
from g3.sdc.clauses import SDC

TOP = 30
"""How many commands the paper's top rows have."""

OnScenario = Callable[[str, Mapping[str, Sequence[Outcome]]], None]


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
    ablate: Iterable[str] = (),
    done: Mapping[str, Mapping[str, Sequence[Outcome]]] = MappingProxyType({}),
    on_scenario: OnScenario | None = None,
    workers: Workers | None = None,
    on_progress: OnProgress | None = None,
) -> EndToEnd:
    """Train, infer plans for the commands of the test corpus, and judge them.

    The plans' probabilities come from curves that have not seen their scenarios, where there are
    several scenarios.

    Parameters
    ----------
    train
        The corpora to learn from, with commas between. Scenarios with the name of the one that
        is tested are always left out, from the extraction of SDCs too.
    test
        The corpus to test on.
    configurations
        Which to run.
    ablate
        Feature sets that costs are learned without, and potentials that are switched off.
    done
        Outcomes of scenarios that are known already, by configuration.
    on_scenario
        Told of each scenario that is done now, with its outcomes by configuration.
    workers
        Who makes the examples to learn from, learns, and follows the commands.

    Raises
    ------
    CorpusError
        If that fails for a scenario, after all others are done.
    ModelError
        If there is no feature set or potential of a name.
    """
    left_out = ablation(ablate)
    known = [open_corpus(name) for name in train.split(",")]
    tested = open_corpus(test)
    names = sorted({a.command.scenario for a in annotated_commands(tested).values()})
    asked = _Asked(train, test, tuple(configurations), l2, seed, left_out)
    found = dict(done)
    left = [name for name in names if name not in found]
    failed: list[Done[str, Mapping[str, Sequence[Outcome]]]] = []
    for item in _followed(asked, known, left, workers or Workers(), on_progress):
        if item.result is None:
            failed.append(item)
            continue
        found[item.item] = item.result
        if on_scenario:
            on_scenario(item.item, item.result)
        if on_progress:
            on_progress("following commands, by scenario", len(found), len(names))
    if failed:
        first = failed[0].error
        raise CorpusError(
            f"commands of {len(failed)} of {len(names)} scenarios can't be followed: "
            f"{', '.join(f.item for f in failed)}",
            where=test,
            fix=f"the first says {type(first).__name__}: {first}",
        ) from first
    metadata = {
        "table": 3,
        "judge": "automatic",
        "protocol": "each scenario held out in turn",
        "train": [c.hash for c in known],
        "test": tested.hash,
        "test_scenarios": names,
        "l2": l2,
        "seed": seed,
        "ablated": sorted(left_out.sets | left_out.potentials),
    }
    together = {
        which: calibrated([o for name in names for o in found[name][which]])
        for which in asked.configurations
    }
    return EndToEnd(together, metadata)


@dataclass(frozen=True, slots=True)
class _Asked:
    """What decides of the outcomes, as `run` takes it."""

    train: str
    test: str
    configurations: tuple[str, ...]
    l2: float
    seed: int
    without: Ablation

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """The feature sets that costs have."""
        return select(without=self.without.sets)


def _followed(
    asked: _Asked,
    known: Sequence[Corpus],
    scenarios: Sequence[str],
    workers: Workers,
    on_progress: OnProgress | None,
) -> Iterator[Done[str, Mapping[str, Sequence[Outcome]]]]:
    """What comes of each scenario's commands; the workers make what they learn from together."""
    if not scenarios:
        return
    with Team(workers) as team:
        data = data_of(known, sets=asked.sets, seed=asked.seed, team=team, on_progress=on_progress)
        with written(data) as file:
            del data
            try:
                yield from team.work(functools.partial(_follow, asked=asked, file=file), scenarios)
            finally:
                _lessons.cache_clear()


@functools.lru_cache(maxsize=1)
def _lessons(
    asked: _Asked, file: Path
) -> tuple[Callable[[str], Scorer], Callable[[str], SDCExtractor], tuple[Annotation, ...]]:
    """What a process has made ready to learn from and to test on."""
    known = [open_corpus(name) for name in asked.train.split(",")]
    # A cluster's worker may not see the file.
    data = read(file) if file.is_file() else data_of(known, sets=asked.sets, seed=asked.seed)
    tested = tuple(annotated_commands(open_corpus(asked.test)).values())
    return costs_without(data, l2=asked.l2), extractor_without(known), tested


def _follow(scenario: str, *, asked: _Asked, file: Path) -> Mapping[str, Sequence[Outcome]]:
    """The outcomes of a scenario's commands by configuration."""
    cost_of, extractor_of, tested = _lessons(asked, file)
    own, learned = [a for a in tested if a.command.scenario == scenario], cost_of(scenario)
    extracted: list[tuple[SDC, ...]] = []
    if "auto" in asked.configurations:
        extracted = extractor_of(scenario).predict(a.command.text for a in own)
    outcomes: dict[str, list[Outcome]] = {}
    for which in asked.configurations:
        cost: Cost = RandomCost(asked.seed) if which == "random" else learned
        trees = extracted if which == "auto" else [a.sdcs for a in own]
        outcomes[which] = [
            outcome(annotation, sdcs, Grounder(cost, without=asked.without.potentials))
            for annotation, sdcs in zip(own, trees, strict=True)
        ]
    return outcomes


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
        note = result.note
        return Outcome(
            own.id, own.scenario, own.text, 0.0, False, note, by_words=False, words_reason=note
        )
    verdict = judge(annotation.context, plan.state)
    by_words = judge_by_words(annotation, planned(annotation.context, plan.actions))
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
        plan.evidence,
        by_words.correct,
        by_words.reason,
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


def table(result: EndToEnd, *, draws: int = 2000, seed: int = 0) -> list[JudgedRow]:
    """The rows of Table 3."""
    rows: list[JudgedRow] = []
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
        correct = [o.correct for o in outcomes]
        scenarios = [o.scenario for o in outcomes]
        by_words = [o.by_words for o in outcomes]
        rows.append(judged_row(name, correct, scenarios, by_words=by_words, draws=draws, seed=seed))
    return rows
