"""Table 3: plans inferred for commands of held-out scenarios, with verdicts.

The verdicts are the automatic judge's (:mod:`eval.judging.judge`) or another one's, not people's as
in section 4.3, and every row names its judge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_registry import AUTOMATIC, PlanJudge, judge_named
from eval.parsing.parser_registry import parser_named
from eval.table_3.baselines import BASELINES
from eval.table_3.following import CONFIGURATIONS, task_of
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, grounder_named
from eval.table_3.held_out import calibrated
from eval.table_3.judged_commands import (
    Facts,
    compared_with,
    facts,
    in_headings,
    judged_commands,
)
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_rows import ALONE, MODELS, check_names
from eval.table_3.scenario_following import PERTURBED, Asked, followed_scenarios, kept_by
from g3.errors import CorpusError
from g3.inference.potentials.potential_registry import ablation
from g3.inference.tree_choice import PARSES
from g3.short_repr import short_repr

OnScenario = Callable[[str, Mapping[str, Sequence[Outcome]]], None]


@short_repr
@dataclass(frozen=True, slots=True)
class EndToEnd:
    """The outcomes of all commands by configuration.

    Parameters
    ----------
    outcomes
        Of ``gold`` and ``auto``, the model with annotated and with extracted clauses, of ``random``
        and the baselines, of other grounders, and of the model with the clauses of other parsers.
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
    parsers: Sequence[str] = (),
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
        The corpora to learn from, with commas between. Scenarios with the name of the one that
        is tested are always left out, from the extraction of SDCs too.
    test
        The corpus to test on.
    configurations
        Configurations to run. ``gold`` is left out where no command is annotated, and so is a
        baseline that can't be run.
    grounders
        Further grounders, each a row beside the baselines.
    parsers
        Names of parsers, each a row of the model with its clauses.
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
    known = [open_corpus(name) for name in train.split(",")]
    tested = open_corpus(test)
    commands = judged_commands(tested, most)
    names = sorted({t.command.scenario for t in commands})
    every = _grounders(configurations, grounders, parsers)
    lacking = {g.name: why for g in every if (why := g.missing())}
    there = tuple(g for g in every if g.name not in lacking)
    is_annotated = any(t.annotation for t in commands)
    models = [n for n in configurations if n not in BASELINES and (is_annotated or n != "gold")]
    judge = judge or judge_named(AUTOMATIC)
    ways = (tuple(headings), tuple(perturb), parses)
    asked = Asked(
        train, test, there, tuple(models), tuple(parsers), judge, l2, seed, left_out, *ways, most
    )
    order = [*ALONE, *(g.name for g in grounders), *MODELS, *parsers]
    chosen = [name for name in order if name in asked.names]
    found = dict(done)
    left = [name for name in names if name not in found]
    tasks = tasks_of(tested, headings, most)
    for own in there:
        own.prepare(tasks, on_progress or no_progress)
    failed: list[Done[str, Mapping[str, Sequence[Outcome]]]] = []
    for item in followed_scenarios(asked, known, left, workers or Workers(), on_progress):
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
    others: dict[str, object] = {
        "perturb": list(perturb),
        "judged_by": {} if judge.name == AUTOMATIC else dict(judge.about),
        "grounders": {g.name: dict(g.about) for g in grounders},
        "parsers": list(parsers),
    }
    metadata |= {key: value for key, value in others.items() if value}

    def together(kind: str) -> dict[str, list[Outcome]]:
        return {
            which: calibrated([o for n in names for o in found[n].get(kept_by(which, kind), ())])
            for which in chosen
            if not kind or which in PERTURBED
        }

    known_facts = {t.command.id: facts(t) for t in commands}
    perturbed = {kind: together(kind) for kind in perturb}
    return EndToEnd(together(""), metadata, known_facts, lacking, perturbed)


def _grounders(
    configurations: Iterable[str], others: Sequence[PlanGrounder], parsers: Sequence[str]
) -> list[PlanGrounder]:
    """Return the chosen baselines and other grounders, with the names of rows checked."""
    check_names([*(g.name for g in others), *parsers])
    for name in parsers:
        parser_named(name)
    return [*(grounder_named(name) for name in configurations if name in BASELINES), *others]


def tasks_of(corpus: Corpus, headings: Sequence[str] = (), most: int = 0) -> list[PlanTask]:
    """Return grounders' tasks; the parameters are those of :func:`run`."""
    return [
        task_of(tested, heading)
        for heading, turned in in_headings(corpus, headings).items()
        for tested in judged_commands(turned, most)
    ]
