"""Painting with OpenCV: things in colours, and names of places on request.

Things with a colour are painted over, with their boards and joints still to be seen.
"""

from __future__ import annotations

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.world.looks.atlas import PICTURE
from corpus_tools.world.looks.drawing import VISUAL_GROUP, add_material, add_plane, add_texture
from corpus_tools.world.looks.markings import PAINT_M
from corpus_tools.world.state.thing_kinds import PAINTS
from g3.groundings import Colour, Context

_GREY = "atlas-grey"
_DARKEST = 0.45
"""Brightness of paint on black surfaces: more shows the shape, less shows boards and joints."""


def paint(spec: mujoco.MjSpec, body: mujoco.MjsBody, colour: Colour) -> None:
    """Paint all that is seen of a body, which has its look; what collides isn't painted."""
    for geom in body.geoms:
        if geom.group == VISUAL_GROUP and geom.material:
            geom.material = _painted(spec, geom.material, colour)


def _painted(spec: mujoco.MjSpec, material: str, colour: Colour) -> str:
    """Return the name of a material like another one, in a colour."""
    name = f"{colour} {material}"
    if spec.material(name) is None:
        if spec.texture(_GREY) is None:
            _add_grey(spec)
        unpainted = spec.material(material)
        made = add_material(
            spec, name, _GREY, specular=unpainted.specular, shininess=unpainted.shininess
        )
        made.rgba = [*PAINTS[colour], 1.0]
    return name


def _add_grey(spec: mujoco.MjSpec) -> None:
    """Add the picture of all surfaces without their colours."""
    light = np.asarray(cv2.imread(str(PICTURE), cv2.IMREAD_GRAYSCALE), dtype=float)
    grey = (255 * _DARKEST + (1 - _DARKEST) * light).astype(np.uint8)
    add_texture(spec, _GREY, np.dstack([grey] * 3))


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
        at = [*middle, ground_m + 2 * PAINT_M]
        add_plane(spec, at, yaw - np.pi / 2, (width / 2, height / 2), name)


def _written(name: str) -> npt.NDArray[np.uint8]:
    """Draw dark letters on yellow, rows from the top down, as textures have them."""
    text = name.encode("ascii", "replace").decode().upper()
    scale = 0.55 * _ROWS / 21  # letters of this font are 21 pixels high
    (width, height), _ = cv2.getTextSize(text, _FONT, scale, _STROKE)
    picture = np.full((_ROWS, width + _ROWS // 2, 3), _BOARD, np.uint8)
    start = (_ROWS // 4, (_ROWS + height) // 2)
    cv2.putText(picture, text, start, _FONT, scale, _INK, _STROKE, cv2.LINE_AA)
    return picture
