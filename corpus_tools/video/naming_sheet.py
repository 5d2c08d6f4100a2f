"""Pictures of every kind of thing from each camera, and a study in which strangers name them.

The study measures whether people recognise things. The sheet shows its pictures; the study asks for
names, and its export has the thing in each clip.
"""

from __future__ import annotations

import io
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from corpus_tools.exporters.csv_tables import write_rows
from corpus_tools.runtime.atomic_folder import write_folder
from corpus_tools.video.drawing.canvas import Image
from corpus_tools.video.encode import encode
from corpus_tools.video.films import open_frames
from corpus_tools.world.physics.build import build_world
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import ROBOT, Bounds, Layout, Robot, Scenario, Thing
from corpus_tools.world.state.replay import replay
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS, OTHER
from g3.short_repr import short_repr

SHEET, TABLE, STUDY, CLIPS = "naming-sheet.jpg", "things.csv", "study.yaml", "clips"
FRAME = (1280, 720)
"""Size of the video that crops are taken from, pixels."""
CROP = (480, 360)
CELL = (240, 180)
MARGIN = 0.35
"""Space around a thing in its crop, as a share of the thing's size."""
AWAY_M = 9.0
"""Distance ahead of the robot at which things begin, in metres."""
ASIDE_M = {"overview": 2.5, "follow": 2.5, "operator": 0.0}
"""Distance of things to its left, in metres: ahead of its seat, where the mast leaves room, else
beside it."""
TURNS_DEG = {"overview": 215.0, "follow": 0.0, "operator": 90.0}
"""Headings of things before each camera, in degrees: askew, from behind, from their side."""
_FPS, _SECONDS = 5, 2


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Crop:
    """A kind of thing as a camera sees it."""

    kind: str
    camera: str
    picture: Image
    """Picture of the size :data:`CROP`; red, green and blue."""
    pixels: tuple[int, int]
    """Width and height of the thing in the whole frame."""


def crops(kinds: tuple[str, ...] = ()) -> Iterator[Crop]:
    """Draw every kind of thing, or the given ones, as each camera sees it.

    The robot isn't seen from its own seat.
    """
    for kind in kinds or tuple(name for name in KINDS if name != OTHER.name):
        for camera in TURNS_DEG:
            if (kind, camera) != (FORKLIFT.name, "operator"):
                yield _crop(kind, camera)


def write_sheet(crops: list[Crop], out: Path, *, force: bool = False) -> None:
    """Write the sheet, a clip of each crop, a table of what they show, and a study.

    The folder `out` appears when all is in it; with `force` it replaces one that was written
    before.
    """
    # Their order tells nothing of what they show.
    mixed = sorted(crops, key=lambda crop: zlib.crc32(f"{crop.kind} {crop.camera}".encode()))
    files = {SHEET: _jpeg(sheet(crops)), STUDY: _STUDY.encode()}
    table, rows = io.StringIO(), []
    for number, crop in enumerate(mixed, start=1):
        name = f"{number:03}"
        rows.append([f"{CLIPS}/{name}.mp4", name, crop.kind, crop.camera, *crop.pixels])
        files[f"{CLIPS}/{name}.mp4"] = _clip(crop.picture)
    columns = ["video", "id", "kind", "camera", "width_px", "height_px"]
    write_rows(table, columns, rows, line_end="\n")
    files[TABLE] = table.getvalue().encode()
    write_folder(out, files, force=force, marker=TABLE)


def sheet(crops: list[Crop]) -> Image:
    """Draw one picture of all crops: a row for each kind, a column for each camera."""
    kinds = list(dict.fromkeys(crop.kind for crop in crops))
    cameras = list(TURNS_DEG)
    width, height = CELL
    label, gap = 22, 6
    shape = (len(kinds) * (height + label), len(cameras) * (width + gap), 3)
    page = np.full(shape, 255, np.uint8)
    for crop in crops:
        y = kinds.index(crop.kind) * (height + label)
        x = cameras.index(crop.camera) * (width + gap)
        small = cv2.resize(crop.picture, CELL, interpolation=cv2.INTER_AREA)
        page[y + label : y + label + height, x : x + width] = small
        size = "{} x {} px".format(*crop.pixels)
        text = f"{crop.kind}, {crop.camera}, {size}"
        cv2.putText(page, text, (x + 3, y + 15), _FONT, 0.36, (0, 0, 0), 1, cv2.LINE_AA)
    return page


def _crop(kind: str, camera: str) -> Crop:
    context = scenario_context(_scene(kind, camera))
    recording = replay(context, 1.0)
    shown = ROBOT if kind == FORKLIFT.name else "thing"
    index = [item.id for item in context.objects].index(shown)
    with open_frames(build_world(context), recording, camera, FRAME, "standard") as frames:
        picture, mask = frames.frame(0), (frames.objects == index).astype(np.uint8)
    box = cv2.boundingRect(mask)
    x, y, width, height = _around(box)
    edge = FRAME[0]
    large = cv2.copyMakeBorder(picture, edge, edge, edge, edge, cv2.BORDER_REPLICATE)
    x, y = x + edge, y + edge
    part = np.ascontiguousarray(large[y : y + height, x : x + width])
    how = cv2.INTER_AREA if width > CROP[0] else cv2.INTER_CUBIC
    resized = np.asarray(cv2.resize(part, CROP, interpolation=how), np.uint8)
    return Crop(kind, camera, resized, (int(box[2]), int(box[3])))


def _scene(kind: str, camera: str) -> Scenario:
    """Return a yard with the robot, a cone far away, and the thing."""
    half = max(KINDS[kind].size) / 2
    things = {"far": Thing("cone", (24.0, -8.0)), "near": Thing("cone", (-3.0, 6.0))}
    if kind != FORKLIFT.name:
        at = (AWAY_M + half, ASIDE_M[camera])
        things["thing"] = Thing(kind, at, TURNS_DEG[camera])
    layout = Layout("naming", "A yard.", (0, 0), 0, Bounds((-50, 50), (-50, 50)), {}, {})
    return Scenario("naming", "Nothing happens.", layout, things, {}, Robot((0.0, 0.0)), ())


def _around(box: Any) -> tuple[int, int, int, int]:
    """Return a rectangle with the shape of a crop around a box, x, y, width and height."""
    x, y, width, height = box
    aspect = CROP[0] / CROP[1]
    wide = max(width * (1 + 2 * MARGIN), height * (1 + 2 * MARGIN) * aspect, 48)
    size = round(wide), round(wide / aspect)
    return x + width // 2 - size[0] // 2, y + height // 2 - size[1] // 2, *size


def _clip(picture: Image) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        frames = [picture] * (_FPS * _SECONDS)
        encode(frames, path, size=CROP, fps=_FPS, quality="standard")
        return path.read_bytes()


def _jpeg(picture: npt.NDArray[np.uint8]) -> bytes:
    _, content = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    return content.tobytes()


_FONT = cv2.FONT_HERSHEY_SIMPLEX

_STUDY = """\
# What do people call these things? Start it with: ct annotate study.yaml
# Exports tell kind, camera and size of each clip in their column metadata.
name: naming
title: Name what you see
videos: things.csv
robot: forklift

tasks:
  describe:
    answers: 10
    practice: false
    title: Name what you see
    summary: Look at a picture and type what the thing in its middle is.
    instructions: |
      1. Each clip is a still picture of **one thing**, in its middle. Look at it to the end.
      2. Type what you would call that thing, in a few words: the first that come to your mind.
      3. If you don't know, type *I don't know*. That helps, too.

access: open

consent: |
  You will look at pictures of things and name them.
  What you type is kept without your name and may be published for research.
  You may stop at any time by closing the page.
"""
