"""What later clauses say of what was named, reached or handled before them."""

import numpy as np
import pytest

from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import Bounds, Layout, Robot, Scenario, Thing
from g3.actions.grounding_candidates import beneath
from g3.geometry.footprints import centre
from g3.groundings import Place

FIELD = Layout("field", "A field.", (0, 0), 0, Bounds((-40, 40), (-40, 40)), {}, {})
TIRES, BOXES, CRATE, TRUCK = "tire-pallet", "box-pallet", "crate", "truck"
YARD = {"tires": (TIRES, (9, 4)), "boxes": (BOXES, (7, -1)), "truck": (TRUCK, (2, -13))}
CROSSROADS = {"left": (CRATE, (-10, 6)), "ahead": (CRATE, (8, 9)), "behind": (CRATE, (-3, -12))}


def world(things, mirrored):
    """A world whose things are where they are told, or on the other side of the robot's x axis."""
    side = -1 if mirrored else 1
    objects = {name: Thing(kind, (x, side * y)) for name, (kind, (x, y)) in things.items()}
    return scenario_context(Scenario("field", "", FIELD, objects, {}, Robot((0, 0), 0), ()))


def ends(grounder, text, things, mirrored=False):
    """The state in the end, and the loads that were handled."""
    plan = grounder.follow(text, world(things, mirrored), least=0.0).plan
    assert plan is not None, text
    return plan.state, {a.object_id for a in plan.actions} - {""}


def on(state, name):
    """What something stands on; None for the ground."""
    found = beneath(Place(state.thing(name).prism), state, name)
    return found.id if found else None


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    "text",
    [
        # What was come to, pointed at; what was handled, by its label and by its number.
        "Go to the tires, pick up this pallet and put it on the truck",
        "Pick up the tires. Put this pallet on the truck",
        "Pick up the tires, drive past the boxes and put them on the truck",
        "Lift the tires, turn around and set the load on the truck",
    ],
)
def test_what_was_spoken_of_is_put_on_the_truck(text, mirrored, grounder):
    state, handled = ends(grounder, text, YARD, mirrored)
    assert handled == {"tires"}
    assert (state.held, on(state, "tires")) == (None, "truck")


@pytest.mark.parametrize("mirrored", [False, True])
def test_them_and_it_are_told_apart_by_number(mirrored, grounder):
    text = "Drive to the truck. Pick up the tires and bring them back to it"
    state, handled = ends(grounder, text, YARD, mirrored)
    assert handled == {"tires"}
    ends_at = centre((state.thing("tires")).prism)
    assert np.linalg.norm(ends_at - centre(state.thing("truck").prism)) < 6


@pytest.mark.xfail(
    strict=True, reason="sides are those that are seen at the start, also after a turn"
)
@pytest.mark.parametrize("mirrored", [False, True])
def test_on_the_left_then_is_the_side_that_was_turned_to(mirrored, grounder):
    side = "right" if mirrored else "left"
    text = f"Turn {side} and pick up the crate on your {side} then"
    assert ends(grounder, text, CROSSROADS, mirrored)[0].held == "left"


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "spots"),
    [
        ("Pick up the crate in the centre", {"a": (9, 4), "meant": (9, 0.5), "b": (9, -4)}),
        ("Pick up the first crate you come to", {"meant": (7, 0), "a": (14, 2), "b": (-12, 4)}),
    ],
)
def test_one_of_several_is_told_by_where_it_is(text, spots, mirrored, grounder):
    things = {name: (CRATE, spot) for name, spot in spots.items()}
    assert ends(grounder, text, things, mirrored)[0].held == "meant"
