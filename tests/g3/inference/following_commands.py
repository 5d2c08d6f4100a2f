"""Commands followed in worlds of a few things, and what became of them.

The robot stands at the origin and looks along x, so that the left is where y is large.
"""

from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import Bounds, Layout, Robot, Scenario, Thing
from g3.actions.grounding_candidates import beneath
from g3.geometry.footprints import centre
from g3.groundings import Place
from g3.language.parsing.trees import Parse, Tree
from g3.sdc.sdc_notation import parse_brackets

FIELD = Layout("field", "A field.", (0, 0), 0, Bounds((-40, 40), (-40, 40)), {}, {})
TIRES, BOXES = "tire-pallet", "box-pallet"


YARD = {
    "tires_1": (TIRES, (9, 5)),
    "tires_2": (TIRES, (12, 1)),
    "crate_1": ("crate", (9, -3)),
    "crate_2": ("crate", (12, -7)),
    "truck_1": ("truck", (20, 9)),
    "truck_2": ("truck", (20, -11)),
    "cone_1": ("cone", (16, -1)),
}
"""Two loads of each of two kinds, and where they may go."""


def told(text, brackets):
    """Return a text with one tree."""
    return Parse(text, (Tree(parse_brackets(brackets, command=text), 1.0),))


def world(carries=None, **things):
    """A context with things: a kind and where it is, or also its heading and on what."""
    objects = {name.replace("_", "-"): Thing(*thing) for name, thing in things.items()}
    return scenario_context(
        Scenario("field", "", FIELD, objects, {}, Robot((0, 0), 0, carries), ())
    )


def followed(result):
    assert result.plan is not None, result.note
    return result.plan


def did(result):
    return [(a.kind.name, a.object_id) for a in followed(result).actions]


def end_of(result, name):
    return centre(followed(result).state.thing(name).prism)


def stands_on(state, name):
    """What something stands on; None for the ground."""
    found = beneath(Place(state.thing(name).prism), state, name)
    return found.id if found else None


def under(result, name):
    """What something stands on at the end; None for the ground."""
    state = followed(result).state
    assert state.held != name
    return stands_on(state, name)
