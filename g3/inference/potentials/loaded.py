"""Rules about a load on the forks."""

from __future__ import annotations

from math import log

from g3.actions.robot_state import is_load
from g3.geometry.plane import BoolArray
from g3.inference.potentials.cases import CandidateCase, CommandCase, FactorCase
from g3.inference.potentials.meant import UNLIKELY
from g3.inference.potentials.potential_registry import HARD, Measured, potential
from g3.inference.problem.asked_kinds import asked_kinds
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, Scorer
from g3.inference.problem.frames import asked, frame, in_order, spares
from g3.inference.problem.grounding_problem import things_of
from g3.inference.problem.phrases import is_uncounted, names_held
from g3.language.lexicon.field_words import field_words, figure_words
from g3.language.similarity.word_similarity import labels_in


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
    order = in_order(tree, holds=True)
    for own in (frame(tree, n) for n in order if tree.nodes[n].type == "EVENT"):
        if not own.handles or own.negated or spares(tree, own.node, state.held):
            continue
        if own.theme is not None:
            if names_held(tree.nodes[own.theme]):
                return ""
            words = figure_words(tree.nodes[own.theme])
            others = (o for o in state.context.objects if o is not held and is_load(state, o.id))
            most = max((labels_in(words, o.labels) for o in others), default=0)
            in_the_way = most > labels_in(words, held.labels)
            named = " ".join(held.labels)
            why = f"the {named} {held.id} is on the forks: have it put down first"
            return why if in_the_way else ""
        if own.places_load:
            return ""
    return ""


@potential("held-said", kind="factor", types=("OBJECT",), weight=2 * UNLIKELY)
def held_said(case: FactorCase) -> Measured:
    """A load that the robot is said to have is on its forks: "put down what you have"."""
    held = case.problem.state.held
    if held is None or not names_held(case.sdc):
        return False
    ids = [o.id for o in case.problem.state.context.objects]
    other: BoolArray = case.batch.figure != ids.index(held)
    return other


@potential("known-verb", kind="command", types=("EVENT",), roles=(), weight=HARD)
def known_verb(case: CommandCase) -> str:
    """A command has a verb that is known, or says what it is about, or where to."""
    tree = case.tree
    verbs = [n for n in asked(tree) if tree.nodes[n].relation]
    if not verbs or any(_says_something(tree, n, case.problem.cost) for n in verbs):
        return ""
    return f"nobody has taught the robot what {frame(tree, verbs[0]).text!r} means"


def _says_something(tree: Tree, node: int, cost: Cost) -> bool:
    own, sdc = frame(tree, node), tree.nodes[node]
    if sdc.type != "EVENT" or asked_kinds(tree, node) or (own.classes and not own.guessed):
        return True
    if own.objects or own.places or own.paths or own.directions or own.end is not None:
        return True
    known = cost.model.space_.words if isinstance(cost, Scorer) else ()
    return any(f"relation:{word}" in known for word in field_words(sdc.relation))


@potential("load-as-theme", kind="argument", types=("EVENT",), roles=("theme",), weight=log(0.1))
def load_as_theme(case: CandidateCase) -> Measured:
    """A plain noun means the load on the forks: "put the pallet down", "put your tires down"."""
    held = case.problem.held
    if held is None or not is_uncounted(case.sdc):
        return False
    return case.each(lambda g: [t.id for t in things_of(g)] != [held])
