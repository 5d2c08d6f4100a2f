"""Things in a colour of their own: painted over, with their boards and joints still to be seen."""

from __future__ import annotations

import cv2
import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import PICTURE
from corpus_tools.world.looks.drawing import VISUAL_GROUP, add_material, add_texture
from corpus_tools.world.state.paints import PAINTS
from g3.groundings import Colour

_GREY = "atlas-grey"
_DARKEST = 0.45
"""How bright paint is on what is black: more shows the shape, less shows boards and joints."""


def paint(spec: mujoco.MjSpec, body: mujoco.MjsBody, colour: Colour) -> None:
    """Paint all that is seen of a body, which has its look; what collides isn't painted."""
    for geom in body.geoms:
        if geom.group == VISUAL_GROUP and geom.material:
            geom.material = _painted(spec, geom.material, colour)


def _painted(spec: mujoco.MjSpec, material: str, colour: Colour) -> str:
    """The name of a material like another one, in a colour."""
    name = f"{colour} {material}"
    if spec.material(name) is None:
        if spec.texture(_GREY) is None:
            _add_grey(spec)
        own = spec.material(material)
        made = add_material(spec, name, _GREY, specular=own.specular, shininess=own.shininess)
        made.rgba = [*PAINTS[colour], 1.0]
    return name


def _add_grey(spec: mujoco.MjSpec) -> None:
    """Add the picture of all surfaces without their colours."""
    light = np.asarray(cv2.imread(str(PICTURE), cv2.IMREAD_GRAYSCALE), dtype=float)
    grey = (255 * _DARKEST + (1 - _DARKEST) * light).astype(np.uint8)
    add_texture(spec, _GREY, np.dstack([grey] * 3))
