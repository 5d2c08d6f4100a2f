"""Objects, places, paths and contexts as slu_core writes them.

The same objects are written out hundreds of times. :class:`Instances` makes one instance
of each, so that a corpus is small and fast to compare.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from g3.errors import FormatError
from g3.groundings import (
    Context,
    FloatArray,
    Grounding,
    Path,
    PhysicalObject,
    Place,
    Prism,
    Trajectory,
)
from g3.short_repr import short_repr

SAME_POSE_M = 1e-3
"""Poses closer than this are the same: the files differ by less in what they copy."""

MICROSECONDS = 1e6

UNIFIED_LABELS = {("generator", "pallet"): ("generator", "accessories", "pallet")}
"""Labels that differ between the published files and mean the same.

The positives call the pallets of boxes generator, accessories, pallet; the negatives call
the same objects generator, pallet. Left alone, the label *accessories* would show a
classifier which file an example comes from, and so whether it is right.
"""

PrismKey = tuple[bytes, float, float]
TrajectoryKey = tuple[bytes, bytes]
ObjectKey = tuple[str, tuple[str, ...], PrismKey, TrajectoryKey]


@short_repr
@dataclass(slots=True)
class Instances:
    """One instance of each trajectory, prism, object and context that has been read."""

    headings_restored: int = 0
    """Number of groundings without headings that are objects of no context that was read."""
    _trajectories: dict[TrajectoryKey, Trajectory] = field(default_factory=dict)
    _prisms: dict[PrismKey, Prism] = field(default_factory=dict)
    _objects: dict[ObjectKey, PhysicalObject] = field(default_factory=dict)
    _contexts: dict[str, list[Context]] = field(default_factory=lambda: defaultdict(list))
    _by_id: dict[str, list[PhysicalObject]] = field(default_factory=lambda: defaultdict(list))

    def contexts(self) -> tuple[Context, ...]:
        """All contexts, by scenario."""
        return tuple(
            context for scenario in sorted(self._contexts) for context in self._contexts[scenario]
        )

    def read_context(self, value: Any, agent: Any, scenario: str) -> Context:
        """Read the context of a record, the agent in it; FormatError if one is unreadable.

        It is named after the scenario; should a scenario have several contexts, the others are
        numbered.
        """
        robot = self.read_object(agent, "agent")
        objects = [
            self.read_object(_value(item, "PhysicalObject", where), where)
            for where, item in _items(value, "objects")
        ]
        if robot.id not in {item.id for item in objects}:
            objects.append(robot)
        places = [
            Place(self._read_prism(_value(item, "Place", where), where))
            for where, item in _items(value, "places")
        ]
        known = self._contexts[scenario]
        for context in known:
            if (
                context.objects == tuple(objects)
                and context.places == tuple(places)
                and context.agent_id == robot.id
            ):
                return context
        name = scenario if not known else f"{scenario}-{len(known) + 1}"
        new = Context(name, tuple(objects), tuple(places), robot.id)
        known.append(new)
        for item in objects:
            self._by_id[item.id].append(item)
        return new

    def read_grounding(self, value: Any, context: Context, where: str) -> Grounding:
        """Read a grounding: the same instance as in `context`, else as in another context.

        Raises FormatError if it can't be read.
        """
        match value:
            case ["PhysicalObject", inner]:
                return self._in_a_context(self.read_object(inner, where), context)
            case ["Place", inner]:
                return Place(self._read_prism(inner, where))
            case ["Path", inner]:
                return Path(self._read_trajectory(inner, where))
        raise _bad(
            "this is not a grounding",
            where,
            "write [PhysicalObject, ...], [Place, ...] or [Path, ...]",
        )

    def _in_a_context(self, read: PhysicalObject, context: Context) -> PhysicalObject:
        for item in (*context.objects, *self._by_id[read.id]):
            if same_object(item, read):
                return item
        if read.id == context.agent_id or not heading_is_lost(read.trajectory):
            return read
        self.headings_restored += 1
        return replace(read, trajectory=self._with_heading_of_footprint(read))

    def _with_heading_of_footprint(self, item: PhysicalObject) -> Trajectory:
        # In all contexts the second edge of a footprint points where the object heads.
        edge = item.prism.xy[2] - item.prism.xy[1]
        yaw = np.full(len(item.trajectory), np.arctan2(edge[1], edge[0]))
        trajectory = Trajectory(item.trajectory.t, item.trajectory.xyz, yaw)
        return self._trajectories.setdefault(_trajectory_key(trajectory), trajectory)

    def read_object(self, value: Any, where: str) -> PhysicalObject:
        """Read an object and unify its labels; FormatError if it can't be read."""
        match value:
            case {"lcmId": int() | str() as number, "tag": [*tags], "path": path}:
                pass
            case _:
                raise _bad("this is not an object", where, "it needs lcmId, tag, path and prism")
        if not all(isinstance(tag, str) for tag in tags):
            raise _bad("a tag is not a word", f"{where}.tag", "correct the tags")
        labels = UNIFIED_LABELS.get(tuple(tags), tuple(tags))
        prism = self._read_prism(value, where)
        trajectory = self._read_trajectory(path, f"{where}.path")
        key = (str(number), labels, _prism_key(prism), _trajectory_key(trajectory))
        return self._objects.setdefault(key, PhysicalObject(str(number), labels, prism, trajectory))

    def _read_prism(self, value: Any, where: str) -> Prism:
        where = f"{where}.prism"
        match value:
            case {"prism": {"points": points, "zStart": bottom, "zEnd": top}}:
                pass
            case _:
                raise _bad("the prism is missing", where, "it needs points, zStart and zEnd")
        try:
            prism = Prism(_numbers(points), float(bottom), float(top))
        except (ValueError, TypeError) as error:
            raise _bad(str(error), where, "correct the prism") from error
        return self._prisms.setdefault(_prism_key(prism), prism)

    def _read_trajectory(self, value: Any, where: str) -> Trajectory:
        match value:
            case {"points_xyztheta": points, "timestamps": [*stamps]}:
                pass
            case _:
                raise _bad(
                    "the path is incomplete", where, "it needs points_xyztheta and timestamps"
                )
        try:
            poses = _numbers(points)
            if poses.ndim != 2 or poses.shape[1] != 4:
                raise ValueError(f"points_xyztheta has shape {poses.shape}, expected (n, 4)")
            t = np.array([int(stamp) for stamp in stamps]) / MICROSECONDS
            trajectory = Trajectory(t, poses[:, :3], poses[:, 3])
        except (ValueError, TypeError) as error:
            raise _bad(str(error), where, "correct the path") from error
        return self._trajectories.setdefault(_trajectory_key(trajectory), trajectory)


def same_object(original: PhysicalObject, copy: PhysicalObject) -> bool:
    """Check that a published copy of an object is that object.

    Copies differ by noise. In the positives and the random negatives, all objects but the agent
    have lost their headings. In the easy negatives they have kept them. The original has to be
    used, or the heading would show which file an example comes from.
    """
    a, b = original, copy
    if a is b:
        return True
    if a.id != b.id or a.labels != b.labels or len(a.trajectory) != len(b.trajectory):
        return False
    return (
        a.prism.xy.shape == b.prism.xy.shape
        and _close(a.prism.xy, b.prism.xy)
        and _close(a.trajectory.xyz, b.trajectory.xyz)
        and (heading_is_lost(b.trajectory) or _same_heading(a.trajectory, b.trajectory))
    )


def heading_is_lost(trajectory: Trajectory) -> bool:
    """Check that the headings were not written: all are exactly zero."""
    return not trajectory.yaw.any()


def _close(a: FloatArray, b: FloatArray) -> bool:
    return bool((np.abs(a - b) <= SAME_POSE_M).all())


def _numbers(value: Any) -> FloatArray:
    try:
        return np.array(value, dtype=np.float64)
    except (ValueError, TypeError):
        raise ValueError("the points are not rows of numbers of the same length") from None


def _prism_key(prism: Prism) -> PrismKey:
    return prism.xy.tobytes(), prism.z_min, prism.z_max


def _trajectory_key(trajectory: Trajectory) -> TrajectoryKey:
    return trajectory.t.tobytes(), trajectory.xyz.tobytes() + trajectory.yaw.tobytes()


def _items(value: Any, name: str) -> list[tuple[str, Any]]:
    match value:
        case {"objects": [*objects], "places": [*places]}:
            items: Sequence[Any] = objects if name == "objects" else places
            return [(f"context.{name}[{i}]", item) for i, item in enumerate(items)]
    raise _bad("the context is incomplete", "context", "it needs lists of objects and of places")


def _value(item: Any, kind: str, where: str) -> Any:
    match item:
        case [str(found), inner] if found == kind:
            return inner
    raise _bad(f"this is not a {kind}", where, f"write [{kind}, ...]")


def _bad(what: str, where: str, fix: str) -> FormatError:
    return FormatError(what, where=where, fix=fix)


def _same_heading(a: Trajectory, b: Trajectory) -> bool:
    turn = (a.yaw - b.yaw + np.pi) % (2 * np.pi) - np.pi
    return _close(turn, np.zeros(1))
