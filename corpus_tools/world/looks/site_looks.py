"""Surroundings of things: ground, light and sky, walls of a hall, a warehouse's front, barriers.

Surfaces of walls face inwards and are seen from inside only: a camera that looks in from outside or
from above sees what is in there, as in a doll's house.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import mujoco
import numpy as np

from corpus_tools.world.looks.atlas import Finish, colour, patch
from corpus_tools.world.looks.drawing import add_material, add_plane, add_texture, draw
from corpus_tools.world.looks.markings import Yard, barrier, barrier_side, markings, yard_of
from corpus_tools.world.looks.parts import Part, Span, join, moved, quad
from g3.groundings import Context
from g3.short_repr import short_repr

Colour = tuple[float, float, float]

WALL_M = 6.5
"""Height of a hall, and of a warehouse's front."""
PLINTH_M = 1.0
"""Height up to which walls are concrete, in metres."""
PANEL_M = 4.0
"""Width of a piece of wall, more or less."""
DOOR_M = (3.6, 4.0)
"""Width and height of doors for trucks."""
DOOR_EVERY = 3
"""Every third piece of a wall has a door."""
BAY_M = 8.0
"""Distance from one roof beam to the next, in metres."""
_OFF_M = 0.03
"""Distance of things on a wall before it, in metres."""


@short_repr
@dataclass(frozen=True, slots=True)
class Site:
    """Look of a kind of site."""

    walls: Callable[[Context, Yard, float], list[Part]]
    """Surroundings of the yard of a context, given the height of the ground."""
    ground: Colour = (1.0, 1.0, 1.0)
    """Visible share of the ground's own colour, red, green and blue."""
    sun: Colour = (0.42, 0.30, -0.86)
    """Direction of the light's source."""
    brightness: tuple[Colour, Colour] = ((0.58, 0.56, 0.52), (0.43, 0.44, 0.47))
    """Light of that sun, and from everywhere, red, green and blue."""
    lamp_m: float = 0.0
    """Width of its shadows' edges: many lamps light a hall."""
    sky: tuple[Colour, Colour] = ((0.45, 0.62, 0.80), (0.82, 0.87, 0.91))
    """Above, and at the horizon."""
    grass: bool = True
    """True if grass is beyond the yard, up to the horizon."""


def _hall(context: Context, yard: Yard, ground_m: float) -> list[Part]:
    """Build four walls with doors and windows, and a roof with beams and lamps."""
    sides = [_wall(yard, quarter, ground_m, windows=True) for quarter in range(4)]
    return [*sides, moved(join(_roof(yard)), (*yard.middle, ground_m), yard.yaw)]


def _depot(context: Context, yard: Yard, ground_m: float) -> list[Part]:
    """Build the front of a warehouse where the robot looks to at the start; low walls else."""
    heading = context.agent.trajectory.yaw[0]
    inward = yard.yaw + np.pi / 2 * (np.arange(4) + 1)
    front = int(np.argmin(np.cos(inward - heading)))
    others = [barrier_side(yard, ground_m, quarter) for quarter in range(4) if quarter != front]
    return [*others, _wall(yard, front, ground_m, windows=False)]


def _wall(yard: Yard, quarter: int, ground_m: float, *, windows: bool) -> Part:
    """Build one side: cladding on a plinth, with doors; above, a row of windows, or a rim."""
    along, across = float(yard.half[quarter % 2]), float(yard.half[1 - quarter % 2])
    n = max(1, round(2 * along / PANEL_M))
    edges = np.linspace(-along, along, n + 1)
    cladding, plinth = patch("cladding"), colour("concrete", 0.7, 0.9)
    frame, hazard = colour("navy", 0.8, 1.0), patch("hazard", s=(0, 0.25))

    def piece(x: Span, z: Span, finish: Finish, off: float = 0.0) -> Part:
        (x0, x1), (z0, z1), y = x, z, off - across
        return quad([(x1, y, z0), (x0, y, z0), (x0, y, z1), (x1, y, z1)], finish)

    parts = [piece((-along, along), (0.0, PLINTH_M), plinth)]
    doors = [k for k in range(n) if (k - n // 2) % DOOR_EVERY == 0]
    for k, (a, b) in enumerate(pairwise(edges)):
        parts.append(piece((a, b), (PLINTH_M, WALL_M), cladding))
        if windows:
            post = colour("steel", 0.8, 1.0)
            parts.append(piece((a - 0.14, a + 0.14), (0.0, WALL_M), post, _OFF_M))
        if windows and k not in doors:
            glass = colour("sky", 1.0, 1.1)
            parts.append(piece((a + 0.3, b - 0.3), (WALL_M - 1.9, WALL_M - 0.9), glass, _OFF_M))
    half, tall = min(DOOR_M[0], 0.85 * PANEL_M) / 2, DOOR_M[1]
    for k in doors:
        x = float(edges[k] + edges[k + 1]) / 2
        parts += [
            piece((x - half - 0.2, x + half + 0.2), (0.0, tall + 0.2), frame, _OFF_M),
            piece((x - half, x + half), (0.0, tall), patch("roller"), 2 * _OFF_M),
            piece((x - half - 0.2, x - half), (0.0, 1.4), hazard, 2 * _OFF_M),
            piece((x + half, x + half + 0.2), (0.0, 1.4), hazard, 2 * _OFF_M),
        ]
    if not windows:
        parts.append(piece((-along, along), (WALL_M - 0.6, WALL_M), frame, _OFF_M))
    return moved(join(parts), (*yard.middle, ground_m), yard.yaw + np.pi / 2 * quarter)


def _roof(yard: Yard) -> list[Part]:
    """Build a ceiling that is seen from below, with beams across and lamps between them."""
    (x, y), z = yard.half.tolist(), WALL_M

    def facing_down(x: Span, y: Span, z: float, finish: Finish) -> Part:
        (x0, x1), (y0, y1) = x, y
        return quad([(x0, y1, z), (x1, y1, z), (x1, y0, z), (x0, y0, z)], finish)

    parts = [facing_down((-x, x), (-y, y), z, colour("white", 1.0, 1.0))]
    bays, rows = max(1, round(2 * x / BAY_M)), max(1, round(2 * y / BAY_M))
    beam, lamp = colour("steel", 0.9, 0.9), colour("lamp", 1.1, 1.1)
    for at in np.linspace(-x, x, bays + 1)[1:-1]:
        parts.append(facing_down((at - 0.2, at + 0.2), (-y, y), z - 0.35, beam))
    for at in np.linspace(-x, x, 2 * bays + 1)[1::2]:
        for row in np.linspace(-y, y, 2 * rows + 1)[1::2]:
            parts.append(facing_down((at - 0.25, at + 0.25), (row - 1.6, row + 1.6), z - 0.2, lamp))
    return parts


SITES: Mapping[str, Site] = MappingProxyType(
    {
        "yard": Site(lambda _, yard, ground_m: barrier(yard, ground_m)),
        "depot": Site(_depot, ground=(0.62, 0.63, 0.66)),
        "hall": Site(
            _hall,
            ground=(0.84, 0.84, 0.88),
            sun=(0.16, 0.12, -0.98),
            brightness=((0.38, 0.37, 0.34), (0.59, 0.60, 0.61)),
            lamp_m=0.3,
            sky=((0.50, 0.52, 0.55), (0.50, 0.52, 0.55)),
            grass=False,
        ),
    }
)
"""By the name that layouts give."""


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
    """Add the surroundings of the objects: nothing of it collides or casts shadows on them.

    `site` is one of :data:`~corpus_tools.world.looks.site_looks.SITES`.
    """
    yard, around = yard_of(context), SITES[site]
    _add_light(spec, yard, ground_m, around)
    _add_ground(spec, yard, ground_m, around)
    for parts in (markings(context, yard, ground_m), around.walls(context, yard, ground_m)):
        draw(spec, spec.worldbody, parts).castshadow = False


def _add_light(spec: mujoco.MjSpec, yard: Yard, ground_m: float, site: Site) -> None:
    """Add a sun whose shadows reach the whole yard, light from everywhere, and a sky."""
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
        bulbradius=site.lamp_m / 2,
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
    """Add slabs of concrete, laid along the yard, and outdoors grass up to the horizon."""
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
