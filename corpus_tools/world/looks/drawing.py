"""Parts become geoms that are seen and do nothing else."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.world.looks.atlas import PICTURE
from corpus_tools.world.looks.parts import Part, Point, join
from corpus_tools.world.state.recording import upright

VISUAL_GROUP = 2
"""Group of geoms that are seen and don't collide."""

_ATLAS = "atlas"


def draw(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, parts: Iterable[Part], *, gloss: bool = False
) -> mujoco.MjsGeom:
    """Add parts to a body, as one geom.

    Parameters
    ----------
    gloss
        True if the surface shines, as paint and glass do.
    """
    name = "gloss" if gloss else "matt"
    if spec.material(name) is None:
        if spec.texture(_ATLAS) is None:
            add_texture(spec, _ATLAS, PICTURE)
        add_material(spec, name, _ATLAS, specular=0.4 if gloss else 0.0, shininess=0.5)
    return _add_mesh_geom(spec, body, join(parts), name)


def add_texture(
    spec: mujoco.MjSpec, name: str, picture: Path | npt.NDArray[np.uint8]
) -> mujoco.MjsTexture:
    """Add a picture: a file, or an array (rows from the top down, columns, RGB)."""
    made = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    if isinstance(picture, Path):
        made.file = str(picture)
    else:
        made.height, made.width, _ = picture.shape
        made.data = picture.tobytes()
    return made


def add_material(
    spec: mujoco.MjSpec, name: str, texture: str, *, specular: float = 0.0, shininess: float = 0.5
) -> mujoco.MjsMaterial:
    """Add a material that shows a texture."""
    material = spec.add_material(name=name, specular=specular, shininess=shininess)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
    return material


def add_plane(spec: mujoco.MjSpec, middle: Point, yaw: float, half: Point, material: str) -> None:
    """Add a level rectangle of a material that is seen and does nothing else."""
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=middle,
        quat=upright(np.array(yaw)),
        size=[*half, 1],
        material=material,
        castshadow=False,
        group=VISUAL_GROUP,
        contype=0,
        conaffinity=0,
    )


def _add_mesh_geom(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, part: Part, material: str
) -> mujoco.MjsGeom:
    """Add a surface to a body; equal surfaces share their mesh."""
    arrays = (part.at, part.normal, part.uv, part.face)
    name = f"look-{zlib.crc32(b''.join(array.tobytes() for array in arrays)):08x}"
    if spec.mesh(name) is None:
        mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.usernormal, mesh.usertexcoord, mesh.userface = (
            array.ravel() for array in arrays
        )
    return body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        material=material,
        group=VISUAL_GROUP,
        contype=0,
        conaffinity=0,
        mass=0,
    )


def variation(body: mujoco.MjsBody) -> np.random.Generator:
    """Return a generator for a thing's variations, always the same for its name."""
    return np.random.default_rng(zlib.crc32(body.name.encode()))
