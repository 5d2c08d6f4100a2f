"""Clauses that ask for the most probable ends, and plans of them where no tree leads there."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.actions.robot_state import start_state
from g3.inference.ends.end_model import (
    AHEAD,
    AROUND,
    BACK,
    ELSEWHERE,
    GROUND,
    HELD,
    LEFT,
    NEAR,
    ON,
    RIGHT,
    SIDES,
    STANDS,
    STAYS,
    EndModel,
    Ends,
    JointEnds,
    default_end_model,
    load_ends,
    robot_ends,
)
from g3.inference.ends.proposal import likely_ends, proposal_of, sides_of
from g3.inference.grounder import Grounder
from g3.inference.problem.costs import RandomCost
from g3.language.parsing.trees import Parse
from g3.sdc.clauses import all_words, breadth_first
from tests.g3.inference.following_commands import YARD, did, followed, told, under, world

START = start_state(world(**YARD))
IDS = [o.id for o in START.context.objects if o.id != START.context.agent_id]
LOADS = ["tires-1", "tires-2", "crate-1", "crate-2"]
MOST = 0.9


def on(name):
    return ON + IDS.index(name)


def beside(name):
    return ON + len(IDS) + IDS.index(name)


def near(name):
    return NEAR + IDS.index(name)


def facing(name):
    return NEAR + len(IDS) + IDS.index(name)


def likely(chance=MOST, robot=ELSEWHERE, stays=1.0, **ends):
    """Ends of which those that are given, by load, have a chance, and staying the rest.

    Loads of which none is given stay with a chance of their own.
    """
    robots = np.full(NEAR + 2 * len(IDS), 1e-9)
    robots[ELSEWHERE], robots[robot] = 1 - chance, chance
    loads = np.full((len(IDS), ON + 2 * len(IDS)), 1e-9)
    loads[:, STAYS], loads[:, GROUND] = stays, 1 - stays + 1e-9
    for name, end in ends.items():
        row = loads[IDS.index(name.replace("_", "-"))]
        row[[STAYS, GROUND]] = 1 - chance, 1e-9
        row[end] = chance
    sides = np.full((len(IDS), len(SIDES)), 1 / len(SIDES))
    return Ends(np.log(loads), np.log(robots), np.log(sides))


def joint(ends):
    """Ends of loads that say nothing about each other."""
    return JointEnds([IDS.index(name) for name in LOADS], lambda told: ends)


def asked(ends, state=START):
    likeliest = likely_ends(joint(ends), state)
    return proposal_of(likeliest, state, sides=sides_of(joint(ends), likeliest))


def said(proposal):
    """Return the words of clauses, and the ids of the things that are meant."""
    words = [" ".join(word.text for word in all_words(sdc)) for sdc in proposal.sdcs]
    return words, sorted(proposal.answers.values())


class Fixed(EndModel):
    """A model that finds the same ends for each command."""

    def ends(self, seen, known=None):
        return likely(**self.fixed)


def fixed(**ends):
    model = default_end_model()
    own = Fixed(model.weights, model.encoder)
    object.__setattr__(own, "fixed", ends)
    return own


def test_loads_with_one_end_are_asked_for_together():
    crates = asked(likely(crate_1=on("truck-1"), crate_2=on("truck-1")))
    assert said(crates) == (
        ["Put the crates on the truck"],
        [("crate-1", "crate-2"), ("truck-1",)],
    )


def test_what_is_lifted_comes_last():
    both = asked(likely(crate_1=HELD, tires_1=beside("cone-1")))
    assert said(both)[0] == ["Put the tire pallet next to the cone", "Pick up the crate"]


def test_the_forks_hold_one_load():
    ends = likely(crate_1=HELD, crate_2=HELD)
    ends.loads[IDS.index("crate-2"), [HELD, STAYS]] = np.log([0.6, 0.4])
    assert said(asked(ends)) == (["Pick up the crate"], [("crate-1",)])


def test_what_is_held_is_put_down_first():
    held = start_state(world("crate-1", **YARD | {"crate_1": ("crate", None)}))
    both = asked(likely(tires_1=on("truck-1"), crate_1=GROUND), held)
    assert said(both)[0] == ["Put the crate on the ground", "Put the tire pallet on the truck"]


def test_what_is_held_is_put_down_beside_what_is_put_there():
    held = start_state(world("crate-1", **YARD | {"crate_1": ("crate", None)}))
    both = asked(likely(tires_1=on("truck-1"), crate_1=on("truck-1")), held)
    assert said(both)[0] == ["Put the crate on the truck", "Put the tire pallet on the truck"]


@pytest.mark.parametrize(
    ("side", "words"),
    [
        ("to the left of", "Put the crate to the left of the cone"),
        ("between", "Put the crate between the cone the truck"),
    ],
)
def test_a_load_is_put_on_a_side(side, words):
    ends = likely(crate_1=beside("cone-1"))
    row = IDS.index("crate-1")
    ends.loads[row, beside("truck-2")] = np.log(1e-3)
    ends.sides[row, SIDES.index(side)] = 0
    found = asked(ends)
    marks = [("cone-1",)] + [("truck-2",)] * (side == "between")
    assert said(found) == ([words], sorted([("crate-1",), *marks]))


@pytest.mark.parametrize("ends", [{}, {"crate_1": STAYS}])
def test_nothing_is_asked_for_where_all_stays(ends):
    assert asked(likely(**ends)) is None


def test_nothing_is_put_on_what_carries_nothing():
    ends = likely(crate_1=on("cone-1"))
    ends.loads[IDS.index("crate-1"), on("truck-2")] = np.log(0.2)
    assert said(asked(ends))[1] == [("crate-1",), ("truck-2",)]


@pytest.mark.parametrize(
    ("end", "words", "things"),
    [
        (STANDS, "Wait", []),
        (LEFT, "Turn left", []),
        (near("truck-2"), "Go to the truck", [("truck-2",)]),
        (facing("cone-1"), "Face the cone", [("cone-1",)]),
    ],
)
def test_where_all_stays_the_robot_is_asked_for(end, words, things):
    assert said(asked(likely(robot=end))) == ([words], things)
    assert said(asked(likely(robot=end, crate_1=HELD))) == (["Pick up the crate"], [("crate-1",)])


def test_the_robot_goes_as_far_as_is_said():
    found = proposal_of(likely_ends(joint(likely(robot=BACK)), START), START, 2.5)
    assert said(found) == (["Back up 2.5 meters"], [])


@pytest.mark.parametrize(
    "end",
    [STANDS, AHEAD, BACK, LEFT, RIGHT, AROUND]
    + [where(name) for where in (near, facing) for name in ("truck-1", "cone-1", "crate-2")],
)
def test_the_plan_for_the_robot_leads_there(end):
    found = asked(likely(robot=end))
    grounder = Grounder(RandomCost(), rewriting=False)
    plan = followed(grounder.follow(found.sdcs, START, answers=found.answers, least=0.0))
    assert not any(action.object_id for action in plan.actions)
    assert end in robot_ends(plan.state.pose, START)


@given(label=st.text(max_size=12))
def test_things_may_have_any_labels(label):
    crate = replace(START.thing("crate-1"), labels=(label,))
    objects = tuple(crate if o.id == crate.id else o for o in START.context.objects)
    state = replace(START, context=replace(START.context, objects=objects))
    found = proposal_of({IDS.index("crate-1"): HELD}, state)
    assert said(found) == ([" ".join(["Pick up the", *label.split()])], [("crate-1",)])


@settings(max_examples=25, deadline=None)
@given(
    ends=st.fixed_dictionaries(
        {},
        optional={
            name.replace("-", "_"): st.sampled_from(
                [GROUND, on("truck-1"), on("truck-2"), beside("cone-1"), beside("truck-2")]
            )
            for name in LOADS
        },
    ).filter(bool)
)
def test_its_plan_leads_to_these_ends(ends):
    found = asked(likely(**ends))
    grounder = Grounder(RandomCost(), rewriting=False)
    plan = followed(grounder.follow(found.sdcs, START, answers=found.answers, least=0.0))
    handled = {a.object_id for a in plan.actions} - {""}
    assert handled == {name.replace("_", "-") for name in ends}
    for name, end in ends.items():
        assert end in load_ends(IDS.index(name.replace("_", "-")), plan.state, START)


def unsure(text, brackets):
    """A text with one tree that is probable, but not certain."""
    (tree,) = told(text, brackets).trees
    return Parse(text, (tree._replace(probability=0.7),))


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("Crate one: left lorry.", "EVENT(r = Crate, l = OBJ(f = left lorry))"),
        pytest.param("Crate one: left lorry, revert", "EVENT(r = revert)", id="no plan at all"),
    ],
)
def test_a_plan_is_made_where_no_tree_leads(text, tree, grounder):
    lost = unsure(text, tree)
    own = Grounder(grounder.cost, end_model=fixed(crate_1=on("truck-1")))
    found = own.follow(lost, START, least=0.0, insist=True)
    assert did(found) == [("carry", "crate-1")]
    assert under(found, "crate-1") == "truck-1"
    assert "planned from all words together" in found.note
    assert found.question is None


def test_what_trees_rule_out_is_not_proposed(grounder):
    text = "Don't touch the crates, drive to the cone"
    clauses = unsure(
        text,
        "EVENT(r = Don't touch, l = OBJ(f = the crates))\n"
        "EVENT(r = drive, l = PATH(r = to, l = OBJ(f = the cone)))",
    )
    own = Grounder(grounder.cost, end_model=fixed(crate_1=on("truck-1"), crate_2=on("truck-1")))
    assert not any(load for _, load in did(own.follow(clauses, START)))


def test_a_command_that_is_given_as_its_only_tree_is_followed_by_it(grounder):
    clauses = told("Pick up the crate", "EVENT(r = Pick up, l = OBJ(f = the crate))")
    own = Grounder(grounder.cost, end_model=fixed(tires_1=HELD))
    assert did(own.follow(clauses, START)) in ([("pick up", name)] for name in LOADS[2:])


def test_an_answer_is_for_the_tree_that_was_asked_about(grounder):
    text = "Pick up the crate"
    clauses = unsure(text, "EVENT(r = Pick up, l = OBJ(f = the crate))")
    own = Grounder(grounder.cost, end_model=fixed(tires_1=HELD))
    node = next(n for n, sdc in enumerate(breadth_first(clauses.trees[0].sdcs)) if sdc.words)
    found = own.follow(clauses, START, answers={node: "crate-2"})
    assert did(found) == [("pick up", "crate-2")]


def test_a_yard_without_loads_has_none(grounder):
    empty = start_state(world(truck_1=("truck", (12, 3)), cone_1=("cone", (9, -5))))
    (action,) = followed(grounder.follow("Drive to the truck", empty)).actions
    assert not action.object_id


@pytest.mark.parametrize("crate", ["crate_1", "crate_2"])
def test_of_a_trees_plans_the_most_probable_is_chosen(grounder, crate):
    clauses = unsure("Pick up the crate", "EVENT(r = Pick up, l = OBJ(f = the crate))")
    own = Grounder(grounder.cost, end_model=fixed(**{crate: HELD}))
    assert did(own.follow(clauses, START, top=2)) == [("pick up", crate.replace("_", "-"))]


@pytest.mark.parametrize(("stays", "trees"), [(1.0, {0}), (0.7, {0, 1})])
def test_trees_after_one_with_sure_ends_are_not_followed(grounder, stays, trees):
    text = "Pick up the crate or the tires"
    first = unsure(text, "EVENT(r = Pick up, l = OBJ(f = the crate))")
    second = unsure(text, "EVENT(r = Pick up, l = OBJ(f = the tires))")
    parse = Parse(text, (*first.trees, second.trees[0]._replace(probability=0.3)))
    own = Grounder(grounder.cost, end_model=fixed(stays=stays, crate_1=HELD))
    choices, _ = own.compared(parse, START)
    assert {choice.tree for choice in choices} == trees
