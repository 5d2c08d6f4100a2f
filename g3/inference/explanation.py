"""Why things and actions were chosen: the features and words that spoke for each grounding.

They are told against the best rival, as most of what is so of the one is so of the other.
:mod:`g3.inference.aspects` puts them in words.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from g3.features.batch import FactorBatch
from g3.groundings import PhysicalObject
from g3.inference.meant import unmeant_scores
from g3.inference.phrases import factor_type, is_complement, is_pronoun
from g3.inference.scene import Group, Scene
from g3.inference.scoring import Reason, Scorer
from g3.inference.tree import Tree
from g3.sdc import Field


def reasons_for_things(
    tree: Tree, nodes: Mapping[int, tuple[Group, float]], scene: Scene, scorer: Scorer
) -> dict[int, tuple[Group | None, tuple[Reason, ...]]]:
    """The best other thing and the reasons, by the nodes of OBJECTs and PLACEs.

    Where several clauses name one thing, as "the pallet" and "the pallet on the left", the
    outermost has the reasons of all. A PLACE has no rival.
    """
    found: dict[int, tuple[Group | None, tuple[Reason, ...]]] = {}
    known: set[int] = set()
    for node, sdc in enumerate(tree.nodes):
        if node not in nodes or node in known or is_pronoun(sdc):
            continue
        if sdc.type == "PLACE":
            batch = _factor(tree, node, nodes, scene, [nodes[node][0]])
            found[node] = None, tuple(scorer.reasons(batch))
        elif sdc.type == "OBJECT":
            clauses = [n for n in _same_thing(tree, node) if n in nodes]
            known.update(clauses)
            others, batches = _with_others(tree, clauses, nodes, scene)
            found[node] = _against_best(tree, others, batches, scorer)
    return found


def _with_others(
    tree: Tree, clauses: Sequence[int], nodes: Mapping[int, tuple[Group, float]], scene: Scene
) -> tuple[list[Group], dict[int, FactorBatch]]:
    """What clauses might name instead, and their factors with what they name and with these."""
    chosen = nodes[clauses[0]][0]
    taken = {*_ids(chosen), scene.context.agent_id}
    others = [group for group in scene.groups if not _ids(group) & taken]
    return [chosen, *others], {
        n: _factor(tree, n, nodes, scene, [nodes[n][0], *others]) for n in clauses
    }


def _against_best(
    tree: Tree, groups: Sequence[Group], batches: Mapping[int, FactorBatch], scorer: Scorer
) -> tuple[Group | None, tuple[Reason, ...]]:
    """The best of all groups but the first, and what speaks for the first rather than for it."""
    if len(groups) == 1:
        return None, tuple(r for batch in batches.values() for r in scorer.reasons(batch))
    sizes = [len(group) for group in groups]
    unmeant = {n: unmeant_scores(tree, n, batch, sizes) for n, batch in batches.items()}
    total = np.sum([scorer.log_probability(b) + unmeant[n] for n, b in batches.items()], axis=0)
    best = 1 + int(np.argmax(total[1:]))
    reasons = [r for b in batches.values() for r in reasons_against(b, (0, best), scorer)]
    which = sum(float(scores[0] - scores[best]) for scores in unmeant.values())
    return groups[best], tuple(weightiest([*reasons, *told_besides({"which": which})]))


def _ids(group: Group) -> set[str]:
    return {g.id for g in group if isinstance(g, PhysicalObject)}


def _same_thing(tree: Tree, node: int) -> list[int]:
    """An OBJECT and the clauses in it that name the same thing."""
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
    """A clause's factor with each of some figures, and with the landmarks that it has.

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
    """What speaks for the first of two rows rather than for the second, the weightiest first."""
    total: Counter[tuple[str, str]] = Counter()
    for row, sign in zip(rows, (1, -1), strict=True):
        for reason in scorer.reasons(batch.take(np.array([row]))):
            total[reason.feature.split(" (")[0], reason.word] += sign * reason.weight  # type: ignore[assignment]
    found = [Reason(feature, word, weight) for (feature, word), weight in total.items() if weight]
    return weightiest(found)


def weightiest(reasons: Iterable[Reason]) -> list[Reason]:
    """Reasons by how much they weigh."""
    return sorted(reasons, key=lambda r: (-abs(r.weight), r.feature, r.word))


def told_besides(scores: Mapping[str, float]) -> list[Reason]:
    """Reasons that no feature is: what a goal adds, and what words rule out."""
    return [Reason(f"besides/{name}", "", score) for name, score in scores.items() if score]
