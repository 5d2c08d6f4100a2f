"""Weights of the potentials of plans: ``python -m benchmarks.plan_weights``.

They are a conditional logit: of the plans that are compared for a command, which is right? It is
learned from commands that imitate people (``benchmarks/written``), by a model that has learned from
``--train``. First each set is left out in turn: that shows what the weights are worth where they
have not learned. The last lines are for `g3.inference.potentials.whole_plans`, from `LEARNED`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp

from benchmarks.written_commands import SETS, Done, is_right, learned_cost, records_of, state_of
from eval.statistics.estimates import BoolArray
from g3.groundings import FloatArray
from g3.inference.grounder import Grounder
from g3.inference.potentials.whole_plans import CUES, ENDS, THINGS, of_ends, of_things
from g3.inference.tree_choice import EVIDENCE

LEARNED = SETS[:5]
"""The sets that weights are learned from; the others are left for tests."""
L2 = 100.0
"""The penalty of weights of standardised features. It and `EVIDENCE` are one of six pairs that were
tried: the one that lost nothing on `automatic` and aaai11."""
COMMANDS = 200
"""How many each set counts for."""


@dataclass(frozen=True, slots=True)
class Compared:
    """The plans that are compared for a command.

    Parameters
    ----------
    evidence
        Of each plan, shape (n,).
    seen
        What potentials measure of it, shape (n, d).
    right
        Whether it is right, shape (n,).
    unsure
        Whether the plans are of several trees; those of a single one stay in their order.
    """

    evidence: FloatArray
    seen: FloatArray
    right: BoolArray
    unsure: bool

    def is_right(self, weights: FloatArray) -> bool:
        """Whether the plan is right that weights, shape (d,), prefer."""
        best = np.argmax(EVIDENCE * self.evidence + self.seen @ weights) if self.unsure else 0
        return bool(self.right[best])


def compared(name: str, grounder: Grounder) -> Iterator[Compared]:
    """The plans for the commands of a set; nothing for those without plans."""
    for record in records_of(name):
        choices, case = grounder.compared(record["text"], state_of(record))
        if choices:
            plans = [c.hypothesis for c in choices]
            yield Compared(
                np.array([c.seen[1] for c in choices]),
                np.hstack((of_things(case), of_ends(case))),
                np.array([is_right(record["want"], Done(p.actions, p.state)) for p in plans]),
                choices[0].tree != choices[-1].tree,
            )


def fitted(sets: Sequence[Sequence[Compared]]) -> FloatArray:
    """The weights that make right plans most probable, shape (d,); each set counts as much."""
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


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plan_weights", description=__doc__)
    parser.add_argument(
        "--train", default="aaai11,warehouse,automatic", help="corpora, with commas between"
    )
    options = parser.parse_args()
    grounder = Grounder(learned_cost(options.train.split(",")))
    sets = {name: list(compared(name, grounder)) for name in SETS}
    print("| set left out | plans | right without potentials | with those of the other sets |")
    for name, own in sets.items():
        weights = fitted([sets[other] for other in LEARNED if other != name])
        none = np.zeros(len(weights))
        right = [sum(c.is_right(w) for c in own) for w in (none, weights)]
        print(f"| {name} | {len(own)} | {right[0]} | {right[1]} |", flush=True)
    weights = np.round(fitted([sets[name] for name in LEARNED]), 2)
    for name, weight in zip(THINGS, weights, strict=False):
        print(f'    "{name}": {weight},')
    for cue, row in zip(CUES, weights[len(THINGS) :].reshape(-1, len(ENDS)), strict=True):
        print(f'    "{cue}": ({", ".join(map(str, row.tolist()))}),')


if __name__ == "__main__":
    main()
