"""Scores of a command's nouns without landmarks: of all of them in one batch."""

from __future__ import annotations

import numpy as np

from g3.groundings import FloatArray
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, Scorer
from g3.inference.problem.packed_scene import Scene
from g3.inference.problem.phrases import factor_type, is_pronoun


def leaf_scores(tree: Tree, scene: Scene, cost: Cost) -> dict[int, FloatArray]:
    """Log-probabilities of all of a scene's groups for OBJECTs without others below, by node.

    Only of a learned cost: one that is random depends on what else is in a batch.
    """
    if not isinstance(cost, Scorer):
        return {}
    nodes = [n for n in range(len(tree.nodes)) if _is_leaf(tree, n)]
    if not nodes:
        return {}
    groups = np.arange(len(scene.groups))
    batch = scene.batch(
        "OBJECT",
        [tree.words[n] for n in nodes],
        np.repeat(np.arange(len(nodes)), len(groups)),
        figure=np.tile(groups, len(nodes)),
    )
    scores = cost.log_probability(batch).reshape(len(nodes), -1)
    return dict(zip(nodes, scores, strict=True))


def _is_leaf(tree: Tree, node: int) -> bool:
    sdc = tree.nodes[node]
    if sdc.is_implicit or factor_type(sdc) != "OBJECT" or is_pronoun(sdc):
        return False
    return not tree.below(node, ("f", "l", "l2"), "OBJECT", "PLACE", "PATH")
