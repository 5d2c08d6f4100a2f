"""Several loads on a working day: with the one that is held, the rest, and the same again."""

import pytest

from g3.language.parsing.trees import Parse, Tree
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.following_commands import TIRES, YARD, followed, told, under, world

LEFT = "l2 = PLACE(r = on, l = OBJ(f = the left truck))"
BY_CONE = "l2 = PLACE(r = by, l = OBJ(f = the cone))"


def where(grounder, text, *trees, carries=None, **things):
    """Return what each handled load stands on in the end, by a tree of the text."""
    yard = YARD | things
    if carries:
        yard[carries.replace("-", "_")] = yard[carries.replace("-", "_")][:1]
    parse = told(text, "; ".join(trees))
    result = grounder.follow(parse, world(carries, **yard), least=0.0, insist=True)
    handled = {a.object_id for a in followed(result).actions} - {""}
    return {name: under(result, name) for name in sorted(handled)}


@pytest.mark.parametrize(
    ("text", "trees", "expected"),
    [
        pytest.param(
            "tires on the left truck",
            [f"EVENT(l = OBJ(f = tires), {LEFT})"],
            {"tires-1": "truck-1", "tires-2": "truck-1"},
            id="all tires, where no more is said of them",
        ),
        pytest.param(
            "near tires on the left truck",
            [f"EVENT(l = OBJ(f = near tires), {LEFT})"],
            {"tires-1": "truck-1"},
            id="one pallet of them, where more is said",
        ),
        pytest.param(
            "near tires and near crate on the left truck, the rest by the cone",
            [
                f"EVENT(l = [OBJ(f = near tires), OBJ(f = near crate)], {LEFT})",
                f"EVENT(l = OBJ(f = the rest), {BY_CONE})",
            ],
            {"tires-1": "truck-1", "crate-1": "truck-1", "tires-2": None, "crate-2": None},
            id="the rest of all kinds that were spoken of",
        ),
        pytest.param(
            "near crate on the left truck, the last one by the cone",
            [
                f"EVENT(l = OBJ(f = near crate), {LEFT})",
                f"EVENT(l = OBJ(f = the last one), {BY_CONE})",
            ],
            {"crate-1": "truck-1", "crate-2": None},
            id="the last one is none that was moved",
        ),
        pytest.param(
            "the crates: the near one on the left truck, the far one by the cone",
            [
                "EVENT(l = OBJ(f = the crates))",
                f"EVENT(l = OBJ(f = the near one), {LEFT})",
                f"EVENT(l = OBJ(f = the far one), {BY_CONE})",
            ],
            {"crate-1": "truck-1", "crate-2": None},
            id="a heading names the kind",
        ),
        pytest.param(
            "near tires by the cone, near crate same place",
            [
                f"EVENT(l = OBJ(f = near tires), {BY_CONE})",
                "EVENT(l = OBJ(f = near crate), l2 = OBJ(f = same place))",
            ],
            {"tires-1": None, "crate-1": None},
            id="the same place",
        ),
        pytest.param(
            "near crate on the left truck, near tires with it",
            [
                f"EVENT(l = OBJ(f = near crate), {LEFT})",
                "EVENT(l = OBJ(f = near tires), l2 = PLACE(r = with, l = OBJ(f = it)))",
            ],
            {"crate-1": "truck-1", "tires-1": "truck-1"},
            id="with it, where it is by then",
        ),
        pytest.param(
            "no crate is to be left by the cone, far crate on the left truck",
            [
                f"EVENT(r = is to be left, l = OBJ(f = no crate), {BY_CONE})",
                f"EVENT(l = OBJ(f = far crate), {LEFT})",
            ],
            {"crate-2": "truck-1"},
            id="what must not be left may be moved",
        ),
        pytest.param(
            "near crate on the left truck, nothing else goes by the cone",
            [
                f"EVENT(l = OBJ(f = near crate), {LEFT})",
                f"EVENT(f = OBJ(f = nothing else), r = goes, {BY_CONE})",
            ],
            {"crate-1": "truck-1"},
            id="nothing is to be moved",
        ),
        pytest.param(
            "all crates but the near crate on the left truck, the near crate by the cone",
            [
                "EVENT(l = OBJ(f = OBJ(f = all crates), r = but, l = OBJ(f = the near crate)),"
                f" {LEFT})",
                f"EVENT(l = OBJ(f = the near crate), {BY_CONE})",
            ],
            {"crate-1": None, "crate-2": "truck-1"},
            id="what is excepted from one clause",
        ),
    ],
)
def test_each_load_ends_where_it_is_said(text, trees, expected, grounder):
    assert where(grounder, text, *trees) == expected


def test_what_is_on_the_forks_goes_first(grounder):
    tree = f"EVENT(l = OBJ(f = both crates), {LEFT})"
    text = "both crates on the left truck"
    ends = {"crate-1": "truck-1", "crate-2": "truck-1"}
    assert where(grounder, text, tree, carries="crate-2") == ends


@pytest.mark.parametrize("held", ["what you have", "what you are carrying", "the one on your fork"])
def test_what_the_robot_has_is_on_its_forks(held, grounder):
    tree = f"EVENT(r = put, l = OBJ(f = {held}), {LEFT})"
    found = where(grounder, f"put {held} on the left truck", tree, carries="tires-2")
    assert found == {"tires-2": "truck-1"}


def test_in_its_place_is_where_it_was(grounder):
    found = where(
        grounder,
        "take the tires on the left truck to the cone and put the near crate in their place",
        "EVENT(r = take, l = OBJ(f = OBJ(f = the tires), r = on, l = OBJ(f = the left truck)),"
        " l2 = PATH(r = to, l = OBJ(f = the cone)))",
        "EVENT(r = put, l = OBJ(f = the near crate), l2 = PLACE(r = in, l = OBJ(f = their place)))",
        tires_1=(TIRES, (20, 9), 0, "truck-1"),
    )
    assert found == {"tires-1": None, "crate-1": "truck-1"}


def test_loads_are_told_by_where_they_are_taken_from(grounder):
    found = where(
        grounder,
        "put the tires from the ground on the left truck",
        "EVENT(r = put, l = OBJ(f = the tires), l2 = [PATH(r = from, l = OBJ(f = the ground)),"
        f" {LEFT[5:]}])",
        tires_1=(TIRES, (20, 9), 0, "truck-1"),
    )
    assert found == {"tires-2": "truck-1"}


@pytest.mark.parametrize("noun", ["farmer", "customer", "nurse"])
def test_people_are_persons_by_whatever_they_do(noun, grounder):
    tree = f"EVENT(r = go, l = PATH(r = to, l = OBJ(f = the {noun})))"
    text = f"go to the {noun}"
    parse = told(text, tree)
    there = world(**YARD, person_1=("person", (-6, 8)))
    (action,) = followed(grounder.follow(parse, there, least=0.0)).actions
    assert [thing.id for thing in action.target] == ["person-1"]


@pytest.mark.parametrize(
    "tree",
    [
        "EVENT(r = change places, l = [OBJ(f = near tires), OBJ(f = near crate)])",
        "EVENT(f = [OBJ(f = near tires), OBJ(f = near crate)], r = change places)",
    ],
)
def test_two_loads_change_places(tree, grounder):
    found = where(
        grounder,
        "near tires and near crate change places",
        tree,
        tires_1=(TIRES, (20, 9), 0, "truck-1"),
        tires_2=("crate", (12, 7)),
    )
    assert found == {"tires-1": None, "crate-1": "truck-1"}


def test_what_is_held_goes_before_what_is_named_first(grounder):
    found = where(
        grounder,
        "the near tires on the left truck, and what you have by the cone",
        f"EVENT(l = OBJ(f = the near tires), {LEFT})",
        f"EVENT(l = OBJ(f = what you have), {BY_CONE})",
        carries="crate-2",
    )
    assert found == {"crate-2": None, "tires-1": "truck-1"}


def test_two_on_the_left_are_the_two_leftmost(grounder):
    found = where(
        grounder,
        "the two crates on the left on the left truck",
        f"EVENT(l = OBJ(f = OBJ(f = the two crates), r = on the left), {LEFT})",
        tires_1=("crate", (9, 5)),
        tires_2=("crate", (9, 1)),
    )
    assert found == {"tires-1": "truck-1", "tires-2": "truck-1"}


def test_one_and_one_are_two(grounder):
    found = where(
        grounder,
        "one crate on the left truck, one crate by the cone",
        f"EVENT(l = OBJ(f = one crate), {LEFT})",
        f"EVENT(l = OBJ(f = one crate), {BY_CONE})",
    )
    assert sorted(found) == ["crate-1", "crate-2"]
    assert set(found.values()) == {"truck-1", None}


@pytest.mark.parametrize("last", ["don't put it down", "do not put down"])
def test_what_must_not_be_put_down_stays_on_the_forks(last, grounder):
    text = f"carry the crate to the cone, {last}"
    obj = ", l = OBJ(f = it)" if " it " in last else ""
    verb = last.replace("it ", "")
    trees = (
        "EVENT(r = carry, l = OBJ(f = the crate), l2 = PATH(r = to, l = OBJ(f = the cone)))",
        f"EVENT(r = {verb}{obj})",
    )
    parse = told(text, "; ".join(trees))
    there = world("crate-1", **YARD | {"crate_1": ("crate",)})
    assert followed(grounder.follow(parse, there, least=0.0)).state.held == "crate-1"


@pytest.mark.parametrize("way", ["", ", l2 = PATH(r = counter -)"])
def test_a_hyphenated_word_is_one_word(way, grounder):
    text = "turn 90 degrees counter-clockwise"
    tree = parse_brackets(f"EVENT(r = turn clockwise, l = OBJ(f = 90 degrees){way})", command=text)
    result = grounder.follow(Parse(text, (Tree(tree, 1.0),)), world(**YARD), least=0.0)
    assert followed(result).state.pose[2] > 1


ON_IT = "PLACE(r = on, l = OBJ(f = the left truck))"
NEAR_CRATE_ON_IT = f"EVENT(l = OBJ(f = near crate), {LEFT})"


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        pytest.param(
            "load the left truck with both crates",
            "EVENT(r = load, l = OBJ(f = the left truck), l2 = PLACE(r = with,"
            " l = OBJ(f = both crates)))",
            id="load it with them",
        ),
        pytest.param(
            "complete the left truck with both crates",
            "EVENT(r = complete, l = OBJ(f = the left truck), l2 = PATH(r = with,"
            " l = OBJ(f = both crates)))",
            id="an unknown verb",
        ),
        pytest.param(
            "give the left truck both crates",
            "EVENT(r = give, l = OBJ(f = the left truck), l2 = OBJ(f = both crates))",
            id="give it them",
        ),
        pytest.param(
            "give both crates the left truck",
            "EVENT(r = give, l = OBJ(f = both crates), l2 = OBJ(f = the left truck))",
            id="the other order",
        ),
        pytest.param(
            "the left truck needs both crates",
            "EVENT(f = OBJ(f = the left truck), r = needs, l = OBJ(f = both crates))",
            id="it needs them",
        ),
    ],
)
def test_what_takes_loads_is_their_goal(text, tree, grounder):
    assert where(grounder, text, tree) == {"crate-1": "truck-1", "crate-2": "truck-1"}


@pytest.mark.parametrize(
    ("words", "tree"),
    [
        ("along with it", "EVENT(l = {}, l2 = PLACE(r = along with, l = OBJ(f = it)))"),
        ("right up there with it", "EVENT(l = {}, l2 = PLACE(r = right up there with, l = it))"),
        ("same truck", "EVENT(l = {}, l2 = OBJ(f = same truck))"),
    ],
)
def test_other_loads_go_where_the_one_before_went(words, tree, grounder):
    own = tree.replace("l = it", "l = OBJ(f = it)").format("OBJ(f = the tires)")
    found = where(
        grounder, f"near crate on the left truck, the tires {words}", NEAR_CRATE_ON_IT, own
    )
    assert found == {"crate-1": "truck-1", "tires-1": "truck-1", "tires-2": "truck-1"}


def test_each_goal_takes_one_of_each_kind(grounder):
    found = where(
        grounder,
        "one crate and one pallet of tires on each truck",
        "EVENT(l = [OBJ(f = one crate), OBJ(f = OBJ(f = one pallet), r = of, l = OBJ(f = tires))],"
        " l2 = PLACE(r = on, l = OBJ(f = each truck)))",
    )
    assert {found["crate-1"], found["crate-2"]} == {"truck-1", "truck-2"}
    assert {found["tires-1"], found["tires-2"]} == {"truck-1", "truck-2"}


def test_the_same_elsewhere_is_of_the_same_kinds(grounder):
    found = where(
        grounder,
        "one crate and one pallet of tires on the left truck, the same on the right truck",
        "EVENT(l = [OBJ(f = one crate), OBJ(f = OBJ(f = one pallet), r = of, l = OBJ(f = tires))],"
        f" {LEFT})",
        "EVENT(l = OBJ(f = the same), l2 = PLACE(r = on, l = OBJ(f = the right truck)))",
    )
    assert {found["crate-1"], found["crate-2"]} == {"truck-1", "truck-2"}
    assert {found["tires-1"], found["tires-2"]} == {"truck-1", "truck-2"}


LOADED = {"tires_1": (TIRES, (20, 9), 0, "truck-1")}


@pytest.mark.parametrize("verb", ["take", "unload", "remove"])
def test_what_is_taken_off_is_put_down_where_another_load_comes_next(verb, grounder):
    found = where(
        grounder,
        f"{verb} the tires off the left truck and put both crates there",
        f"EVENT(r = {verb}, l = OBJ(f = the tires), l2 = PATH(r = off, l = OBJ(f = the left"
        " truck)))",
        "EVENT(r = put, l = OBJ(f = both crates), l2 = PLACE(r = there))",
        **LOADED,
    )
    assert found == {"tires-1": None, "crate-1": "truck-1", "crate-2": "truck-1"}


def test_several_loads_in_its_stead_go_where_it_was(grounder):
    found = where(
        grounder,
        "take the tires off the left truck and put both crates in their stead",
        "EVENT(r = take, l = OBJ(f = the tires), l2 = PATH(r = off, l = OBJ(f = the left truck)))",
        "EVENT(r = put, l = OBJ(f = both crates), l2 = PLACE(r = in, l = OBJ(f = their stead)))",
        **LOADED,
    )
    assert found == {"tires-1": None, "crate-1": "truck-1", "crate-2": "truck-1"}


def test_him_is_a_person(grounder):
    tree = "EVENT(r = bring, l = OBJ(f = the near crate), l2 = PATH(r = to, l = OBJ(f = him)))"
    parse = told("bring the near crate to him", tree)
    result = grounder.follow(parse, world(**YARD, person_1=("person", (-6, 8))), least=0.0)
    (end,) = (followed(result).state.thing(name).prism.xy.mean(axis=0) for name in ["crate-1"])
    assert abs(end - (-6, 8)).max() < 4


def test_what_must_not_be_put_somewhere_may_be_put_elsewhere(grounder):
    found = where(
        grounder,
        "the crates don't go by the cone; the crates on the left truck",
        f"EVENT(f = OBJ(f = the crates), r = don't go, {BY_CONE.replace('l2', 'l')})",
        f"EVENT(l = OBJ(f = the crates), {LEFT})",
    )
    assert found == {"crate-1": "truck-1", "crate-2": "truck-1"}


def kinds_done(grounder, text, *trees, carries=None, **things):
    """Return the kinds of the actions for a command, by a tree of the text."""
    parse = told(text, "; ".join(trees))
    result = grounder.follow(parse, world(carries, **YARD | things), least=0.0, insist=True)
    return [action.kind.name for action in followed(result).actions]


GO = "EVENT(r = go, l = PATH(r = to, l = OBJ(f = the cone)))"


@pytest.mark.parametrize(
    ("words", "tree"),
    [
        ("stand by for the inspector", "EVENT(r = stand by for, l = OBJ(f = the inspector))"),
        ("stay there", "EVENT(r = stay, l = PLACE(r = there))"),
        ("wait just there", "EVENT(r = wait, l = PLACE(r = just there))"),
    ],
)
def test_who_is_to_stay_does_nothing_else(words, tree, grounder):
    went, waited = kinds_done(grounder, f"go to the cone and {words}", GO, tree)
    assert (went.split()[0], waited) == ("drive", "wait")


@pytest.mark.parametrize("verb", ["approach", "reach", "inspect"])
def test_what_cannot_be_lifted_is_gone_to(verb, grounder):
    tree = f"EVENT(r = {verb}, l = OBJ(f = the person))"
    (done,) = kinds_done(grounder, f"{verb} the person", tree, person_1=("person", (-6, 8)))
    assert done.startswith("drive")


@pytest.mark.parametrize(
    ("text", "tree", "kind"),
    [
        ("pass the cone", "EVENT(r = pass, l = PATH(l = OBJ(f = the cone)))", "past"),
        ("get out of the way", "EVENT(r = get, l = PATH(r = out of, l = OBJ(f = the way)))", ""),
    ],
)
def test_ways_that_are_none(text, tree, kind, grounder):
    (done,) = kinds_done(grounder, text, tree)
    assert kind in done
    assert kind or not done.startswith(("pick", "carry"))
