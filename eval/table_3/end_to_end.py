"""Table 3: plans inferred for commands of held-out scenarios, with verdicts.

The verdicts are the automatic judge's (:mod:`eval.judging.judge`) or another one's, not people's as
in section 4.3, and every row names its judge.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from corpus_tools.corpus.annotated_trees import Annotated, with_perturbed_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_registry import AUTOMATIC, PlanJudge, judge_named
from eval.parsing.parser_registry import ParseTask, TextParser, parser_named
from eval.table_3.baselines import BASELINES
from eval.table_3.following import (
    CONFIGURATIONS,
    FollowedPlan,
    judged,
    papers_own,
    plan_by_grounder,
    plan_by_model,
    task_of,
)
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, Proposal, grounder_named
from eval.table_3.held_out import (
    calibrated,
    costs_without,
    parser_without,
    read_or_made,
    shared,
    trees_without,
)
from eval.table_3.judged_commands import (
    Facts,
    JudgedCommand,
    compared_with,
    facts,
    in_headings,
    judged_commands,
)
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_rows import ALONE, MODELS, PAPERS_OWN, check_names
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.features.feature_registry import FeatureSet
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import Ablation, ablation
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.training import search_sets
from g3.inference.tree_choice import PARSES
from g3.language.parsing.parser import parse_unsure
from g3.language.parsing.sdc_parser import SDCParser
from g3.language.parsing.trees import Parse
from g3.short_repr import short_repr

PERTURBED = ("keywords", "embeddings", "gold", "auto")
"""Configurations in which perturbed commands are followed."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Settings that decide the outcomes, as `run` takes them."""

    train: str
    test: str
    grounders: tuple[PlanGrounder, ...]
    models: tuple[str, ...]
    parsers: tuple[TextParser, ...]
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
        """Names of all configurations."""
        return (*(g.name for g in self.grounders), *self.models, *(p.name for p in self.parsers))

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """Feature sets of costs."""
        return search_sets(self.without.sets)


def followed_scenarios(
    asked: Asked,
    corpora: Sequence[Corpus],
    scenarios: Sequence[str],
    workers: Workers,
    on_progress: OnProgress | None,
) -> Iterator[Done[str, Mapping[str, Sequence[Outcome]]]]:
    """Yield the outcomes of each scenario; the workers make training data together."""
    if not scenarios:
        return
    made = shared(corpora, asked.sets, seed=asked.seed, workers=workers, on_progress=on_progress)
    with made as (executor, file):
        try:
            yield from executor.work(functools.partial(_follow, asked=asked, file=file), scenarios)
        finally:
            _lessons.cache_clear()


@dataclass(frozen=True, slots=True, eq=False)
class _Lessons:
    """A process's training data, and its tested commands by perturbation and heading."""

    annotations: Sequence[Annotation]
    cost_of: Callable[[str], Scorer]
    parser_of: Callable[[str], SDCParser]
    trees_of: Callable[[str], Sequence[Annotated]]
    tested: Mapping[tuple[str, str], Sequence[JudgedCommand]]


@functools.lru_cache(maxsize=1)
def _lessons(asked: Asked, file: Path) -> _Lessons:
    corpora = [open_corpus(name) for name in asked.train.split(",")]
    data = read_or_made(file, corpora, asked.sets, seed=asked.seed)
    corpus = open_corpus(asked.test)
    tested = {
        (kind, heading): judged_commands(turned, asked.most)
        for kind in ("", *asked.perturb)
        for heading, turned in in_headings(
            with_perturbed_commands(corpus, kind, seed=asked.seed) if kind else corpus,
            asked.headings,
        ).items()
    }
    choices = load_choices_of(corpora)
    annotations = [a for corpus in corpora for a in corpus.annotations]
    costs, parsers = costs_without(data, choices, l2=asked.l2), parser_without(corpora)
    return _Lessons(annotations, costs, parsers, trees_without(corpora), tested)


def kept_by(which: str, kind: str) -> str:
    """Return the key under which a configuration's outcomes are kept."""
    return f"{which}, {kind}" if kind else which


def _follow(scenario: str, *, asked: Asked, file: Path) -> Mapping[str, Sequence[Outcome]]:
    """Return the outcomes of a scenario's commands by configuration."""
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
            extracted[kind] = _extracted(own, lessons.parser_of, asked)
        plans: list[tuple[str, JudgedCommand, FollowedPlan]] = []
        for g in asked.grounders:
            if not kind or g.name in PERTURBED:
                made = (plan_by_grounder(g, task_of(t, heading), learned.get(g.name)) for t in own)
                plans += [(g.name, t, plan) for t, plan in zip(own, made, strict=True)]
        for name, plan_of in plan_by_name.items():
            if not kind or name in PERTURBED:
                both = zip(own, extracted[kind], strict=True)
                plans += [
                    (name, t, plan_of(t, e)) for t, e in both if name != "gold" or t.annotation
                ]
        for (name, *_), outcome in zip(plans, _judged(plans, heading, asked.judge), strict=True):
            outcomes[kept_by(name, kind)].append(outcome)
    return dict(outcomes)


def _models(
    scenario: str, lessons: _Lessons, asked: Asked
) -> dict[str, Callable[[JudgedCommand, Parse], FollowedPlan]]:
    """Return planners of a command and its extracted clauses, by configuration."""
    without = asked.without.potentials
    result: dict[str, Callable[[JudgedCommand, Parse], FollowedPlan]] = {}
    guesser = Grounder(RandomCost(asked.seed), without=without)
    by_name = {"random": guesser}
    if asked.parsers or set(asked.models) - {"random"}:
        cost = lessons.cost_of(scenario)
        by_name |= dict.fromkeys(MODELS, Grounder(cost, without=without))
        by_name[PAPERS_OWN] = papers_own(cost)
    for name in asked.models:
        result[name] = functools.partial(plan_by_model, name, grounder=by_name[name])
    for parser in asked.parsers:
        learned = parser.fit(lessons.trees_of(scenario)) if parser.learns else None
        result[parser.name] = functools.partial(_by_parser, parser, learned, by_name["auto"])
    return result


def _by_parser(
    parser: TextParser, learned: Any, grounder: Grounder, tested: JudgedCommand, _: Parse
) -> FollowedPlan:
    parse = parser.parse(tested.command.text, learned)
    if not parse.trees and parse.note:
        return FollowedPlan(Proposal(note=parse.note))
    return plan_by_model(parser.name, tested, parse, grounder)


def _judged(
    plans: Sequence[tuple[str, JudgedCommand, FollowedPlan]], heading: str, judge: PlanJudge
) -> list[Outcome]:
    """Judge plans, as many at the same time as the judge allows."""

    def one(plan: tuple[str, JudgedCommand, FollowedPlan]) -> Outcome:
        return judged(plan[1], plan[2], heading, judge)

    if judge.at_once == 1:
        return [one(plan) for plan in plans]
    with ThreadPoolExecutor(judge.at_once) as threads:
        return list(threads.map(one, plans))


def _extracted(
    own: Sequence[JudgedCommand], parser_of: Callable[[str], SDCParser], asked: Asked
) -> Sequence[Parse]:
    """Return the extracted trees of a scenario's commands; none where nothing needs them."""
    needs_them = "auto" in asked.models or (
        {"random", PAPERS_OWN}.intersection(asked.models) and not all(t.annotation for t in own)
    )
    if not needs_them:
        return [Parse(t.command.text, ()) for t in own]
    parser = parser_of(own[0].command.scenario)
    texts = (t.command.text for t in own)
    return [parse_unsure(text, n_best=asked.parses, extractor=parser) for text in texts]


OnScenario = Callable[[str, Mapping[str, Sequence[Outcome]]], None]


@short_repr
@dataclass(frozen=True, slots=True)
class EndToEnd:
    """The outcomes of all commands by configuration.

    Parameters
    ----------
    outcomes
        Of ``gold`` and ``auto``, the model with annotated and with extracted clauses, of
        ``paper``, the paper's own model, of ``random`` and the baselines, of other grounders, and
        of the model with the clauses of other parsers.
    missing
        Grounders that couldn't be run, with the reasons.
    perturbed
        The outcomes of perturbed commands by perturbation and configuration.
    """

    outcomes: Mapping[str, Sequence[Outcome]]
    metadata: Mapping[str, object]
    facts: Mapping[str, Facts] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    perturbed: Mapping[str, Mapping[str, Sequence[Outcome]]] = field(default_factory=dict)

    def with_metadata(self, more: Mapping[str, object]) -> EndToEnd:
        """Return a copy with more metadata."""
        return replace(self, metadata={**self.metadata, **more})


def run(
    train: str,
    test: str,
    *,
    configurations: Iterable[str] = CONFIGURATIONS,
    grounders: Sequence[PlanGrounder] = (),
    parsers: Sequence[str | TextParser] = (),
    judge: PlanJudge | None = None,
    l2: float = 1.0,
    seed: int = 0,
    ablate: Iterable[str] = (),
    headings: Sequence[str] = (),
    perturb: Sequence[str] = (),
    parses: int = PARSES,
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
        The corpora to learn from, with commas between. Scenarios with the name of that which
        is tested are always left out, from the extraction of SDCs too.
    test
        The corpus to test on.
    configurations
        Configurations to run. ``gold`` is left out where no command is annotated, and so is a
        baseline that can't be run.
    grounders
        Further grounders, each a row beside the baselines.
    parsers
        Parsers or their names, each a row of the model with its clauses.
    judge
        Judge of the first verdict; the automatic judge if left out.
    ablate
        Feature sets that costs are learned without, and potentials that are switched off.
    headings
        Rules for the headings of robots whose heading is assumed
        (:func:`corpus_tools.corpus.start_headings.parse_heading`). All commands are followed in
        each.
    perturb
        Perturbations of commands to follow in addition, in the configurations of `PERTURBED`.
    parses
        Largest number of trees of each text.
    most
        Number of commands of each scenario to follow; 0 for all.
    done
        Outcomes of scenarios that are known already, by configuration.
    on_scenario
        Called for each newly finished scenario, with its outcomes by configuration.
    workers
        Workers that make the training examples, learn, and follow the commands.

    Raises
    ------
    CorpusError
        If that fails for a scenario, after all others are done, or plans for the test corpus's
        commands can't be judged.
    ModelError
        If there is no feature set or potential of a name.
    """
    left_out = ablation(ablate)
    corpora = [open_corpus(name) for name in train.split(",")]
    tested = open_corpus(test)
    commands = judged_commands(tested, most)
    names = sorted({t.command.scenario for t in commands})
    others = tuple(parser_named(own) if isinstance(own, str) else own for own in parsers)
    every = _grounders(configurations, grounders, others)
    lacking = {g.name: why for g in every if (why := g.missing())}
    there = tuple(g for g in every if g.name not in lacking)
    is_annotated = any(t.annotation for t in commands)
    models = [n for n in configurations if n not in BASELINES and (is_annotated or n != "gold")]
    judge = judge or judge_named(AUTOMATIC)
    ways = (tuple(headings), tuple(perturb), parses)
    asked = Asked(train, test, there, tuple(models), others, judge, l2, seed, left_out, *ways, most)
    order = [*ALONE, PAPERS_OWN, *(g.name for g in grounders), *MODELS, *(p.name for p in others)]
    chosen = [name for name in order if name in asked.names]
    outcomes_of = dict(done)
    left = [name for name in names if name not in outcomes_of]
    tasks = tasks_of(tested, headings, most)
    for own in there:
        own.prepare(tasks, on_progress or no_progress)
    trees_of = trees_without(corpora)
    for parser in others:
        learned = {name: parser.fit(trees_of(name)) for name in left} if parser.learns else {}
        texts = dict.fromkeys((t.command.text, t.command.scenario) for t in commands)
        parser.prepare(
            [ParseTask(text, learned.get(name)) for text, name in texts if name in left],
            on_progress or no_progress,
        )
    failed: list[Done[str, Mapping[str, Sequence[Outcome]]]] = []
    for item in followed_scenarios(asked, corpora, left, workers or Workers(), on_progress):
        if item.result is None:
            failed.append(item)
            continue
        outcomes_of[item.item] = item.result
        if on_scenario:
            on_scenario(item.item, item.result)
        if on_progress:
            on_progress("following commands, by scenario", len(outcomes_of), len(names))
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
        "train": [c.hash for c in corpora],
        "test": tested.hash,
        "test_scenarios": names,
        "is_authored": tested.is_authored,
        "l2": l2,
        "seed": seed,
        "ablated": sorted(left_out.sets | left_out.potentials),
        "headings": list(headings),
        "parses": parses,
        "most": most,
    }
    further: dict[str, object] = {
        "perturb": list(perturb),
        "judged_by": {} if judge.name == AUTOMATIC else dict(judge.about),
        "grounders": {g.name: dict(g.about) for g in grounders},
        "parsers": [p.name for p in others],
        "parsed_by": {p.name: dict(p.about) for p in others if p.about},
    }
    metadata |= {key: value for key, value in further.items() if value}

    def together(kind: str) -> dict[str, list[Outcome]]:
        return {
            which: calibrated(
                [o for n in names for o in outcomes_of[n].get(kept_by(which, kind), ())]
            )
            for which in chosen
            if not kind or which in PERTURBED
        }

    known_facts = {t.command.id: facts(t) for t in commands}
    perturbed = {kind: together(kind) for kind in perturb}
    return EndToEnd(together(""), metadata, known_facts, lacking, perturbed)


def _grounders(
    configurations: Iterable[str], others: Sequence[PlanGrounder], parsers: Sequence[TextParser]
) -> list[PlanGrounder]:
    """Return the chosen baselines and other grounders, with the names of rows checked."""
    check_names([*(g.name for g in others), *(p.name for p in parsers)])
    return [*(grounder_named(name) for name in configurations if name in BASELINES), *others]


def tasks_of(corpus: Corpus, headings: Sequence[str] = (), most: int = 0) -> list[PlanTask]:
    """Return grounders' tasks; the parameters are those of :func:`run`."""
    return [
        task_of(tested, heading)
        for heading, turned in in_headings(corpus, headings).items()
        for tested in judged_commands(turned, most)
    ]
