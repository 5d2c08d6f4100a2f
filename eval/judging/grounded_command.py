"""An annotated command's words in a world: its own, or that of another video of the same site."""

from __future__ import annotations

from dataclasses import dataclass

from eval.judging.execution import counterparts, replayed
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.geometry.footprints import apart
from g3.groundings import PhysicalObject, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.phrases import is_complement
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import field_words, normalise
from g3.language.lexicon.word_sets import (
    ARTICLES,
    CARDINALS,
    LADEN,
    ORDINALS,
    OTHERS,
    QUANTIFIERS,
    THESE,
)
from g3.short_repr import short_repr

Things = frozenset[str]
"""Ids of things."""
FIXED_M = 1.0
"""Largest distance between two maps at which an object hasn't been moved, in metres."""
_FUNCTION = frozenset(
    normalise(word)
    for word in ARTICLES | LADEN | OTHERS | QUANTIFIERS | THESE | set(ORDINALS) | set(CARDINALS)
)


@short_repr
@dataclass(frozen=True)
class GroundedCommand:
    """A command's clauses with their annotated groundings in a world."""

    tree: Tree
    state: State
    """The world before anything is done."""
    own: bool
    """True if this is the annotated world."""
    annotated: tuple[Things, ...]
    """Annotated object ids of each clause."""
    things: tuple[Things, ...]
    """Ids of the same objects in this world, where they exist in it."""
    labels: tuple[frozenset[tuple[str, ...]], ...]
    """Labels of these objects, for each clause."""
    places: tuple[tuple[Place, ...], ...]
    """Annotated regions of each clause."""
    fixed: Things
    """Objects that stand where they stood when they were annotated."""
    state_after: State | None
    """The world after its own log; None in another world."""

    @property
    def robot(self) -> str:
        """Id of the robot in the world."""
        return self.state.context.agent_id

    def alike(self, node: int) -> Things:
        """Return things that an OBJECT's noun names as well as its groundings.

        A noun that consists of labels names all things with these labels: "the pallet of tires" any
        pallet of tires, "the pallet" any pallet. A more specific noun, such as "the box pallet",
        names things with all the labels of its groundings.
        """
        said = self._noun(node)
        others = [o for o in self.state.context.objects if o.id != self.robot]
        found = set()
        for labels in self.labels[node]:
            known = {normalise(label): label for label in labels}
            wanted = {known[w] for w in said} if said and said <= known.keys() else set(labels)
            found |= {o.id for o in others if wanted <= set(o.labels)}
        return frozenset(found)

    def _noun(self, node: int) -> set[str]:
        """Return an OBJECT's normalised words that describe its kind."""
        nodes, here = self.tree.nodes, node
        said = list(noun_leaf(nodes[node]).words)
        while nodes[here].figure:
            inside = self.tree.children[here]
            for mark in inside.get("l", ()):
                # "Of tires" and "containing tires" name the same thing once more.
                if self.annotated[mark] == self.annotated[node] or is_complement(nodes[here]):
                    said += noun_leaf(nodes[mark]).words
            here = inside["f"][0]
        words = set(field_words(said)) - _FUNCTION
        return {word for word in words if not concepts([word])}


def grounded_command(annotation: Annotation, start: State) -> GroundedCommand:
    """Ground a command's annotation in the start state of a world."""
    own, world = annotation.context, start.context
    same = own.id == world.id
    now = {o.id: o.id for o in own.objects} if same else counterparts(own, world)
    then = start_state(own)
    fixed = {
        n for o, n in now.items() if apart(then.thing(o).prism, start.thing(n).prism) < FIXED_M
    }
    now[own.agent_id] = world.agent_id
    grounded = [
        groundings if right is not False else ()
        for groundings, right in zip(annotation.groundings, annotation.correct, strict=True)
    ]
    things = [[g for g in gs if isinstance(g, PhysicalObject)] for gs in grounded]
    return GroundedCommand(
        Tree(annotation.sdcs),
        start,
        same,
        tuple(frozenset(o.id for o in several) for several in things),
        tuple(frozenset(now[o.id] for o in several if o.id in now) for several in things),
        tuple(frozenset(o.labels for o in gs if o.id != own.agent_id) for gs in things),
        tuple(tuple(g for g in gs if isinstance(g, Place)) for gs in grounded),
        frozenset(fixed),
        replayed(own, own) if same else None,
    )
