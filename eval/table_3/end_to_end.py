"""Table 3: plans inferred for commands of held-out scenarios, and whether they are right.

The verdicts are the automatic judge's (:mod:`eval.judging.judge`), not people's as in section 4.3,
and every row says so.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.perturbed_commands import with_perturbed_commands
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Executor, Workers
from corpus_tools.runtime.progress import OnProgress
from eval.table_3.baselines import missing
from eval.table_3.following import CONFIGURATIONS, follow_command
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
from eval.table_3.plan_rows import MODELS
from eval.table_3.search_examples import data_of, read, written
from g3.errors import CorpusError
from g3.features.feature_registry import FeatureSet
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import Ablation, ablation
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.training.search_training import search_sets
from g3.inference.tree_choice import PARSES
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
        and of the baselines.
    facts
        What is known of each command.
    missing
        Baselines that couldn't be run, and why.
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
        The corpora to learn from, with commas between. Scenarios with the name of the one that
        is tested are always left out, from the extraction of SDCs too.
    test
        The corpus to test on.
    configurations
        Which to run. ``gold`` is left out where nobody has annotated a command, and so is a
        baseline that can't be run.
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
    lacking = {name: why for name, why in missing().items() if name in configurations}
    is_annotated = any(t.annotation for t in commands)
    chosen = tuple(
        name for name in configurations if name not in lacking and (is_annotated or name != "gold")
    )
    ways = (tuple(headings), tuple(perturb), parses)
    asked = _Asked(train, test, chosen, l2, seed, left_out, *ways, most)
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

    def together(kind: str) -> dict[str, list[Outcome]]:
        return {
            which: calibrated([o for name in names for o in found[name][_key(which, kind)]])
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
    configurations: tuple[str, ...]
    l2: float
    seed: int
    without: Ablation
    headings: tuple[str, ...]
    perturb: tuple[str, ...]
    parses: int
    most: int

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
    return _Lessons(costs_without(data, choices, l2=asked.l2), extractor_without(known), tested)


def _perturbed(corpus: Corpus, kind: str, asked: _Asked) -> Corpus:
    return with_perturbed_commands(corpus, kind, seed=asked.seed) if kind else corpus


def _key(which: str, kind: str) -> str:
    """What outcomes of a configuration are kept by."""
    return f"{which}, {kind}" if kind else which


def _follow(scenario: str, *, asked: _Asked, file: Path) -> Mapping[str, Sequence[Outcome]]:
    """The outcomes of a scenario's commands by configuration."""
    lessons = _lessons(asked, file)
    without = asked.without.potentials
    needs_model = any(name in MODELS for name in asked.configurations)
    model = Grounder(lessons.cost_of(scenario), without=without) if needs_model else None
    guesser = Grounder(RandomCost(asked.seed), without=without)
    outcomes: dict[str, list[Outcome]] = defaultdict(list)
    extracted: dict[str, Sequence[Parse]] = {}
    for (kind, heading), everything in lessons.tested.items():
        own = [t for t in everything if t.command.scenario == scenario]
        if kind not in extracted:
            extracted[kind] = _extracted(own, lessons.extractor_of, asked)
        for which in asked.configurations:
            if kind and which not in PERTURBED:
                continue
            grounder = model if which in MODELS else guesser
            outcomes[_key(which, kind)] += [
                follow_command(which, tested, trees, grounder, heading)
                for tested, trees in zip(own, extracted[kind], strict=True)
                if which != "gold" or tested.annotation
            ]
    return dict(outcomes)


def _extracted(
    own: Sequence[JudgedCommand], extractor_of: Callable[[str], SDCExtractor], asked: _Asked
) -> Sequence[Parse]:
    """The extracted trees of a scenario's commands; none where nothing needs them."""
    needs_them = "auto" in asked.configurations or (
        "random" in asked.configurations and not all(t.annotation for t in own)
    )
    if not needs_them:
        return [Parse(t.command.text, ()) for t in own]
    extractor = extractor_of(own[0].command.scenario)
    texts = (t.command.text for t in own)
    return [parse_unsure(text, n_best=asked.parses, extractor=extractor) for text in texts]
