from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from corpus_tools.video.drawing.camera import CAMERAS
from corpus_tools.video.drawing.segmentation import describe, label_image
from corpus_tools.video.films import open_frames
from corpus_tools.world.physics.build import build_world
from tests.corpus_tools.video.recordings import CRATE, PALLET, ROBOT, TRUCK, drive

SIZE = (320, 240)
RECORDING = drive(rate_hz=4, still_s=0.5)


def draw(camera, quality, moments, size=SIZE, start=RECORDING.start):
    world = build_world(start)
    with open_frames(world, RECORDING, camera, size, quality) as frames:
        return [frames.frame(k) for k in moments], frames


@pytest.fixture(scope="module")
def composite():
    """All frames as the standard quality composes them."""
    return draw("overview", "standard", range(len(RECORDING.t_ns)))


@pytest.fixture(scope="module")
def whole():
    """Some frames, each drawn as a whole, by moment."""
    moments = (0, 5, 10)
    pictures, frames = draw("overview", "high", moments)
    return dict(zip(moments, pictures, strict=True)), frames


@pytest.fixture(scope="module")
def draft():
    """Two frames without shadows."""
    return draw("overview", "draft", [0, 4])


@pytest.mark.parametrize("moment", [0, 5, 10])
def test_composites_look_like_whole_drawings(composite, whole, moment):
    composed, drawn = composite[0][moment], whole[0][moment]
    assert cv2.PSNR(composed, drawn) > 28
    # No halo and no hole: blurred a little, nothing differs much anywhere but at shadows' edges.
    near = [cv2.blur(picture, (5, 5)).astype(int) for picture in (composed, drawn)]
    assert (np.abs(near[0] - near[1]).max(axis=-1) > 48).mean() < 0.01


@pytest.mark.parametrize(
    ("colour", "hue"), [("red", (1, 0, 0)), ("green", (0, 1, 0)), ("blue", (0, 0, 1))]
)
def test_a_thing_is_seen_in_its_colour(draft, colour, hue):
    (plain, _), frames = draft
    things = list(RECORDING.start.objects)
    things[CRATE] = replace(things[CRATE], colours=(colour,))
    painted, _ = draw("overview", "draft", [0], start=replace(RECORDING.start, objects=things))
    crate = frames.objects == CRATE
    assert (painted[0] != plain)[crate].any(axis=-1).mean() > 0.9
    assert (painted[0] == plain)[~crate].mean() > 0.99  # but for its edges
    light = painted[0][crate].mean(axis=0)
    assert (light / light.max()).round().tolist() == list(hue)
    # Its boards are still to be seen.
    assert painted[0][crate].max(axis=-1).std() > 10


def test_frames_do_not_depend_on_those_drawn_before(composite):
    frames, _ = draw("overview", "standard", [10, 3, 3, 0])
    for picture, k in zip(frames, (10, 3, 3, 0), strict=True):
        assert (picture == composite[0][k]).all()


def test_only_what_moves_changes(composite):
    pictures, _ = composite
    changed = (pictures[0] != pictures[12]).any(axis=-1)
    assert 0.01 < changed.mean() < 0.4
    assert (pictures[-1] == pictures[-2]).all()


def test_things_throw_shadows(composite, draft):
    (sunny, _), frames = draft
    shady = composite[0][0]
    floor = frames.objects < 0
    darker = (sunny.astype(int) - shady).min(axis=-1) > 25
    assert 0.005 < (darker & floor).mean() < 0.2


@pytest.mark.parametrize("camera", ["follow", "operator"])
def test_moving_cameras_show_shadows_too_and_the_same_frames_again(camera):
    (shaded,), _ = draw(camera, "standard", [6])
    (again,), _ = draw(camera, "standard", [6])
    assert (shaded == again).all()
    (drawn,), _ = draw(camera, "high", [6])
    assert cv2.PSNR(shaded, drawn) > 22


@pytest.mark.parametrize("camera", CAMERAS)
def test_every_camera_shows_something_and_drafts_are_the_same_again(camera, draft):
    (picture,), _ = draw(camera, "draft", [4])
    assert picture.shape == (240, 320, 3)
    assert picture.std() > 10
    assert (picture == draft[0][1]).all() == (camera == "overview")


@pytest.mark.parametrize("quality", ["draft", "composite", "whole"])
def test_the_segmentation_tells_objects(quality, request):
    _, frames = request.getfixturevalue(quality)
    camera = frames.cameras[0]
    assert set(np.unique(frames.objects)) == {-1, ROBOT, PALLET, CRATE, TRUCK}
    # The middle of the pallet's side that faces the camera.
    points = RECORDING.position[0][[PALLET, CRATE]] + [-0.4, 0, 0.6]
    for pixel, item in zip(camera.project(points, SIZE)[0], (PALLET, CRATE), strict=True):
        x, y = pixel.astype(int)
        assert frames.objects[y, x] == item


def test_the_segmentation_is_described(draft):
    _, frames = draft
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


def test_what_is_not_in_the_picture_has_no_outline(draft):
    _, frames = draft
    nothing = np.full_like(frames.objects, -1)
    told = describe(nothing, RECORDING.start, frames.cameras[0])
    assert all(item["box"] is None and item["polygons"] == [] for item in told["objects"])
