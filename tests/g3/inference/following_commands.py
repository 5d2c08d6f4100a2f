"""Commands followed in worlds of a few things, and what became of them.

The robot stands at the origin and looks along x, so that the left is where y is large.
"""

from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import Bounds, Layout, Robot, Scenario, Thing
from g3.actions.grounding_candidates import beneath
from g3.geometry.footprints import centre
from g3.groundings import Place

FIELD = Layout("field", "A field.", (0, 0), 0, Bounds((-40, 40), (-40, 40)), {}, {})
TIRES, BOXES = "tire-pallet", "box-pallet"


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
