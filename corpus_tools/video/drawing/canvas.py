"""Drawing parts of a world into arrays.

Rows of all arrays run from the bottom up, as OpenGL has them, and so do rectangles.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.gl import gl_context
from corpus_tools.world.physics.build import World, body_name, set_state
from corpus_tools.world.state.recording import Recording
from corpus_tools.world.state.solids import SOLID_GROUP
from g3.groundings import FloatArray

Image: TypeAlias = npt.NDArray[np.uint8]
Depth: TypeAlias = npt.NDArray[np.float32]

MAX_GEOMS = 20_000
BACKDROP, STILL, MOVING = 0, 1, 2
"""Groups of visible things: planes and others without a shadow; still things; moving things."""
HIDDEN = 5
NEAR = 1.0
"""Distance to visible things that MuJoCo needs, without perspective too."""
LOW_POLY = (1, 20, 10)
"""Facets along the edges of boxes, around cylinders, and along spheres."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Pixels from (x, y) on, (width, height) of them, counted from the lower left corner."""

    x: int
    y: int
    width: int
    height: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the rectangle in an image."""
        return slice(self.y, self.y + self.height), slice(self.x, self.x + self.width)

    def overlaps(self, other: Rectangle) -> bool:
        """Check that both have a pixel in common."""
        return (
            self.x < other.x + other.width
            and other.x < self.x + self.width
            and self.y < other.y + other.height
            and other.y < self.y + self.height
        )

    def union(self, other: Rectangle) -> Rectangle:
        """Return the smallest rectangle around both."""
        x, y = min(self.x, other.x), min(self.y, other.y)
        right = max(self.x + self.width, other.x + other.width)
        top = max(self.y + self.height, other.y + other.height)
        return Rectangle(x, y, right - x, top - y)

    def scaled(self, factor: int) -> Rectangle:
        """Return the same part of a picture that is larger by a factor."""
        return Rectangle(
            self.x * factor, self.y * factor, self.width * factor, self.height * factor
        )


class Canvas:
    """A world's geometry in an OpenGL context, to draw pictures of it.

    One canvas at a time can be open in a process; :meth:`close` frees it. It changes the visual
    settings of the world's model. `size` is the width and height of the largest picture in pixels,
    `samples` how many a pixel has (0 for one), `shadow_size` the width of the shadow map in pixels,
    `moving` has the indices of the objects that move.
    """

    def __init__(
        self,
        world: World,
        size: tuple[int, int],
        *,
        samples: int,
        shadow_size: int,
        moving: Iterable[int],
    ) -> None:
        self.world = world
        self.model = model = world.model
        self.data = mujoco.MjData(model)
        model.vis.global_.offwidth, model.vis.global_.offheight = size
        quality = model.vis.quality
        quality.offsamples, quality.shadowsize = samples, shadow_size
        quality.numquads, quality.numslices, quality.numstacks = LOW_POLY
        self.object_of_geom = _objects(world)
        self._corners = _local_corners(model)
        self._group(frozenset(moving))
        self.sun = sun_of(model)
        self._emission = model.mat_emission.copy()
        self._gl = gl_context(*size)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(model, min(MAX_GEOMS, model.ngeom + 100))
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._view = mujoco.MjvCamera()
        self._options = mujoco.MjvOption()

    def close(self) -> None:
        """Free the resources of OpenGL."""
        self._context.free()
        self._gl.free()

    def show(self, recording: Recording, k: int) -> None:
        """Put everything where it was at the k-th moment of a recording of this world."""
        set_state(self.world, self.data, recording, k)
        mujoco.mj_camlight(self.model, self.data)

    def draw(
        self,
        camera: Camera,
        size: tuple[int, int],
        *,
        groups: Iterable[int] = (BACKDROP, STILL, MOVING),
        part: Rectangle | None = None,
        rows: float = 1,
        sun: bool = True,
        other_light: bool = True,
        shadows: bool = False,
        sky: bool = True,
    ) -> None:
        """Draw what :meth:`pixels` and :meth:`depth` then read.

        `size` is the width and height of the whole picture, `rows` the number of rows drawn for
        each of the picture's. `sun` is true if the sun shines, `other_light` if anything else does:
        light from everywhere, lamps. `shadows` are MuJoCo's own. `sky` is the sky, and the
        haze before it.
        """
        part = part or Rectangle(0, 0, *size)
        self.model.vis.global_.fovy = np.degrees(camera.fovy)
        self._aim(camera)
        self._update(groups, sun=sun, other_light=other_light)
        self._crop(size, part)
        flags = mujoco.mjtRndFlag
        self._render(
            part.width,
            int(part.height * rows),
            {flags.mjRND_SHADOW: shadows, flags.mjRND_SKYBOX: sky, flags.mjRND_HAZE: sky},
        )

    def draw_along(
        self, axes: FloatArray, low: FloatArray, high: FloatArray, size: tuple[int, int], group: int
    ) -> None:
        """Draw without perspective along the third of the axes, to read :meth:`depth`.

        `axes` are unit vectors to the right, up and ahead, shape (3, 3); `low` and `high` the
        corners of the box that is seen, shape (3,), along these axes.
        """
        self._update((group,), sun=False)
        middle = (low + high) / 2
        eye = np.array([middle[0], middle[1], low[2] - NEAR]) @ axes
        for view in self._scene.camera:
            view.pos[:], view.forward[:], view.up[:] = eye, axes[2], axes[1]
            view.orthographic = 1
            view.frustum_center, view.frustum_width = 0.0, (high[0] - low[0]) / 2
            view.frustum_bottom, view.frustum_top = -(high[1] - low[1]) / 2, (high[1] - low[1]) / 2
            view.frustum_near, view.frustum_far = NEAR, NEAR + high[2] - low[2]
        flags = mujoco.mjtRndFlag
        self._render(
            *size, {flags.mjRND_SHADOW: False, flags.mjRND_SKYBOX: False, flags.mjRND_HAZE: False}
        )

    def pixels(self) -> Image:
        """Return the colours of the last drawing, shape (height, width, 3)."""
        image = np.empty((self._viewport.height, self._viewport.width, 3), np.uint8)
        mujoco.mjr_readPixels(image, None, self._viewport, self._context)
        return image

    def depth(self) -> Depth:
        """Return depths of the last drawing from 0, near, to 1, far or nothing, (height, width)."""
        image = np.empty((self._viewport.height, self._viewport.width), np.float32)
        mujoco.mjr_readPixels(None, image, self._viewport, self._context)
        return image

    def clip(self) -> tuple[float, float]:
        """Return the distances from the camera where the depth is 0 and 1, in metres."""
        view = self._scene.camera[0]
        return float(view.frustum_near), float(view.frustum_far)

    def objects(self, camera: Camera, size: tuple[int, int]) -> npt.NDArray[np.int64]:
        """Return the index of the object at each pixel, -1 for none, shape (height, width)."""
        self._aim(camera)
        self.model.vis.global_.fovy = np.degrees(camera.fovy)
        self._update((BACKDROP, STILL, MOVING), sun=True)
        flags = mujoco.mjtRndFlag
        switched = (flags.mjRND_SEGMENT, flags.mjRND_IDCOLOR)
        off = (flags.mjRND_SHADOW, flags.mjRND_SKYBOX, flags.mjRND_HAZE)
        self._render(*size, dict.fromkeys(switched, True) | dict.fromkeys(off, False))
        for flag in switched:
            self._scene.flags[flag] = 0
        rgb = self.pixels().astype(np.int64)
        number = rgb[..., 0] + 256 * rgb[..., 1] + 65536 * rgb[..., 2]
        drawn = np.full(self._scene.ngeom + 1, -1)
        geom_type = int(mujoco.mjtObj.mjOBJ_GEOM)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.objtype == geom_type and 0 <= geom.segid < self._scene.ngeom:
                drawn[geom.segid + 1] = self.object_of_geom[geom.objid]
        objects: npt.NDArray[np.int64] = drawn[np.minimum(number, self._scene.ngeom)]
        return objects

    def geoms_of(self, group: int) -> npt.NDArray[np.int64]:
        """Return the indices of a group's geoms."""
        return np.flatnonzero(self.model.geom_group == group)

    def corners(self, geoms: npt.NDArray[np.int64]) -> FloatArray:
        """Return the corners of boxes around geoms at their present poses, shape (8 n, 3)."""
        rotation = self.data.geom_xmat[geoms].reshape(-1, 3, 3)
        turned = np.einsum("nij,nkj->nki", rotation, self._corners[geoms])
        placed: FloatArray = (turned + self.data.geom_xpos[geoms][:, None]).reshape(-1, 3)
        return placed

    def _aim(self, camera: Camera) -> None:
        ahead = camera.axes[2]
        self._view.lookat[:] = camera.position + ahead
        self._view.distance = 1.0
        self._view.azimuth = np.degrees(np.arctan2(ahead[1], ahead[0]))
        self._view.elevation = np.degrees(np.arcsin(ahead[2]))

    def _update(self, groups: Iterable[int], *, sun: bool, other_light: bool = True) -> None:
        self._options.geomgroup[:] = 0
        self._options.geomgroup[list(groups)] = 1
        if self.sun is not None:
            self.model.light_active[self.sun] = sun
        self.model.vis.headlight.active = other_light
        self.model.mat_emission[:] = self._emission if other_light else 0
        mujoco.mjv_updateScene(
            self.model,
            self.data,
            self._options,
            None,
            self._view,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )

    def _crop(self, size: tuple[int, int], part: Rectangle) -> None:
        """Narrow the view from a whole picture to a part of it."""
        for view in self._scene.camera:
            bottom, top = view.frustum_bottom, view.frustum_top
            pixel = (top - bottom) / size[1]
            view.frustum_bottom = bottom + pixel * part.y
            view.frustum_top = bottom + pixel * (part.y + part.height)
            view.frustum_center = pixel * (part.x + part.width / 2 - size[0] / 2)
            view.frustum_width = pixel * part.width / 2

    def _render(self, width: int, height: int, flags: dict[int, bool]) -> None:
        for flag, value in flags.items():
            self._scene.flags[flag] = value
        self._viewport = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(self._viewport, self._scene, self._context)

    def _group(self, moving: frozenset[int]) -> None:
        """Sort visible geoms into groups, by which :meth:`draw` chooses its geoms."""
        plane = self.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        shadowless = plane | (self.model.geom_castshadow == 0)
        moves = np.isin(self.object_of_geom, list(moving))
        seen = (self.model.geom_group != SOLID_GROUP) & (self.model.geom_group != HIDDEN)
        self.model.geom_group[:] = np.select(
            [~seen, shadowless, moves], [HIDDEN, BACKDROP, MOVING], STILL
        )


def sun_of(model: mujoco.MjModel) -> int | None:
    """Return the directional light that throws shadows; None if there is none."""
    directional = model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    lights = np.flatnonzero(directional & model.light_castshadow.astype(bool))
    return int(lights[0]) if len(lights) else None


def _objects(world: World) -> npt.NDArray[np.int64]:
    """Return the index of the object that each geom belongs to, -1 for none, shape (ngeom,)."""
    model = world.model
    of_body = np.full(model.nbody, -1)
    for i, item in enumerate(world.context.objects):
        of_body[model.body(body_name(item.id)).id] = i
    roots = model.body_rootid
    of_geom: npt.NDArray[np.int64] = of_body[roots[model.geom_bodyid]]
    return of_geom


def _local_corners(model: mujoco.MjModel) -> FloatArray:
    """Return the corners of the boxes around all geoms in their frames, shape (ngeom, 8, 3)."""
    signs = np.stack(np.meshgrid(*[(-1, 1)] * 3, indexing="ij"), axis=-1).reshape(8, 3)
    box = model.geom_aabb.reshape(-1, 2, 3)
    corners: FloatArray = box[:, :1] + signs * box[:, 1:]
    return corners
