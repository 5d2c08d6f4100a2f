"""Every row of Table 3 applied to the commands of held-out scenarios."""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.perturbed_commands import with_perturbed_commands
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Workers
from corpus_tools.runtime.progress import OnProgress
from eval.judging.judge_registry import PlanJudge
from eval.parsing.parser_registry import parser_named
from eval.table_3.following import (
    FollowedPlan,
    judged,
    plan_by_grounder,
    plan_by_model,
    task_of,
)
from eval.table_3.grounder_registry import PlanGrounder
from eval.table_3.held_out import costs_without, extractor_without
from eval.table_3.judged_commands import JudgedCommand, in_headings, judged_commands
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_rows import MODELS
from eval.table_3.search_examples import read_or_made, shared
from g3.annotation import Annotation
from g3.features.feature_registry import FeatureSet
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import Ablation
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.training import search_sets
from g3.language.parsing.extractor import Parse, SDCExtractor
from g3.language.parsing.parser import parse_unsure

PERTURBED = ("keywords", "embeddings", "gold", "auto")
"""Configurations in which perturbed commands are followed."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Settings that decide the outcomes, as `run` takes them."""

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
        """Names of all configurations."""
        return (*(g.name for g in self.grounders), *self.models, *self.parsers)

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """Feature sets of costs."""
        return search_sets(self.without.sets)


def followed_scenarios(
    asked: Asked,
    known: Sequence[Corpus],
    scenarios: Sequence[str],
    workers: Workers,
    on_progress: OnProgress | None,
) -> Iterator[Done[str, Mapping[str, Sequence[Outcome]]]]:
    """Yield the outcomes of each scenario; the workers make training data together."""
    if not scenarios:
        return
    made = shared(known, asked.sets, seed=asked.seed, workers=workers, on_progress=on_progress)
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
    extractor_of: Callable[[str], SDCExtractor]
    tested: Mapping[tuple[str, str], Sequence[JudgedCommand]]


@functools.lru_cache(maxsize=1)
def _lessons(asked: Asked, file: Path) -> _Lessons:
    known = [open_corpus(name) for name in asked.train.split(",")]
    data = read_or_made(file, known, asked.sets, seed=asked.seed)
    corpus = open_corpus(asked.test)
    tested = {
        (kind, heading): judged_commands(turned, asked.most)
        for kind in ("", *asked.perturb)
        for heading, turned in in_headings(
            with_perturbed_commands(corpus, kind, seed=asked.seed) if kind else corpus,
            asked.headings,
        ).items()
    }
    choices = load_choices_of(known)
    annotations = [a for corpus in known for a in corpus.annotations]
    return _Lessons(
        annotations, costs_without(data, choices, l2=asked.l2), extractor_without(known), tested
    )


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
            extracted[kind] = _extracted(own, lessons.extractor_of, asked)
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
    found: dict[str, Callable[[JudgedCommand, Parse], FollowedPlan]] = {}
    guesser = Grounder(RandomCost(asked.seed), without=without)
    needs_model = asked.parsers or any(name in MODELS for name in asked.models)
    model = Grounder(lessons.cost_of(scenario), without=without) if needs_model else guesser
    for name in asked.models:
        grounder = model if name in MODELS else guesser
        found[name] = functools.partial(plan_by_model, name, grounder=grounder)
    for name in asked.parsers:
        found[name] = functools.partial(_by_parser, name, model)
    return found


def _by_parser(name: str, grounder: Grounder, tested: JudgedCommand, _: Parse) -> FollowedPlan:
    return plan_by_model(name, tested, parser_named(name).parse(tested.command.text), grounder)


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
    own: Sequence[JudgedCommand], extractor_of: Callable[[str], SDCExtractor], asked: Asked
) -> Sequence[Parse]:
    """Return the extracted trees of a scenario's commands; none where nothing needs them."""
    needs_them = "auto" in asked.models or (
        "random" in asked.models and not all(t.annotation for t in own)
    )
    if not needs_them:
        return [Parse(t.command.text, ()) for t in own]
    extractor = extractor_of(own[0].command.scenario)
    texts = (t.command.text for t in own)
    return [parse_unsure(text, n_best=asked.parses, extractor=extractor) for text in texts]
