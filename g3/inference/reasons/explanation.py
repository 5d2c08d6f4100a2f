"""Reasons for chosen things and actions: features and words in favour of each grounding.

They are compared with the best rival, as most of what is so of the one is so of the other.
:mod:`g3.inference.reasons.aspects` puts them in words.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from g3.features.factor_batch import FactorBatch
from g3.geometry.footprints import centre
from g3.groundings import FloatArray, Place, object_ids
from g3.inference.potentials.cases import CandidateCase, FactorCase
from g3.inference.potentials.potential_registry import Case, added_by
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.packed_scene import Group, Scene
from g3.inference.problem.phrases import factor_type, is_complement, is_pronoun
from g3.inference.problem.scoring import Reason, Scorer
from g3.sdc.clauses import Field

BESIDES = "besides/"
"""Prefix of the names of reasons that are no features."""


class Grounded(Protocol):
    """A plan as the search returns it."""

    @property
    def nodes(self) -> Mapping[int, tuple[Group, float]]:
        """Groundings of clauses."""
        ...

    @property
    def problems(self) -> Mapping[int, GroundingProblem]:
        """Problems in which the clauses were grounded."""
        ...


def reasons_for_things(
    tree: Tree, plan: Grounded, problem: GroundingProblem, scorer: Scorer
) -> dict[int, tuple[Group | None, tuple[Reason, ...]]]:
    """Return the best other thing and the reasons, by the nodes of OBJECTs and PLACEs.

    Where several clauses name one thing, as "the pallet" and "the pallet on the left", the
    outermost has the reasons of all. A PLACE has no rival.
    """
    found: dict[int, tuple[Group | None, tuple[Reason, ...]]] = {}
    known: set[int] = set()
    nodes, scene = plan.nodes, problem.scene
    for node, sdc in enumerate(tree.nodes):
        if node not in nodes or node in known or is_pronoun(sdc):
            continue
        own = plan.problems.get(node, problem)
        if sdc.type == "PLACE":
            group = nodes[node][0]
            batch = _factor(tree, node, nodes, scene, [group])
            told = told_besides((name, x[0]) for name, x in _ruled(tree, node, batch, own, [group]))
            found[node] = None, tuple(weightiest([*scorer.reasons(batch), *told]))
        elif sdc.type == "OBJECT":
            clauses = [n for n in _same_thing(tree, node) if n in nodes]
            known.update(clauses)
            others, batches = _with_others(tree, clauses, nodes, scene)
            ruled = [r for n, b in batches.items() for r in _ruled(tree, n, b, own, others)]
            found[node] = _against_best(others, list(batches.values()), ruled, scorer)
    return found


def _ruled(
    tree: Tree, node: int, batch: FactorBatch, problem: GroundingProblem, groups: Sequence[Group]
) -> list[tuple[str, FloatArray]]:
    """Return the contributions of potentials to groundings of a clause, by name."""
    cases: list[Case] = [FactorCase(tree, node, batch, problem, [len(group) for group in groups])]
    if tree.nodes[node].is_leaf:
        cases.append(CandidateCase(tree, node, problem, groups, "figure", node))
    return [item for case in cases for item in added_by(case).items()]


def _with_others(
    tree: Tree, clauses: Sequence[int], nodes: Mapping[int, tuple[Group, float]], scene: Scene
) -> tuple[list[Group], dict[int, FactorBatch]]:
    """Yield the alternatives of clauses, with the factors of these and of the choices."""
    chosen = nodes[clauses[0]][0]
    taken = {*_members(chosen), scene.context.agent_id}
    others = [group for group in scene.groups if not _members(group) & taken]
    return [chosen, *others], {
        n: _factor(tree, n, nodes, scene, [nodes[n][0], *others]) for n in clauses
    }


def _against_best(
    groups: Sequence[Group],
    batches: Sequence[FactorBatch],
    ruled: Sequence[tuple[str, FloatArray]],
    scorer: Scorer,
) -> tuple[Group | None, tuple[Reason, ...]]:
    """Return the best group but the first, and the reasons for the first rather than for it.

    Parameters
    ----------
    ruled
        Contributions of potentials to the groups, by name.
    """
    if len(groups) == 1:
        return None, tuple(r for batch in batches for r in scorer.reasons(batch))
    fits = [scorer.log_probability(batch) for batch in batches]
    total = np.sum([*fits, *(scores for _, scores in ruled)], axis=0)
    best = 1 + int(np.argmax(total[1:]))
    reasons = [r for batch in batches for r in reasons_against(batch, (0, best), scorer)]
    told = told_besides((name, scores[0] - scores[best]) for name, scores in ruled)
    return groups[best], tuple(weightiest([*reasons, *told]))


def _members(group: Group) -> set[object]:
    """Return ids of a group's objects, and middles of its places, whose heights may change."""
    places = (g for g in group if isinstance(g, Place))
    return {*object_ids(group), *(tuple(centre(place.prism).round(3)) for place in places)}


def _same_thing(tree: Tree, node: int) -> list[int]:
    """Return an OBJECT and the clauses in it that name the same thing."""
    found = [node]
    for n in found:
        fields: tuple[Field, ...] = ("f", "l") if is_complement(tree.nodes[n]) else ("f",)
        found += [c for c in tree.below(n, fields, "OBJECT") if not is_pronoun(tree.nodes[c])]
    return found


def _factor(
    tree: Tree,
    node: int,
    nodes: Mapping[int, tuple[Group, float]],
    scene: Scene,
    figures: Sequence[Group],
) -> FactorBatch:
    """Return a clause's factor with each of some figures, and with its landmarks.

    A complement's landmark is the figure itself.
    """
    sdc = tree.nodes[node]
    below = tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
    mark = tuple(g for n in below if n in nodes for g in nodes[n][0])
    bodies, index = scene.indices([*figures, *([mark] if mark else [])])
    figure = index[: len(figures)]
    own = figure if is_complement(sdc) else np.full(len(figures), index[-1])
    return scene.batch(
        factor_type(sdc),
        [tree.words[node]],
        np.zeros(len(figures), dtype=np.intp),
        bodies,
        figure=figure,
        landmark=own if mark else np.full(len(figures), -1, dtype=np.intp),
    )


def reasons_against(batch: FactorBatch, rows: tuple[int, int], scorer: Scorer) -> list[Reason]:
    """Return the reasons for the first of two rows over the second, the weightiest first."""
    total: Counter[tuple[str, str]] = Counter()
    for row, sign in zip(rows, (1, -1), strict=True):
        for reason in scorer.reasons(batch.take(np.array([row]))):
            total[reason.feature.split(" (")[0], reason.word] += sign * reason.weight  # type: ignore[assignment]
    found = [Reason(feature, word, weight) for (feature, word), weight in total.items() if weight]
    return weightiest(found)


def weightiest(reasons: Iterable[Reason]) -> list[Reason]:
    """Sort reasons by their weight, the largest first."""
    return sorted(reasons, key=lambda r: (-abs(r.weight), r.feature, r.word))


def told_besides(scores: Iterable[tuple[str, float | FloatArray]]) -> list[Reason]:
    """Return reasons that are no features: potentials by their names, and the scores of goals."""
    return [Reason(f"{BESIDES}{name}", "", float(score)) for name, score in scores if score]
