"""Commands that say otherwise what a plain clause says, annotated and typed."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from g3.actions.robot_state import start_state
from g3.inference.problem.alternations import plain
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.negation import negated
from g3.language.parsing.parser import parse
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import format_brackets, parse_brackets
from tests.g3.inference.following_commands import did, followed, stands_on, world

SPOTS = [(11, 5), (11, -6), (-6, 12), (-7, -11)]


def yard(spots=SPOTS, carries=None, aboard=None):
    """A crate and bricks, a truck and a trailer, each somewhere.

    Parameters
    ----------
    aboard
        What one of the loads stands on.
    """
    crate, bricks, truck, trailer = spots
    if aboard:
        x, y = {"truck-1": truck, "trailer-1": trailer}[aboard]
        bricks = (x - 1, y), 0, aboard
    else:
        bricks = (bricks,)
    return world(
        carries,
        crate_1=("crate",) if carries else ("crate", crate),
        bricks_1=("bricks-pallet", *bricks),
        truck_1=("truck", truck),
        trailer_1=("trailer", trailer),
    )


NOUNS = Nouns(start_state(yard()))


def written(sdcs):
    """Clauses in brackets, without numbers."""
    return re.sub(r"_\d+", "", format_brackets(sdcs))


def made(notation, nouns=NOUNS):
    """The plain clauses of annotated ones."""
    return written(plain(parse_brackets(notation), nouns))


@pytest.mark.parametrize(
    ("said", "clauses"),
    [
        # What is filled comes first, and what with in it.
        (
            "EVENT(r = Stock, l = OBJ(f = OBJ(f = the van), r = with, l = OBJ(f = the crates)))",
            "EVENT(r = Stock with, l = OBJ(f = the van), l2 = OBJ(f = the crates))",
        ),
        # A crate with bricks is filled already.
        ("EVENT(r = Load, l = OBJ(f = OBJ(f = the crate), r = with, l = OBJ(f = bricks)))", None),
        # What is emptied comes first, and what of in it.
        (
            "EVENT(r = Rid, l = OBJ(f = OBJ(f = the van), r = of, l = OBJ(f = the crate)))",
            "EVENT(r = Rid, l = OBJ(f = the crate), l2 = PATH(r = of, l = OBJ(f = the van)))",
        ),
        (
            "EVENT(r = Unload, l = OBJ(f = OBJ(f = the truck), r = of, l = OBJ(f = bricks)))",
            "EVENT(r = Unload, l = OBJ(f = bricks), l2 = PATH(r = of, l = OBJ(f = the truck)))",
        ),
        ("EVENT(r = Unload, l = OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = bricks)))", None),
        ("EVENT(r = Offload, l = OBJ(f = OBJ(f = a skid), r = of, l = OBJ(f = bricks)))", None),
        # Who is asked is no load.
        (
            "EVENT(r = lift, l = OBJ(f = the forklift), l2 = OBJ(f = the crate))",
            "EVENT(r = lift, l2 = OBJ(f = the crate))",
        ),
        # What is on the forks isn't there before it is lifted.
        (
            "EVENT(r = get, l = OBJ(f = OBJ(f = bricks), r = on, l = OBJ(f = your forks)))",
            "EVENT(r = get, l = OBJ(f = bricks), l2 = PLACE(r = on, l = OBJ(f = your forks)))",
        ),
        # A noun that nobody knows, before a verb.
        (
            "EVENT(r = gensets go, l = PATH(r = to, l = OBJ(f = the truck)))",
            "EVENT(f = OBJ(f = gensets), r = go, l = PATH(r = to, l = OBJ(f = the truck)))",
        ),
        # A noun tells what to do.
        (
            "EVENT(r = Make, l = OBJ(f = a sharp turn), l2 = PATH(r = to, l = OBJ(f = the gate)))",
            "EVENT(r = turn sharp, l = PATH(r = to, l = OBJ(f = the gate)))",
        ),
        (
            "EVENT(r = Do, l = OBJ(f = OBJ(f = a pickup), r = of, l = OBJ(f = the crate)))",
            "EVENT(r = pickup, l = OBJ(f = the crate))",
        ),
        (
            "EVENT(r = Give, l = OBJ(f = the bricks a push))",
            "EVENT(r = push, l = OBJ(f = the bricks))",
        ),
        ("EVENT(r = Hang, l = OBJ(f = a right))", "EVENT(r = right)"),
        ("EVENT(r = Take, l = OBJ(f = a crate))", None),
        ("EVENT(r = Take, l = OBJ(f = the lift))", None),
        # A noun that was taken for a verb.
        (
            "EVENT(r = Bricks, l = PATH(r = to, l = OBJ(f = the van)))",
            "EVENT(l = OBJ(f = Bricks), l2 = PATH(r = to, l = OBJ(f = the van)))",
        ),
        ("EVENT(r = Swing, l = PATH(r = to, l = OBJ(f = the van)))", None),
        # A verb that was taken for a noun.
        (
            "EVENT(l = OBJ(f = trundle), l2 = PATH(r = to, l = OBJ(f = the van)))",
            "EVENT(r = trundle, l = PATH(r = to, l = OBJ(f = the van)))",
        ),
        ("EVENT(l = OBJ(f = it), l2 = PATH(r = to, l = OBJ(f = the van)))", None),
        # What needs something is where that goes.
        (
            "EVENT(f = OBJ(f = The van), r = requires, l = OBJ(f = the bricks))",
            "EVENT(r = requires, l = OBJ(f = the bricks), l2 = OBJ(f = The van))",
        ),
        ("EVENT(f = OBJ(f = We), r = need, l = OBJ(f = the bricks))", None),
        # Where something shall be.
        (
            "EVENT(f = OBJ(f = I), r = want, l = OBJ(f = OBJ(f = the crate), r = on, "
            "l = OBJ(f = the truck)))",
            "EVENT(f = OBJ(f = I), r = want, l = OBJ(f = the crate), "
            "l2 = PLACE(r = on, l = OBJ(f = the truck)))",
        ),
        (
            "EVENT(r = Lift, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = the truck)))",
            None,
        ),
        (
            "EVENT(f = OBJ(f = I), r = said get, l = OBJ(f = OBJ(f = the crate), r = on, "
            "l = OBJ(f = the truck)))",
            "EVENT(f = OBJ(f = I), r = said get, l = OBJ(f = the crate), "
            "l2 = PLACE(r = on, l = OBJ(f = the truck)))",
        ),
        (
            "EVENT(r = Put, l = OBJ(f = OBJ(f = the crate), r = beside, l = OBJ(f = the van)))",
            "EVENT(r = Put, l = OBJ(f = the crate), l2 = PLACE(r = beside, l = OBJ(f = the van)))",
        ),
        (
            "EVENT(r = Put down, l = OBJ(f = OBJ(f = the crate), r = by, l = OBJ(f = the van)))",
            None,
        ),
        # What is taken off, with a letter missing; a pallet of bricks is one thing.
        (
            "EVENT(r = take, l = OBJ(f = OBJ(f = the crate), r = of, l = OBJ(f = the truck)))",
            "EVENT(r = take, l = OBJ(f = the crate), l2 = PATH(r = of, l = OBJ(f = the truck)))",
        ),
        (
            "EVENT(r = take, l = OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = bricks)))",
            None,
        ),
        # What is named before the verb is what "it" is.
        (
            "EVENT(f = OBJ(f = The crate), r = lift, l = OBJ(f = it))",
            "EVENT(r = lift, l = OBJ(f = The crate))",
        ),
        ("EVENT(f = OBJ(f = You), r = lift, l = OBJ(f = it))", None),
        ("EVENT(f = OBJ(f = The gate), r = lift, l = OBJ(f = it))", None),
        # Who drives is told what to do.
        (
            "EVENT(f = OBJ(f = The driver), r = goes, l = PATH(r = to, l = OBJ(f = the truck)))",
            "EVENT(r = goes, l = PATH(r = to, l = OBJ(f = the truck)))",
        ),
        # Loads don't drive.
        (
            "EVENT(r = go, l = OBJ(f = Bricks), l2 = PATH(r = to, l = OBJ(f = the van)))",
            None,
        ),
    ],
)
def test_clauses_are_said_plainly(said, clauses):
    found = made(said)
    assert found == written(parse_brackets(clauses or said))
    assert made(clauses or said) == found


PUT = "EVENT(r = put, l = OBJ(f = the bricks), l2 = PLACE(r = on, l = OBJ(f = the van)))"
AGAIN = "EVENT(r = put, l = OBJ(f = {}), l2 = PLACE(r = on, l = OBJ(f = the van)))"


@pytest.mark.parametrize(
    ("said", "load"),
    [
        ("EVENT(r = then, l = OBJ(f = the crate))", "the crate"),
        ("EVENT(r = then, l = [OBJ(f = the crate), OBJ(f = same place)])", "the crate"),
        ("OBJ(f = OBJ(f = the crate), r = as well)", "the crate"),
        ("EVENT(r = do, l = OBJ(f = OBJ(f = the same), r = with, l = OBJ(f = crate)))", "crate"),
        ("EVENT(r = do, l = PLACE(r = likewise with, l = OBJ(f = crate)))", "crate"),
        ("PLACE(r = same for, l = OBJ(f = the crate))", "the crate"),
        ("EVENT(r = after, l = OBJ(f = this also the crate))", "the crate"),
        ("EVENT(r = then, l = OBJ(f = the other one))", "the other one"),
        # Nothing says that it is the same, or it is no load.
        ("OBJ(f = the crate)", None),
        ("EVENT(r = then, l = OBJ(f = the van))", None),
        ("EVENT(r = then lift, l = OBJ(f = the crate))", None),
    ],
)
def test_the_same_is_said_of_another_load(said, load):
    first, second = plain(parse_brackets(f"{PUT}; {said}"), NOUNS)
    assert written([first]) == PUT
    assert (written([second]) == AGAIN.format(load)) == (load is not None)


def test_the_same_is_said_of_what_goes_somewhere():
    goes = "EVENT(f = OBJ(f = {}), r = goes, l = PATH(r = on, l = OBJ(f = the van)))".format
    then = "EVENT(r = then, l = OBJ(f = the crate))"
    assert made(f"{goes('the bricks')}; {then}") == written(
        parse_brackets(f"{goes('the bricks')}; {goes('the crate')}")
    )
    for before in ("EVENT(r = lift, l = OBJ(f = bricks))", goes("you")):
        assert "then" in made(f"{before}; {then}")


@pytest.mark.parametrize("no", ["do nt", "Please don't", "never"])
def test_a_negation_before_a_clause_is_its_own(no):
    lift = "EVENT(r = lift, l = OBJ(f = the crate))"
    (found,) = plain(parse_brackets(f"EVENT(r = {no}); {lift}"), NOUNS)
    assert negated(found)
    # What has an argument of its own is no negation of the next clause.
    told = parse_brackets(f"EVENT(r = {no} wait, l = OBJ(f = the van)); {lift}")
    assert not negated(plain(told, NOUNS)[-1])


def test_what_is_there_already_is_not_where_it_shall_be():
    said = (
        "EVENT(f = OBJ(f = I), r = want, l = OBJ(f = OBJ(f = the bricks), r = on, "
        "l = OBJ(f = the truck)))"
    )
    there = Nouns(start_state(yard(aboard="truck-1")))
    assert made(said, there) == written(parse_brackets(said))
    assert "PLACE" in made(said)


def test_what_is_on_the_forks_is_put_where_it_is_said_to_be():
    beside = "l = OBJ(f = OBJ(f = the {}), r = beside, l = OBJ(f = the truck))"
    loaded = Nouns(start_state(yard(carries="crate-1")))
    lower = f"EVENT(r = Lower, {beside})".format
    assert made(lower("crate"), loaded) == written(
        parse_brackets(
            "EVENT(r = Lower, l = OBJ(f = the crate), "
            "l2 = PLACE(r = beside, l = OBJ(f = the truck)))"
        )
    )
    lower = "EVENT(r = Lower, l = OBJ(f = OBJ(f = {}), r = beside, l = OBJ(f = the truck)))".format
    for noun in ("your box", "the load"):
        assert "PLACE" in made(lower(noun), loaded)
    for said, nouns in ((lower("bricks"), loaded), (lower("crate"), NOUNS)):
        assert made(said, nouns) == written(parse_brackets(said))


@pytest.mark.parametrize(
    "kept",
    [
        "PATH(r = with, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = your forks)))",
        "PLACE(r = still on, l = OBJ(f = the forks))",
    ],
)
def test_what_stays_on_the_forks_is_nowhere_to_go(kept):
    goal = "PATH(r = to, l = OBJ(f = the truck))"
    loaded = Nouns(start_state(yard(carries="crate-1")))
    said = f"EVENT(r = Drive, l = [{kept}, {goal}])"
    assert made(said, loaded) == written(parse_brackets(f"EVENT(r = Drive, l = {goal})"))
    assert made(said) == written(parse_brackets(said))
    put = f"EVENT(r = Lower, l = {kept})"
    assert made(put, loaded) == written(parse_brackets(put))


TEXTS = (
    "Stock the truck with the crate",
    "Clear the trailer of bricks and turn around",
    "Make a U-turn, then give the bricks a lift",
    "Crate to the trailer",
    "Crate to the trailer, then the bricks too",
    "The bricks onto the truck please",
    "Make sure the crate ends up on the truck",
    "The trailer requires the bricks",
    "We want the crate on the trailer",
    "Use the forks to fill the truck with the bricks",
)


@pytest.mark.parametrize("text", TEXTS)
def test_what_is_plain_stays_and_no_word_is_made_up(text):
    sdcs = parse(text).sdcs
    once = plain(sdcs, NOUNS)
    assert once != sdcs
    assert plain(once, NOUNS) == once
    spoken = [text[w.start : w.end] == w.text for sdc in once for w in all_words(sdc)]
    assert all(spoken)


def test_a_thing_with_where_it_comes_from_and_goes_is_one_clause():
    text = "Bricks from the trailer to the truck"
    (found,) = plain(parse(text).sdcs, NOUNS)
    assert written([found]) == (
        "EVENT(l = OBJ(f = Bricks), l2 = [PATH(r = from, l = OBJ(f = the trailer)), "
        "PATH(r = to, l = OBJ(f = the truck))])"
    )


def end(grounder, text, context):
    """What is done to what, and what that stands on in the end."""
    found = grounder.follow(text, context, least=0.0)
    done, state = did(found), followed(found).state
    moved = done[-1][1]
    return done, stands_on(state, moved) if moved and state.held != moved else None


QUICK = settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
spots = st.permutations(SPOTS)


@pytest.mark.parametrize(
    "text",
    [
        "Stock the truck with the crate",
        "Pile the truck with the crate",
        "Crate onto the truck",
        "The crate onto the truck please",
        "Make sure the crate ends up on the truck",
        "Ensure that the crate is on the truck",
        "The truck requires the crate",
        "We want the crate on the truck",
        "Give the crate a ride to the truck",
        "Crates go onto the truck",
        "Crate -> truck",
        "Get the crate on the truck",
    ],
)
@QUICK
@given(spots=spots)
def test_what_is_said_otherwise_is_carried(text, spots, grounder):
    assert end(grounder, text, yard(spots)) == ([("carry", "crate-1")], "truck-1")


@pytest.mark.parametrize(
    "text",
    [
        "Unload the trailer",
        "Empty the trailer",
        "Clear the trailer of bricks",
        "Strip the trailer of its bricks",
        "Give the bricks a lift",
        "Perform a pickup of the bricks",
    ],
)
@QUICK
@given(spots=spots)
def test_what_is_taken_off_stands_there(text, spots, grounder):
    done, _ = end(grounder, text, yard(spots, aboard="trailer-1"))
    assert done == [("pick up", "bricks-1")]


@pytest.mark.parametrize(
    "text",
    [
        "Deliver it to the trailer",
        "Transfer the crate to the trailer",
        "Get it on the trailer",
    ],
)
@QUICK
@given(spots=spots)
def test_what_is_sent_is_there_in_the_end(text, spots, grounder):
    assert end(grounder, text, yard(spots, "crate-1")) == (
        [("put down", "crate-1")],
        "trailer-1",
    )


@pytest.mark.parametrize(
    ("text", "amount"),
    [
        ("Make a right turn", -np.pi / 2),
        ("Take a left", np.pi / 2),
        ("Do a quick turn to the left", np.pi / 2),
        ("Perform a U-turn", np.pi),
    ],
)
def test_a_noun_may_say_how_to_turn(text, amount, grounder):
    (action,) = grounder.follow(text, yard(), least=0.0).plan.actions
    assert action.kind.name == "turn"
    assert action.amount == pytest.approx(amount)
