"""Evidence of all words of a command for the load that is picked up first.

Clauses may be wrong, and their own factors see few words. So the search multiplies by the learned
probability of the load given the whole command (:mod:`g3.learning.load_choice`), once: where the
first clause that handles something is grounded.

It counts where a load has a label that no annotated clause was ever about. Where the factors of
OBJECTs know all labels, they know better: they see which words are about which thing.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from g3.features.sets.order import is_ordinal
from g3.groundings import PhysicalObject
from g3.inference.potentials.cases import CandidateCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import is_source
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Scorer
from g3.inference.problem.frames import asked, frame, spares
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.loads_of_state import loads_of, words_of
from g3.inference.problem.phrases import (
    is_complement,
    is_pronoun,
    is_singled_out,
    names_forks,
    names_robot,
)
from g3.language.discourse.anaphora import anaphors
from g3.language.discourse.groups import noun_words
from g3.language.lexicon.concepts import BESIDE, concepts
from g3.language.lexicon.field_words import bare, field_words, figure_words, normalise
from g3.language.lexicon.tables import WORDS
from g3.language.similarity.presence import is_called
from g3.learning.load_choice import Load, LoadChoice, LoadChooser
from g3.sdc.clauses import SDC, Span, all_words

WEIGHT = -8.0
"""Of 3, 5 and 8, what is right most often on random tasks, in folds by world."""


@potential("command-load", kind="argument", types=("EVENT",), roles=("theme",), weight=WEIGHT)
def command_load(case: CandidateCase) -> Measured:
    """The first load handled is the one that all words of the command tell, as learned."""
    chooser = _chooser(case.problem)
    if chooser is None or case.problem.held is not None:
        return False
    if case.within != first_handling(case.tree, case.problem):
        return False
    taken_off = any(is_source(case.tree.nodes[n]) for n in frame(case.tree, case.within).ways)
    named = _named(case)
    if _has_landmark(named) and not _names_kind(named, case.problem):
        return False
    says_which = taken_off or _says_more(named)
    says_kind = _has_label(named, case.problem)
    if says_kind and says_which:
        return False
    behind = _behind(case, chooser, kinds=not says_kind, alike=not says_which)
    most = max(behind.values())

    def measure(group: tuple[object, ...]) -> float:
        own = [behind.get(g.id, most) for g in group if isinstance(g, PhysicalObject)]
        return float(np.mean(own)) if own else most

    return np.array([measure(group) for group in case.groups])


def _chooser(problem: GroundingProblem) -> LoadChooser | None:
    """Return the learned chooser; None where OBJECTs' factors know all labels."""
    cost, loads = problem.cost, _possible_loads(problem)
    if not isinstance(cost, Scorer) or len(loads) < 2:
        return None
    known = _knows(cost, {label for load in loads.values() for label in load.labels})
    return None if known else cost.model.load_chooser_


def _possible_loads(problem: GroundingProblem) -> dict[str, Load]:
    """Return the loads that the command doesn't rule out, by id."""
    loads = loads_of(problem.state)
    return {name: load for name, load in loads.items() if name not in problem.ruled_out}


def _named(case: CandidateCase) -> SDC:
    """The clause that names the load: of "drive to the crate by the cone and lift it" the crate."""
    known, node = case.tree.once(_antecedents), case.node
    while is_pronoun(case.tree.nodes[node]) and node in known:
        node = known[node]
    sdc = case.tree.nodes[node]
    noun = case.tree.left_out(sdc) if sdc.is_leaf else ()
    return replace(sdc, words=(*sdc.words[:-1], *noun)) if noun else sdc


def _antecedents(tree: Tree) -> dict[int, int]:
    """The most probable antecedent of each pronoun."""
    return {a.index: a.antecedents[0].index for a in anaphors(tree.sdcs) if a.antecedents}


def _says_more(sdc: SDC) -> bool:
    """Check that words say which of several alike is meant otherwise than by left and right.

    The learned choice sees sides and distances, but neither landmarks nor numbers.
    """
    words = field_words(all_words(sdc))
    aside = concepts(words) & {"left", "right"} and not any(map(is_ordinal, words))
    return is_singled_out(sdc) and (_has_landmark(sdc) or not aside)


def _has_landmark(sdc: SDC) -> bool:
    """Check that words say what a load stands by or on: "on the left of the truck"."""
    said = concepts(field_words(sdc.relation)) & (BESIDE | {"on"})
    marks = (bare(word.text) for mark in sdc.landmark1 for word in all_words(mark))
    return bool(said and sdc.landmark1) and WORDS["you"].isdisjoint(marks)


def _has_label(named: SDC, problem: GroundingProblem) -> bool:
    if any(map(set(_noun(named)).issuperset, _labels(problem)[0])):
        return True
    noun = noun_words(named)[-1:]
    return any(
        is_called(word, x.labels) for word in noun for x in _possible_loads(problem).values()
    )


def _names_kind(named: SDC, problem: GroundingProblem) -> bool:
    """Check that the noun names a kind of load: not "the pallet that is on the truck"."""
    common = _labels(problem)[1]
    return not WORDS["generic"].union(WORDS["articles"], *common).issuperset(_noun(named))


def _noun(sdc: SDC) -> tuple[str, ...]:
    """Normal forms of an OBJECT's words but for its modifiers."""
    while sdc.figure and not is_complement(sdc):
        sdc = sdc.figure[0]
    return field_words(all_words(sdc))


def _labels(problem: GroundingProblem) -> tuple[list[set[str]], list[set[str]]]:
    """Normal forms of each label that tells loads apart, and of each other one that loads have."""
    loads = tuple(_possible_loads(problem).values())
    telling = {label for own in LoadChoice((), loads).telling for label in own}
    common = {label for load in loads for label in load.labels} - telling
    told, shared = (
        [set(map(normalise, label.split())) for label in labels] for labels in (telling, common)
    )
    return told, shared


def first_handling(tree: Tree, problem: GroundingProblem) -> int | None:
    """The first top-level clause that handles a thing; None if none does."""
    own = {normalise(label) for label in problem.state.context.agent.labels}
    for root in asked(tree):
        done = frame(tree, root)
        if not done.handles or done.negated or spares(tree, root, None):
            continue
        themes = [tree.nodes[node] for node in done.objects[:1]]
        if any(
            not (names_forks(t) or names_robot(t) or own.intersection(figure_words(t)))
            for t in themes
        ):
            return root
    return None


def _behind(
    case: CandidateCase, chooser: LoadChooser, *, kinds: bool, alike: bool
) -> Mapping[str, float]:
    """Return how much less probable each load is than the most probable one, by id; in nats.

    With `kinds` it counts which labels it has, and with `alike` which one it is among those.
    """
    loads = _possible_loads(case.problem)
    words = words_of(case.tree, _told_besides(case))
    score = chooser.log_probability(LoadChoice(words, tuple(loads.values())))
    best: dict[frozenset[str], float] = {}
    for load, own in zip(loads.values(), score.tolist(), strict=True):
        kind = frozenset(load.labels)
        best[kind] = max(best.get(kind, -np.inf), own)
    of_kind = np.array([best[frozenset(load.labels)] for load in loads.values()])
    found = kinds * of_kind + alike * (score - of_kind)
    return dict(zip(loads, (found.max() - found).tolist(), strict=True))


def _told_besides(case: CandidateCase) -> set[Span]:
    """Words for other things than the load: "drive around the boxes, lift the pallet by them".

    So are those for what must be left alone, or is handled, too: "lift the tires, not the crate".
    """
    tree, named = case.tree, _named(case)
    marks = list(named.landmark1) if _has_landmark(named) else []
    meant = is_pronoun(case.sdc) or bool(tree.left_out(case.sdc))
    before = [n for n in asked(tree) if n < case.within]
    ways = [tree.nodes[p] for n in before for p in frame(tree, n).ways]
    marks += [mark for way in ways if not meant or _leads_past(way) for mark in way.landmark1]
    nodes, others = tree.left_alone
    apart = {
        n
        for own in (frame(tree, root) for root in asked(tree) if root != case.within)
        if own.negated or own.handles
        for n in own.objects
        if tree.nodes[n] is not named
    }
    marks += [*others, *(tree.nodes[n] for n in nodes | apart)]
    return {word for mark in marks for word in all_words(mark)}


def _leads_past(way: SDC) -> bool:
    return not (WORDS["around"] | WORDS["passing"]).isdisjoint(
        bare(word.text) for word in way.relation
    )


def _knows(cost: Scorer, labels: Collection[str]) -> bool:
    bases = cost.model.space_.bases
    return all(f"OBJECT/labels/{label}" in bases for label in labels)
