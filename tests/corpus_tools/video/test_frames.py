from __future__ import annotations

import cv2
import numpy as np
import pytest

from corpus_tools.video.camera import CAMERAS
from corpus_tools.video.frames import open_frames
from corpus_tools.video.segmentation import describe, label_image
from corpus_tools.world.build import build_world
from tests.corpus_tools.video.recordings import CRATE, PALLET, ROBOT, TRUCK, drive

SIZE = (320, 240)
RECORDING = drive(rate_hz=4, still_s=0.5)


def draw(camera, quality, moments, size=SIZE):
    world = build_world(RECORDING.start)
    with open_frames(world, RECORDING, camera, size, quality) as frames:
        return [frames.frame(k) for k in moments], frames


@pytest.fixture(scope="module")
def composite():
    return draw("overview", "standard", range(len(RECORDING.t_ns)))[0]


@pytest.mark.parametrize("moment", [0, 5, 10])
def test_composites_look_like_whole_drawings(composite, moment):
    (whole,), _ = draw("overview", "high", [moment])
    assert cv2.PSNR(composite[moment], whole) > 28
    # No halo and no hole: blurred a little, nothing differs much anywhere but at shadows' edges.
    near = [cv2.blur(picture, (5, 5)).astype(int) for picture in (composite[moment], whole)]
    assert (np.abs(near[0] - near[1]).max(axis=-1) > 48).mean() < 0.01


def test_frames_do_not_depend_on_those_drawn_before(composite):
    frames, _ = draw("overview", "standard", [10, 3, 3, 0])
    for picture, k in zip(frames, (10, 3, 3, 0), strict=True):
        assert (picture == composite[k]).all()


def test_only_what_moves_changes(composite):
    changed = (composite[0] != composite[12]).any(axis=-1)
    assert 0.01 < changed.mean() < 0.4
    assert (composite[-1] == composite[-2]).all()


def test_things_throw_shadows():
    (sunny,), frames = draw("overview", "draft", [0])
    (shady,), _ = draw("overview", "standard", [0])
    floor = frames.objects < 0
    darker = (sunny.astype(int) - shady).min(axis=-1) > 25
    assert 0.005 < (darker & floor).mean() < 0.2


@pytest.mark.parametrize("camera", ["follow", "operator"])
def test_moving_cameras_show_shadows_too(camera):
    (shaded,), _ = draw(camera, "standard", [6])
    (whole,), _ = draw(camera, "high", [6])
    assert cv2.PSNR(shaded, whole) > 22


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_the_same_frames_again(camera, quality):
    first, _ = draw(camera, quality, [4])
    again, _ = draw(camera, quality, [4])
    assert (first[0] == again[0]).all()
    assert first[0].shape == (240, 320, 3)
    assert first[0].std() > 10


@pytest.mark.parametrize("quality", ["draft", "standard", "high"])
def test_the_segmentation_tells_objects(quality):
    _, frames = draw("overview", quality, [])
    camera = frames.cameras[0]
    assert set(np.unique(frames.objects)) == {-1, ROBOT, PALLET, CRATE, TRUCK}
    # The middle of the pallet's side that faces the camera.
    points = RECORDING.position[0][[PALLET, CRATE]] + [-0.4, 0, 0.6]
    for pixel, item in zip(camera.project(points, SIZE)[0], (PALLET, CRATE), strict=True):
        x, y = pixel.astype(int)
        assert frames.objects[y, x] == item


def test_the_segmentation_is_described():
    _, frames = draw("overview", "draft", [])
    told = describe(frames.objects, RECORDING.start, frames.cameras[0])
    image = label_image(frames.objects)
    assert [item["id"] for item in told["objects"]] == ["robot", "load", "crate", "lorry"]
    for item in told["objects"]:
        mask = image == item["value"]
        assert item["pixels"] == mask.sum() > 0
        x, y, width, height = item["box"]
        assert mask[y : y + height, x : x + width].sum() == mask.sum()
        filled = np.zeros(mask.shape, np.uint8)
        cv2.fillPoly(filled, [np.array(polygon) for polygon in item["polygons"]], 1)
        both = (filled.astype(bool) & mask).sum()
        assert both > 0.9 * mask.sum()
    (place,) = told["places"]
    assert place["name"] == "receiving"
    assert len(place["polygon"]) == 4


def test_what_is_not_in_the_picture_has_no_outline():
    _, frames = draw("overview", "draft", [])
    nothing = np.full_like(frames.objects, -1)
    told = describe(nothing, RECORDING.start, frames.cameras[0])
    assert all(item["box"] is None and item["polygons"] == [] for item in told["objects"])
