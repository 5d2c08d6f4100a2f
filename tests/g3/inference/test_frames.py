"""What clauses ask for, wherever their verb stands, and what comes of unknown verbs."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked, frame
from g3.language.parsing.parser import parse
from g3.sdc.clauses import all_words
from tests.g3.inference.following_commands import world

SPOTS = [(9, 4), (9, -4), (-5, 9), (-5, -9)]
PREFIXES = (
    *("go ahead and", "please", "you need to", "get ready to", "proceed to", "I want you to"),
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


def frames(text):
    """The clauses of a text that ask for something: verb, classes, and the words of arguments."""
    tree = Tree(parse(text).sdcs)

    def words(nodes):
        return ", ".join(" ".join(w.text for w in all_words(tree.nodes[n])) for n in nodes)

    for own in (frame(tree, n) for n in asked(tree)):
        yield own, words(own.objects[:1]), words((*own.places, *own.paths))


@pytest.mark.parametrize(
    ("text", "verb", "classes", "theme", "goal"),
    [
        ("Go fetch the drum.", "fetch", "taking", "the drum", ""),
        ("Go ahead and lift the drum.", "lift", "taking", "the drum", ""),
        ("Get ready to deposit the drum on the floor.", "deposit", "placing", "the drum", "on"),
        ("I want you to haul the drum to the gate.", "haul", "carrying", "the drum", "to"),
        ("Use the forklift to raise the drum.", "raise", "taking", "the drum", ""),
        ("Help me carry the drum to the gate.", "carry", "carrying", "the drum", "to"),
        ("Let's drive to the gate.", "drive", "going", "", "to"),
        ("Turn so that you face the gate.", "face", "turning", "the gate", ""),
        ("You have to turn left.", "turn left", "turning", "", ""),
        ("Blick the drum onto the lorry.", "blick", "carrying", "the drum", "onto"),
        ("Blick the drum.", "blick", "placing+taking", "the drum", ""),
        ("Blick to the lorry.", "blick", "going", "", "to"),
        ("Proceed to blick the drum.", "blick", "placing+taking", "the drum", ""),
        # Who moves, pulls or returns nothing drives.
        ("Move forward.", "move forward", "going", "", ""),
        ("Pull out.", "pull out", "going", "", ""),
        ("Move the drum.", "move", "carrying", "the drum", ""),
    ],
)
def test_the_frame_is_that_of_the_content_verb(text, verb, classes, theme, goal):
    ((own, handled, leads),) = frames(text)
    assert own.text == verb
    assert "+".join(sorted(own.classes)) == classes
    assert own.guessed == ("lick" in text)
    assert handled == theme
    assert leads.split(" ")[0] == goal


def test_a_purpose_comes_after_what_leads_to_it():
    goes, lifts = frames("Drive to the drum to pick it up.")
    assert (goes[0].text, goes[2]) == ("drive", "to the drum")
    assert (lifts[0].text, lifts[1]) == ("pick up", "it")


def test_who_does_not_want_it_forbids_it():
    ((own, theme, _),) = frames("I don't want you to lift the drum.")
    assert own.negated
    assert theme == "the drum"


def test_a_frame_has_ends_extents_ways_and_instruments():
    ((turns, *_),) = frames("Turn until you face the gate.")
    assert turns.until is not None
    assert turns.end is not None
    ((backs, *_),) = frames("Back up three metres.")
    assert len(backs.extents) == 1
    assert backs.directions == {"back"}
    ((lifts, *_),) = frames("Use the forks to lift the drum.")
    assert len(lifts.instruments) == 1
    assert not lifts.forks


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
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_a_prefix_changes_nothing(command, prefix, spots, grounder):
    context = yard(spots)
    plain = done(grounder, command.capitalize(), context)
    said = f"{prefix} {command}"
    assert done(grounder, said[0].upper() + said[1:], context) == plain


@given(verb=st.sampled_from(("Blick", "Zorp", "Frindle", "Quonk")), spots=st.permutations(SPOTS))
@settings(max_examples=8, deadline=None)
def test_unknown_verbs_do_what_their_arguments_allow(verb, spots, grounder):
    context = yard(spots)
    (carries,) = done(grounder, f"{verb} the boxes onto the truck", context)
    assert carries[:2] == ("carry", "box-pallet-1")
    (goes,) = done(grounder, f"{verb} to the truck", context)
    assert goes[1:3] == ("", ("truck-1",))
    (takes,) = done(grounder, f"{verb} the boxes", context)
    assert takes[:2] == ("pick up", "box-pallet-1")
    held = grounder.follow("Lift the boxes", context).plan.state
    (puts,) = done(grounder, f"{verb} the boxes", held)
    assert puts[:2] == ("put down", "box-pallet-1")


@given(spots=st.permutations(SPOTS))
@settings(max_examples=6, deadline=None)
def test_what_is_picked_up_without_a_name_is_what_was_driven_to(spots, grounder):
    context = yard(spots)
    _, takes = done(grounder, "Drive to the boxes and pick up.", context)
    assert takes[:2] == ("pick up", "box-pallet-1")
