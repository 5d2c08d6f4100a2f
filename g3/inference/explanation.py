"""Why things and actions were chosen: the features and words that spoke for each grounding.

What speaks for a thing is told by itself; what speaks for an action is told against its best rival,
for most features of actions are alike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from g3.features.batch import FactorBatch
from g3.features.registry import catalogue
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


def reasons_against(batch: FactorBatch, rows: tuple[int, int], scorer: Scorer) -> list[Reason]:
    """What speaks for the first of two rows rather than for the second, the weightiest first."""
    total: Counter[tuple[str, str]] = Counter()
    for row, sign in zip(rows, (1, -1), strict=True):
        for reason in scorer.reasons(batch.take(np.array([row]))):
            total[reason.feature.split(" (")[0], reason.word] += sign * reason.weight  # type: ignore[assignment]
    found = [Reason(feature, word, weight) for (feature, word), weight in total.items() if weight]
    return sorted(found, key=lambda r: (-abs(r.weight), r.feature, r.word))


def plain(reason: Reason) -> str:
    """A reason for people to read.

    >>> plain(Reason("labels/tire", "figure:tyre", 1.5))
    '"tyre" with tire (labels that the semantic map gives the figure: all of it, for a plural)'
    """
    name, column = reason.feature.split(" (")[0].split("/", 1)
    word = reason.word.split(":")[-1].replace("_", " ")
    about = {s.name: s.description for s in catalogue()}.get(name, name)
    what = column.replace("_", " ").replace(".", " ")
    says = f'"{word}" with ' if word else ""
    return f"{says}{what} ({about[:1].lower()}{about[1:].rstrip('.')})"
