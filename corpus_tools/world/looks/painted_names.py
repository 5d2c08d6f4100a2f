"""The names of places, painted on the ground: only where somebody asks for them."""

from __future__ import annotations

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.world.looks.drawing import VISUAL_GROUP, add_material, add_texture
from corpus_tools.world.looks.markings import PAINT_M
from corpus_tools.world.state.recording import upright
from g3.groundings import Context

LETTERS_M = 1.5
"""Height of the letters, where the name has room; the camera sees them from far and slanted."""
WIDEST_M = 9.0
_ROWS = 96
_FONT, _STROKE = cv2.FONT_HERSHEY_SIMPLEX, 9
_INK, _BOARD = (25, 25, 30), (245, 215, 90)


def add_names(spec: mujoco.MjSpec, context: Context, ground_m: float) -> None:
    """Paint each named place's name before it, to be read as the robot looks at the start."""
    yaw = float(context.agent.trajectory.yaw[0])
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    aside = np.array([-ahead[1], ahead[0]])
    for i, place in enumerate(context.places):
        if not place.name:
            continue
        picture = _written(place.name)
        name = f"name {i}"
        height = LETTERS_M
        width = height * picture.shape[1] / picture.shape[0]
        if width > WIDEST_M:
            width, height = WIDEST_M, height * WIDEST_M / width
        along, across = place.prism.xy @ ahead, place.prism.xy @ aside
        near = along.min() - height / 2 - 0.2
        middle = near * ahead + (across.min() + across.max()) / 2 * aside
        add_texture(spec, name, picture)
        add_material(spec, name, name)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            pos=[*middle, ground_m + 2 * PAINT_M],
            quat=upright(np.array(yaw - np.pi / 2)),
            size=[width / 2, height / 2, 1],
            material=name,
            castshadow=False,
            group=VISUAL_GROUP,
            contype=0,
            conaffinity=0,
        )


def _written(name: str) -> npt.NDArray[np.uint8]:
    """Dark letters on yellow, rows from the top down, as textures have them."""
    text = name.encode("ascii", "replace").decode().upper()
    scale = 0.55 * _ROWS / 21  # letters of this font are 21 pixels high
    (width, height), _ = cv2.getTextSize(text, _FONT, scale, _STROKE)
    picture = np.full((_ROWS, width + _ROWS // 2, 3), _BOARD, np.uint8)
    start = (_ROWS // 4, (_ROWS + height) // 2)
    cv2.putText(picture, text, start, _FONT, scale, _INK, _STROKE, cv2.LINE_AA)
    return picture
