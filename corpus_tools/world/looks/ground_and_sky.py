"""The ground, light and sky around the objects of a context."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from corpus_tools.world.looks.drawing import add_material, add_plane, add_texture, draw
from corpus_tools.world.looks.markings import Yard, markings, yard_of
from corpus_tools.world.looks.site_looks import SITES, Site
from g3.groundings import Context

SLAB_M = 4.0
"""Edge of a slab of the concrete ground."""
GRASS_M = 16.0
"""After how far the picture of the grass repeats."""
FAR_M = 400.0
NEAR_M = 0.2
_PICTURES = Path(__file__).parent


def add_surroundings(
    spec: mujoco.MjSpec, context: Context, ground_m: float, site: str = "yard"
) -> None:
    """Add what surrounds the objects: nothing of it collides or casts shadows on them.

    `site` is one of :data:`~corpus_tools.world.looks.site_looks.SITES`.
    """
    yard, around = yard_of(context), SITES[site]
    _add_light(spec, yard, ground_m, around)
    _add_ground(spec, yard, ground_m, around)
    for parts in (markings(context, yard, ground_m), around.walls(context, yard, ground_m)):
        draw(spec, spec.worldbody, parts).castshadow = False


def _add_light(spec: mujoco.MjSpec, yard: Yard, ground_m: float, site: Site) -> None:
    """A sun whose shadows reach the whole yard, light from everywhere, and a sky."""
    centre = np.array([*yard.middle, ground_m])
    extent = float(np.hypot(*yard.half))
    spec.stat.center, spec.stat.extent = centre, extent
    view = spec.visual
    view.map.znear, view.map.zfar = NEAR_M / extent, FAR_M / extent
    view.map.shadowclip = 1.0
    view.quality.shadowsize = 2048
    view.map.haze = 0.25
    above, horizon = site.sky
    sunshine, everywhere = site.brightness
    view.rgba.haze = [*horizon, 1]
    view.headlight.ambient = everywhere
    view.headlight.diffuse = [0.08, 0.08, 0.08]
    view.headlight.specular = [0, 0, 0]
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=centre - 1.5 * extent * np.array(site.sun),
        dir=site.sun,
        ambient=[0, 0, 0],
        diffuse=sunshine,
        specular=[0.3, 0.3, 0.3],
        castshadow=True,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=above,
        rgb2=horizon,
        width=64,
        height=384,
    )


def _add_ground(spec: mujoco.MjSpec, yard: Yard, ground_m: float, site: Site) -> None:
    """Slabs of concrete, laid along the yard, and outdoors grass up to the horizon."""
    surfaces = [("concrete", ground_m, yard.half + 0.5, 2 * SLAB_M, site.ground)]
    if site.grass:
        surfaces.append(("grass", ground_m - 0.03, np.zeros(2), GRASS_M, (1.0, 1.0, 1.0)))
    # The nearer surface first: the renderer then skips what it hides of the other.
    for name, height, half, edge, tint in surfaces:
        add_texture(spec, name, _PICTURES / f"{name}.png")
        material = add_material(spec, name, name)
        material.rgba = [*tint, 1]
        material.texuniform = True
        material.texrepeat = [1 / edge, 1 / edge]
        add_plane(spec, [*yard.middle, height], yard.yaw, half, name)
