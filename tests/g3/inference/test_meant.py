"""What words rule out for an OBJECT."""

import pytest

from g3.actions.robot_state import start_state
from g3.groundings import Context, Place
from g3.inference.potentials.cases import CandidateCase
from g3.inference.potentials.meant import UNLIKELY
from g3.inference.potentials.potential_registry import added
from g3.inference.problem.phrases import named_places
from g3.inference.search.thing_search import ground_others, ground_thing
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.ruled import (
    WEIGHT,
    adds,
    of_examples,
    of_groups,
    of_things,
    problem_in,
    tree_of,
)
from tests.worlds import prism, robot, scene, thing

TRUCK = thing("truck", "trailer", 20, 0, (4, 6), (0, 1))
OTHER = thing("other", "trailer", -20, 0, (4, 6), (0, 1))
BOXES = thing("boxes", "box pallet", 20, 0, (1.2, 1.2), (1, 2))
TIRES = thing("tires", "tire pallet", 5, 3, (1.2, 1.2))
RECEIVING, STORAGE_A, STORAGE_B = (
    Place(prism(x, 9), name) for x, name in ((0, "receiving"), (5, "storage A"), (9, "storage B"))
)
NAMELESS = Place(prism(12, 9))
PLACES = (RECEIVING, STORAGE_A, STORAGE_B, NAMELESS)
STATE = start_state(Context("yard", (TRUCK, OTHER, BOXES, TIRES, robot()), PLACES, "robot"))


def around(**options):
    return problem_in(STATE.context, **options)


def possible(noun, *candidates):
    """Which candidates cost nothing, by their names or ids."""
    tree = tree_of(f"OBJ(f = {noun})")
    groups = [(c,) for c in candidates]
    scores = added(CandidateCase(tree, 0, around(), groups, "figure", 0))
    assert set(scores) <= {0.0, UNLIKELY, WEIGHT["own-label"]}
    found = [c for c, score in zip(candidates, scores, strict=True) if score == 0]
    return {c.name if isinstance(c, Place) else c.id for c in found}


@pytest.mark.parametrize(
    ("noun", "names"),
    [
        ("receiving", {"receiving"}),
        ("the receiving area", {"receiving"}),
        ("storage B", {"storage B"}),
        ("the storage area", {"storage A", "storage B"}),
        # "A" is no letter there.
        ("a storage area", {"storage A", "storage B"}),
        ("recieving", {"receiving"}),
        ("the area", set()),
        ("the tires", set()),
    ],
)
def test_places_are_called_by_their_names(noun, names):
    (sdc,) = parse_brackets(f"OBJ(f = {noun})")
    assert named_places(sdc, [p.name for p in PLACES]) == names


def test_who_has_a_name_is_meant_by_it():
    candidates = (*PLACES, TRUCK, TIRES)
    assert possible("receiving", *candidates) == {"receiving"}
    assert possible("the storage area", *candidates) == {"storage A", "storage B"}
    assert possible("the tires", *candidates) == {"tires"}
    assert possible("the truck", *candidates) == {"truck"}
    assert possible("the area", *candidates) == {p.name for p in PLACES} | {"truck", "tires"}


def test_a_noun_that_is_a_label_of_a_load_means_such_a_load():
    crate, boxes = (
        thing("crate", "crate", 6, 2, (1.2, 1.2)),
        thing("boxes", "box pallet", 6, -2, (1, 1)),
    )
    problem = problem_in(Context("yard", (crate, boxes, TRUCK, robot()), (), "robot"))

    def costs(noun):
        return of_groups("own-label", f"OBJ(f = {noun})", [(crate,), (boxes,)], problem).tolist()

    dear = WEIGHT["own-label"]
    assert costs("the crate") == costs("the big crates") == [0, dear]
    assert costs("the box pallet") == [dear, 0]
    # Neither is a truck, and "load" is no label.
    assert costs("the truck") == [dear, dear]
    assert costs("the load") == [0, 0]


@pytest.mark.parametrize("parts", ["generator accessories pallet", "generator accessories"])
def test_a_noun_that_is_all_of_a_label_means_no_thing_that_it_only_begins(parts):
    whole = thing("whole", parts.replace(" accessories", ""), 6, 2, (1, 1))
    others = thing("parts", parts, 4, -2, (1, 1))
    problem = problem_in(Context("yard", (whole, others, robot()), (), "robot"))

    def costs(noun):
        return of_groups("own-label", f"OBJ(f = {noun})", [(whole,), (others,)], problem).tolist()

    dear = WEIGHT["own-label"]
    assert costs("the generator") == [0, dear]
    assert costs("the generator accessories") == [dear, 0]
    # Both stand on pallets.
    assert costs("the pallet") == [0, 0] or "pallet" not in parts


def test_the_plain_name_of_one_thing_means_none_that_has_a_longer_one():
    truck = thing("truck", "truck", 20, 8, (4, 6))
    flatbed = thing("flatbed", "flatbed truck", 20, -8, (4, 6))
    problem = problem_in(Context("yard", (truck, flatbed, robot()), (), "robot"))

    def costs(text):
        return of_groups("own-label", text, [(truck,), (flatbed,)], problem).tolist()

    dear = WEIGHT["own-label"]
    assert costs("OBJ(f = the truck)") == [0, dear]
    assert costs("OBJ(f = the flatbed truck)") == [0, 0]
    assert costs("OBJ(f = the right truck)") == [0, 0]
    assert costs("OBJ(f = OBJ(f = the truck), r = by, l = OBJ(f = the gate))") == [0, 0]


def test_you_are_the_robot():
    assert possible("you", TRUCK, STATE.context.agent) == {"robot"}


def test_a_noun_for_something_else_is_not_the_robot():
    own = STATE.context.agent.labels[0]
    assert possible("the trailer", TRUCK, STATE.context.agent) == {"truck"}
    assert possible(f"the {own}", TRUCK, STATE.context.agent) == {"truck", "robot"}
    # No other thing has that label: the robot may be meant.
    assert possible("the elephant", TRUCK, STATE.context.agent) == {"truck", "robot"}


@pytest.mark.parametrize(
    ("relation", "costs"),
    [
        ("on", [0, UNLIKELY]),
        ("that is not on", [UNLIKELY, 0]),
        ("on the left of", [0, 0]),
        ("near", [0, 0]),
    ],
)
def test_the_one_on_the_truck_stands_on_it(relation, costs):
    words = f"OBJ(f = OBJ(f = the pallet), r = {relation}, l = OBJ(f = the truck))"
    found = of_things("stands-on", (BOXES, TIRES, TRUCK), words, landmark=(TRUCK,))
    assert found.tolist() == [*costs, 0]


def test_what_is_on_the_ground_stands_on_nothing():
    words = "OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the ground))"
    assert of_things("stands-on", (BOXES, TIRES, TRUCK), words).tolist() == [UNLIKELY, 0, 0]


def test_nothing_is_by_itself():
    words = "OBJ(f = OBJ(f = the pallet), r = {}, l = OBJ(f = {}))".format
    found = of_things("apart", (BOXES, TIRES), words("behind", "it"), landmark=(TIRES,))
    assert found.tolist() == [0, WEIGHT["apart"]]
    for relation, mark in (("by", "itself"), ("of", "tires"), ("which is", "the tires")):
        found = of_things("apart", (BOXES, TIRES), words(relation, mark), landmark=(TIRES,))
        assert not found.any()


def test_of_several_things_no_word_names_one_and_not_another():
    spots = {"a": ("fridge", 3), "b": ("fridge", 6), "c": ("tire", 9)}
    a, b, c = (thing(n, f"{kind} pallet", 5, y, (1, 1)) for n, (kind, y) in spots.items())
    problem = problem_in(Context("yard", (a, b, c, robot()), (), "robot"))
    groups = [(a, b), (a, c), (a,)]
    found = of_groups("each-named", "OBJ(f = the fridge pallets)", groups, problem)
    assert found.tolist() == [0, UNLIKELY, 0]
    assert not of_groups("each-named", "OBJ(f = the pallets)", groups, problem).any()
    # What no label says names one kind of things, but for what may stand for any.
    unknown = of_groups("each-named", "OBJ(f = both coolers)", groups, problem)
    assert unknown.tolist() == [0, UNLIKELY, 0]
    for noun in ("them", "the others", "all the stuff", "both"):
        assert not of_groups("each-named", f"OBJ(f = {noun})", groups, problem).any()


def named_again(second, spoken=frozenset({"truck"}), load=None):
    """What the last noun of two clauses costs, if it means a truck, the other one, or a load."""
    first = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"
    tree = tree_of(f"{first}\nEVENT(r = Pass, l = {second})")
    problem = problem_in(STATE.context, spoken=spoken, load=load)
    groups = [(TRUCK,), (OTHER,), (TIRES,)]
    case = CandidateCase(tree, 5, problem, groups, "figure", 5)
    return adds("named-again", case).tolist()


@pytest.mark.parametrize("noun", ["the truck", "truck", "its bed", "the deck"])
def test_a_noun_that_is_said_again_names_the_same(noun):
    assert named_again(f"OBJ(f = {noun})") == [0, UNLIKELY, UNLIKELY]


@pytest.mark.parametrize("noun", ["the left truck", "another truck", "a truck", "the trailer"])
def test_a_noun_that_says_more_may_name_another_one(noun):
    assert named_again(f"OBJ(f = {noun})") == [0, 0, 0]


def test_what_is_moved_is_not_what_is_said_again():
    assert named_again("OBJ(f = the truck)", load="truck") == [0, 0, 0]


def test_the_nearest_to_something_is_no_further_from_it_than_its_like():
    rank = [thing(name, "pallet", x, 0) for name, x in (("a", 5), ("b", 9), ("c", 14))]
    barrel = thing("barrel", "barrel", 8, 3, (1, 1))
    world = scene(*rank, barrel, agent=robot())

    def costs(relation):
        roles = {"words": "the pallet", "relation": relation, "landmark": (barrel,)}
        return of_examples("superlative", world, "OBJECT", rank, **roles).tolist()

    dear = WEIGHT["superlative"]
    assert costs("nearest") == costs("closest to") == [dear, 0, dear]
    assert costs("farthest from") == [dear, dear, 0]
    assert costs("near") == [0, 0, 0]


def test_what_is_next_to_something_has_nothing_alike_much_nearer():
    rank = [thing(name, "pallet", x, 0) for name, x in (("a", 5), ("b", 9), ("c", 12), ("d", 14))]
    barrel = thing("barrel", "barrel", 1, 3, (1, 1))
    world = scene(*rank, barrel, thing("e", "crate", 1, 4), agent=robot())

    def costs(relation):
        roles = {"words": "the pallet", "relation": relation, "landmark": (barrel,)}
        return of_examples("near-to", world, "OBJECT", rank, **roles).tolist()

    dear = WEIGHT["near-to"]
    assert costs("next to") == costs("by") == costs("near") == [0, dear, dear, dear]
    assert costs("not far from") == costs("left of") == costs("far from") == [0, 0, 0, 0]


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("the first and second pallets from the left", "ab"),
        ("the second and third pallets from the left", "bc"),
        ("the first and second pallets from the right", "bc"),
        ("the two leftmost pallets", "ab"),
        ("the two pallets", "ab bc ac"),
        ("the pallets", "ab bc ac"),
    ],
)
def test_several_things_are_those_that_words_count(words, meant):
    things = {name: thing(name, "pallet", 8, y) for name, y in (("a", 6), ("b", 0), ("c", -6))}
    world = scene(*things.values(), agent=robot())
    pairs = ["ab", "bc", "ac"]
    groups = [tuple(things[n] for n in pair) for pair in pairs]
    cost = of_examples("counted-things", world, "OBJECT", groups, f"OBJ(f = {words})", words=words)
    assert set(cost) <= {0.0, WEIGHT["counted-things"]}
    assert {p for p, c in zip(pairs, cost, strict=True) if c == 0} == set(meant.split())


def test_its_old_position_is_where_the_load_stood():
    tree = tree_of("OBJ(f = its old position)")
    (found,) = ground_thing(tree, 0, around(load="tires"))
    assert found.group[0].prism.xy.mean(axis=0) == pytest.approx((5, 3))
    tree = tree_of("OBJ(f = your original spot)")
    (found,) = ground_thing(tree, 0, around(load="tires"))
    assert found.group[0].prism.xy.mean(axis=0) == pytest.approx((0, 0))


def test_what_a_plan_does_not_need_is_grounded_too():
    tree = tree_of(
        "EVENT(r = Turn, l = EVENT(r = until, l = EVENT(f = OBJ(f = you), r = face, "
        "l = OBJ(f = the truck))))"
    )
    you, truck = (n for n, sdc in enumerate(tree.nodes) if sdc.type == "OBJECT" and sdc.words)
    found = ground_others(tree, {}, around())
    assert set(found) == {you, truck}
    assert found[you][0] == (STATE.context.agent,)
    assert set(ground_others(tree, {you: None}, around())) == {truck}
