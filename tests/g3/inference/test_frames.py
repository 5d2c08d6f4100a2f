"""Plans for clauses with verbs in other places, and with unknown verbs."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.g3.inference.following_commands import world

SPOTS = [(9, 4), (9, -4), (-5, 9), (-5, -9)]
PREFIXES = (
    *("please", "you need to", "get ready to", "proceed to", "I want you to"),
    *("go and", "try to", "you should", "use your forks to", "help me"),
)
COMMANDS = (
    "pick up the tire pallet",
    "lift the boxes",
    "put the tire pallet on the truck",
    "carry the boxes to the trailer",
    "drive to the truck",
    "go to the trailer",
    "turn left",
    "back up",
)


def yard(spots):
    """A context with a load of two kinds, a truck and a trailer, each in a corner."""
    kinds = ("tire-pallet", "box-pallet", "truck", "trailer")
    return world(**{f"{k}-1": (k, spot) for k, spot in zip(kinds, spots, strict=True)})


def done(grounder, text, context):
    """What the best plan does: kinds, loads and targets."""
    plan = grounder.follow(text, context, least=0.0).plan
    assert plan is not None, text
    return [
        (a.kind.name, a.object_id, tuple(g.id for g in a.target if hasattr(g, "id")), a.amount)
        for a in plan.actions
    ]


@given(
    command=st.sampled_from(COMMANDS),
    prefix=st.sampled_from(PREFIXES),
    spots=st.permutations(SPOTS),
)
@settings(
    max_examples=12,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_a_prefix_changes_nothing(command, prefix, spots, grounder):
    context = yard(spots)
    plain = done(grounder, command.capitalize(), context)
    said = f"{prefix} {command}"
    assert done(grounder, said[0].upper() + said[1:], context) == plain


@pytest.mark.xfail(reason="one of its trees has 'go ahead' as something to do", strict=True)
def test_going_ahead_and_driving_is_driving(grounder):
    plain, said = "Drive to the truck", "Go ahead and drive to the truck"
    assert done(grounder, said, yard(SPOTS)) == done(grounder, plain, yard(SPOTS))


@given(verb=st.sampled_from(("Blick", "Zorp", "Frindle", "Quonk")), spots=st.permutations(SPOTS))
@settings(max_examples=4, deadline=None)
def test_unknown_verbs_do_what_their_arguments_allow(verb, spots, grounder):
    context = yard(spots)
    (carries,) = done(grounder, f"{verb} the boxes onto the truck", context)
    assert carries[:2] == ("carry", "box-pallet-1")
    (goes,) = done(grounder, f"Please {verb.lower()} over to the truck", context)
    assert goes[1:3] == ("", ("truck-1",))
    (takes,) = done(grounder, f"{verb} the boxes", context)
    assert takes[:2] == ("pick up", "box-pallet-1")
    held = grounder.follow("Lift the boxes", context).plan.state
    (puts,) = done(grounder, f"{verb} the boxes", held)
    assert puts[:2] == ("put down", "box-pallet-1")


@given(spots=st.permutations(SPOTS))
@settings(max_examples=3, deadline=None)
def test_what_is_picked_up_without_a_name_is_what_was_driven_to(spots, grounder):
    context = yard(spots)
    _, takes = done(grounder, "Drive to the boxes and pick up.", context)
    assert takes[:2] == ("pick up", "box-pallet-1")
