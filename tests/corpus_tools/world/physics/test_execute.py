"""Scripts in physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco")

from corpus_tools.world.physics.execute import Execution, execute, reached
from corpus_tools.world.physics.pacing import EMPTY
from corpus_tools.world.state.dimensions import ENTRY_HEIGHT
from corpus_tools.world.state.recording import NS_PER_S, heading, to_context
from corpus_tools.world.state.robot_script import ScriptStep
from g3.errors import CorpusError
from g3.geometry.plane import rotate, wrap
from g3.groundings import Context, Place
from tests.physics_scenes import TURNED, on_deck, thing, yard
from tests.worlds import place


def run(context: Context, *steps: tuple[str, str | float]) -> Execution:
    return execute(context, tuple(ScriptStep(*step) for step in steps))


def track(execution: Execution, name: str) -> np.ndarray:
    names = [item.id for item in execution.recording.start.objects]
    return execution.recording.position[:, names.index(name)]


@pytest.fixture(scope="module")
def moved_tires() -> Execution:
    return run(yard(), ("pick_up", "tires"), ("put_down", "truck bed"))


def test_a_load_goes_up_by_contact_with_the_forks(moved_tires: Execution) -> None:
    recording = moved_tires.recording
    lifting, _ = recording.steps
    up = recording.t_s <= lifting.end_s
    load, forks = track(moved_tires, "tires")[up, 2], recording.fork_height_m[up]
    off_the_ground = load > 0.01
    assert off_the_ground.any()
    assert not off_the_ground.all()
    np.testing.assert_allclose(
        load[off_the_ground], forks[off_the_ground] - ENTRY_HEIGHT, atol=0.01
    )
    assert (load[forks < ENTRY_HEIGHT - 0.01] < 0.001).all()


def test_a_load_put_on_a_truck_stands_on_its_deck(moved_tires: Execution) -> None:
    assert moved_tires.problems == ()
    assert reached(moved_tires)
    end = track(moved_tires, "tires")[-1]
    assert end[2] == pytest.approx(1.0, abs=0.005)
    bed = next(p for p in moved_tires.recording.start.places if p.name == "truck bed")
    assert moved_tires.handled == {"tires"}
    np.testing.assert_allclose(end[:2], bed.prism.xy.mean(axis=0), atol=0.15)


def test_bystanders_stay_exactly_where_they_are(moved_tires: Execution) -> None:
    for name in ("boxes", "person", "truck", "trailer"):
        positions = track(moved_tires, name)
        assert (positions == positions[0]).all()
    context = to_context(moved_tires.recording)
    poses = {item.id: len(item.trajectory) for item in context.objects}
    assert poses["boxes"] == poses["person"] == 1
    assert poses["tires"] > 1


def test_the_robot_drives_within_its_limits(moved_tires: Execution) -> None:
    recording = moved_tires.recording
    robot = [item.id for item in recording.start.objects].index("robot")
    velocity = np.diff(recording.position[:, robot, :2], axis=0) * 50
    yaw = heading(recording.orientation[:, robot])
    rate = wrap(np.diff(yaw)) * 50
    assert np.hypot(*velocity.T).max() < EMPTY.drive.speed + 0.05
    assert np.abs(rate).max() < EMPTY.turn.speed + 0.05
    # It has wheels: it doesn't go sideways.
    sideways = -np.sin(yaw[1:]) * velocity[:, 0] + np.cos(yaw[1:]) * velocity[:, 1]
    assert np.abs(sideways).max() < 0.06


def test_moments_are_on_an_exact_grid(moved_tires: Execution) -> None:
    t = moved_tires.recording.t_ns
    np.testing.assert_array_equal(t, np.arange(len(t)) * (NS_PER_S // 50))
    assert moved_tires.recording.steps[-1].end_s < moved_tires.recording.t_s[-1]


def test_the_same_script_gives_the_same_bits() -> None:
    first, second = (
        run(
            yard(),
            ("approach", "person"),
        )
        for _ in range(2)
    )
    for name in ("t_ns", "position", "orientation", "fork_height_m"):
        a, b = (getattr(e.recording, name) for e in (first, second))
        assert a.tobytes() == b.tobytes()


def test_a_load_comes_down_from_a_deck_and_stands_where_it_was_sent() -> None:
    done = run(yard(), ("pick_up", "boxes"), ("put_down", "spot"))
    assert done.problems == ()
    assert track(done, "boxes")[-1, 2] == pytest.approx(0.0, abs=0.005)
    outcome = done.outcomes[1]
    assert outcome.error_m < 0.05
    assert outcome.error_deg < 1


def test_driving_actions() -> None:
    done = run(
        yard(),
        ("drive_past", "person"),
        ("drive_to", "receiving"),
        ("back_up_m", 0.5),
        ("turn_deg", -90),
        ("forward_m", 0.4),
        ("wait_s", 0.5),
    )
    assert done.problems == ()
    assert [outcome.error_m < 0.01 for outcome in done.outcomes] == [True] * 6
    last = done.recording.steps[-1]
    assert last.end_s - last.start_s == pytest.approx(0.5)
    assert last.arguments == (("number", "0.5"),)


def loaded_yard() -> Context:
    """A yard where a crate hangs on the forks."""
    load = thing("crate", "crate", (1.0, 0.1), 0.0, z=0.3)
    wall = thing("wall", "truck", (-12.0, 0.0), np.pi / 2)
    return yard(load, wall, robot=(0.0, 0.0, 0.0))


def test_a_load_that_hangs_at_the_start_is_on_the_forks() -> None:
    done = run(loaded_yard(), ("drive_to", "spot"), ("put_down", "receiving"))
    assert done.problems == ()
    start = track(done, "crate")[0]
    assert start[2] == pytest.approx(0.3, abs=0.02)
    assert done.recording.fork_height_m[0] == pytest.approx(start[2] + ENTRY_HEIGHT, abs=0.01)
    assert track(done, "crate")[-1, 2] == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(
    ("context", "step", "what"),
    [
        (loaded_yard(), ("pick_up", "boxes"), "crate is on the forks already"),
        (loaded_yard(), ("put_down", "cab"), "don't reach so far over truck, or there is no room"),
        (yard(), ("put_down", "spot"), "nothing is on the forks"),
        (yard(), ("pick_up", "person"), "the forks can't lift person"),
        (loaded_yard(), ("back_up_m", 12.0), "something is in the way"),
    ],
)
def test_what_can_not_be_done_is_told(
    context: Context, step: tuple[str, str | float], what: str
) -> None:
    done = run(context, ("wait_s", 0.1), step)
    assert done.failure is not None
    assert what in str(done.failure)
    assert str(done.failure).startswith(step[0])
    assert not reached(done)
    assert len(done.outcomes) == len(done.recording.steps) - 1 == 1


def with_place(context: Context, at: Place) -> Context:
    return replace(context, places=(*context.places, at))


def test_what_is_put_down_over_a_cab_goes_onto_the_deck_beside_it() -> None:
    context = yard()
    truck = next(o for o in context.objects if o.id == "truck")
    wide = place("top", on_deck(truck, 2.3, 0.0), (6.0, 6.0), TURNED, 1.0)
    done = run(with_place(context, wide), ("pick_up", "tires"), ("put_down", "top"))
    assert done.problems == ()
    end = track(done, "tires")[-1]
    assert end[2] == pytest.approx(1.0, abs=0.005)
    along, across = rotate(end[:2] - truck.trajectory.xyz[0, :2], np.array(-TURNED))
    # Its middle is 0.3 m from the end of the deck at 1.3 m, or as near as the load beside allows.
    assert 0.4 < along < 1.05
    assert abs(across) < 0.8


def test_what_has_no_room_on_a_deck_is_not_put_down_beside_it() -> None:
    truck = thing("truck", "truck", (6.0, 7.0), TURNED)
    loads = [
        thing(f"load{x}", "box-pallet", on_deck(truck, x, 0.0), TURNED, 1.0)
        for x in (-2.55, -1.45, -0.35, 0.75)
    ]
    wide = place("top", on_deck(truck, 0.0, 0.0), (9.0, 9.0), TURNED, 1.0)
    done = run(with_place(yard(*loads), wide), ("pick_up", "tires"), ("put_down", "top"))
    assert "the forks don't reach so far over truck, or there is no room" in str(done.failure)


def test_nothing_is_put_down_in_the_air() -> None:
    high = place("high", (0.5, -5.0), z=1.0)
    done = run(with_place(loaded_yard(), high), ("put_down", "high"))
    assert "nothing that can be loaded is under high, 1.0 m up" in str(done.failure)


def test_a_place_behind_walls_is_out_of_reach() -> None:
    walls = [
        thing(f"wall-{i}", "truck", xy, yaw)
        for i, (xy, yaw) in enumerate(
            (
                ((20.0, -3.5), 0.0),
                ((20.0, 3.5), 0.0),
                ((16.0, 0.0), np.pi / 2),
                ((24.0, 0.0), np.pi / 2),
            )
        )
    ]
    context = replace(yard(*walls), places=(place("pen", (20.0, 0.0), (3.0, 3.0)),))
    done = run(context, ("drive_to", "pen"))
    assert done.failure is not None
    assert "can't get to pen" in str(done.failure) or "no room" in str(done.failure)
    assert (track(done, "robot") == track(done, "robot")[0]).all()


@pytest.mark.parametrize(
    "step", [("fly", "spot"), ("pick_up", "spot"), ("drive_to", "tires"), ("wait_s", "long")]
)
def test_a_script_with_mistakes_is_refused(step: tuple[str, str]) -> None:
    with pytest.raises(CorpusError, match="step 1 of the script"):
        run(yard(), step)


def test_things_that_stand_in_each_other_are_refused() -> None:
    twin = thing("twin", "box-pallet", (5.2, -2.1), 0.5)
    with pytest.raises(CorpusError, match="stands in something"):
        run(yard(twin), ("wait_s", 1.0))
