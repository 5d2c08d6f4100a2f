from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from g3.annotation import Annotation, Command
from g3.groundings import Context, Grounding, Path, Place
from g3.learning.examples import Example, examples, factor_words, labels, to_batch
from g3.sdc.clauses import SDC, SDC_TYPES, breadth_first
from g3.sdc.sdc_notation import parse_brackets
from tests.strategies import annotations
from tests.worlds import line, log, prism, robot, scene, thing

PALLET = thing("pallet", "tire pallet", 5, 0)
OTHER = thing("other", "tire pallet", 5, 5)
TRUCK = thing("truck", "trailer", 20, 0, (6, 3))
WORLD = scene(PALLET, OTHER, TRUCK, agent=robot(log(line((0, 0), (4, 0)))))
AGENT = WORLD.agent
PATH = Path(AGENT.trajectory)
PLACE = Place(prism(18, 0, z=(1, 2)))

Groundings = tuple[Grounding, ...]


def annotated(
    notation: str,
    groundings: Sequence[Grounding | Groundings | None],
    correct: Sequence[bool | None] | None = None,
    context: Context = WORLD,
) -> Annotation:
    """Groundings in breadth-first order, None where there is none; all of them right."""
    sdcs = parse_brackets(notation)
    count = sum(1 for _ in breadth_first(sdcs))
    assert count == len(groundings)
    plural = tuple(() if g is None else g if isinstance(g, tuple) else (g,) for g in groundings)
    return Annotation(
        "a",
        Command("c", "text", "scenario"),
        context,
        sdcs,
        plural,
        (True,) * count if correct is None else tuple(correct),
        "positive",
    )


def only(type: str, notation: str, groundings: Sequence[Grounding | Groundings | None]) -> Example:
    """The first example of a type."""
    return next(e for e in examples([annotated(notation, groundings)]) if e.sdc.type == type)


PUT = "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
"""In breadth-first order: EVENT, the implicit robot, OBJ, PLACE, OBJ."""
GO = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"
"""EVENT, the implicit robot, PATH, OBJ."""


def test_notation_in_these_tests_makes_implicit_robots() -> None:
    types = [[sdc.type for sdc in breadth_first(parse_brackets(text))] for text in (PUT, GO)]
    assert types == [
        ["EVENT", "OBJECT", "OBJECT", "PLACE", "OBJECT"],
        ["EVENT", "OBJECT", "PATH", "OBJECT"],
    ]


def test_clauses_with_groundings_and_labels_are_examples() -> None:
    annotation = annotated(PUT, [PATH, None, PALLET, PLACE, TRUCK], [True, True, None, False, True])
    found = examples([annotation])
    assert [(e.node, e.sdc.type, e.figure, e.correct) for e in found] == [
        (0, "EVENT", (PATH,), True),
        (3, "PLACE", (PLACE,), False),
        (4, "OBJECT", (TRUCK,), True),
    ]
    assert all(e.annotation is annotation and e.source == "positive" for e in found)
    assert_array_equal(labels(found), [True, False, True])


def test_no_annotations_give_no_examples() -> None:
    assert examples([]) == []
    assert examples([annotated("OBJ(f = the pallet)", [None])]) == []
    assert labels([]).shape == (0,)


@settings(max_examples=20)
@given(annotations())
def test_examples_are_aligned_with_their_clauses(annotation: Annotation) -> None:
    nodes = list(breadth_first(annotation.sdcs))
    found = examples([annotation])
    assert [e.node for e in found] == [
        i
        for i, (groundings, correct) in enumerate(
            zip(annotation.groundings, annotation.correct, strict=True)
        )
        if groundings and correct is not None
    ]
    for e in found:
        assert e.sdc is nodes[e.node]
        assert e.figure == annotation.groundings[e.node]
        assert e.correct == annotation.correct[e.node]
        # Events have themes and goals, the others landmarks; nothing is a path.
        assert not (e.theme or e.goal) if e.sdc.type != "EVENT" else not e.landmark
        assert not any(isinstance(g, Path) for g in (*e.landmark, *e.theme, *e.goal))


def test_an_event_has_a_theme_and_its_place_as_goal() -> None:
    event = only("EVENT", PUT, [PATH, AGENT, PALLET, PLACE, TRUCK])
    assert (event.theme, event.goal, event.landmark) == ((PALLET,), (PLACE,), ())


def test_a_place_that_is_not_grounded_leads_to_its_landmark() -> None:
    event = only("EVENT", PUT, [PATH, AGENT, PALLET, None, TRUCK])
    assert event.goal == (TRUCK,)


def test_a_paths_landmark_is_the_goal() -> None:
    event = only("EVENT", GO, [PATH, AGENT, PATH, TRUCK])
    assert (event.theme, event.goal) == ((), (TRUCK,))


def test_a_second_object_is_the_goal() -> None:
    load = "EVENT(r = Load, l = OBJ(f = the truck), l2 = OBJ(f = the pallet))"
    event = only("EVENT", load, [PATH, AGENT, TRUCK, PALLET])
    assert (event.theme, event.goal) == ((TRUCK,), (PALLET,))


def test_the_agent_is_no_theme() -> None:
    turn = "EVENT(r = Turn, l = OBJ(f = yourself), l2 = OBJ(f = the pallet))"
    assert only("EVENT", turn, [PATH, AGENT, AGENT, PALLET]).theme == (PALLET,)
    assert only("EVENT", turn, [PATH, AGENT, (AGENT, OTHER), PALLET]).theme == (OTHER,)
    assert only("EVENT", turn, [PATH, AGENT, AGENT, None]).theme == ()


def test_a_place_is_no_theme() -> None:
    event = only("EVENT", "EVENT(r = Lift, l = OBJ(f = that))", [PATH, AGENT, PLACE])
    assert event.theme == ()


def test_a_plural_is_a_theme_of_several_things() -> None:
    event = only(
        "EVENT", "EVENT(r = Lift, l = OBJ(f = the pallets))", [PATH, AGENT, (PALLET, OTHER)]
    )
    assert event.theme == (PALLET, OTHER)


BETWEEN = "OBJ(f = OBJ(f = the box), r = between, l = OBJ(f = the truck), l2 = OBJ(f = it))"


def test_both_landmarks_count_together() -> None:
    first, *_ = examples([annotated(BETWEEN, [PALLET, PALLET, TRUCK, OTHER])])
    assert first.figure == (PALLET,)
    assert first.landmark == (TRUCK, OTHER)


def test_a_leaf_has_no_landmark() -> None:
    *_, leaf = examples([annotated(BETWEEN, [PALLET, PALLET, TRUCK, OTHER])])
    assert leaf.landmark == leaf.theme == leaf.goal == ()


def test_a_paths_figure_field_may_hold_its_landmark() -> None:
    path = only("PATH", "PATH(f = OBJ(f = the truck), r = past)", [PATH, TRUCK])
    assert path.landmark == (TRUCK,)


def test_a_landmark_that_is_not_grounded_leads_to_the_one_below() -> None:
    go = "PATH(r = to, l = PLACE(r = beside, l = OBJ(f = the truck)))"
    assert only("PATH", go, [PATH, PLACE, TRUCK]).landmark == (PLACE,)
    assert only("PATH", go, [PATH, None, TRUCK]).landmark == (TRUCK,)


def words(notation: str) -> dict[str, tuple[str, ...]]:
    (sdc,) = parse_brackets(notation)
    return dict(factor_words(sdc))


def test_words_of_an_event() -> None:
    assert words(PUT) == {
        "figure": (), "name": (), "relation": ("put",), "goal": ("on",),
        "landmark": ("the", "pallet", "on", "the", "truck"),
    }  # fmt: skip


def test_words_of_an_object() -> None:
    assert words("OBJ(f = OBJ(f = the pallets), r = next to, l = OBJ(f = it))") == {
        "figure": ("the", "pallet"), "name": ("the", "pallets"),
        "relation": ("next", "to"), "goal": (), "landmark": ("it",),
    }  # fmt: skip


def test_words_of_a_path_have_no_figure() -> None:
    found = words("PATH(f = OBJ(f = it), r = to, l = OBJ(f = the truck))")
    assert (found["figure"], found["relation"], found["goal"]) == ((), ("to",), ())


def test_a_batch_shares_the_groundings_that_examples_share() -> None:
    found = examples(
        [
            annotated(PUT, [PATH, AGENT, PALLET, PLACE, TRUCK]),
            annotated(GO, [PATH, AGENT, PATH, TRUCK]),
            annotated("OBJ(f = the pallets)", [(PALLET, OTHER)]),
        ]
    )
    batch = to_batch(found)
    used = {tuple(map(id, getattr(e, r))) for e in found for r in ("figure", "theme", "goal")}
    used |= {(id(o),) for o in WORLD.objects}
    assert len(batch.bodies.count) == len(used - {()})
    pallet = next(i for i, e in enumerate(found) if e.figure == (PALLET,))
    assert batch.theme[0] == batch.figure[pallet]
    assert batch.bodies.count[batch.figure[-1]] == 2


def test_a_batch_of_examples() -> None:
    found = examples([annotated(PUT, [PATH, None, PALLET, PLACE, TRUCK])])
    batch = to_batch(found)
    assert len(batch) == 4
    assert [SDC_TYPES[i] for i in batch.type] == ["EVENT", "OBJECT", "PLACE", "OBJECT"]
    assert_array_equal(batch.theme >= 0, [True, False, False, False])
    assert_array_equal(batch.landmark >= 0, [False, False, True, False])
    assert [batch.words[i] for i in batch.factor] == [e.words for e in found]
    # Peers are the context's things without the agent.
    peers = batch.bodies.xyz[batch.peers[0], 0, :2]
    assert_allclose(peers, [[5, 0], [5, 5], [20, 0]])
    assert batch.agent_body[0] not in batch.peers


def test_a_batch_of_several_contexts_pads_peers() -> None:
    small = scene(PALLET)
    found = examples(
        [
            annotated("OBJ(f = it)", [PALLET], context=small),
            annotated("OBJ(f = it)", [TRUCK]),
            annotated("OBJ(f = it)", [TRUCK], context=scene()),
        ]
    )
    batch = to_batch(found)
    assert_array_equal((batch.peers >= 0).sum(axis=1), [1, 3, 0])


def test_the_agents_headings() -> None:
    turning = robot(log([(1, 2), (2, 2), (3, 2)], yaw=[0, np.pi - 0.2, -np.pi + 0.2]))
    (found,) = examples([annotated("OBJ(f = it)", [PALLET], context=scene(PALLET, agent=turning))])
    batch = to_batch([found])
    assert_allclose(batch.agent, [[1, 2, 0]])
    assert_allclose(batch.agent_end_yaw, [0.2 - np.pi])
    # The mean of directions: cos 0 + 2 cos(pi - 0.2) is negative, the sines cancel.
    assert_allclose(np.cos(batch.agent_mean_yaw), -1)


@settings(max_examples=15)
@given(st.lists(annotations(), min_size=1, max_size=3))
def test_any_annotations_make_a_batch(drawn: list[Annotation]) -> None:
    found = examples(drawn)
    if found:
        batch = to_batch(found)
        assert len(batch) == len(found)
        for role in ("figure", "landmark", "theme", "goal"):
            counts = [len(getattr(e, role)) for e in found]
            bodies = batch.role(role)  # type: ignore[arg-type]
            assert_array_equal(np.where(bodies < 0, 0, batch.bodies.count[bodies]), counts)


def test_no_examples_make_an_empty_batch() -> None:
    assert len(to_batch([])) == 0


def test_an_sdc_of_no_words_has_no_factor_words() -> None:
    assert set(factor_words(SDC("OBJECT")).values()) == {()}
