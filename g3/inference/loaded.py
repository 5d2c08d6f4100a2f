"""What a loaded robot can't do before it has put its load down."""

from __future__ import annotations

from collections.abc import Sequence

from g3.groundings import PhysicalObject
from g3.inference.phrases import verb_class
from g3.inference.proposals import is_load
from g3.inference.roles import objects, spares
from g3.inference.state import State
from g3.inference.tree import Tree
from g3.language.lexicon import HANDLING_VERBS
from g3.language.negation import negated
from g3.language.similarity import lemma
from g3.language.words import figure_words


def load_in_the_way(tree: Tree, state: State) -> PhysicalObject | None:
    """The load on the forks, if a command first of all handles another one.

    That is so where the first clause that handles something names a load by words that
    are labels of one that stands about, and not of the one on the forks.
    """
    if state.held is None:
        return None
    held = state.thing(state.held)
    for root, sdc in enumerate(tree.sdcs):
        verbs = HANDLING_VERBS.intersection(verb_class(sdc).split("+"))
        if sdc.type != "EVENT" or not verbs or negated(sdc) or spares(tree, root, state.held):
            continue
        handled = objects(tree, root)
        if handled:
            words = figure_words(tree.nodes[handled[0]])
            others = (o for o in state.context.objects if o is not held and is_load(state, o.id))
            most = max((_labels_in(words, o.labels) for o in others), default=0)
            return held if most > _labels_in(words, held.labels) else None
        if "placing" in verbs:
            return None
    return None


def _labels_in(words: Sequence[str], labels: Sequence[str]) -> int:
    """How many of some words are labels."""
    own = [word for label in labels for word in label.split()]
    return int(lemma(words, own).any(axis=1).sum()) if words and own else 0
