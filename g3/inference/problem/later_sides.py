"""Sides as they are when a clause begins, not at the start: "on your left then", "now ahead".

People tell most sides as they are at the start, also of what is done later. They tell them as the
robot will see them where they say so, and mostly where it has just turned: "turn around and lift
the crate on your left". What is nearest is so from where it is then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from g3.inference.problem.asked_spots import scene_asked
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked, frame
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import Field, all_words

_ARGUMENTS: tuple[Field, ...] = ("f", "l", "l2")


def is_seen_later(tree: Tree, node: int) -> bool:
    """Check that a clause, or its noun, tells a side as it is when its clause begins."""
    return node in tree.once(_seen_later)


def any_seen_later(tree: Tree) -> bool:
    """Check that any clause tells a side as it is when its clause begins."""
    return bool(tree.once(_seen_later))


def says_later(tree: Tree, node: int) -> bool:
    """Check that the words of such a clause say so: it isn't only told after a turn."""
    return tree.once(_seen_later).get(node, False)


def _seen_later(tree: Tree) -> dict[int, bool]:
    """Such clauses, and whether words say so."""
    found: dict[int, bool] = {}
    moved: frozenset[str] = frozenset()
    for root in asked(tree):
        is_event = tree.nodes[root].type == "EVENT"
        follows = _follows(tree, root)
        is_elsewhere = "going" in moved or follows
        is_turned = "turning" in moved or follows or (is_elsewhere and not is_event)
        for argument in _arguments(tree, root):
            below = tree.all_below(argument)
            says = _says_later(tree, below)
            turned = is_turned and any(_is_own_side(tree, n) for n in below)
            nearest = is_elsewhere and any(_is_nearest(tree, n) for n in below)
            if says or turned or nearest:
                found |= dict.fromkeys(below, says or follows)
        if is_event:
            own = frame(tree, root)
            moved = frozenset() if own.handles else moved | own.classes
    return found


def _arguments(tree: Tree, root: int) -> Iterator[int]:
    """The outermost OBJECTs and PLACEs of a clause that asks for something, or it itself."""
    if tree.nodes[root].type in ("OBJECT", "PLACE"):
        yield root
    for node in tree.all_below(root):
        if tree.nodes[node].type in ("EVENT", "PATH"):
            yield from tree.below(node, _ARGUMENTS, "OBJECT", "PLACE")


def _follows(tree: Tree, root: int) -> bool:
    """Check that a clause says what was done before: "when you are there", "once turned"."""
    events = (tree.nodes[n] for n in tree.all_below(root) if tree.nodes[n].type == "EVENT")
    return any(not WORDS["when"].isdisjoint(bare_words(sdc.relation)) for sdc in events)


def _says_later(tree: Tree, below: Sequence[int]) -> bool:
    relations = [word for n in below for word in tree.nodes[n].relation]
    tells_side = SIDES & concepts(field_words(relations))
    return bool(tells_side) and not WORDS["later"].isdisjoint(bare_words(relations))


def _is_own_side(tree: Tree, node: int) -> bool:
    sdc = tree.nodes[node]
    sides = SIDES & concepts(field_words(sdc.relation))
    is_yours = not WORDS["you"].isdisjoint(bare_words(all_words(sdc)))
    return bool(sides - {"back"}) and (is_yours or (sides == {"front"} and not sdc.landmark1))


def _is_nearest(tree: Tree, node: int) -> bool:
    """Check that a clause tells a thing by how near to the robot it is: "the closest crate"."""
    sdc = tree.nodes[node]
    ranks = not WORDS["nearest"].isdisjoint(field_words((*sdc.words, *sdc.relation)))
    marks = {bare(word.text) for mark in sdc.landmark1 for word in all_words(mark)}
    return ranks and marks <= WORDS["you"]


def seen_from(tree: Tree, node: int, problem: GroundingProblem) -> GroundingProblem:
    """Return the problem of a clause: where its side is told as it is later, of the state then."""
    state = problem.later
    if state is None or not is_seen_later(tree, node):
        return problem
    return replace(problem, state=state, scene=scene_asked(tree, state), later=None, leaves={})
