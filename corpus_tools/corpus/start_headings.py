"""Heading of the robot at the start, where nobody has recorded it.

Such a context lists the heading of its agent in `assumed`. Results for such
worlds should be given for several headings: give each rule to :func:`with_headings`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation
from g3.errors import FormatError
from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, Grounding, PhysicalObject, Prism, Trajectory
from g3.short_repr import short_repr

Toward: TypeAlias = Literal["loads", "things", "east"]
LOAD = "pallet"
"""Label of loads."""


@short_repr
@dataclass(frozen=True, slots=True)
class HeadingRule:
    """A direction, and how far the robot is turned from it."""

    toward: Toward = "loads"
    """``loads``: the middle of all loads, or of all things where there are no loads. ``things``:
    the middle of all things. ``east``: +x of the map."""
    turned_rad: float = 0.0
    """Counter-clockwise."""


def parse_heading(text: str) -> HeadingRule:
    """Read a rule as people write it.

    Examples
    --------
    >>> parse_heading("loads")
    HeadingRule(toward='loads', turned_rad=0.0)
    >>> parse_heading("things-90").toward, round(parse_heading("loads+30").turned_rad, 3)
    ('things', 0.524)
    >>> parse_heading("180").toward
    'east'
    """
    match = re.fullmatch(r"(loads|things|east)?([-+]?\d+(?:\.\d+)?)?", text.strip())
    if not match or not text.strip() or (match[1] and match[2] and match[2][0] not in "+-"):
        raise FormatError(
            f"{text!r} is not a heading",
            where="--heading",
            fix="write loads, things, loads+30 (degrees counter-clockwise) or degrees from +x",
        )
    towards: tuple[Toward, ...] = get_args(Toward)
    toward: Toward = next((name for name in towards if name == match[1]), "east")
    return HeadingRule(toward, float(np.deg2rad(float(match[2] or 0))))


def with_headings(corpus: Corpus, rule: HeadingRule) -> Corpus:
    """Turn the robot in each context in which its heading is assumed.

    Annotations of these contexts follow. Contexts with a recorded heading, and those in which
    the robot moves, stay as they are.

    Returns
    -------
    Corpus
        With a hash of its own if anything was turned.
    """
    turned = {name: turn_robot(context, rule) for name, context in corpus.contexts.items()}
    if all(turned[name] is context for name, context in corpus.contexts.items()):
        return corpus
    robots = {
        id(context.agent): turned[name].agent
        for name, context in corpus.contexts.items()
        if turned[name] is not context
    }

    def follow(grounding: Grounding) -> Grounding:
        return robots.get(id(grounding), grounding)

    def moved(annotation: Annotation) -> Annotation:
        return replace(
            annotation,
            context=turned[annotation.context.id],
            groundings=tuple(tuple(map(follow, group)) for group in annotation.groundings),
        )

    annotations = tuple(map(moved, corpus.annotations))
    return replace(corpus, contexts=turned, annotations=annotations)


def turn_robot(context: Context, rule: HeadingRule) -> Context:
    """Turn the robot of a context, if its heading is assumed and it stands still."""
    robot = context.agent
    is_assumed = (robot.id, "heading") in context.assumed
    if not is_assumed or len(robot.trajectory) > 1:
        return context
    yaw = _direction(context, rule.toward) + rule.turned_rad
    at = robot.trajectory.xyz[0, :2]
    corners = robot.prism.xy - at
    prism = Prism(
        at + rotate(corners, np.full(len(corners), yaw - robot.trajectory.yaw[0])),
        robot.prism.z_min,
        robot.prism.z_max,
    )
    trajectory = Trajectory(robot.trajectory.t, robot.trajectory.xyz, np.array([yaw]))
    new = replace(robot, prism=prism, trajectory=trajectory)
    objects = tuple(new if item is robot else item for item in context.objects)
    return replace(context, objects=objects)


def _direction(context: Context, toward: Toward) -> float:
    things = [item for item in context.objects if item.id != context.agent_id]
    if toward == "loads":
        things = [item for item in things if LOAD in item.labels] or things
    if toward == "east" or not things:
        return 0.0
    x, y = np.mean([_middle(item) for item in things], axis=0) - _middle(context.agent)
    return float(np.arctan2(y, x))


def _middle(item: PhysicalObject) -> FloatArray:
    middle: FloatArray = item.trajectory.xyz[0, :2]
    return middle
