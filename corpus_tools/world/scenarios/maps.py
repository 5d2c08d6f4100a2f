"""Scenarios seen from above, as SVG."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape

import numpy as np

from corpus_tools.world.scenarios.boxes import Box, place_box, robot_box, thing_box
from corpus_tools.world.scenarios.scenario import ROBOT, Scenario
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS
from g3.groundings import FloatArray

PIXELS_PER_M = 24
MARGIN_M = 1.0
CAPTION_M = 1.2
"""Room for a line of text."""

_COLOURS: Mapping[str, str] = {
    "forklift": "#f2b01e",
    "tire-pallet": "#4a4a4a",
    "box-pallet": "#b98b55",
    "crate": "#8a5a2b",
    "trailer": "#7a8fa6",
    "truck": "#4f7cac",
    "shelf": "#5f7f5f",
    "barrel": "#2f6f9f",
    "person": "#c0504d",
    "cone": "#f07020",
}
_OTHER = "#999999"
_DECK = "#c9d6e3"


def draw_map(scenario: Scenario) -> str:
    """Draw an SVG document: x is to the right and y up, as in the layout's frame."""
    bounds = scenario.layout.bounds
    (left, right), (bottom, top) = bounds.x, bounds.y
    width = (right - left + 2 * MARGIN_M) * PIXELS_PER_M
    captions = [
        f"{scenario.id} ({scenario.layout.name}): {scenario.title}",
        *(f"{i}. {s.action} {s.argument}" for i, s in enumerate(scenario.script, start=1)),
    ]
    height = (top - bottom + 2 * MARGIN_M + CAPTION_M * len(captions)) * PIXELS_PER_M
    origin = np.array([MARGIN_M - left, MARGIN_M + top])
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}"'
        f' viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="11">',
        f"<title>{escape(scenario.title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        _polygon(corners, origin, 'fill="#f4f4f1" stroke="#333333" stroke-width="2"'),
        *_places(scenario, origin),
        *_objects(scenario, origin),
    ]
    for i, caption in enumerate(captions):
        y = height - (len(captions) - i - 0.5) * CAPTION_M * PIXELS_PER_M
        parts.append(
            f'<text x="{MARGIN_M * PIXELS_PER_M:.0f}" y="{y:.0f}">{escape(caption)}</text>'
        )
    return "\n".join((*parts, "</svg>")) + "\n"


def _places(scenario: Scenario, origin: FloatArray) -> Iterator[str]:
    objects = scenario.all_objects
    for name, region in scenario.all_places.items():
        box = place_box(region, objects)
        if region.deck is not None:
            continue
        yield _polygon(
            box.footprint, origin, 'fill="#e8e4c9" stroke="#b0a860" stroke-dasharray="4 3"'
        )
        yield _label(box.middle, origin, region.name or name, "#7a7230")


def _objects(scenario: Scenario, origin: FloatArray) -> Iterator[str]:
    objects = scenario.all_objects
    boxes = {name: thing_box(t, objects, scenario.robot) for name, t in objects.items()}
    # What is higher is drawn later, and the robot before its load.
    order = sorted(boxes, key=lambda name: (boxes[name].z_min, name == scenario.robot.carries))
    carried = scenario.robot.carries
    for name in [n for n in order if n != carried]:
        yield from _solid(name, objects[name].kind, boxes[name], origin)
    for name, region in scenario.all_places.items():
        if region.deck is not None:
            box = place_box(region, objects)
            yield _polygon(
                box.footprint, origin, 'fill="none" stroke="#b0a860" stroke-dasharray="4 3"'
            )
            yield _label(box.middle, origin, name, "#7a7230")
    yield from _solid(ROBOT, FORKLIFT.name, robot_box(scenario.robot), origin)
    if carried is not None:
        yield from _solid(carried, objects[carried].kind, boxes[carried], origin)


def _solid(name: str, kind: str, box: Box, origin: FloatArray) -> Iterator[str]:
    colour = _COLOURS.get(kind, _OTHER)
    yield _polygon(box.footprint, origin, f'fill="{colour}" fill-opacity="0.85" stroke="#222222"')
    deck = KINDS[kind].deck
    if deck is not None:
        middle, length = (deck[0] + deck[1]) / 2, deck[1] - deck[0]
        loadable = Box(box.pose, (length, box.size[1] - 0.2), 0.0, 1.0, middle)
        yield _polygon(loadable.footprint, origin, f'fill="{_DECK}"')
    nose = Box(box.pose, (0.0, 0.0), 0.0, 1.0, box.ahead_m + box.size[0] / 2).middle
    (x0, y0), (x1, y1) = _pixels(np.array([box.middle, nose]), origin)
    yield (
        f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
        ' stroke="#ffffff" stroke-width="2"/>'
    )
    yield _label(box.middle, origin, name, "#000000")


def _polygon(corners: FloatArray, origin: FloatArray, style: str) -> str:
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in _pixels(corners, origin))
    return f'<polygon points="{points}" {style}/>'


def _label(at: FloatArray, origin: FloatArray, text: str, colour: str) -> str:
    ((x, y),) = _pixels(at[None], origin)
    return (
        f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle" fill="{colour}"'
        f' stroke="#ffffff" stroke-width="2.5" paint-order="stroke">{escape(text)}</text>'
    )


def _pixels(points: FloatArray, origin: FloatArray) -> FloatArray:
    pixels: FloatArray = (points * np.array([1, -1]) + origin) * PIXELS_PER_M
    return pixels
