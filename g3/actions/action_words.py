"""Actions and groundings in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from g3.actions.action_kinds import Action
from g3.actions.grounding_candidates import ground
from g3.actions.robot_state import State, names_person
from g3.geometry.footprints import covers
from g3.geometry.plane import convex_hull, point_gap, rotate
from g3.geometry.relations import LEVEL_M, rests_on
from g3.groundings import FloatArray, Grounding, Path, Place

Frame = tuple[float, float, float]
"""Pose of a frame in the map's: x and y in metres, yaw in radians."""
MAP: Frame = (0.0, 0.0, 0.0)
"""The frame of the map itself."""
BESIDE_M = 2.5
"""Distance from a thing up to which a place is beside it, without a number of metres."""


class PlaceName(NamedTuple):
    """A place in words."""

    name: str
    """Of itself, of a thing under it, or where it is from the nearest thing."""
    is_on: bool = False
    """True if the name is that of a thing under it."""
    is_ground: bool = False
    """True if the name is a side of a thing."""
    point: str = ""
    """Its middle, and its height if it is up in the air; empty if it has a name of its own."""


class PlanWords:
    """Describes the actions and groundings of a plan.

    Parameters
    ----------
    start
        The state before the plan. Its things and places name other places, and its frame is that
        of points. Without a state there are only points, in the map.
    actions
        The plan. Things that it moves don't name places.
    points
        False leaves out the points of places.
    """

    def __init__(
        self, start: State | None = None, actions: Sequence[Action] = (), *, points: bool = True
    ) -> None:
        self._start, self._actions, self._points = start, actions, points
        moved = {action.object_id for action in actions}
        gone = moved if start is None else moved | {start.context.agent_id, start.held or ""}
        things = () if start is None else start.context.objects
        self._things = [thing for thing in things if thing.id not in gone]

    def action(self, action: Action) -> str:
        """Describe an action, its object, and its place by name."""
        target = " and ".join(self._target(g) for g in action.target if not isinstance(g, Path))
        words = [action.kind.name, action.object_id, target]
        if action.place is not None:
            where = self.place(action.place)
            on, at = ("onto", "to") if action.kind.takes else ("on", "at")
            if where.is_ground:
                words.append(f"{at if action.kind.takes else on} the ground {where.name}")
            else:
                words.append(f"{on if where.is_on else at} {where.name}".rstrip())
            words.append(where.point)
        if action.kind.unit == "rad":
            words.append(f"{np.rad2deg(action.amount):.0f} degrees")
        elif action.amount:  # also of a kind that mostly has none: "drive away", by so many metres
            words.append(f"{abs(action.amount):.3g} {action.kind.unit or 'm'}")
        return " ".join(word for word in words if word)

    def group(self, group: Sequence[Grounding]) -> str:
        """Describe a clause's groundings."""
        if any(isinstance(g, Path) for g in group):
            return "the way there"
        return " and ".join(self._target(g) for g in group)

    def place(self, place: Place) -> PlaceName:
        """Name a place."""
        if place.name:
            return PlaceName(place.name)
        middle = place.prism.xy.mean(axis=0)
        if self._start is None:
            return PlaceName("", point=self._point(middle, float(place.prism.z_min)))
        point = self._point(middle)
        under = next((o.id for o in self._things if rests_on(place.prism, o.prism)), "")
        under = under or self._brought_under(place, middle)
        if under:
            return PlaceName(under, is_on=True, point=point)
        up = float(place.prism.z_min) - ground(self._start)
        point = self._point(middle, up)
        regions = (region for region in self._start.context.places if region.name)
        around = next((r.name for r in regions if covers(r.prism, middle)), "")
        if around:
            return PlaceName(around, point=point)
        return PlaceName(self._side(middle, self._start), is_ground=bool(self._things), point=point)

    def _brought_under(self, place: Place, middle: FloatArray) -> str:
        """Return the id of a load that the plan puts under a place; empty for none."""
        for action in self._actions:
            spot = action.place.prism if action.place is not None else place.prism
            if spot.z_min + LEVEL_M < place.prism.z_min and covers(spot, middle):
                return action.object_id
        return ""

    def _side(self, middle: FloatArray, start: State) -> str:
        """Describe where a point (2,) is from the nearest thing, as the robot sees it at first."""
        things = [o for o in self._things if not names_person(o.labels)] or self._things
        if not things:
            return ""
        hulls = [convex_hull(thing.prism.xy) for thing in things]
        nearest = int(np.argmin([point_gap(middle[None, None], h[None])[0, 0] for h in hulls]))
        turn = np.array(-start.pose[2])
        at, corners = rotate(middle, turn), rotate(hulls[nearest], turn)
        low, high = corners.min(axis=0), corners.max(axis=0)
        beyond = np.array([at[0] - high[0], low[0] - at[0], at[1] - high[1], low[1] - at[1]])
        side = ("behind", "in front of", "left of", "right of")[int(beyond.argmax())]
        apart = float(beyond.max())
        far = f"{apart:.0f} m " if apart > BESIDE_M else ""
        return f"{far}{side} {things[nearest].id}"

    def _target(self, target: Grounding) -> str:
        if not isinstance(target, Place):
            return getattr(target, "id", "")
        where = self.place(target)
        link = "the place on " if where.is_on else "the place " if where.is_ground else ""
        return f"{link}{where.name} {where.point}".strip()

    def _point(self, middle: FloatArray, up: float = 0.0) -> str:
        if not self._points:
            return ""
        x, y = in_frame(middle, MAP if self._start is None else self._start.frame) + 0.0
        height = round(up, 1)
        return f"at ({x:.1f}, {y:.1f})" + (f", {height} m up" if height > 0 else "")


def in_frame(point: FloatArray, frame: Frame) -> FloatArray:
    """Return a point (2,) of the map in a frame, rounded to millimetres."""
    x, y, yaw = frame
    moved: FloatArray = rotate(point - np.array([x, y]), np.array(-yaw)).round(3)
    return moved
