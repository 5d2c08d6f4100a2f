"""Weights of the evidence for plans: ``python -m benchmarks.plan_weights NAME NAME...``.

A name is a corpus or a set of commands that imitate people (``benchmarks/written``). Of each
command all plans that are compared are noted with their evidence and whether they are right: of
sets by a model that has learned from ``--train``, of corpora by models and parsers that have not
seen the scenario. The bundled end model has learned from all sets but those that are held out and
the default ones: for others give one that has not by ``--end-model`` (``python -m
benchmarks.end_model --without 26 --without 27 --out FILE``).

A plan for an annotated command is right by half if it agrees with its known outcome alone, or with
its annotated words alone. The weights are fitted to all plans, and then to those that these choose,
each command and each name counted the same. The table shows each name, left out in turn: the share
of right plans where the first plan for the most probable tree is taken, and where weights of the
others choose. The last lines are for `g3.inference.calibration`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import groupby
from pathlib import Path

import numpy as np
from scipy.special import expit

from benchmarks.written_commands import (
    CHOICE,
    SETS,
    Done,
    is_right,
    learned_cost,
    parser_of,
    records_of,
    state_of,
)
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from eval.table_3.following import FollowedPlan, judged
from eval.table_3.grounder_registry import Proposal
from eval.table_3.held_out import costs_without, data_of, parser_without
from eval.table_3.judged_commands import JudgedCommand, judged_commands
from eval.table_3.outcomes import Outcome, reliability, risk_coverage
from g3.actions.robot_state import start_state
from g3.groundings import FloatArray
from g3.inference.calibration import WEIGHTS, fit_curve
from g3.inference.ends.end_model import EndModel
from g3.inference.grounder import Grounder
from g3.inference.tree_choice import PARSES, Choice, best_plans
from g3.language.parsing.parser import parse_unsure

COMMANDS = 200
"""Weight of each name as a number of commands, compared with the prior of the weights."""


@dataclass(frozen=True, slots=True)
class Compared:
    """The n plans that are compared for a command."""

    text: str
    trees: tuple[int, ...]
    evidence: FloatArray
    """Shape (n, len(WEIGHTS))."""
    right: FloatArray
    """Shape (n,)."""

    def choose(self, weights: FloatArray) -> int:
        """Return the index of the plan that weights prefer."""
        return best_plans(self.trees, self.evidence @ weights, 1)[0]


def of_set(name: str, grounder: Grounder) -> Iterator[Compared]:
    """Yield the plans for each command of a set that has any."""
    for record in records_of(name):
        choices, seen = grounder.compared(record["text"], state_of(record))
        plans = [choice.hypothesis for choice in choices]
        right = [is_right(record["want"], Done(p.actions, p.state)) for p in plans]
        yield _compared(record["text"], choices, seen, right)


def of_corpus(name: str, train: Sequence[str], ends: EndModel | None) -> Iterator[Compared]:
    """Yield the plans for each command of a corpus; costs and trees don't know its scenario."""
    others = (open_corpus(other) for other in train if other != name)
    corpora = [open_corpus(name), *others]
    costs = costs_without(data_of(corpora), load_choices_of(corpora))
    parsers = parser_without(corpora)
    for scenario, commands in groupby(judged_commands(corpora[0]), lambda c: c.command.scenario):
        grounder, parser = Grounder(costs(scenario), end_model=ends), parsers(scenario)
        for tested in commands:
            parse = parse_unsure(tested.command.text, n_best=PARSES, extractor=parser)
            choices, seen = grounder.compared(parse, start_state(tested.context))
            right = [_is_right(tested, choice) for choice in choices]
            yield _compared(tested.command.text, choices, seen, right)


def _is_right(tested: JudgedCommand, choice: Choice) -> float:
    plan = choice.hypothesis
    outcome = judged(tested, FollowedPlan(Proposal(plan.actions), plan.state))
    by_words = outcome.correct if outcome.by_words is None else outcome.by_words
    return (outcome.correct + by_words) / 2


def _compared(
    text: str, choices: Sequence[Choice], seen: FloatArray, right: Sequence[float]
) -> Compared:
    rows = seen.reshape(len(choices), len(WEIGHTS))
    return Compared(text, tuple(c.tree for c in choices), rows, np.array(right, dtype=float))


def fitted(parts: Sequence[Sequence[Compared]]) -> FloatArray:
    """Fit the weights to the plans of several parts, shape (len(WEIGHTS),).

    Those that are fitted to all plans choose one for each command, and the weights are fitted to
    these: what is stated is the probability of a plan that was chosen.
    """
    weights = _fitted(parts)
    return _fitted([[_chosen(c, weights) for c in own] for own in parts])


def _chosen(compared: Compared, weights: FloatArray) -> Compared:
    """Return a command with the plan alone that weights prefer."""
    if not len(compared.right):
        return compared
    i = compared.choose(weights)
    one = slice(i, i + 1)
    return replace(
        compared,
        trees=compared.trees[one],
        evidence=compared.evidence[one],
        right=compared.right[one],
    )


def _fitted(parts: Sequence[Sequence[Compared]]) -> FloatArray:
    counts = [
        np.full(len(c.right), COMMANDS / len(own) / len(c.right))
        for own in parts
        for c in own
        if len(c.right)
    ]
    seen = np.vstack([c.evidence for own in parts for c in own])
    right = np.concatenate([c.right for own in parts for c in own])
    times = np.concatenate(counts)
    both = np.concatenate((times * right, times * (1 - right)))
    return fit_curve(np.vstack((seen, seen)), np.repeat([True, False], len(right)), both)


def _row(name: str, own: Sequence[Compared], weights: FloatArray) -> str:
    first = sum(float(c.right[0]) for c in own if len(c.right))
    there = [(c, c.choose(weights)) for c in own if len(c.right)]
    right = np.array([c.right[i] for c, i in there])
    stated = expit(np.array([c.evidence[i] @ weights for c, i in there]))
    told = [
        Outcome(str(n), name, c.text, float(p), bool(c.right[i] > 0.5), "")
        for n, ((c, i), p) in enumerate(zip(there, stated, strict=True))
    ]
    sure = stated >= 0.9
    figures = (
        right.sum() / len(own),
        stated.sum() / len(own),
        float(np.square(stated - right).mean()),
        reliability(told)[0].value,
        risk_coverage(told).value,
        right[sure].mean() if sure.any() else np.nan,
    )
    shown = " | ".join(f"{figure:.3f}" for figure in figures)
    return f"| {name} | {len(own)} | {first / len(own):.3f} | {shown} | {sure.sum()} |"


def main() -> None:
    parser = parser_of("plan_weights", __doc__)
    parser.add_argument("names", nargs="*", default=CHOICE)
    parser.add_argument("--kept", type=Path, help="folder that keeps what was compared")
    parser.add_argument("--end-model", type=Path, help="file of the model of ends")
    options = parser.parse_args()
    ends = EndModel.from_bytes(options.end_model.read_bytes()) if options.end_model else None
    train, parts = options.train.split(","), dict[str, list[Compared]]()
    of_sets = cache(lambda: Grounder(learned_cost(train), end_model=ends))
    for name in options.names:
        kept = options.kept / f"{Path(name).name}.json" if options.kept else None
        if kept is None or not kept.exists():
            is_set = name in SETS
            parts[name] = list(of_set(name, of_sets()) if is_set else of_corpus(name, train, ends))
            if kept is not None:
                rows = [
                    (c.text, c.trees, c.evidence.tolist(), c.right.tolist()) for c in parts[name]
                ]
                kept.write_text(json.dumps(rows), encoding="utf-8")
        else:
            parts[name] = [
                Compared(
                    text,
                    tuple(trees),
                    np.array(seen, dtype=float).reshape(len(right), len(WEIGHTS)),
                    np.array(right),
                )
                for text, trees, seen, right in json.loads(kept.read_text(encoding="utf-8"))
            ]
    print(
        "| left out | commands | first | right | stated | Brier | ECE | under risk-coverage"
        " | right from .9 | of |"
    )
    for name, own in parts.items():
        others = [part for other, part in parts.items() if other != name]
        print(_row(name, own, fitted(others) if others else fitted([own])), flush=True)
    for key, weight in zip(WEIGHTS, fitted(list(parts.values())), strict=True):
        print(f'    "{key}": {weight:.2f},')


if __name__ == "__main__":
    main()
