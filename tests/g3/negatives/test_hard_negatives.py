from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import CARRY, DRIVE_TO, PUT_DOWN
from g3.actions.logged_actions import end_of, handling, loaded, moved, recorded
from g3.annotation import Annotation, Command
from g3.groundings import Context, Grounding, Path, PhysicalObject, Place, Trajectory
from g3.learning.examples import examples
from g3.negatives.hard_negatives import hard_negatives
from g3.sdc.clauses import SDC, Span, breadth_first
from tests.g3.actions.yards import box, logged, spot, with_load, yard
from tests.strategies import annotations

Groundings = tuple[Grounding, ...]


def words(text: str) -> tuple[Span, ...]:
    return tuple(Span(7 * i, word) for i, word in enumerate(text.split()))


def leaf(text: str) -> SDC:
    return SDC("OBJECT", words(text))


def thing(context: Context, id: str) -> PhysicalObject:
    return next(o for o in context.objects if o.id == id)


def annotation(
    id: str, context: Context, sdc: SDC, groundings: dict[int, Groundings]
) -> Annotation:
    """A positive annotation of one clause; `groundings` by index in breadth-first order."""
    count = sum(1 for _ in breadth_first([sdc]))
    return Annotation(
        id,
        Command(f"{id}/command", "text", "scenario"),
        context,
        (sdc,),
        tuple(groundings.get(n, ()) for n in range(count)),
        (True,) * count,
        "positive",
    )


def scene() -> Context:
    context = yard((0.0, 0.0, 0.0), box("more tires", "tire pallet", (6.0, 8.0, 0.0)))
    floor = [spot(x, y) for x, y in ((12.0, 9.0), (0.0, -6.0), (14.0, 0.0))]
    return replace(context, places=(*context.places, *floor))


def put_on_truck(id: str = "put") -> Annotation:
    """Put (the tire pallet by the boxes) (on the truck): the log carries tires to the truck."""
    context = scene()
    context = logged(context, Action(CARRY, "tires", place=context.places[1]))
    tires, boxes, truck = (thing(context, name) for name in ("tires", "boxes", "truck"))
    theme = SDC(
        "OBJECT",
        relation=words("by"),
        figure=(leaf("the tire pallet"),),
        landmark1=(leaf("the boxes"),),
    )
    where = SDC("PLACE", relation=words("on"), landmark1=(leaf("the truck"),))
    sdc = SDC(
        "EVENT",
        relation=words("put"),
        figure=(SDC("OBJECT"),),
        landmark1=(theme,),
        landmark2=(where,),
    )
    # In breadth-first order: put, robot, theme, where, tire pallet, boxes, truck.
    found: dict[int, Groundings] = {
        0: (context.agent,),
        2: (tires,),
        3: (context.places[1],),
        4: (tires,),
        5: (boxes,),
        6: (truck,),
    }
    return annotation(id, context, sdc, found)


def go_to_truck(id: str = "go") -> Annotation:
    context = scene()
    context = logged(context, Action(DRIVE_TO, target=(thing(context, "truck"),)))
    path = SDC("PATH", relation=words("to"), landmark1=(leaf("the truck"),))
    sdc = SDC("EVENT", relation=words("go"), figure=(SDC("OBJECT"),), landmark1=(path,))
    found: dict[int, Groundings] = {
        0: (context.agent,),
        2: (Path(context.agent.trajectory),),
        3: (thing(context, "truck"),),
    }
    return annotation(id, context, sdc, found)


def pick_it_up(id: str = "pick") -> Annotation:
    context = scene()
    context = logged(context, Action(CARRY, "tires", place=context.places[1]))
    sdc = SDC(
        "EVENT",
        relation=words("pick up"),
        figure=(SDC("OBJECT"),),
        landmark1=(leaf("the pallet"),),
    )
    return annotation(id, context, sdc, {0: (context.agent,), 2: (thing(context, "tires"),)})


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def one(annotations: list[Annotation], ending: str) -> Annotation:
    (found,) = [a for a in annotations if a.id.endswith(ending)]
    return found


def many(positive: Annotation, count: int = 12) -> list[Annotation]:
    """Hard negatives of one positive under many ids, which draw independently."""
    return hard_negatives(
        [replace(positive, id=f"{positive.id}-{i}") for i in range(count)], generator()
    )


def test_they_are_deterministic_and_do_not_depend_on_order() -> None:
    positives = [put_on_truck(), go_to_truck(), pick_it_up()]
    first = hard_negatives(positives, generator())
    again = hard_negatives(positives[::-1], generator())
    assert {a.id: a for a in first} == {a.id: a for a in again}
    assert first != hard_negatives(positives, generator(1))


def test_only_positives_give_negatives() -> None:
    positive = put_on_truck()
    others = [replace(positive, id="random", source="random")]
    made = hard_negatives([positive, *others], generator())
    assert {a.id.split("/")[0] for a in made} == {"put"}
    assert {a.source for a in made} == {"hard"}


def test_every_example_is_wrong_and_every_label_has_a_grounding() -> None:
    made = hard_negatives([put_on_truck(), go_to_truck(), pick_it_up()], generator())
    for a in made:
        assert True not in a.correct
        assert any(label is False for label in a.correct)
        for groundings, label in zip(a.groundings, a.correct, strict=True):
            assert label is None or groundings
    assert len(examples(made)) == sum(label is False for a in made for label in a.correct)


def test_actions_start_in_the_commands_own_state() -> None:
    for a in many(put_on_truck()):
        if "hard-action-" in a.id:
            (agent,) = a.groundings[0]
            assert isinstance(agent, PhysicalObject)
            own = a.context.agent.trajectory
            np.testing.assert_array_equal(agent.trajectory.xyz[0], own.xyz[0])
            assert agent.trajectory.t[0] == own.t[0]


def test_landmarks_of_actions_stay_right_and_move_as_the_action_moves_them() -> None:
    positive = put_on_truck()
    moves = 0
    for a in many(positive):
        if "hard-action-" not in a.id:
            continue
        assert a.correct == (False, *(None,) * 6)
        for groundings, right in zip(a.groundings[2:], positive.groundings[2:], strict=True):
            assert [getattr(g, "id", "") for g in groundings] == [
                getattr(g, "id", "") for g in right
            ]
        (theme,), (agent,) = a.groundings[2], a.groundings[0]
        assert isinstance(theme, PhysicalObject)
        assert isinstance(agent, PhysicalObject)
        assert theme == a.groundings[4][0]
        if len(theme.trajectory) > 1:
            moves += 1
            assert set(theme.trajectory.t) <= set(agent.trajectory.t)
    assert moves


def test_an_object_carried_elsewhere_is_neither_where_the_log_puts_it_nor_at_the_goal() -> None:
    positive = put_on_truck()
    right = end_of(thing(positive.context, "tires"))
    for a in many(positive):
        theme = a.groundings[2][0]
        if "hard-action-" not in a.id:
            continue
        assert isinstance(theme, PhysicalObject)
        if len(theme.trajectory) > 1:
            end = end_of(theme)
            assert np.linalg.norm(end - right) > 3.0
            assert np.linalg.norm(end - [-3.0, 14.0]) > 2.0


def test_an_object_that_is_picked_up_is_left_alone_by_every_wrong_action() -> None:
    made = [a for a in many(pick_it_up()) if "hard-action-" in a.id]
    assert made
    for a in made:
        theme = a.groundings[2][0]
        assert isinstance(theme, PhysicalObject)
        assert len(theme.trajectory) == 1


def test_a_path_shares_the_action_of_its_event_and_ends_away_from_its_landmark() -> None:
    log = go_to_truck().context.agent.trajectory
    for a in many(go_to_truck()):
        if "hard-action-" not in a.id:
            continue
        (agent,), (path,) = a.groundings[0], a.groundings[2]
        assert isinstance(agent, PhysicalObject)
        assert isinstance(path, Path)
        assert path.trajectory == agent.trajectory
        assert a.correct[2] is False
        end = agent.trajectory.xyz[-1, :2]
        assert np.linalg.norm(end - log.xyz[-1, :2]) > 4.0
        assert a.context.agent.trajectory == agent.trajectory


def test_half_of_the_actions_do_to_a_load_what_the_log_does() -> None:
    kinds = put_on_truck(), go_to_truck()
    positives = [replace(a, id=f"{a.id}-{i}") for a in kinds for i in range(40)]
    made = [a for a in hard_negatives(positives, generator()) if "hard-action-" in a.id]
    carried = {
        kind: np.mean(
            [handling(a.context) == CARRY.handling for a in made if a.id.startswith(kind)]
        )
        for kind in ("put", "go")
    }
    assert 0.5 < carried["put"] < 0.95
    assert 0.05 < carried["go"] < 0.5


def test_landmarks_of_objects_stay_right() -> None:
    positive = put_on_truck()
    made = hard_negatives([positive], generator())
    relational = one(made, "hard-objects-1")
    assert relational.correct == (None, None, False, False, None, None, None)
    assert relational.groundings[5:] == positive.groundings[5:]
    assert relational.groundings[2] != positive.groundings[2]
    leaves = one(made, "hard-objects-2")
    assert leaves.correct == (None, None, None, None, False, False, False)
    assert leaves.groundings[:4] == positive.groundings[:4]


def test_another_object_is_one_of_the_scene_with_other_labels() -> None:
    positive = put_on_truck()
    for a in many(positive):
        if a.id.endswith("hard-objects-2"):
            for n, own in ((4, "tires"), (5, "boxes"), (6, "truck")):
                (other,) = a.groundings[n]
                assert isinstance(other, PhysicalObject)
                assert other in a.context.objects
                assert other.labels != thing(a.context, own).labels
                assert other.id != a.context.agent_id


def test_an_object_named_by_its_relation_may_be_mistaken_for_one_alike() -> None:
    found = {
        getattr(g, "id", "")
        for a in many(put_on_truck(), 30)
        if a.id.endswith("hard-objects-1")
        for g in a.groundings[2]
    }
    assert "more tires" in found
    assert "tires" not in found
    assert len(found) > 1


def test_another_place_is_elsewhere_and_free() -> None:
    positive = put_on_truck()
    right = positive.groundings[3][0]
    assert isinstance(right, Place)
    for a in many(positive):
        if a.id.endswith("hard-objects-1"):
            (other,) = a.groundings[3]
            assert isinstance(other, Place)
            shift = other.prism.xy - right.prism.xy
            np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-9)
            assert np.linalg.norm(shift[0]) > 3.0


def test_words_that_fit_all_objects_alike_give_only_what_they_cannot_mean() -> None:
    for a in many(pick_it_up()):
        if a.id.endswith("hard-objects-1"):
            assert [getattr(g, "id", "") for g in a.groundings[2]] == ["truck"]


def test_a_clause_without_a_wrong_candidate_is_no_example() -> None:
    context = scene()
    lonely = replace(
        context, objects=tuple(o for o in context.objects if o.id in ("tires", "agent"))
    )
    positive = annotation("lonely", lonely, leaf("the pallet"), {0: (lonely.objects[0],)})
    assert hard_negatives([positive], generator()) == []


def test_labels_that_are_not_positive_give_no_examples() -> None:
    positive = put_on_truck()
    unsure = replace(positive, correct=(None,) * 7)
    assert hard_negatives([unsure], generator()) == []


@pytest.mark.parametrize("kind", ["put", "go"])
def test_a_load_from_the_start_stays_on_the_forks_or_is_put_down(kind: str) -> None:
    context = with_load()
    put = Action(PUT_DOWN, "load", place=spot(8.0, 8.0))
    go = Action(DRIVE_TO, target=(thing(context, "truck"),))
    context = logged(context, put if kind == "put" else go)
    sdc = SDC("EVENT", relation=words("do"), landmark1=(leaf("the load"),))
    positive = annotation(kind, context, sdc, {0: (context.agent,), 1: (thing(context, "load"),)})
    assert loaded(context) == "load"
    assert moved(recorded(context)) == {"load"}
    for a in many(positive):
        if "hard-action-" in a.id:
            (load,) = a.groundings[1]
            assert isinstance(load, PhysicalObject)
            assert len(load.trajectory) > 1


@settings(max_examples=20)
@given(annotations())
def test_any_annotation_gives_only_wrong_examples(positive: Annotation) -> None:
    for a in hard_negatives([replace(positive, source="positive")], generator()):
        assert len(a.groundings) == len(a.correct) == len(positive.correct)
        for label, groundings, before in zip(
            a.correct, a.groundings, positive.correct, strict=True
        ):
            assert label is not True
            assert label is None or (groundings and before)


def test_a_place_without_height_keeps_it_where_it_is_moved() -> None:
    low = -0.6657574557760609  # sums with it round, so that it could end below its own bottom
    context = scene()
    agent = context.agent
    raised = Trajectory(
        agent.trajectory.t, agent.trajectory.xyz + np.eye(3)[2], agent.trajectory.yaw
    )
    context = replace(
        context,
        objects=tuple(
            replace(o, trajectory=raised) if o.id == agent.id else o for o in context.objects
        ),
    )
    flat = Place(replace(spot(1.0, 1.0).prism, z_min=low, z_max=low))
    positive = annotation("flat", context, leaf("there"), {0: (flat,)})
    made = [a for a in many(positive) if "hard-objects" in a.id]
    assert made
    for a in made:
        for place in a.groundings[0]:
            assert isinstance(place, Place)
            assert place.prism.z_min == place.prism.z_max
