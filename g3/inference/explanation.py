"""Why things were chosen: the features and words that spoke for each grounding."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from g3.inference.scene import Group, Scene
from g3.inference.scoring import Reason, Scorer
from g3.inference.things import Tree, is_pronoun

MOST = 5
"""How many reasons are given for a grounding."""


def reasons_for_things(
    tree: Tree, nodes: Mapping[int, tuple[Group, float]], scene: Scene, scorer: Scorer
) -> dict[int, tuple[Reason, ...]]:
    """The weightiest reasons for the groundings of OBJECTs and PLACEs, by node."""
    found: dict[int, tuple[Reason, ...]] = {}
    for node, (group, _) in nodes.items():
        sdc = tree.nodes[node]
        if sdc.type not in ("OBJECT", "PLACE") or is_pronoun(sdc):
            continue
        below = tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
        mark = tuple(g for n in below if n in nodes for g in nodes[n][0])
        bodies, index = scene.indices([group, *([mark] if mark else [])])
        batch = scene.batch(
            sdc.type,
            [tree.words[node]],
            np.zeros(1, dtype=np.intp),
            bodies,
            figure=index[:1],
            landmark=index[1:] if mark else np.full(1, -1, dtype=np.intp),
        )
        found[node] = tuple(scorer.reasons(batch)[:MOST])
    return found
