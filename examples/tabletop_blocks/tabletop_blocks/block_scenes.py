"""Random tables with blocks, and tasks of a hand there.

The table's near edge is at x = 0 and the hand looks along +x from there, so that +y is to its
left. Lengths are in metres, times in seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from g3.groundings import (
    Context,
    FloatArray,
    Path,
    PhysicalObject,
    Place,
    Prism,
    Trajectory,
)

TABLE_TOP = 0.75
TABLE = (0.8, 1.2)
TRAY = (0.24, 0.24, 0.02)
SIZES = {"block": (0.05, 0.05, 0.05), "bar": (0.05, 0.15, 0.05)}
COLOURS = ("red", "green", "blue", "yellow", "white")
BESIDE_M = 0.09
"""Distance between the middles of a block and of its neighbour, in metres."""
HIGH = TABLE_TOP + 0.3
SPEED_M_S = 0.25
RATE_HZ = 5.0
DIRECTIONS = {
    "left of": (0.0, BESIDE_M),
    "right of": (0.0, -BESIDE_M),
    "behind": (BESIDE_M, 0.0),
    "in front of": (-BESIDE_M, 0.0),
}


@dataclass(frozen=True, slots=True)
class Table:
    """A table before anything happens.

    Parameters
    ----------
    name
        Id of its context.
    start_s
        When the log starts; logs mustn't overlap.
    things
        The table, the tray, then the blocks.
    """

    name: str
    start_s: float
    things: tuple[PhysicalObject, ...]

    def thing(self, name: str) -> PhysicalObject:
        """Return a thing by its id."""
        return next(thing for thing in self.things if thing.id == name)


@dataclass(frozen=True, slots=True)
class Task:
    """A task of a hand on a table.

    Parameters
    ----------
    context
        The table with everything's trajectory.
    theme
        The thing that is taken or touched.
    relation
        "on", one of `DIRECTIONS`, "in" for the tray; "up" where it is only lifted, "to" where
        it is only touched.
    landmark
        The thing that it is put on, in or beside; None where it is put nowhere.
    place
        The place that it is put in.
    table
        The table as it was before.
    """

    context: Context
    theme: PhysicalObject
    relation: str
    table: Table
    landmark: PhysicalObject | None = None
    place: Place | None = None

    @property
    def path(self) -> Path:
        """The hand's path."""
        return Path(self.context.agent.trajectory)


def make_task(name: str, start_s: float, rng: np.random.Generator) -> Task:
    """Make a random table and a task on it; the parameters are those of `Table`."""
    while True:
        table = Table(name, start_s, tuple(_things(rng)))
        task = _task(table, _any_block(table, rng), None, rng)
        if task is not None:
            return task


def other_task(task: Task, name: str, start_s: float, rng: np.random.Generator) -> Task:
    """Return another task that is possible at the same table, mostly with the same thing."""
    table = Table(name, start_s, task.table.things)
    while True:
        theme, landmark = _any_block(table, rng), None
        if rng.random() < 0.7:
            theme = table.thing(task.theme.id)
            if task.landmark is not None and rng.random() < 0.7:
                landmark = table.thing(task.landmark.id)
        other = _task(table, theme, landmark, rng)
        if other is not None and _differ(task, other):
            return other


def _any_block(table: Table, rng: np.random.Generator) -> PhysicalObject:
    return table.things[int(rng.integers(2, len(table.things)))]


def other_place(task: Task, rng: np.random.Generator) -> Place:
    """Return a place in another direction from a task's landmark than the task's own."""
    if task.landmark is None or task.place is None:
        raise ValueError(f"nothing is put anywhere in {task.context.id}")
    relations = [r for r in ("on", *DIRECTIONS) if r != task.relation]
    relation = relations[int(rng.integers(len(relations)))]
    size = np.ptp(task.theme.prism.xy, axis=0)
    height = task.theme.prism.z_max - task.theme.prism.z_min
    bottom = task.landmark.prism.z_max if relation == "on" else TABLE_TOP
    goal = _goal(task.theme, task.landmark, relation)
    if relation == "on" and task.relation == "in":
        goal, bottom = goal + np.array([0.0, 0.2]), TABLE_TOP
    return Place(box(goal, (float(size[0]), float(size[1]), height), bottom))


def _differ(a: Task, b: Task) -> bool:
    if a.theme.id != b.theme.id or a.place is None or b.place is None:
        return a.theme.id != b.theme.id or a.relation != b.relation
    return a.place.prism.z_min != b.place.prism.z_min or not np.allclose(
        a.place.prism.xy, b.place.prism.xy, atol=BESIDE_M / 2
    )


def _task(
    table: Table,
    theme: PhysicalObject,
    landmark: PhysicalObject | None,
    rng: np.random.Generator,
) -> Task | None:
    """Return a task with a thing, and with a landmark if one is given; None if there is none."""
    relation = str(rng.choice(["on", "on", *DIRECTIONS, *([] if landmark else ["in", "up", "to"])]))
    if relation == "to":
        return _done(table, theme, relation)
    if _is_covered(theme, table.things):
        return None
    if relation == "up":
        return _done(table, theme, relation)
    possible = _landmarks(table.things, theme, relation)
    if landmark is not None:
        possible = [thing for thing in possible if thing.id == landmark.id]
    if not possible:
        return None
    chosen = possible[int(rng.integers(len(possible)))]
    goal = _goal(theme, chosen, relation)
    others = [thing for thing in table.things[2:] if thing.id not in (theme.id, chosen.id)]
    if not _on_table(goal) or any(_near(goal, thing) for thing in others):
        return None
    return _done(table, theme, relation, chosen, goal)


def box(middle: FloatArray, size: tuple[float, float, float], bottom: float) -> Prism:
    """Return an upright box whose edges are the axes'."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.array(size[:2]) / 2
    return Prism(middle + corners, bottom, bottom + size[2])


def _thing(
    name: str, labels: tuple[str, ...], middle: FloatArray, size: tuple[float, ...], bottom: float
) -> PhysicalObject:
    pose = Trajectory(np.zeros(1), np.array([[*middle, bottom]]), np.zeros(1))
    return PhysicalObject(name, labels, box(middle, (size[0], size[1], size[2]), bottom), pose)


def _things(rng: np.random.Generator) -> list[PhysicalObject]:
    """Return a table, a tray, and five to seven blocks, some of them on others or on the tray."""
    table = _thing("table", ("table",), np.array([0.4, 0.0]), (*TABLE, TABLE_TOP), 0.0)
    tray = _thing("tray", ("tray",), _spot(rng), TRAY, TABLE_TOP)
    things = [table, tray]
    wanted = int(rng.integers(5, 8))
    while len(things) < wanted + 2:
        colour, shape = str(rng.choice(COLOURS)), str(rng.choice(["block", "block", "bar"]))
        below = things[int(rng.integers(1, len(things)))]
        if rng.random() < 0.25 and not _is_covered(below, things):
            middle, bottom = middle_of(below), below.prism.z_max
        else:
            middle, bottom = _spot(rng), TABLE_TOP
            if any(_near(middle, thing) for thing in things[1:]):
                continue
        number = len(things) - 1
        labels = (colour, shape)
        things.append(_thing(f"{colour}-{shape}-{number}", labels, middle, SIZES[shape], bottom))
    return things


def _spot(rng: np.random.Generator) -> FloatArray:
    return np.array([rng.uniform(0.2, 0.65), rng.uniform(-0.45, 0.45)])


def middle_of(thing: PhysicalObject) -> FloatArray:
    """Return the middle of a thing's footprint."""
    middle: FloatArray = thing.prism.xy.mean(axis=0)
    return middle


def _near(middle: FloatArray, thing: PhysicalObject) -> bool:
    reach = float(np.ptp(thing.prism.xy, axis=0).max()) / 2
    return bool(np.abs(middle - middle_of(thing)).max() < reach + 0.06)


def is_on(upper: PhysicalObject, lower: PhysicalObject) -> bool:
    """Check that one thing stands on another."""
    apart = np.abs(middle_of(upper) - middle_of(lower))
    inside = bool((apart < np.ptp(lower.prism.xy, axis=0) / 2).all())
    return inside and abs(upper.prism.z_min - lower.prism.z_max) < 0.005


def _is_covered(thing: PhysicalObject, things: Sequence[PhysicalObject]) -> bool:
    return any(is_on(other, thing) for other in things)


def _on_table(middle: FloatArray) -> bool:
    return bool(0.05 < middle[0] < TABLE[0] - 0.05 and abs(middle[1]) < TABLE[1] / 2 - 0.05)


def _landmarks(
    things: Sequence[PhysicalObject], theme: PhysicalObject, relation: str
) -> list[PhysicalObject]:
    """Return the things that a thing can be put on, in or beside."""
    if relation == "in":
        return [] if _is_covered(things[1], things) else [things[1]]
    possible = [t for t in things[2:] if t.id != theme.id and not is_on(theme, t)]
    if relation == "on":
        return [t for t in possible if not _is_covered(t, things)]
    return [t for t in possible if abs(t.prism.z_min - TABLE_TOP) < 0.005]


def _goal(theme: PhysicalObject, landmark: PhysicalObject, relation: str) -> FloatArray:
    offset = np.array(DIRECTIONS.get(relation, (0.0, 0.0)))
    depth = np.ptp(theme.prism.xy, axis=0) + np.ptp(landmark.prism.xy, axis=0)
    room = np.where(offset != 0, depth / 2 - 0.05, 0.0)
    goal: FloatArray = middle_of(landmark) + offset + np.sign(offset) * room
    return goal


def _done(
    table: Table,
    theme: PhysicalObject,
    relation: str,
    landmark: PhysicalObject | None = None,
    goal: FloatArray | None = None,
) -> Task:
    """Let the hand do it."""
    home, taken = np.array([0.1, 0.0, HIGH]), np.array([*middle_of(theme), theme.prism.z_max])
    above = np.array([*taken[:2], HIGH])
    way, grip, drop = [home, above, taken], 2, None
    if relation == "up":
        way.append(above)
    place = None
    if goal is not None and landmark is not None:
        bottom = landmark.prism.z_max if relation in ("on", "in") else TABLE_TOP
        height = theme.prism.z_max - theme.prism.z_min
        high = np.array([*goal, HIGH])
        way += [above, high, np.array([*goal, bottom + height]), high]
        drop = 5
        size = np.ptp(theme.prism.xy, axis=0)
        place = Place(box(goal, (float(size[0]), float(size[1]), height), bottom))
    hand = _sampled(np.array(way), table.start_s)
    moved = theme
    if relation != "to":
        moved = replace(theme, trajectory=_carried(theme, hand, way, grip, drop))
    own = _thing("hand", ("hand",), home[:2], (0.08, 0.08, 0.1), HIGH)
    rest = [
        replace(t, trajectory=replace(t.trajectory, t=np.array([table.start_s])))
        for t in table.things
        if t.id != theme.id
    ]
    objects = (replace(own, trajectory=hand), moved, *rest)
    context = Context(table.name, objects, (), "hand")
    chosen = landmark and named(context, landmark.id)
    return Task(context, moved, relation, table, chosen, place)


def named(context: Context, name: str) -> PhysicalObject:
    """Return a context's thing by its id."""
    return next(thing for thing in context.objects if thing.id == name)


def _sampled(way: FloatArray, start_s: float) -> Trajectory:
    """Return a straight way from pose to pose at an even speed."""
    at_s = np.concatenate(
        ([0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1) / SPEED_M_S))
    )
    t = np.unique(np.append(np.arange(0.0, at_s[-1], 1 / RATE_HZ), at_s))
    xyz = np.column_stack([np.interp(t, at_s, way[:, axis]) for axis in range(3)])
    return Trajectory(start_s + t, xyz, np.zeros(len(t)))


def _carried(
    theme: PhysicalObject,
    hand: Trajectory,
    way: list[FloatArray],
    grip: int,
    drop: int | None,
) -> Trajectory:
    """Return the trajectory of a thing that the hand holds from one of its poses to another."""
    length = np.linalg.norm(np.diff(np.array(way), axis=0), axis=1) / SPEED_M_S
    at_s = np.concatenate(([0.0], np.cumsum(length))) + hand.t[0]
    held = np.clip(hand.t, at_s[grip], at_s[drop] if drop is not None else np.inf)
    xyz = np.column_stack([np.interp(held, hand.t, hand.xyz[:, axis]) for axis in range(3)])
    return Trajectory(hand.t, xyz - [0, 0, theme.prism.z_max - theme.prism.z_min], hand.yaw)
