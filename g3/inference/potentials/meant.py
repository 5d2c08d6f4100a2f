"""Groundings that words rule out for an OBJECT, whatever the model has learned of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import log

import numpy as np

from g3.actions.robot_state import is_load
from g3.geometry.plane import BoolArray
from g3.groundings import Place
from g3.inference.plan_things import NAMES
from g3.inference.potentials.cases import CandidateCase, FactorCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import names_again
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import Group, things_of
from g3.inference.problem.phrases import (
    is_bare,
    is_floor,
    names_other,
    names_robot,
    names_same,
    names_thing,
)
from g3.language.discourse.groups import group as group_of
from g3.language.discourse.groups import noun_leaf, noun_words
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import BESIDE, SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.similarity.presence import best_naming, is_called
from g3.language.similarity.word_similarity import labels_in
from g3.sdc.clauses import all_words

UNLIKELY = log(0.01)


def _ids(group: Group) -> set[str]:
    return {thing.id for thing in things_of(group)}


def _places(group: Group) -> list[Place]:
    return [g for g in group if isinstance(g, Place)]


def _says(case: CandidateCase, test: Callable[[Group], bool]) -> Measured:
    """Apply a test to each candidate, where a noun is no place's name."""
    return not case.called and case.each(test)


@potential("place-name", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def place_name(case: CandidateCase) -> Measured:
    """A place is meant by its name, or most of its words: "storage" may be A or B."""
    called = case.called
    return bool(called) and case.each(lambda g: not any(p.name in called for p in _places(g)))


@potential("no-place", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def no_place(case: CandidateCase) -> Measured:
    """A noun that names no area, and no place by its name, names things: "the pallet"."""
    return names_thing(case.sdc) and _says(case, lambda g: bool(_places(g)))


@potential("spoken-of", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def spoken_of(case: CandidateCase) -> Measured:
    """A thing that is pointed at was spoken of before: "this truck"."""
    same = case.problem.spoken - {case.problem.load}
    if not same or not names_same(case.sdc):
        return False
    return _says(case, lambda g: not _ids(g) <= same)


@potential("other-one", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def other_one(case: CandidateCase) -> Measured:
    """Another one wasn't spoken of, nor does the load stand on it: "the other truck"."""
    if not names_other(case.sdc):
        return False
    load = case.problem.load
    meant = case.problem.spoken | ({case.problem.carriers.get(load)} if load else set())
    return _says(case, lambda g: bool(_ids(g) & meant))


@potential("you", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def you(case: CandidateCase) -> Measured:
    """A word for who is spoken to names the robot: "you"."""
    robot = {case.problem.state.context.agent_id}
    return names_robot(case.sdc) and _says(case, lambda g: _ids(g) != robot)


@potential("not-robot", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def not_robot(case: CandidateCase) -> Measured:
    """A noun that names something else better than the robot isn't the robot."""
    noun, context = noun_words(case.sdc)[-1:], case.problem.state.context
    robot = context.agent_id
    others = [o.labels for o in context.objects if o.id != robot]
    if not noun or _says_no_kind(noun):
        return False
    best = best_naming(noun[0], others)
    if best < NAMES or best_naming(noun[0], [context.agent.labels]) >= best:
        return False
    return _says(case, lambda g: robot in _ids(g))


@potential("load-elsewhere", kind="noun", types=("OBJECT",), weight=log(0.05))
def load_elsewhere(case: CandidateCase) -> Measured:
    """A load isn't the landmark of its own goal."""
    return bool(case.problem.load) and _says(case, lambda g: case.problem.load in _ids(g))


@potential("own-label", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def own_label(case: CandidateCase) -> Measured:
    """A noun that surely names something means such a thing: "the crate", "the worker".

    What loads hold is a name of others, too: a crate is a box. Beside a truck, a flatbed truck
    isn't "the truck", unless more is said of it: "the truck on the right".
    """
    left_out, state = case.tree.left_out(case.sdc), case.problem.state
    noun = bare_words(left_out)[-1:] or noun_words(case.sdc)[-1:]
    if not noun or _says_no_kind(noun):
        return False
    objects = [o for o in state.context.objects if o.id != state.context.agent_id]
    leaf = left_out or noun_leaf(case.sdc).words
    is_content = not WORDS["heaped"].isdisjoint(field_words(leaf)[-1:])
    named = {o.labels for o in objects if labels_in(noun, o.labels)} or {
        o.labels
        for o in objects
        if is_called(noun[0], o.labels) and not (is_content and is_load(state, o.id))
    }
    plain = is_bare(case.sdc) and not _is_told_more(case.tree, case.node)
    said = noun_words(case.sdc) if plain else []
    names = {own for own in named if not any(_is_said_shorter(own, n, noun, said) for n in named)}
    meant = {o.id for o in objects if o.labels in names}
    return bool(meant) and _says(case, lambda g: not _ids(g) or not _ids(g) <= meant)


def _is_told_more(tree: Tree, node: int) -> bool:
    """Check that another OBJECT says more of what an OBJECT names."""
    return any(
        node in fields.get("f", ())
        for outer, fields in enumerate(tree.children)
        if tree.nodes[outer].type == "OBJECT"
    )


def _is_said_shorter(
    labels: tuple[str, ...], other: tuple[str, ...], noun: Sequence[str], said: Sequence[str]
) -> bool:
    """Check that some labels have others in them that fit better.

    A noun that is all of the others only begins them, as of generators and their parts; or what is
    said is all of the others: "the truck", beside a flatbed truck.
    """
    own, plain = ([word for label in of for word in label.split()] for of in (labels, other))
    if not set(plain) < set(own):
        return False
    in_full = {word for word in own if labels_in(said, [word])} == set(plain)
    return in_full or not labels_in(noun, own[-1:])


@potential("each-named", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def each_named(case: CandidateCase) -> Measured:
    """Of several things no word names one and not another: "the two refrigerator pallets".

    What no label says, as "washers", names things of one kind.
    """
    words = noun_words(case.sdc)
    known = {o.labels: labels_in(words, o.labels) for o in case.problem.state.context.objects}
    some_kind = not (case.tree.left_out(case.sdc) or _says_no_kind(words[-1:]))

    def is_mixed(group: Group) -> bool:
        labels = {thing.labels for thing in things_of(group)}
        named = {known[own] for own in labels}
        return len(named) > 1 or (some_kind and len(labels) > 1 and not any(named))

    return _says(case, is_mixed)


def _says_no_kind(noun: Sequence[str]) -> bool:
    """Check that a noun may stand for things of any kind: "them", "the others", "all the stuff"."""
    closed = (
        WORDS["pronouns"]
        | WORDS["nounless"]
        | WORDS["collectives"]
        | WORDS["parts"]
        | WORDS["quantifiers"]
        | COUNTS["cardinals"].keys()
    )
    return closed.issuperset(noun) or not WORDS["generic"].isdisjoint(map(normalise, noun))


@potential("named-again", kind="noun", types=("OBJECT",), weight=UNLIKELY)
def named_again(case: CandidateCase) -> Measured:
    """A plain noun that was said before names the same: "the truck", after "the left truck"."""
    same = case.problem.spoken - {case.problem.load}
    if not same or not names_again(case.tree, case.node):
        return False
    return _says(case, lambda g: not _ids(g) <= same)


@potential("apart", kind="factor", types=("OBJECT",), roles=("landmark",), weight=2 * log(0.05))
def apart(case: FactorCase) -> Measured:
    """Nothing is by itself, nor on itself: "drive around the boxes and lift the pallet by them"."""
    said = concepts(field_words(case.sdc.relation)) & (BESIDE | {"on"})
    marks = {bare(word.text) for mark in case.sdc.landmark1 for word in all_words(mark)}
    if not said or marks & WORDS["reflexives"]:  # "the one by itself"
        return False
    same: BoolArray = case.batch.figure == case.batch.landmark
    return same


@potential("stands-on", kind="factor", types=("OBJECT",), weight=UNLIKELY)
def stands_on(case: FactorCase) -> Measured:
    """A thing "on the truck" or off the ground stands there, and one "not on the truck" doesn't."""
    said = concepts(field_words(case.sdc.relation))
    if not said & {"on", "from"} or said & (SIDES | {"between"}):
        return False
    batch, problem = case.batch, case.problem
    on_floor = any(map(is_floor, case.sdc.landmark1))
    ids = [o.id for o in problem.state.context.objects]
    under, surface = np.full((2, len(batch.bodies.z_min)), -1)
    for i, own in enumerate(ids):
        under[i] = ids.index(problem.carriers[own]) if own in problem.carriers else -1
        surface[i] = own in problem.surfaces
    there = under[batch.figure] == (-1 if on_floor else batch.landmark)
    applies = on_floor | ((batch.landmark >= 0) & (surface[batch.landmark] == 1))
    applies &= (batch.figure != batch.landmark) & (batch.bodies.count[batch.figure] == 1)
    wrong: BoolArray = applies & (there if negated(case.sdc) else ~there)
    return wrong


def _number_said(case: FactorCase) -> str:
    """Return the number of things that a noun says: a row, a count, one, or several."""
    if case.sdc.figure:
        return ""
    said = group_of(case.sdc)
    if said.collective in WORDS["rows"]:
        return "row"
    if said.count is not None and said.count > 1:
        return "count"
    return "one" if said.number == "singular" else "several"


@potential("count", kind="factor", types=("OBJECT",), weight=log(0.001))
def count(case: FactorCase) -> Measured:
    """As many things are meant as words say: "both crates"."""
    said = group_of(case.sdc).count or 0
    return _number_said(case) == "count" and np.not_equal(case.sizes, said)


@potential("singular", kind="factor", types=("OBJECT",), weight=log(0.1))
def singular(case: FactorCase) -> Measured:
    """A noun in the singular names one thing."""
    return _number_said(case) == "one" and np.not_equal(case.sizes, 1)


@potential("plural", kind="factor", types=("OBJECT",), weight=log(0.4))
def plural(case: FactorCase) -> Measured:
    """A plural names several things, or often one that holds many: "the tires"."""
    return _number_said(case) == "several" and np.less_equal(case.sizes, 1)
