"""Trajectories of each kind of action, a batch of actions of one kind at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions import REACH_M, SIDE_ENTRY_M, centre, covers
from g3.driving import direction
from g3.geometry import convex_hull, point_gap, rotate
from g3.groundings import FloatArray, Grounding, Path, PhysicalObject
from g3.inference import motions
from g3.inference.actions import Action
from g3.inference.motions import Legs, Motions
from g3.inference.state import State, centres

STAND_OFF_M = 2.5
PAST_M, BEYOND_M = 2.0, 4.0


def _sampled(state: State, legs: Legs, ids: Sequence[str]) -> Motions:
    index = {o.id: i for i, o in enumerate(state.context.objects)}
    load = np.array([index.get(i, -1) for i in ids], dtype=np.intp)
    tracks = [state.context.objects[max(i, 0)].trajectory for i in load]
    pose = np.array([[*t.xyz[0, :2], t.yaw[0]] for t in tracks])
    height = np.array([t.xyz[0, 2] for t in tracks])
    return motions.sampled(legs, _floor(state), load, pose, height)


def _floor(state: State) -> float:
    return float(state.context.agent.trajectory.xyz[0, 2])


def _starts(state: State, n: int) -> FloatArray:
    return np.repeat(state.pose[None], n, axis=0)


def _middles(state: State, but: str | None) -> FloatArray:
    """Middles of what stands in the way of a robot on the ground."""
    others = [o for o in state.context.objects if o.id not in (but, state.context.agent_id)]
    return centres([o.prism for o in others])


def _driven(state: State, poses: FloatArray) -> Motions:
    return _sampled(state, motions.driven(poses), [state.held or ""] * len(poses))


def wait(state: State, actions: Sequence[Action]) -> Motions:
    """Stay."""
    return _driven(state, np.repeat(_starts(state, len(actions))[:, None], 2, axis=1))


def straight(state: State, actions: Sequence[Action]) -> Motions:
    """Straight ahead, or back."""
    legs = [motions.straights(_starts(state, 1), a.amount) for a in actions]
    return _driven(state, np.concatenate(legs))


def turn(state: State, actions: Sequence[Action]) -> Motions:
    """Turn on the spot."""
    pose, fraction = state.pose, np.linspace(0, 1, 9)
    poses = np.repeat(_starts(state, len(actions))[:, None], 9, axis=1)
    for row, action in zip(poses, actions, strict=True):
        row[:, 2] = pose[2] + action.amount * fraction
    return _driven(state, poses)


def footprint_of(group: Sequence[Grounding]) -> FloatArray:
    """The hull of a group's footprints, shape (k, 2)."""
    corners = [g.prism.xy for g in group if not isinstance(g, Path)]
    return convex_hull(np.concatenate(corners))


def drive_to(state: State, actions: Sequence[Action]) -> Motions:
    """Up to a thing, facing it; into the middle of a place, or before what stands there."""
    finals = []
    for action in actions:
        footprint = footprint_of(action.target)
        middle = footprint.mean(axis=0)
        ahead = middle - state.pose[:2]
        edge = footprint[1] - footprint[0]
        square = np.arctan2(edge[1], edge[0]) + np.pi / 2 * np.arange(4)
        headings = np.append(square, np.arctan2(ahead[1], ahead[0]))
        back = np.zeros(len(headings))
        thing = isinstance(action.target[0], PhysicalObject)
        blocked = footprint if thing else _standing(state, middle)
        if blocked is not None:
            back = _stand_offs(blocked, middle, headings)
        finals.append(np.column_stack((middle - back[:, None] * direction(headings), headings)))
    every = np.array(finals)
    way = motions.ways(_starts(state, len(actions)), every, np.zeros(every.shape[:2]))
    return _driven(state, way)


def _standing(state: State, point: FloatArray) -> FloatArray | None:
    """The footprint of what stands at a point; None where nothing does."""
    own = (state.context.agent_id, state.held)
    things = [o for o in state.context.objects if o.id not in own and covers(o.prism, point)]
    return footprint_of(things[:1]) if things else None


def _stand_offs(footprint: FloatArray, middle: FloatArray, headings: FloatArray) -> FloatArray:
    """How far before the middle of a footprint the robot stops, for each heading."""
    far = float(np.linalg.norm(footprint - middle, axis=1).max()) + STAND_OFF_M
    back = np.arange(0.0, far + 0.25, 0.25)
    points = middle - back[None, :, None] * direction(headings)[:, None]
    gaps = point_gap(points, np.repeat(footprint[None], len(headings), axis=0))
    chosen: FloatArray = back[(gaps >= STAND_OFF_M - 0.1).argmax(axis=1)]
    return chosen


def drive_past(state: State, actions: Sequence[Action]) -> Motions:
    """Past a thing on the side that the robot faces and on; or around it, to its other side."""
    abeams, beyonds = [], []
    for action in actions:
        footprint = footprint_of(action.target)
        middle = footprint.mean(axis=0)
        ahead = middle - state.pose[:2]
        yaw = float(np.arctan2(ahead[1], ahead[0]))
        own = rotate(footprint - middle, np.full(len(footprint), -yaw))
        depth, width = np.abs(own).max(axis=0)
        side = width + PAST_M
        left = np.sin(state.pose[2] - yaw) >= 0
        offset = np.array(
            [[0.0, side if left else -side], [depth + BEYOND_M, side if left else -side]]
        )
        if action.kind == "drive around":
            offset[1] = [depth + STAND_OFF_M, 0.0]
        points = middle + rotate(offset, np.full(2, yaw))
        heading = yaw + (np.pi if action.kind == "drive around" else 0.0)
        abeams.append([*points[0], yaw])
        beyonds.append([*points[1], heading])
    return _through(state, np.array(abeams), np.array(beyonds))


def drive_between(state: State, actions: Sequence[Action]) -> Motions:
    """Through between two things and on."""
    first, last = [], []
    for action in actions:
        a, b = (centre(g.prism) for g in action.target[:2] if not isinstance(g, Path))
        across = (b - a) / max(float(np.linalg.norm(b - a)), 1e-6)
        along = np.array([-across[1], across[0]])
        middle = (a + b) / 2
        if (middle - state.pose[:2]) @ along < 0:
            along = -along
        yaw = float(np.arctan2(along[1], along[0]))
        first.append([*(middle - along), yaw])
        last.append([*(middle + BEYOND_M * along), yaw])
    return _through(state, np.array(first), np.array(last))


def _through(state: State, first: FloatArray, last: FloatArray) -> Motions:
    free = np.zeros((len(first), 1))
    to = motions.ways(_starts(state, len(first)), first[:, None], free)
    on = motions.ways(to[:, -1], last[:, None], free)
    return _driven(state, np.concatenate((to, on), axis=1))


def _pick_entries(state: State, ids: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    things = [state.thing(i) for i in ids]
    middle = centres([o.prism for o in things])
    headings = motions.quarters(np.array([o.trajectory.yaw[0] for o in things]))
    reach = np.tile([REACH_M, 0.0], (len(ids), 1))
    finals, blocked = motions.entries(middle, headings, reach, _middles(state, None))
    return finals, blocked + np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M])


def pick_up(state: State, actions: Sequence[Action]) -> Motions:
    """Up to a load, lift it, and back out."""
    ids = [a.object_id for a in actions]
    legs = motions.picked(_starts(state, len(ids)), *_pick_entries(state, ids))
    return _sampled(state, legs, ids)


def _spots(state: State, actions: Sequence[Action]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middles and headings of places, and how high they are over where the loads were."""
    prisms = [a.place.prism for a in actions if a.place is not None]
    middle = centres(prisms)
    edge = np.array([p.xy[1] - p.xy[0] for p in prisms])
    yaw = np.arctan2(edge[:, 1], edge[:, 0])
    bottoms = np.array([state.thing(a.object_id).prism.z_min for a in actions])
    return middle, motions.quarters(yaw), np.array([p.z_min for p in prisms]) - bottoms


def carry(state: State, actions: Sequence[Action]) -> Motions:
    """Pick a load up and put it down elsewhere."""
    ids = [a.object_id for a in actions]
    middle, headings, down = _spots(state, actions)
    reach = np.tile([REACH_M, 0.0], (len(ids), 1))
    put_at = motions.entries(middle, headings, reach, _middles(state, None))
    pick = _pick_entries(state, ids)
    legs = motions.carried(_starts(state, len(ids)), pick, put_at, down)
    return _sampled(state, legs, ids)


def put_down(state: State, actions: Sequence[Action]) -> Motions:
    """Drive the load on the forks to a place and put it down."""
    ids = [a.object_id for a in actions]
    middle, headings, down = _spots(state, actions)
    load = state.thing(ids[0])
    reach = rotate(centre(load.prism) - state.pose[:2], -state.pose[2])
    finals, blocked = motions.entries(
        middle, headings, np.tile(reach, (len(ids), 1)), _middles(state, load.id)
    )
    legs = motions.put(_starts(state, len(ids)), finals, blocked, np.zeros(len(ids)), down)
    return _sampled(state, legs, ids)
