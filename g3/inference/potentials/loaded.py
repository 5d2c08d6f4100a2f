"""What a load on the forks forbids, and what is meant because it is there."""

from __future__ import annotations

from collections.abc import Sequence
from math import log

from g3.actions.forklift_actions import is_load
from g3.inference.potentials.cases import CandidateCase, CommandCase
from g3.inference.potentials.potential_registry import HARD, Measured, potential
from g3.inference.problem.clause_roles import objects, spares
from g3.inference.problem.costs import Scorer
from g3.inference.problem.grounding_problem import things_of
from g3.inference.problem.phrases import is_bare, verb_class
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import field_words, figure_words
from g3.language.lexicon.word_sets import HANDLING_VERBS
from g3.language.similarity.word_similarity import lemma


@potential("load-in-the-way", kind="command", types=("EVENT",), roles=(), weight=HARD)
def load_in_the_way(case: CommandCase) -> str:
    """A command doesn't begin with another load than the one on the forks.

    It does where the first clause that handles something names a load by words that are labels
    of one that stands about, and not of the one on the forks.
    """
    tree, state = case.tree, case.problem.state
    if state.held is None:
        return ""
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
            in_the_way = most > _labels_in(words, held.labels)
            named = " ".join(held.labels)
            why = f"the {named} {held.id} is on the forks: have it put down first"
            return why if in_the_way else ""
        if "placing" in verbs:
            return ""
    return ""


@potential("known-verb", kind="command", types=("EVENT",), roles=(), weight=HARD)
def known_verb(case: CommandCase) -> str:
    """The model knows at least one verb of the command."""
    if not isinstance(case.problem.cost, Scorer):
        return ""
    known = {word for word in case.problem.cost.model.space_.words if word.startswith("relation:")}
    verbs = [sdc for sdc in case.tree.sdcs if field_words(sdc.relation)]
    for sdc in verbs:
        if any(f"relation:{word}" in known for word in field_words(sdc.relation)):
            return ""
    verb = " ".join(word.text for word in verbs[0].relation) if verbs else ""
    return f"nobody has taught the robot what {verb!r} means" if verb else ""


@potential("load-as-theme", kind="argument", types=("EVENT",), roles=("theme",), weight=log(0.1))
def load_as_theme(case: CandidateCase) -> Measured:
    """A plain noun means the load on the forks: "put the pallet down"."""
    held = case.problem.held
    if held is None or not is_bare(case.sdc):
        return False
    return case.each(lambda g: [t.id for t in things_of(g)] != [held])


def _labels_in(words: Sequence[str], labels: Sequence[str]) -> int:
    """How many of some words are labels."""
    own = [word for label in labels for word in label.split()]
    return int(lemma(words, own).any(axis=1).sum()) if words and own else 0
