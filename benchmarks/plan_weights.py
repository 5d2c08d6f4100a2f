"""Weights of the potentials of plans: ``python -m benchmarks.plan_weights``.

They are a conditional logit: of the plans that are compared for a command, which is right? It is
learned from commands that imitate people (``benchmarks/written``), by a model that has learned from
``--train``, and from the annotated commands of ``--held-out``, by models that have not seen their
scenarios. First each set is left out in turn, and each scenario: that shows what the weights are
worth where they have not learned. The last lines are for `g3.inference.potentials.whole_plans`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp

from benchmarks.written_commands import (
    SETS,
    Done,
    is_right,
    learned_cost,
    parser_of,
    records_of,
    state_of,
)
from corpus_tools.importers.authored.bundled import open_corpus
from eval.statistics.estimates import BoolArray
from eval.table_3.following import FollowedPlan, judged
from eval.table_3.grounder_registry import Proposal
from eval.table_3.held_out import costs_without, data_of, parser_without
from eval.table_3.judged_commands import JudgedCommand, judged_commands
from g3.actions.robot_state import start_state
from g3.groundings import FloatArray
from g3.inference.grounder import Grounder
from g3.inference.potentials.cases import PlanCase
from g3.inference.potentials.whole_plans import CUES, ENDS, THINGS, of_ends, of_things
from g3.inference.tree_choice import EVIDENCE, PARSES, Choice
from g3.language.parsing.parser import parse_unsure

LEARNED = SETS[:7]
"""The sets that weights are learned from; the others are left for tests."""
L2 = 100.0
"""The penalty of weights of standardised features. It and `EVIDENCE` are one of nine pairs that
were tried, by what is right in sets and scenarios that are left out and on `automatic`."""
COMMANDS = 200
"""Weight of each set and of the corpus, as a number of commands."""
Parts = dict[str, dict[str, list["Compared"]]]
"""The commands of sets and of a corpus, by what is left out at a time: a set, or a scenario."""


@dataclass(frozen=True, slots=True)
class Compared:
    """The n plans that are compared for a command."""

    evidence: FloatArray
    seen: FloatArray
    """Measurements of each plan by potentials, shape (n, d)."""
    right: BoolArray
    unsure: bool
    """True if the plans are of several trees; those of a single one stay in their order."""

    def is_right(self, weights: FloatArray) -> bool:
        """Check that the plan that weights, shape (d,), prefer is right."""
        best = np.argmax(EVIDENCE * self.evidence + self.seen @ weights) if self.unsure else 0
        return bool(self.right[best])


def compared(name: str, grounder: Grounder) -> Iterator[Compared]:
    """Yield the plans for each command of a set that has any."""
    for record in records_of(name):
        choices, case = grounder.compared(record["text"], state_of(record))
        if choices:
            plans = [c.hypothesis for c in choices]
            right = [is_right(record["want"], Done(p.actions, p.state)) for p in plans]
            yield _seen(choices, case, right)


def held_out(name: str, train: Sequence[str]) -> Iterator[tuple[str, Compared]]:
    """Yield scenarios and plans of annotated commands; costs and trees don't know the scenario."""
    others = (open_corpus(other) for other in train if other != name)
    corpora = [open_corpus(name), *(corpus for corpus in others if corpus.annotations)]
    costs = costs_without(data_of(corpora))
    parsers = parser_without(corpora)
    for scenario, commands in groupby(judged_commands(corpora[0]), lambda c: c.command.scenario):
        grounder, parser = Grounder(costs(scenario)), parsers(scenario)
        for tested in commands:
            parse = parse_unsure(tested.command.text, n_best=PARSES, extractor=parser)
            choices, case = grounder.compared(parse, start_state(tested.context))
            if choices:
                yield scenario, _seen(choices, case, [_is_as_done(tested, c) for c in choices])


def _is_as_done(tested: JudgedCommand, choice: Choice) -> bool:
    plan = choice.hypothesis
    own = FollowedPlan(Proposal(plan.actions), plan.state)
    return judged(tested, own).correct


def _seen(choices: Sequence[Choice], case: PlanCase, right: Sequence[bool]) -> Compared:
    return Compared(
        np.array([c.fit for c in choices]),
        np.hstack((of_things(case), of_ends(case))),
        np.array(right),
        choices[0].tree != choices[-1].tree,
    )


def fitted(sets: Sequence[Sequence[Compared]]) -> FloatArray:
    """Return the weights, shape (d,), that make right plans most probable; sets count the same."""
    told = [[c for c in own if c.right.any() and not c.right.all()] for own in sets]
    together = [c for own in told for c in own]
    count = np.concatenate([np.full(len(own), COMMANDS / len(own)) for own in told])
    scale = np.vstack([c.seen for c in together]).std(axis=0)
    scale[scale == 0] = np.inf  # what is always the same tells nothing

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        value, slope = L2 / 2 * weights @ weights, L2 * weights
        for own, times in zip(together, count, strict=True):
            seen = own.seen / scale
            odds = EVIDENCE * own.evidence + seen @ weights
            of_all, of_right = logsumexp(odds), logsumexp(odds[own.right])
            share = np.where(own.right, np.exp(odds - of_right), 0.0) - np.exp(odds - of_all)
            value -= times * (of_right - of_all)
            slope = slope - times * share @ seen
        return float(value), slope

    found: FloatArray = minimize(loss, np.zeros(len(scale)), jac=True).x / scale
    return found


def learned(parts: Parts, annotated: str, *, but: tuple[str, str] = ("", "")) -> FloatArray:
    """Return weights from the sets of `LEARNED` and the annotated corpus, one unit left out."""
    known = (
        [c for unit, own in parts[name].items() if (name, unit) != but for c in own]
        for name in (*LEARNED, *filter(None, [annotated]))
    )
    return fitted(list(filter(None, known)))


def main() -> None:
    parser = parser_of("plan_weights", __doc__)
    parser.add_argument("--held-out", default="aaai11", help="the annotated corpus; '' for none")
    options = parser.parse_args()
    train, annotated = options.train.split(","), options.held_out
    grounder = Grounder(learned_cost(train))
    parts: Parts = {name: {name: list(compared(name, grounder))} for name in SETS}
    if annotated:
        parts[annotated] = {}
        for scenario, own in held_out(annotated, train):
            parts[annotated].setdefault(scenario, []).append(own)
    print("| left out | plans | right without potentials | with those of the others |")
    for name, units in parts.items():
        without, right = list[bool](), list[bool]()
        for unit, commands in units.items():
            weights = learned(parts, annotated, but=(name, unit))
            without += [c.is_right(np.zeros(len(weights))) for c in commands]
            right += [c.is_right(weights) for c in commands]
        print(f"| {name} | {len(right)} | {sum(without)} | {sum(right)} |", flush=True)
    weights = np.round(learned(parts, annotated), 2)
    for name, weight in zip(THINGS, weights, strict=False):
        print(f'    "{name}": {weight},')
    for cue, row in zip(CUES, weights[len(THINGS) :].reshape(-1, len(ENDS)), strict=True):
        print(f'    "{cue}": ({", ".join(map(str, row.tolist()))}),')


if __name__ == "__main__":
    main()
