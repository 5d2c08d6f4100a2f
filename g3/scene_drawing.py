"""A map of a scene as an SVG picture: footprints from above, what is meant, and the ways driven."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from g3.groundings import Context, FloatArray, PhysicalObject, Place, Trajectory
from g3.short_repr import short_repr, shortened

WIDTH = 560.0
"""Pixels from the left to the right, if the scene is not much higher than wide."""
HIGHEST = 560.0
MARGIN_M = 1.5
LETTERS = 24
"""Longest shown name of an object, in letters."""
PLAIN, ROBOT, MEANT = "#e4e8ee", "#f2c14e", "#7fb7e6"
INK, WAY = "#1f2933", "#c2410c"


@short_repr
@dataclass(frozen=True, slots=True)
class Marks:
    """Highlights of a scene: things by their ids, and the driven ways, in their order."""

    things: Collection[str] = ()
    places: Sequence[Place] = ()
    ways: Sequence[Trajectory] = field(default=())


def scene_svg(context: Context, marks: Marks | None = None) -> str:
    """Draw a scene from above as SVG, x to the right and y up; the same scene gives the same text.

    Objects are drawn where their prisms are.
    """
    marked = marks or Marks()
    view = _View.around(
        [
            *(o.prism.xy for o in context.objects),
            *(p.prism.xy for p in marked.places),
            *(way.xyz[:, :2] for way in marked.ways),
        ]
    )
    # What is low comes first, so that loads stand on what carries them.
    things = sorted(context.objects, key=lambda o: (o.prism.z_min, o.id))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{view.width:.0f}" '
        f'height="{view.height:.0f}" viewBox="0 0 {view.width:.0f} {view.height:.0f}" '
        'font-family="sans-serif" font-size="11" text-anchor="middle" role="img">',
        "<title>The scene from above</title>",
        '<rect width="100%" height="100%" fill="white"/>',
        *(_thing(thing, view, context, marked) for thing in things),
        *(
            _polygon(view.at(place.prism.xy), "none", f'stroke="{WAY}" stroke-dasharray="4 3"')
            for place in marked.places
        ),
        *(_way(view.at(way.xyz[:, :2]), n) for n, way in enumerate(marked.ways, start=1)),
        *(_name(thing, view) for thing in things),
    ]
    return "\n".join([*lines, "</svg>"])


@dataclass(frozen=True, slots=True)
class _View:
    """Transformation of metres to pixels."""

    left_m: float
    top_m: float
    pixels: float
    width: float
    height: float

    @classmethod
    def around(cls, parts: Sequence[FloatArray]) -> _View:
        points = np.concatenate(parts) if parts else np.zeros((1, 2))
        low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
        wide, tall = (float(length) for length in high - low)
        pixels = min(WIDTH / wide, HIGHEST / tall)
        return cls(float(low[0]), float(high[1]), pixels, wide * pixels, tall * pixels)

    def at(self, xy: FloatArray) -> FloatArray:
        """Pixels of points, shape (n, 2)."""
        return (xy - (self.left_m, self.top_m)) * (self.pixels, -self.pixels)


def _thing(thing: PhysicalObject, view: _View, context: Context, marks: Marks) -> str:
    is_robot = thing.id == context.agent_id
    fill = ROBOT if is_robot else MEANT if thing.id in marks.things else PLAIN
    title = escape(f"{' '.join(thing.labels)} ({thing.id})")
    return _polygon(view.at(thing.prism.xy), fill, f'stroke="{INK}"', title)


def _polygon(points: FloatArray, fill: str, style: str, title: str = "") -> str:
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polygon points="{corners}" fill="{fill}" {style}><title>{title}</title></polygon>'


def _way(points: FloatArray, number: int) -> str:
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    x, y = points[-1]
    return (
        f'<polyline points="{line}" fill="none" stroke="{WAY}" stroke-width="2"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="{WAY}"/>'
        f'<text x="{x:.1f}" y="{y + 4:.1f}" fill="white">{number}</text>'
    )


def _name(thing: PhysicalObject, view: _View) -> str:
    ((x, y),) = view.at(thing.prism.xy.mean(axis=0)[None])
    name = escape(shortened(" ".join(thing.labels) or thing.id, LETTERS))
    return (
        f'<text x="{x:.1f}" y="{y + 4:.1f}" fill="{INK}" stroke="white" stroke-width="3" '
        f'paint-order="stroke">{name}</text>'
    )
