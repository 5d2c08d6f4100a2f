"""Candidates that only some words ask for: far spots, corners, so many things."""

from __future__ import annotations

from g3.actions.grounding_candidates import SpotsAsked, object_groups
from g3.actions.robot_state import State
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.packed_scene import Scene, scene_of
from g3.language.discourse.groups import group
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare_words, field_words
from g3.language.lexicon.measures import metres_said
from g3.language.lexicon.tables import WORDS

FAR_M = 3.0
"""Nearer spots are there anyway: who says "a few feet" or "a metre" doesn't measure."""
PAIR = 2
"""Pairs are always candidates."""


def spots_asked(tree: Tree, node: int) -> SpotsAsked:
    """Return the spots that the words of a PLACE, or of another clause for a place, ask for."""
    sdc = tree.nodes[node]
    relation = field_words(sdc.relation)
    said = concepts(relation)
    apart = metres_said(bare_words(sdc.relation))
    return SpotsAsked(
        apart=apart if apart is not None and apart > FAR_M else None,
        corner="corner" in relation,
        side="on" in said and bool(said & SIDES),
        top="top" in relation or (said == {"on"} and node in tree.once(_stacked)),
    )


def _stacked(tree: Tree) -> frozenset[int]:
    """Clauses in the one that says where something is stacked."""
    stacks = (
        n
        for n, sdc in enumerate(tree.nodes)
        if sdc.type == "EVENT" and WORDS["stacking"].intersection(field_words(sdc.relation))
    )
    return frozenset(below for n in stacks for below in tree.all_below(n))


def scene_asked(tree: Tree, state: State) -> Scene:
    """A state's things packed, with the groups that a command may name."""
    return scene_of(state.context, object_groups(state.context, state.held, counts_said(tree)))


def counts_said(tree: Tree) -> tuple[int, ...]:
    """Return the numbers of things that OBJECTs name, where they are more than two."""
    said = {group(sdc).count or 0 for sdc in tree.nodes if sdc.type == "OBJECT" and sdc.is_leaf}
    return tuple(sorted(count for count in said if count > PAIR))
