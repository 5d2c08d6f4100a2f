from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from g3.actions.action_candidates import candidates, kind_of, moved, perform, square
from g3.actions.action_log import DEFAULT_PACE, Pace
from g3.actions.driving import TURNING_RADIUS_M, route, straight
from g3.actions.logged_actions import (
    LIFT_M,
    REACH_M,
    Outcome,
    back_up,
    carry,
    centre,
    covers,
    drive_along,
    drive_past,
    drive_to,
    loaded,
    pick_up,
    put_down,
    recorded,
    turn,
)
from g3.geometry.plane import convex_hull, point_gap, rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Place, Prism, Trajectory
from tests.strategies import metres, prisms
from tests.worlds import log, prism


def box(
    id: str,
    labels: str,
    pose: tuple[float, float, float],
    size: tuple[float, float] = (1.2, 1.2),
    z: tuple[float, float] = (0.0, 0.7),
) -> PhysicalObject:
    x, y, yaw = pose
    way = log([(x, y)], yaw, sum(z) / 2, [100.0])
    return PhysicalObject(id, tuple(labels.split()), prism(x, y, size, z, yaw), way)


def forklift(pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> PhysicalObject:
    agent = box("agent", "forklift", pose, (1.5, 1.5), (0.0, 2.0))
    xyz = agent.trajectory.xyz * [1, 1, 0]
    return replace(agent, trajectory=Trajectory(agent.trajectory.t, xyz, agent.trajectory.yaw))


def yard(agent: tuple[float, float, float] = (0.0, 0.0, 0.0), *more: PhysicalObject) -> Context:
    objects = (
        box("tires", "tire pallet", (10.0, 3.0, 0.3)),
        box("boxes", "box pallet", (10.0, -3.0, 0.0)),
        box("truck", "trailer", (-3.0, 14.0, 0.0), (6.0, 2.4), (0.4, 0.85)),
        *more,
        forklift(agent),
    )
    places = (
        Place(square(np.array([4.0, -9.0]), 0.2)),
        Place(square(np.array([-4.0, 14.0]), 0.85)),
    )
    return Context("yard", objects, places, "agent")


def with_load(agent: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Context:
    x, y, yaw = agent
    at = (x + 1.12 * np.cos(yaw), y + 1.12 * np.sin(yaw), yaw + 0.02)
    return yard(agent, box("load", "tire pallet", at, z=(0.3, 1.0)))


def thing(outcome: Outcome, id: str) -> PhysicalObject:
    return next(o for o in outcome.objects if o.id == id)


poses = st.tuples(st.floats(-6, 6), st.floats(-8, 8), st.floats(-3, 3))


@st.composite
def outcomes(draw: st.DrawFn) -> tuple[Context, Outcome]:
    """What some action gives in a yard, from some start, with or without a load."""
    make = draw(st.sampled_from([yard, with_load]))
    context = make(draw(poses))
    found = candidates(context, {"pallet"})
    return context, perform(context, draw(st.sampled_from(found)))


def in_agent_frame(agent: Trajectory, load: Trajectory) -> FloatArray:
    """Poses of a load relative to the agent at the load's own times, shape (n, 3)."""
    at = [int(np.searchsorted(agent.t, t + 1e-6)) - 1 for t in load.t]
    offset = rotate(load.xyz[:, :2] - agent.xyz[at, :2], -agent.yaw[at])
    return np.column_stack((offset, load.yaw - agent.yaw[at]))


@settings(max_examples=25, deadline=None)
@given(outcomes())
def test_an_action_starts_where_the_context_does(made: tuple[Context, Outcome]) -> None:
    context, outcome = made
    for before, after in zip(
        (*recorded(context).objects, context.agent), (*outcome.objects, outcome.agent), strict=True
    ):
        assert (after.id, after.labels, after.prism) == (before.id, before.labels, before.prism)
        assert after.trajectory.t[0] == before.trajectory.t[0]
        np.testing.assert_array_equal(after.trajectory.xyz[0], before.trajectory.xyz[0])
        assert after.trajectory.yaw[0] == before.trajectory.yaw[0]


@settings(max_examples=25, deadline=None)
@given(outcomes())
def test_nothing_teleports(made: tuple[Context, Outcome]) -> None:
    _, outcome = made
    track = outcome.agent.trajectory
    dt = np.diff(track.t)
    assert (dt >= 0).all()
    assert (np.linalg.norm(np.diff(track.xyz, axis=0), axis=1) <= 1.2 * dt + 1e-6).all()
    assert (np.abs(np.diff(track.yaw)) <= 1.2 / DEFAULT_PACE.turn_m * dt + 1e-6).all()
    for o in outcome.objects:
        rise = np.abs(np.diff(o.trajectory.xyz[:, 2]))
        assert (rise <= DEFAULT_PACE.lift_m_s * np.diff(o.trajectory.t) + 1e-6).all()


@settings(max_examples=25, deadline=None)
@given(outcomes())
def test_at_most_one_object_moves_and_it_moves_with_the_agent(
    made: tuple[Context, Outcome],
) -> None:
    _, outcome = made
    carried = [o for o in outcome.objects if len(o.trajectory) > 1]
    assert len(carried) <= 1
    for o in carried:
        relative = in_agent_frame(outcome.agent.trajectory, o.trajectory)[1:]
        np.testing.assert_allclose(
            relative, np.broadcast_to(relative[0], relative.shape), atol=1e-6
        )
        assert 1.0 < np.hypot(*relative[0, :2]) < 1.2
        assert set(o.trajectory.t) <= set(outcome.agent.trajectory.t)


@settings(max_examples=20, deadline=None)
@given(poses, st.sampled_from(["tires", "boxes"]), st.sampled_from([0, 1]))
def test_a_carried_object_ends_on_the_place(
    agent: tuple[float, float, float], load: str, place: int
) -> None:
    context = yard(agent)
    target = context.places[place].prism
    outcome = carry(context, load, target)
    end = thing(outcome, load).trajectory
    np.testing.assert_allclose(end.xyz[-1, :2], centre(target), atol=1e-6)
    assert end.xyz[-1, 2] - 0.35 == pytest.approx((0.0, 0.85)[place])
    away = np.linalg.norm(outcome.agent.trajectory.xyz[-1, :2] - centre(target))
    assert away == pytest.approx(REACH_M + 2.5, abs=0.05)


@settings(max_examples=20, deadline=None)
@given(poses)
def test_a_load_is_put_down(agent: tuple[float, float, float]) -> None:
    context = with_load(agent)
    outcome = put_down(context, "load", context.places[0].prism)
    end = thing(outcome, "load").trajectory
    np.testing.assert_allclose(end.xyz[-1], [4.0, -9.0, 0.35], atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(poses, st.sampled_from(["tires", "boxes"]))
def test_picking_up_lifts(agent: tuple[float, float, float], load: str) -> None:
    outcome = pick_up(yard(agent), load)
    track = thing(outcome, load).trajectory
    assert track.xyz[-1, 2] - track.xyz[0, 2] == pytest.approx(LIFT_M)
    assert np.linalg.norm(track.xyz[-1, :2] - track.xyz[0, :2]) == pytest.approx(1.0, abs=0.01)


def test_the_same_action_gives_the_same_log() -> None:
    context = yard()
    assert carry(context, "tires", context.places[0].prism) == carry(
        context, "tires", context.places[0].prism
    )


def test_driving_to_an_object_stops_in_front_of_it_and_faces_it() -> None:
    context = yard()
    target = context.objects[1].prism
    end = drive_to(context, target, gap_m=2.0).agent.trajectory
    gap = point_gap(end.xyz[None, -1:, :2], convex_hull(target.xy)[None])[0, 0]
    assert gap == pytest.approx(2.0, abs=0.06)
    ahead = centre(target) - end.xyz[-1, :2]
    assert np.cos(np.arctan2(ahead[1], ahead[0]) - end.yaw[-1]) == pytest.approx(1.0)


def test_driving_into_a_place_ends_in_its_middle() -> None:
    context = yard()
    end = drive_to(context, context.places[0].prism, gap_m=None).agent.trajectory
    np.testing.assert_allclose(end.xyz[-1, :2], [4.0, -9.0], atol=1e-6)


def test_driving_past_keeps_clear_and_ends_beyond() -> None:
    context = yard()
    target = context.objects[0].prism
    track = drive_past(context, target).agent.trajectory.xyz[:, :2]
    gaps = point_gap(track[None], convex_hull(target.xy)[None])[0]
    assert gaps.min() > 1.0
    assert np.argmin(gaps) < len(gaps) - 1
    assert track[-1, 0] > 12


def test_driving_along_goes_through_the_waypoints() -> None:
    points = np.array([[3.0, 1.0], [5.0, 6.0]])
    track = drive_along(yard(), points).agent.trajectory.xyz[:, :2]
    near = np.linalg.norm(track[:, None] - points, axis=2).min(axis=0)
    assert (near < 0.7).all()
    np.testing.assert_allclose(track[-1], points[-1], atol=1e-6)


def test_turning_and_backing_up() -> None:
    turned = turn(yard(), -np.pi / 2).agent.trajectory
    assert turned.yaw[-1] == pytest.approx(-np.pi / 2)
    np.testing.assert_allclose(turned.xyz[-1], [2.0, -2.0, 0.0], atol=1e-9)
    backed = back_up(yard((1.0, 2.0, np.pi / 2)), 3.0).agent.trajectory
    np.testing.assert_allclose(backed.xyz[-1], [1.0, -1.0, 0.0], atol=1e-9)
    assert (backed.yaw == np.pi / 2).all()


def test_the_load_is_found() -> None:
    assert loaded(yard()) is None
    assert loaded(with_load((1.0, -2.0, 2.0))) == "load"
    standing = yard((0.0, 0.0, 0.0), box("near", "tire pallet", (1.1, 0.0, 0.0)))
    assert loaded(standing) is None


def test_what_moves_off_with_the_agent_is_its_load() -> None:
    context = yard((0.0, 0.0, 0.0), box("near", "tire pallet", (1.1, 0.0, 0.0)))
    t, x = np.array([100.0, 101.0, 102.0]), np.array([0.0, -0.4, -1.0])

    def along(start: FloatArray) -> Trajectory:
        return Trajectory(t, start + np.column_stack((x, 0 * x, 0 * x)), 0 * x)

    moving = tuple(
        replace(o, trajectory=along(o.trajectory.xyz[0])) if o.id in ("near", "agent") else o
        for o in context.objects
    )
    assert loaded(replace(context, objects=moving)) == "near"


def test_the_forks_hold_one_load() -> None:
    context = with_load()
    with pytest.raises(ValueError, match="object load is on the forks already"):
        pick_up(context, "tires")
    with pytest.raises(ValueError, match="tires is not on the forks"):
        put_down(context, "tires", context.places[0].prism)


def test_kinds_are_told_apart_from_logs() -> None:
    for context in (yard(), with_load()):
        for candidate in candidates(context, {"pallet"}):
            outcome = perform(context, candidate)
            log = replace(context, objects=(*outcome.objects, outcome.agent))
            expected = "drive" if candidate.kind in ("turn", "back up") else candidate.kind
            assert kind_of(log) == expected
            lifted = {"pick up", "carry", "put down"} & {candidate.kind}
            assert bool(moved(outcome)) == bool(lifted or loaded(context))


def test_a_pace_sets_how_often_poses_are_logged() -> None:
    fine = back_up(yard(), 3.0, Pace(period_s=0.1)).agent.trajectory
    assert len(fine) > 5 * len(back_up(yard(), 3.0).agent.trajectory)
    hasty = pick_up(yard(), "tires", Pace(waits=0.0)).agent.trajectory
    assert np.diff(hasty.t).max() == pytest.approx(1.0)


def test_a_way_goes_around_what_stands_in_it() -> None:
    wall = [convex_hull(box("wall", "wall", (5.0, 0.0, 0.0), (1.0, 4.0)).prism.xy)]
    goal = np.array([[10.0, 0.0, 0.0]])
    found = route(np.zeros(3), goal, wall)
    track = np.concatenate(found.way)
    assert point_gap(track[None, :, :2], wall[0][None]).min() > 0.5
    np.testing.assert_allclose(track[-1], goal[0], atol=1e-6)


def test_a_way_backs_up_where_a_curve_would_be_too_tight() -> None:
    behind = np.array([[-3.0, 0.0, 0.0]])
    way = route(np.zeros(3), behind, []).way
    assert len(way) == 2, "one leg back, one ahead"
    assert way[0][-1, 0] < 0
    assert straight(np.zeros(3), -TURNING_RADIUS_M)[-1, 0] == -TURNING_RADIUS_M


@given(prisms(), st.tuples(metres(), metres()), st.sampled_from([0.0, 0.5]))
def test_a_footprint_covers_what_is_no_further_from_it_than_the_margin(
    prism: Prism, offset: tuple[float, float], margin: float
) -> None:
    point = centre(prism) + np.array(offset) / 40
    gap = point_gap(point[None, None], convex_hull(prism.xy)[None])[0, 0]
    assume(gap == 0 or abs(gap - margin) > 1e-6)
    assert covers(prism, point, margin) == (gap <= margin)
