"""What a command's words together say of the load is heard by the search."""

from dataclasses import replace

import pytest

from g3.actions.robot_state import start_state
from g3.inference.grounder import Grounder
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.loads_of_state import loads_of, words_of
from g3.learning.grounding_model import GroundingModel
from g3.learning.load_choice import Load, LoadChoice, LoadChooser
from g3.sdc.sdc_notation import parse_brackets

TEXT = "Pick up the gizmo"
RIGHT = parse_brackets("EVENT_1(r = Pick up, l = OBJ_2(f = the gizmo))", command=TEXT)


@pytest.fixture(scope="module")
def known_yard(warehouse):
    """All that stands here has labels that the model has learned."""
    return warehouse.contexts["court_put_crate_on_trailer"]


@pytest.fixture(scope="module")
def yard(known_yard):
    """The same where the crates are of a kind that the model has never seen."""
    things = tuple(
        replace(o, labels=("turbine",)) if "crate" in o.labels else o for o in known_yard.objects
    )
    return replace(known_yard, objects=things)


def taught(model, kinds, meant):
    """The model with what somebody who calls one kind of load a gizmo has taught it."""
    choices = [
        LoadChoice(
            ("pick", "up", "the", word),
            tuple(Load(kind, 5.0, 0.0) for kind in kinds),
            tuple((kind == meant) == (word == "gizmo") for kind in kinds),
            scenario=f"{word}{n}",
        )
        for word in ("gizmo", "gadget")
        for n in range(8)
    ]
    known = GroundingModel()
    return known.with_weights(model.space_, model.weights_, LoadChooser.fit(choices))


def planned(model, context, **options):
    return Grounder.load(model, **options).follow(RIGHT, context, least=0.0, insist=True).plan


def kinds_in(context):
    """The labels of the loads in a context, by their ids and each once."""
    loads = {name: load.labels for name, load in loads_of(start_state(context)).items()}
    return loads, sorted(set(loads.values()))


def test_a_word_means_what_it_was_taught_to_mean(model, yard):
    loads, kinds = kinds_in(yard)
    assert len(kinds) > 1
    for meant in kinds:
        actions = planned(taught(model, kinds, meant), yard).actions
        (thing,) = {a.object_id for a in actions if a.object_id}
        assert loads[thing] == meant


def test_it_can_be_switched_off_and_a_model_without_it_is_as_before(model, yard):
    _, kinds = kinds_in(yard)
    plain = planned(model, yard)
    for meant in kinds:
        off = planned(taught(model, kinds, meant), yard, without=["command-load"])
        assert off.score == plain.score


def test_where_all_labels_are_known_the_clauses_factors_tell(model, known_yard):
    _, kinds = kinds_in(known_yard)
    plain = planned(model, known_yard)
    for meant in kinds:
        assert planned(taught(model, kinds, meant), known_yard).score == plain.score


def test_words_of_a_tree_are_in_the_order_of_the_command():
    text = "Lift, then carry it to the truck"
    tree = parse_brackets(
        "EVENT_1(r = Lift); EVENT_2(r = carry, l = OBJ_3(f = it), "
        "l2 = PATH_4(r = to, l = OBJ_5(f = the truck)))",
        command=text,
    )
    assert words_of(Tree(tree)) == ("lift", "carry", "it", "to", "the", "truck")


@pytest.mark.parametrize(
    ("text", "telling"),
    [
        # What the load stands by, or is driven around, isn't the load.
        ("EVENT(r = lift, l = OBJ(f = OBJ(f = the gizmo), r = by, l = OBJ(f = the gadget)))", True),
        (
            "EVENT(r = go, l = PATH(r = around, l = OBJ(f = the gadget)))\n"
            "EVENT(r = lift, l = OBJ(f = the gizmo))",
            True,
        ),
        # Nor is what must be left alone.
        (
            "EVENT(r = Don't touch, l = OBJ(f = the gadget))\n"
            "EVENT(r = lift, l = OBJ(f = the gizmo))",
            True,
        ),
        # A pronoun is what the words say that it stands for.
        (
            "EVENT(r = go, l = PATH(r = to, l = OBJ(f = OBJ(f = the gizmo), r = by, "
            "l = OBJ(f = the gadget))))\nEVENT(r = lift, l = OBJ(f = it))",
            True,
        ),
        # "The pallet by the gizmo" says nothing of which kind is meant.
        ("EVENT(r = lift, l = OBJ(f = OBJ(f = the load), r = by, l = OBJ(f = the gizmo)))", False),
    ],
)
def test_only_words_for_the_load_tell_it(text, telling, model, yard):
    _, kinds = kinds_in(yard)
    sdcs = parse_brackets(text)
    for meant in kinds:
        grounder = Grounder.load(taught(model, kinds, meant))
        plan = grounder.follow(sdcs, yard, least=0.0, insist=True).plan
        off = Grounder.load(model).follow(sdcs, yard, least=0.0, insist=True).plan
        (thing,) = {a.object_id for a in plan.actions if a.object_id}
        if telling:
            assert loads_of(start_state(yard))[thing].labels == meant
        else:
            assert plan.score == off.score


@pytest.mark.parametrize("label", ["turbine", "wind turbine"])
def test_who_names_a_load_by_its_label_means_its_kind(label, model, yard):
    things = (replace(o, labels=(label,)) if "turbine" in o.labels else o for o in yard.objects)
    context = replace(yard, objects=tuple(things))
    _, kinds = kinds_in(context)
    sdcs = parse_brackets(
        "EVENT(r = face, l = OBJ(f = the gizmo gizmo gizmo))\n"
        f"EVENT(r = lift, l = OBJ(f = the {label}))"
    )
    for meant in kinds:
        plan = Grounder.load(taught(model, kinds, meant)).follow(sdcs, context, least=0.0).plan
        handled = {a.object_id for a in plan.actions if a.object_id}
        assert {loads_of(start_state(context))[load].labels for load in handled} == {(label,)}
