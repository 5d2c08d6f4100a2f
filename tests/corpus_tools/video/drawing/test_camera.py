from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from corpus_tools.logs.log_reading import read_log
from corpus_tools.video.drawing.camera import CAMERAS, OPENING_S, Camera, overview, track
from corpus_tools.video.drawing.drawn_moments import sampled
from corpus_tools.world.state.recording import heading, upright
from corpus_tools.world.state.shapes import shape_of
from g3.geometry.plane import rotate
from tests.corpus_tools.video.recordings import CRATE, PALLET, ROBOT, drive

SIZE = (320, 240)
LOGS = Path(__file__).parents[4] / "datasets/warehouse/logs"


def test_a_camera_above_the_origin_by_hand():
    camera = Camera(np.array([0.0, 0, 1]), np.array([1.0, 0, 1]), np.pi / 2)
    # It looks along x: the world's y is to its left, the world's z up.
    assert camera.axes == pytest.approx(np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]))
    pixels, ahead = camera.project(np.array([[2.0, 0, 1], [2, 2, 1], [2, 0, 3]]), SIZE)
    # 90 degrees are 240 pixels: half of them, 120, at 45 degrees.
    assert pixels == pytest.approx(np.array([[160, 120], [40, 120], [160, 0]]))
    assert ahead == pytest.approx([2, 2, 2])


@pytest.mark.parametrize("name", CAMERAS)
def test_matrices_project_as_the_camera_does(name):
    recording = drive()
    camera = CAMERAS[name](recording, SIZE)[0]
    points = recording.position[0] + [3.0, 0, 1]
    homogeneous = np.concatenate((points, np.ones((len(points), 1))), axis=1)
    projected = homogeneous @ (camera.intrinsics(SIZE) @ camera.extrinsics()).T
    assert projected[:, :2] / projected[:, 2:] == pytest.approx(camera.project(points, SIZE)[0])


@pytest.mark.parametrize("turn", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("size", [(320, 240), (240, 320), (640, 200)])
def test_the_overview_shows_all_that_moves(turn, size):
    recording = drive()
    cos, sin = np.cos(turn), np.sin(turn)
    rotation = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    turned = replace(
        recording,
        position=recording.position @ rotation.T,
        orientation=upright(
            turn + 2 * np.arctan2(recording.orientation[..., 3], recording.orientation[..., 0])
        ),
    )
    (camera,) = overview(turned, size)
    for i in (ROBOT, PALLET):
        high = shape_of(recording.start.objects[i]).high[2]
        for xyz in turned.position[:, i]:
            pixels, ahead = camera.project(np.stack((xyz, xyz + np.array([0, 0, high]))), size)
            assert (ahead > 0).all()
            assert (pixels > 0).all()
            assert (pixels < size).all()


def test_where_nothing_happens_the_overview_shows_everything():
    recording = drive()
    still = replace(
        recording,
        t_ns=recording.t_ns[:1],
        position=recording.position[:1],
        orientation=recording.orientation[:1],
        fork_height_m=recording.fork_height_m[:1],
        steps=(),
    )
    far = still.position.copy()
    far[0, CRATE, :2] += 40
    still = replace(still, position=far)
    (camera,) = overview(still, SIZE)
    pixels, ahead = camera.project(still.position[0], SIZE)
    assert (ahead > 0).all()
    assert ((pixels > 0) & (pixels < SIZE)).all()


def test_left_of_the_robot_is_left_in_the_overview():
    recording = drive()
    (camera,) = overview(recording, SIZE)
    pixels, _ = camera.project(recording.position[0][[ROBOT, CRATE]], SIZE)
    assert pixels[1, 0] < pixels[0, 0]


@pytest.mark.parametrize("name", ["follow", "operator"])
def test_other_cameras_go_along(name):
    recording = drive()
    cameras = CAMERAS[name](recording, SIZE)
    assert len(cameras) == len(recording.t_ns)
    assert cameras[-1].position[0] > cameras[0].position[0] + 1


def test_the_follower_moves_smoothly():
    cameras = CAMERAS["follow"](drive(rate_hz=50), SIZE)
    eyes = np.array([camera.position for camera in cameras])
    # The robot starts at full speed, 3.4 m/s: the camera takes its time.
    assert np.abs(np.diff(eyes, n=2, axis=0)).max() < 3.4 / 50 / 5


@pytest.mark.parametrize("apart", np.linspace(0, 14, 15))
def test_the_overview_cuts_nothing_off(apart):
    recording = drive()
    position = recording.position.copy()
    position[:, CRATE] += (apart, apart / 2, 0)
    recording = replace(recording, position=position)
    (camera,) = overview(recording, SIZE)
    low, high = (getattr(shape_of(recording.start.objects[CRATE]), end) for end in ("low", "high"))
    box = np.stack(np.meshgrid(*np.stack((low, high), axis=1)), axis=-1).reshape(8, 3)
    pixels, _ = camera.project(box + position[0, CRATE], SIZE)
    inside = ((pixels >= 0) & (pixels <= SIZE)).all(axis=1)
    assert inside.all() or not inside.any()


def test_tracking_begins_with_the_overview_and_comes_nearer():
    recording = drive(rate_hz=10, still_s=10)
    position = recording.position.copy()
    position[:, CRATE, 0] += 40
    # A step names the crate, so that the overview shows it.
    step = replace(recording.steps[0], arguments=(("object", "crate"),))
    recording = replace(recording, position=position, steps=(step,))
    cameras, (whole,) = track(recording, SIZE), overview(recording, SIZE)
    assert cameras[0].position == pytest.approx(whole.position)
    robot = recording.position[:, [ROBOT]]
    far = [np.linalg.norm(c.position - at) for c, at in zip(cameras, robot, strict=True)]
    assert far[-1] < 0.6 * far[0]
    for camera, at in zip(cameras, robot, strict=True):
        pixels, ahead = camera.project(at, SIZE)
        assert (ahead > 0).all()
        assert ((pixels > 0) & (pixels < SIZE)).all()
        assert camera.axes == pytest.approx(whole.axes)
    eyes = np.array([camera.position for camera in cameras])
    # In two seconds it comes as near as it will be: at most 6 / 2² of the way a second squared.
    way = np.linalg.norm(eyes[-1] - eyes[0])
    assert np.linalg.norm(np.diff(eyes, n=2, axis=0), axis=1).max() < 2 * way * 0.1**2


def test_a_lift_is_seen_from_its_side():
    # The robot looks along x while it lifts.
    ahead = overview(drive(), SIZE)[0].axes[2]
    assert abs(np.degrees(np.arctan2(ahead[1], ahead[0]))) == pytest.approx(45)


@pytest.mark.parametrize("side", [-1, 1])
def test_nothing_hides_a_load_in_the_end(side):
    recording = drive()
    objects, position = list(recording.start.objects), recording.position.copy()
    # A tall crate stands on one of the sides from which the lift could be seen.
    objects[CRATE] = replace(objects[CRATE], prism=replace(objects[CRATE].prism, z_max=4.0))
    position[:, CRATE, :2] = position[-1, PALLET, :2] + [-1.4, 1.4 * side]
    start = replace(recording.start, objects=tuple(objects))
    (camera,) = overview(replace(recording, start=start, position=position), SIZE)
    assert camera.axes[2][1] * side > 0


def test_the_robot_takes_a_fifth_of_the_width():
    recording = drive(still_s=10)
    camera, robot = track(recording, SIZE)[-1], recording.position[-1, ROBOT]
    shape = shape_of(recording.start.objects[ROBOT])
    box = np.stack(np.meshgrid(*zip(shape.low, shape.high, strict=True)), axis=-1).reshape(8, 3)
    pixels, _ = camera.project(box + robot, SIZE)
    assert np.ptp(pixels[:, 0]) > 0.2 * SIZE[0]


@pytest.mark.parametrize("log", sorted(LOGS.glob("*.mcap")), ids=lambda log: log.stem)
def test_the_robot_takes_a_fifth_of_the_width_in_every_scenario(log):
    recording = sampled(read_log(log).recording, 2, skip_idle=True)
    robot = [item.id for item in recording.start.objects].index(recording.start.agent_id)
    shape = shape_of(recording.start.objects[robot])
    box = np.stack(np.meshgrid(*zip(shape.low, shape.high, strict=True)), axis=-1).reshape(8, 3)
    shares = []
    for k, camera in enumerate(track(recording, (640, 360))):
        if recording.t_s[k] > 2 * OPENING_S:
            yaw = heading(recording.orientation[k, robot])
            xy = rotate(box[:, :2], np.repeat(yaw, 8))
            corners = np.concatenate((xy, box[:, 2:]), axis=1) + recording.position[k, robot]
            pixels, _ = camera.project(corners, (640, 360))
            shares.append(np.ptp(pixels[:, 0]) / 640)
    # It draws back where a thing beside the robot, such as a truck, would be cut off.
    assert np.mean(shares) > 0.2
    assert np.median(shares) > 0.2
    assert np.min(shares) > 0.15


def test_what_the_robot_is_at_is_whole():
    near = cut = 0
    for name in ("court_go_to_second_truck", "hall_take_tires_to_truck"):
        recording = sampled(read_log(LOGS / f"{name}.mcap").recording, 2, skip_idle=True)
        robot = [item.id for item in recording.start.objects].index(recording.start.agent_id)
        for k, camera in enumerate(track(recording, SIZE)):
            for i, item in enumerate(recording.start.objects):
                shape, yaw = shape_of(item), heading(recording.orientation[k, i])
                edges = np.stack((shape.low, shape.high), axis=1)
                box = np.stack(np.meshgrid(*edges, indexing="ij"), axis=-1).reshape(8, 3)
                box[:, :2] = rotate(box[:, :2], np.repeat(yaw, 8))
                box += recording.position[k, i]
                low, high = box.min(axis=0), box.max(axis=0)
                at = recording.position[k, robot]
                gap = np.maximum(np.maximum(low - at, at - high), 0.0)
                if np.linalg.norm(gap[:2]) < 1.5:
                    pixels, _ = camera.project(box, SIZE)
                    near += 1
                    cut += not ((pixels >= 0) & (pixels <= SIZE)).all()
    assert cut < 0.03 * near
