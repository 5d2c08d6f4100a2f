"""The forklift's actions: where they go, what they change, and what they need."""

from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from g3.actions.action_kinds import (
    KINDS,
    Action,
    Focus,
    action_kind,
    kind_named,
    move,
    possible_actions,
    result,
)
from g3.actions.courses import TURNING_RADIUS_M
from g3.actions.forklift_actions import (
    BACK_UP,
    CARRY,
    DRIVE_PAST,
    DRIVE_TO,
    PICK_UP,
    PUT_DOWN,
    TURN,
    WAIT,
)
from g3.actions.grounding_candidates import are_free
from g3.actions.logged_actions import REACH_M, Outcome, recorded
from g3.actions.motions import LIFT_M, LIFT_M_S, SPEED_M_S
from g3.actions.robot_state import start_state
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import convex_hull, point_gap, rotate
from g3.groundings import Context, FloatArray, Prism, Trajectory
from tests.g3.actions.yards import Pose, done, spot, thing, with_load, yard
from tests.strategies import metres, prisms

PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
POSES = st.tuples(st.floats(-6, 6), st.floats(-8, 8), st.floats(-3, 3))


@st.composite
def outcomes(draw: st.DrawFn) -> tuple[Context, Outcome]:
    """What some action gives in a yard, from some start, with or without a load."""
    context = draw(st.sampled_from([yard, with_load]))(draw(POSES))
    things = tuple((o,) for o in recorded(context).objects)
    goals = (*((place,) for place in context.places), *things)
    actions = possible_actions(start_state(context), Focus(("tires", "boxes"), goals))
    return context, done(context, draw(st.sampled_from(actions)))


def in_agent_frame(agent: Trajectory, load: Trajectory) -> FloatArray:
    """Poses of a load relative to the agent, shape (n, 3)."""
    offset = rotate(load.xyz[:, :2] - agent.xyz[:, :2], -agent.yaw)
    return np.column_stack((offset, load.yaw - agent.yaw))


@settings(max_examples=25)
@given(outcomes())
def test_an_action_starts_where_the_context_does(made: tuple[Context, Outcome]) -> None:
    context, outcome = made
    for before, after in zip(
        (*recorded(context).objects, context.agent), (*outcome.objects, outcome.agent), strict=True
    ):
        assert (after.id, after.labels, after.prism) == (before.id, before.labels, before.prism)
        assert after.trajectory.t[0] == before.trajectory.t[0]
        np.testing.assert_allclose(after.trajectory.xyz[0], before.trajectory.xyz[0], atol=1e-9)
        assert after.trajectory.yaw[0] == pytest.approx(before.trajectory.yaw[0])


@settings(max_examples=25)
@given(outcomes())
def test_nothing_teleports(made: tuple[Context, Outcome]) -> None:
    _, outcome = made
    track = outcome.agent.trajectory
    dt = np.diff(track.t)
    assert (dt >= -1e-9).all()
    assert (np.linalg.norm(np.diff(track.xyz, axis=0), axis=1) <= SPEED_M_S * dt + 1e-6).all()
    for o in outcome.objects:
        rise = np.abs(np.diff(o.trajectory.xyz[:, 2]))
        assert (rise <= LIFT_M_S * np.diff(o.trajectory.t) + 1e-6).all()


@settings(max_examples=25)
@given(outcomes())
def test_at_most_one_object_moves_and_it_moves_with_the_agent(
    made: tuple[Context, Outcome],
) -> None:
    _, outcome = made
    carried = [o for o in outcome.objects if len(o.trajectory) > 1]
    assert len(carried) <= 1
    for o in carried:
        high = o.trajectory.xyz[:, 2]
        moves = np.linalg.norm(np.diff(o.trajectory.xyz[:, :2], axis=0), axis=1) > 1e-6
        held = np.flatnonzero((high[1:] == high.max()) & moves) + 1
        # Samples lie on straight lines between poses, so that in bends both cut corners.
        relative = in_agent_frame(outcome.agent.trajectory, o.trajectory)[held]
        np.testing.assert_allclose(
            relative, np.broadcast_to(relative[:1], relative.shape), atol=0.05
        )
        assert (np.abs(np.hypot(*relative[:, :2].T) - 1.1) < 0.1).all()


@settings(max_examples=20)
@given(POSES, st.sampled_from(["tires", "boxes"]), st.sampled_from([0, 1]))
def test_a_carried_object_ends_on_the_place(agent: Pose, load: str, place: int) -> None:
    context = yard(agent)
    target = context.places[place]
    outcome = done(context, Action(CARRY, load, place=target))
    end = thing(outcome.objects, load).trajectory
    np.testing.assert_allclose(end.xyz[-1, :2], centre(target.prism), atol=1e-6)
    assert end.xyz[-1, 2] - 0.35 == pytest.approx((0.0, 0.85)[place])
    away = np.linalg.norm(outcome.agent.trajectory.xyz[-1, :2] - centre(target.prism))
    assert away == pytest.approx(REACH_M + 2.5)


@settings(max_examples=20)
@given(POSES)
def test_a_load_is_put_down(agent: Pose) -> None:
    context = with_load(agent)
    outcome = done(context, Action(PUT_DOWN, "load", place=context.places[0]))
    end = thing(outcome.objects, "load").trajectory
    np.testing.assert_allclose(end.xyz[-1], [4.0, -9.0, 0.35], atol=1e-6)


@settings(max_examples=20)
@given(POSES, st.sampled_from(["tires", "boxes"]))
def test_picking_up_lifts(agent: Pose, load: str) -> None:
    track = thing(done(yard(agent), Action(PICK_UP, load)).objects, load).trajectory
    assert track.xyz[-1, 2] - track.xyz[0, 2] == pytest.approx(LIFT_M)
    assert np.linalg.norm(track.xyz[-1, :2] - track.xyz[0, :2]) == pytest.approx(1.0)


def test_driving_to_an_object_stops_in_front_of_it_and_faces_it() -> None:
    context = yard()
    boxes = thing(context.objects, "boxes")
    end = done(context, Action(DRIVE_TO, target=(boxes,))).agent.trajectory
    gap = point_gap(end.xyz[None, -1:, :2], convex_hull(boxes.prism.xy)[None])[0, 0]
    assert gap == pytest.approx(2.5, abs=0.25)
    ahead = centre(boxes.prism) - end.xyz[-1, :2]
    assert np.cos(np.arctan2(ahead[1], ahead[0]) - end.yaw[-1]) == pytest.approx(1.0)


def test_driving_into_a_place_ends_in_its_middle() -> None:
    context = yard()
    end = done(context, Action(DRIVE_TO, target=(context.places[0],))).agent.trajectory
    np.testing.assert_allclose(end.xyz[-1, :2], [4.0, -9.0], atol=1e-6)


def test_driving_past_keeps_clear_and_ends_beyond() -> None:
    context = yard()
    tires = thing(context.objects, "tires")
    track = done(context, Action(DRIVE_PAST, target=(tires,))).agent.trajectory.xyz[:, :2]
    gaps = point_gap(track[None], convex_hull(tires.prism.xy)[None])[0]
    assert gaps.min() > 1.0
    assert np.argmin(gaps) < len(gaps) - 1
    assert track[-1, 0] > 12


def test_turning_and_backing_up() -> None:
    turned = done(yard(), Action(TURN, amount=-np.pi / 2)).agent.trajectory
    assert turned.yaw[-1] == pytest.approx(-np.pi / 2)
    np.testing.assert_allclose(turned.xyz[-1], [0.0, 0.0, 0.0], atol=1e-9)
    backed = done(yard((1.0, 2.0, np.pi / 2)), Action(BACK_UP, amount=-3.0)).agent.trajectory
    np.testing.assert_allclose(backed.xyz[-1], [1.0, -1.0, 0.0], atol=1e-9)
    assert backed.yaw == pytest.approx(np.pi / 2)


def test_a_way_backs_up_where_a_curve_would_be_too_tight() -> None:
    behind = spot(-3.0, 0.0)
    track = done(yard(), Action(DRIVE_TO, target=(behind,))).agent.trajectory
    step = rotate(np.diff(track.xyz[:, :2], axis=0), -track.yaw[:-1])
    assert step[0, 0] < 0
    assert -track.xyz[:, 0].min() >= TURNING_RADIUS_M


def test_kinds_need_free_forks_or_a_load() -> None:
    empty, full = start_state(yard()), start_state(with_load())
    for kind in KINDS.values():
        needs_load = kind.leaves and not kind.takes
        assert kind.fits(empty) == (not needs_load)
        assert kind.fits(full) == (not kind.takes)


def test_kinds_tell_what_is_on_the_forks_afterwards() -> None:
    for context, action, held in (
        (yard(), Action(PICK_UP, "tires"), "tires"),
        (yard(), Action(CARRY, "tires", place=spot(0.0, 8.0)), None),
        (with_load(), Action(PUT_DOWN, "load", place=spot(0.0, 8.0)), None),
        (with_load(), Action(TURN, amount=1.0), "load"),
    ):
        state = start_state(context)
        assert result(state, action, move(state, [action]), 0).held == held


def test_a_kind_is_itself_in_another_process_too() -> None:
    action = Action(PICK_UP, "tires")
    assert pickle.loads(pickle.dumps(action)) == action
    assert kind_named("pick up") is PICK_UP
    assert str(PICK_UP) == "pick up"


def test_others_add_kinds() -> None:
    @action_kind("nod", WAIT.course, unit="rad")
    def nod(state, focus):
        """Tilt the mast back and forth."""
        return [Action(nod, amount=0.1)]

    try:
        state = start_state(yard())
        (found,) = [a for a in possible_actions(state, Focus()) if a.kind is nod]
        assert found.kind.description == "Tilt the mast back and forth."
        assert result(state, found, move(state, [found]), 0).pose == pytest.approx(state.pose)
        with pytest.raises(ValueError, match="'nod' is registered already"):
            action_kind("nod", WAIT.course)(nod.propose)
    finally:
        KINDS.remove("nod")


SHOW = """
from g3.actions.action_kinds import Focus, kind_named, possible_actions
from g3.actions.robot_state import start_state
from tests.g3.actions.yards import yard

actions = possible_actions(start_state(yard()), Focus())
(action,) = (action for action in actions if action.kind.name == "look back")
print(action.kind.description, action.amount > 3)
"""


def test_other_distributions_add_kinds(tmp_path):
    info = tmp_path / "own_actions-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-actions\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[g3.actions]\nown = own_actions\n")
    page = Path(__file__).parents[3] / "docs" / "actions.md"
    (code,) = (c for c in PYTHON.findall(page.read_text()) if "@action_kind" in c)
    (tmp_path / "own_actions.py").write_text(code)
    paths = os.pathsep.join([str(tmp_path), str(Path.cwd())])
    run = [sys.executable, "-c", SHOW]
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(run, check=True, capture_output=True, text=True, env=environment)
    assert done.stdout == "Turn half around, to see what is behind. True\n"


def test_a_place_is_free_unless_something_stands_there() -> None:
    state = start_state(yard())
    at_tires, beside_them, on_truck = spot(10.0, 3.0), spot(10.0, 5.5), spot(-3.0, 14.0, 0.85)
    spots = [at_tires, beside_them, on_truck, spot(-3.0, 14.0)]
    assert are_free(spots, state, None).tolist() == [False, True, True, False]
    assert are_free(spots, state, "tires").tolist() == [True, True, True, False]


@given(prisms(), st.tuples(metres(), metres()), st.sampled_from([0.0, 0.5]))
def test_a_footprint_covers_what_is_no_further_from_it_than_the_margin(
    prism: Prism, offset: tuple[float, float], margin: float
) -> None:
    point = centre(prism) + np.array(offset) / 40
    gap = point_gap(point[None, None], convex_hull(prism.xy)[None])[0, 0]
    assume(gap == 0 or abs(gap - margin) > 1e-6)
    assert covers(prism, point, margin) == (gap <= margin)
