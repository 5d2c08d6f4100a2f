"""Exhaustive search over small problems, to test the beam against.

Every combination of groundings of an OBJECT and the OBJECTs in it is scored by itself, one after
the other: nothing is shared with the beam but the factors' scores.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from g3.inference.potentials.cases import CandidateCase, FactorCase
from g3.inference.potentials.potential_registry import added
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.packed_scene import Group
from g3.inference.problem.phrases import is_complement


def best_groundings(
    tree: Tree, root: int, problem: GroundingProblem
) -> tuple[float, dict[int, Group]]:
    """The best groundings of an OBJECT of OBJECTs, each with one figure and one landmark at most.

    Returns
    -------
    tuple
        The sum of the factors' log-probabilities, and the groundings by node.
    """
    nodes = tree.all_below(root)
    own = [n for n in nodes if not tree.nodes[n].figure]
    best: tuple[float, dict[int, Group]] = (-np.inf, {})
    for groups in product(problem.scene.groups, repeat=len(own)):
        found = dict(zip(own, groups, strict=True))
        for n in reversed(nodes):
            if n not in found:
                found[n] = found[tree.below(n, ("f",), "OBJECT")[0]]
        if any(is_complement(tree.nodes[n]) and not _is_one(tree, n, found) for n in nodes):
            continue
        total = sum(_score(tree, n, found, problem) for n in nodes)
        if total > best[0]:
            best = (total, found)
    return best


def _is_one(tree: Tree, node: int, found: dict[int, Group]) -> bool:
    """Whether a clause and its landmark are grounded in the same thing."""
    return all(found[mark] == found[node] for mark in tree.below(node, ("l", "l2"), "OBJECT"))


def _score(tree: Tree, node: int, found: dict[int, Group], problem: GroundingProblem) -> float:
    marks = tree.below(node, ("l", "l2"), "OBJECT")
    bodies, index = problem.scene.indices([found[node], *(found[m] for m in marks)])
    batch = problem.scene.batch(
        "OBJECT",
        [tree.words[node]],
        np.zeros(1, dtype=np.intp),
        bodies,
        figure=index[:1],
        landmark=index[1:2] if marks else np.full(1, -1, dtype=np.intp),
    )
    score = float(problem.cost.log_probability(batch)[0])
    score += float(added(FactorCase(tree, node, batch, problem, [len(found[node])]))[0])
    if not tree.nodes[node].figure:
        score += float(added(CandidateCase(tree, node, problem, [found[node]], "figure", node))[0])
    return score
