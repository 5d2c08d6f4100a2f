"""Candidates packed for features: the things of a state, places, and trajectories of actions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from g3.actions.robot_state import centres
from g3.features.bodies import MAX_CORNERS, SAMPLES, Bodies, IntArray, pack, padded
from g3.features.factor_batch import FactorBatch, FieldWords
from g3.geometry.plane import area, centroid, convex_hull
from g3.groundings import Context, FloatArray, Grounding, Place, Prism
from g3.sdc.clauses import SDC_TYPES, SDCType
from g3.short_repr import short_repr

Group = tuple[Grounding, ...]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The things of a state as bodies; places and motions are added behind them.

    Parameters
    ----------
    context
        The state's context.
    groups
        The grounding that each of the bodies stands for.
    bodies
        The groundings packed.
    peers
        Bodies of the objects other than the agent.
    agent
        Body of the agent.
    """

    context: Context
    groups: tuple[Group, ...]
    bodies: Bodies
    peers: IntArray
    agent: int

    def indices(self, groups: Sequence[Group]) -> tuple[Bodies, IntArray]:
        """Bodies that hold some groundings, the scene's own first, and where; shape (n,)."""
        place = {_key(group): i for i, group in enumerate(self.groups)}
        new = {_key(group): group for group in groups if _key(group) not in place}
        bodies = self.bodies
        if new:
            place |= {key: len(self.groups) + i for i, key in enumerate(new)}
            bodies = join(bodies, pack_like(list(new.values()), bodies))
        return bodies, np.array([place[_key(group)] for group in groups], dtype=np.intp)

    def things(self) -> Scene:
        """The scene of the context's objects alone, which come first."""
        n = len(self.context.objects)
        some = {name: getattr(self.bodies, name)[:n] for name in (*_PER_BODY, *_SAMPLED)}
        some["offsets"] = offsets = self.bodies.offsets[: n + 1]
        some |= {name: getattr(self.bodies, name)[: offsets[-1]] for name in _RAW}
        return replace(self, groups=self.groups[:n], bodies=replace(self.bodies, **some))

    def batch(
        self,
        kind: SDCType,
        words: Sequence[FieldWords],
        factor: IntArray,
        bodies: Bodies | None = None,
        **roles: IntArray,
    ) -> FactorBatch:
        """Rows of one type.

        Parameters
        ----------
        words
            Words of each factor.
        factor
            Which factor each row is of, shape (n,).
        bodies
            What the roles refer to, if more than the scene's own.
        roles
            Bodies in the roles figure, landmark, theme and goal, shape (n,); -1 for none.
        """
        n = len(factor)
        track = self.context.agent.trajectory
        pose = np.array([*track.xyz[0, :2], track.yaw[0]])
        none = np.full(n, -1, dtype=np.intp)
        return FactorBatch(
            bodies=self.bodies if bodies is None else bodies,
            type=np.broadcast_to(np.int8(SDC_TYPES.index(kind)), n),
            figure=roles.get("figure", none),
            landmark=roles.get("landmark", none),
            theme=roles.get("theme", none),
            goal=roles.get("goal", none),
            agent=np.broadcast_to(pose, (n, 3)),
            agent_end_yaw=np.broadcast_to(pose[2], n),
            agent_mean_yaw=np.broadcast_to(pose[2], n),
            agent_body=np.broadcast_to(np.intp(self.agent), n),
            peers=np.broadcast_to(self.peers, (n, len(self.peers))),
            factor=factor,
            words=words,
        )


def scene_of(context: Context, groups: Sequence[Group] = ()) -> Scene:
    """Pack a context's objects, and other groundings behind them."""
    singles: list[Group] = [(o,) for o in context.objects]
    everything = (*singles, *groups)
    ids = [o.id for o in context.objects]
    agent = ids.index(context.agent_id)
    peers = np.array([i for i in range(len(ids)) if i != agent], dtype=np.intp)
    return Scene(context, everything, pack(everything), peers, agent)


def _key(group: Group) -> tuple[int, ...]:
    return tuple(id(g) for g in group)


def pack_like(groups: Sequence[Group], like: Bodies) -> Bodies:
    """Pack groundings with the labels of other bodies."""
    places = [g[0] for g in groups if len(g) == 1 and isinstance(g[0], Place)]
    hulls = [convex_hull(place.prism.xy) for place in places]
    if len(places) == len(groups) and max(map(len, hulls)) <= MAX_CORNERS:
        return _pack_places([place.prism for place in places], padded(hulls), like)
    packed = pack(groups)
    column = [like.label_names.index(name) for name in packed.label_names]
    labels = np.zeros((len(groups), len(like.label_names)), dtype=bool)
    shared = labels.copy()
    labels[:, column], shared[:, column] = packed.labels, packed.shared_labels
    return replace(packed, labels=labels, shared_labels=shared, label_names=like.label_names)


def _pack_places(prisms: Sequence[Prism], corners: FloatArray, like: Bodies) -> Bodies:
    """Places, of which there are many and nothing moves, packed as :func:`pack` does."""
    z_min = np.array([prism.z_min for prism in prisms])
    pose = np.column_stack((centres(prisms), z_min))
    rest = _points(pose, np.zeros(len(prisms)), like)
    rest.members[:, 0] = centre = centroid(corners)
    z_max = np.array([prism.z_max for prism in prisms])
    return replace(rest, corners=corners, centre=centre, area=area(corners), z_max=z_max)


def moving_bodies(xyz: FloatArray, yaw: FloatArray, t: FloatArray, like: Bodies) -> Bodies:
    """Trajectories (n, SAMPLES) of the robot; as features see it, its shape is the agent's.

    Parameters
    ----------
    xyz, yaw, t
        Poses evenly spread along each trajectory, (n, SAMPLES, 3), (n, SAMPLES), and times.
    """
    rest = _points(xyz[:, 0], yaw[:, 0], like)
    return _moving(rest, xyz, yaw, t)


def carried_bodies(
    of: IntArray, xyz: FloatArray, yaw: FloatArray, t: FloatArray, bodies: Bodies
) -> Bodies:
    """Bodies ``of`` (n,) with trajectories (n, SAMPLES) on the robot's clock."""
    return _moving(take(bodies, of), xyz, yaw, t)


def _points(pose: FloatArray, yaw: FloatArray, like: Bodies) -> Bodies:
    n = len(pose)
    corners = np.zeros((n, like.corners.shape[1], 2)) + pose[:, None, :2]
    members = np.full((n, like.members.shape[1], 2), np.nan)
    z_min = z_max = pose[:, 2]
    labels = np.zeros((n, len(like.label_names)), dtype=bool)
    return Bodies(
        corners=corners,
        centre=pose[:, :2],
        area=np.zeros(n),
        z_min=z_min,
        z_max=z_max,
        count=np.ones(n),
        members=members,
        labels=labels,
        shared_labels=labels,
        label_names=like.label_names,
        **_at_rest(pose, yaw),
    )


def _at_rest(pose: FloatArray, yaw: FloatArray) -> dict[str, Any]:
    """The fields of bodies that stay where they are: poses (n, 3) and headings (n,)."""
    n = len(pose)
    return {
        "t": np.zeros((n, SAMPLES)),
        "xyz": np.repeat(pose[:, None], SAMPLES, axis=1),
        "yaw": np.repeat(yaw[:, None], SAMPLES, axis=1),
        "moves": np.zeros(n, dtype=bool),
        "raw_t": np.zeros(n),
        "raw_xyz": pose,
        "raw_yaw": yaw,
        "offsets": np.arange(n + 1, dtype=np.intp),
    }


def _moving(rest: Bodies, xyz: FloatArray, yaw: FloatArray, t: FloatArray) -> Bodies:
    n = len(xyz)
    same = {f.name: getattr(rest, f.name) for f in fields(rest)}
    return Bodies(
        **same
        | {
            "t": t,
            "xyz": xyz,
            "yaw": yaw,
            "moves": np.ones(n, dtype=bool),
            "raw_t": t.reshape(-1),
            "raw_xyz": xyz.reshape(-1, 3),
            "raw_yaw": yaw.reshape(-1),
            "offsets": SAMPLES * np.arange(n + 1, dtype=np.intp),
        }
    )


_PER_BODY = (
    *("corners", "centre", "area", "z_min", "z_max"),
    *("count", "members", "labels", "shared_labels"),
)
_SAMPLED = ("t", "xyz", "yaw", "moves")
_RAW = ("raw_t", "raw_xyz", "raw_yaw")


def take(bodies: Bodies, index: IntArray) -> Bodies:
    """Some bodies, at rest at their first poses."""
    first = bodies.offsets[index]
    pose, yaw = bodies.raw_xyz[first], bodies.raw_yaw[first]
    picked = {name: getattr(bodies, name)[index] for name in _PER_BODY}
    return Bodies(
        **picked,
        label_names=bodies.label_names,
        **_at_rest(pose, yaw),
    )


def join(*parts: Bodies) -> Bodies:
    """Bodies one after another; all must have the labels of the first."""
    width = max(p.corners.shape[1] for p in parts)
    corners = [_widened(p.corners, width) for p in parts]
    ends = np.cumsum([0, *(p.offsets[-1] for p in parts)])
    offsets = [p.offsets[:-1] + e for p, e in zip(parts, ends, strict=False)]
    names = (*_PER_BODY[1:], *_SAMPLED, *_RAW)
    joined = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
    return Bodies(
        corners=np.concatenate(corners),
        label_names=parts[0].label_names,
        offsets=np.concatenate([*offsets, ends[-1:]]).astype(np.intp),
        **joined,
    )


def _widened(corners: FloatArray, width: int) -> FloatArray:
    missing = width - corners.shape[1]
    if not missing:
        return corners
    return np.concatenate((corners, np.repeat(corners[:, -1:], missing, axis=1)), axis=1)
