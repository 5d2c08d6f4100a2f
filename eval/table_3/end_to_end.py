"""Table 3: plans inferred for commands of held-out scenarios, and whether they are right.

The verdicts are the automatic judge's (:mod:`eval.judging.judge`), not people's as in section 4.3,
and every row says so.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.perturbed_commands import with_perturbed_commands
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Executor, Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_registry import AUTOMATIC, PlanJudge, judge_named
from eval.parsing.parser_registry import parser_named
from eval.table_3.baselines import BASELINES
from eval.table_3.following import (
    CONFIGURATIONS,
    FollowedPlan,
    judged,
    plan_by_grounder,
    plan_by_model,
    task_of,
)
from eval.table_3.grounder_registry import PlanGrounder, grounder_named
from eval.table_3.held_out import calibrated, costs_without, extractor_without
from eval.table_3.judged_commands import (
    Facts,
    JudgedCommand,
    compared_with,
    facts,
    in_headings,
    judged_commands,
)
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_rows import MODELS, check_names
from eval.table_3.search_examples import data_of, read, written
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.features.feature_registry import FeatureSet
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import Ablation, ablation
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.training.search_training import search_sets
from g3.language.parsing.extractor import Parse, SDCExtractor
from g3.language.parsing.parser import parse_unsure

PERTURBED = ("keywords", "embeddings", "gold", "auto")
"""Configurations in which perturbed commands are followed."""

OnScenario = Callable[[str, Mapping[str, Sequence[Outcome]]], None]


@dataclass(frozen=True, slots=True)
class EndToEnd:
    """The outcomes of all commands by configuration.

    Parameters
    ----------
    outcomes
        Of ``gold`` and ``auto``, the model with annotated and with extracted clauses, of ``random``
        and the baselines, of other grounders, and of the model with the clauses of other parsers.
    facts
        What is known of each command.
    missing
        Grounders that couldn't be run, and why.
    perturbed
        The outcomes of perturbed commands by perturbation and configuration.
    """

    outcomes: Mapping[str, Sequence[Outcome]]
    metadata: Mapping[str, object]
    facts: Mapping[str, Facts] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    perturbed: Mapping[str, Mapping[str, Sequence[Outcome]]] = field(default_factory=dict)


def run(
    train: str,
    test: str,
    *,
    configurations: Iterable[str] = CONFIGURATIONS,
    grounders: Sequence[PlanGrounder] = (),
    parsers: Sequence[str] = (),
    judge: PlanJudge | None = None,
    l2: float = 1.0,
    seed: int = 0,
    ablate: Iterable[str] = (),
    headings: Sequence[str] = (),
    perturb: Sequence[str] = (),
    parses: int = 1,
    most: int = 0,
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
        Which to run. ``gold`` is left out where nobody has annotated a command, and so is a
        baseline that can't be run.
    grounders
        Others that make plans, each a row beside the baselines.
    parsers
        Names of parsers, each a row of the model with its clauses.
    judge
        Who gives the first verdict; the automatic judge if left out.
    ablate
        Feature sets that costs are learned without, and potentials that are switched off.
    headings
        Which way robots face whose heading is assumed, each by a rule
        (:func:`corpus_tools.corpus.start_headings.parse_heading`). All commands are followed in
        each.
    perturb
        How commands are perturbed that are followed besides, as far as `PERTURBED` says.
    parses
        How many trees of each text are tried at most.
    most
        How many commands of each scenario to follow; 0 for all.
    done
        Outcomes of scenarios that are known already, by configuration.
    on_scenario
        Told of each scenario that is done now, with its outcomes by configuration.
    workers
        Who makes the examples to learn from, learns, and follows the commands.

    Raises
    ------
    CorpusError
        If that fails for a scenario, after all others are done, or plans for the test corpus's
        commands can't be judged.
    ModelError
        If there is no feature set or potential of a name.
    """
    left_out = ablation(ablate)
    known = [open_corpus(name) for name in train.split(",")]
    tested = open_corpus(test)
    commands = judged_commands(tested, most)
    in_headings(tested, headings)  # so that a wrong one is told at once
    names = sorted({t.command.scenario for t in commands})
    check_names([*(g.name for g in grounders), *parsers])
    every = [*(grounder_named(name) for name in configurations if name in BASELINES), *grounders]
    lacking = {g.name: why for g in every if (why := g.missing())}
    there = tuple(g for g in every if g.name not in lacking)
    is_annotated = any(t.annotation for t in commands)
    models = [n for n in configurations if n not in BASELINES and (is_annotated or n != "gold")]
    judge = judge or judge_named(AUTOMATIC)
    for name in parsers:
        parser_named(name)
    ways = (tuple(headings), tuple(perturb), parses)
    asked = _Asked(
        train, test, there, tuple(models), tuple(parsers), judge, l2, seed, left_out, *ways, most
    )
    chosen = asked.names
    found = dict(done)
    left = [name for name in names if name not in found]
    tasks = [
        task_of(t, heading)
        for heading, turned in in_headings(tested, headings).items()
        for t in judged_commands(turned, most)
        if t.command.scenario in left
    ]
    for own in there:
        own.prepare(tasks, on_progress or no_progress)
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
        "judge": judge.name,
        "protocol": "each scenario held out in turn",
        "compared_with": compared_with(commands),
        "train": [c.hash for c in known],
        "test": tested.hash,
        "test_scenarios": names,
        "l2": l2,
        "seed": seed,
        "ablated": sorted(left_out.sets | left_out.potentials),
        "headings": list(headings),
        "parses": parses,
        "most": most,
    }
    if perturb:
        metadata["perturb"] = list(perturb)
    if judge.name != AUTOMATIC:
        metadata["judged_by"] = dict(judge.about)
    if grounders:
        metadata["grounders"] = {g.name: dict(g.about) for g in grounders}
    if parsers:
        metadata["parsers"] = list(parsers)

    def together(kind: str) -> dict[str, list[Outcome]]:
        return {
            which: calibrated([o for n in names for o in found[n].get(_key(which, kind), ())])
            for which in chosen
            if not kind or which in PERTURBED
        }

    known_facts = {t.command.id: facts(t) for t in commands}
    perturbed = {kind: together(kind) for kind in perturb}
    return EndToEnd(together(""), metadata, known_facts, lacking, perturbed)


@dataclass(frozen=True, slots=True)
class _Asked:
    """What decides of the outcomes, as `run` takes it."""

    train: str
    test: str
    grounders: tuple[PlanGrounder, ...]
    models: tuple[str, ...]
    parsers: tuple[str, ...]
    judge: PlanJudge
    l2: float
    seed: int
    without: Ablation
    headings: tuple[str, ...]
    perturb: tuple[str, ...]
    parses: int
    most: int

    @property
    def names(self) -> tuple[str, ...]:
        """Of all configurations."""
        return (*(g.name for g in self.grounders), *self.models, *self.parsers)

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """The feature sets that costs have."""
        return search_sets(self.without.sets)


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
    with Executor(workers) as executor:
        data = data_of(
            known, sets=asked.sets, seed=asked.seed, executor=executor, on_progress=on_progress
        )
        with written(data) as file:
            del data
            try:
                yield from executor.work(
                    functools.partial(_follow, asked=asked, file=file), scenarios
                )
            finally:
                _lessons.cache_clear()


@dataclass(frozen=True, slots=True, eq=False)
class _Lessons:
    """What a process has made ready to learn from, and to test on by perturbation and heading."""

    annotations: Sequence[Annotation]
    cost_of: Callable[[str], Scorer]
    extractor_of: Callable[[str], SDCExtractor]
    tested: Mapping[tuple[str, str], Sequence[JudgedCommand]]


@functools.lru_cache(maxsize=1)
def _lessons(asked: _Asked, file: Path) -> _Lessons:
    known = [open_corpus(name) for name in asked.train.split(",")]
    # A cluster's worker may not see the file.
    data = read(file) if file.is_file() else data_of(known, sets=asked.sets, seed=asked.seed)
    corpus = open_corpus(asked.test)
    tested = {
        (kind, heading): judged_commands(turned, asked.most)
        for kind in ("", *asked.perturb)
        for heading, turned in in_headings(_perturbed(corpus, kind, asked), asked.headings).items()
    }
    choices = load_choices_of(known)
    annotations = [a for corpus in known for a in corpus.annotations]
    return _Lessons(annotations, costs_without(data, choices, l2=asked.l2), extractor_without(known), tested)


def _perturbed(corpus: Corpus, kind: str, asked: _Asked) -> Corpus:
    return with_perturbed_commands(corpus, kind, seed=asked.seed) if kind else corpus


def _key(which: str, kind: str) -> str:
    """What outcomes of a configuration are kept by."""
    return f"{which}, {kind}" if kind else which


def _follow(scenario: str, *, asked: _Asked, file: Path) -> Mapping[str, Sequence[Outcome]]:
    """The outcomes of a scenario's commands by configuration."""
    lessons = _lessons(asked, file)
    learned = {
        g.name: g.fit([a for a in lessons.annotations if a.command.scenario != scenario])
        for g in asked.grounders
        if g.learns
    }
    plan_by_name = _models(scenario, lessons, asked)
    outcomes: dict[str, list[Outcome]] = defaultdict(list)
    extracted: dict[str, Sequence[Parse]] = {}
    for (kind, heading), everything in lessons.tested.items():
        own = [t for t in everything if t.command.scenario == scenario]
        if kind not in extracted:
            extracted[kind] = _extracted(own, lessons.extractor_of, asked)
        plans: list[tuple[str, JudgedCommand, FollowedPlan]] = []
        for g in asked.grounders:
            if not kind or g.name in PERTURBED:
                made = (plan_by_grounder(g, task_of(t, heading), learned.get(g.name)) for t in own)
                plans += [(g.name, t, plan) for t, plan in zip(own, made, strict=True)]
        for name, plan_of in plan_by_name.items():
            if not kind or name in PERTURBED:
                both = zip(own, extracted[kind], strict=True)
                plans += [(name, t, plan_of(t, e)) for t, e in both if name != "gold" or t.annotation]
        for (name, *_), outcome in zip(plans, _judged(plans, heading, asked.judge), strict=True):
            outcomes[_key(name, kind)].append(outcome)
    return dict(outcomes)


def _models(
    scenario: str, lessons: _Lessons, asked: _Asked
) -> dict[str, Callable[[JudgedCommand, Parse], FollowedPlan]]:
    """What makes plans of a command and its extracted clauses, by configuration."""
    without = asked.without.potentials
    found: dict[str, Callable[[JudgedCommand, Parse], FollowedPlan]] = {}
    guesser = Grounder(RandomCost(asked.seed), without=without)
    needs_model = asked.parsers or any(name in MODELS for name in asked.models)
    model = Grounder(lessons.cost_of(scenario), without=without) if needs_model else guesser
    for name in asked.models:
        grounder = model if name in MODELS else guesser
        found[name] = functools.partial(_by_model, name, grounder)
    for name in asked.parsers:
        found[name] = functools.partial(_by_parser, name, model)
    return found


def _by_model(name: str, grounder: Grounder, tested: JudgedCommand, trees: Parse) -> FollowedPlan:
    return plan_by_model(name, tested, trees, grounder)


def _by_parser(name: str, grounder: Grounder, tested: JudgedCommand, _: Parse) -> FollowedPlan:
    trees = parser_named(name).trees(tested.command.text)
    return plan_by_model(name, tested, trees, grounder)


def _judged(
    plans: Sequence[tuple[str, JudgedCommand, FollowedPlan]], heading: str, judge: PlanJudge
) -> list[Outcome]:
    """What becomes of plans, as many at the same time as the judge likes."""

    def one(plan: tuple[str, JudgedCommand, FollowedPlan]) -> Outcome:
        return judged(plan[1], plan[2], heading, judge)

    if judge.at_once == 1:
        return [one(plan) for plan in plans]
    with ThreadPoolExecutor(judge.at_once) as threads:
        return list(threads.map(one, plans))


def _extracted(
    own: Sequence[JudgedCommand], extractor_of: Callable[[str], SDCExtractor], asked: _Asked
) -> Sequence[Parse]:
    """The extracted trees of a scenario's commands; none where nothing needs them."""
    needs_them = "auto" in asked.models or (
        "random" in asked.models and not all(t.annotation for t in own)
    )
    if not needs_them:
        return [Parse(t.command.text, ()) for t in own]
    extractor = extractor_of(own[0].command.scenario)
    texts = (t.command.text for t in own)
    return [parse_unsure(text, n_best=asked.parses, extractor=extractor) for text in texts]
