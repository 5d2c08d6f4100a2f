"""Trajectories: by themselves, with the thing acted on, towards their goal (section 3.3).

Everything is computed from the candidate trajectory itself, in its own frames of reference. So the
start of a candidate doesn't give away that it isn't the annotated one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from g3.features.avs.vector_sums import avs_directions
from g3.features.bodies import SAMPLES, IntArray, moved_corners, positions_at
from g3.features.factor_batch import Boxes, FactorBatch, Role, measured, stacked
from g3.features.feature_registry import Column, Columns, feature_set
from g3.features.sets.label_words import label_columns
from g3.features.sets.prisms import PRISM_COLUMNS, prism_pair, size
from g3.features.sets.reference_frames import DIRECTIONS, footprints_of
from g3.geometry.plane import BoolArray, length, point_gap, rotate, wrap
from g3.groundings import FloatArray
from g3.short_repr import short_repr

REACH_M = 3.0
"""A thing that moves while the agent's centre is further away is not moved by the agent."""

STILL_M = 0.3
"""Moves shorter than this are noise of the logs."""

path_set = partial(
    feature_set,
    types=("PATH",),
    roles=("figure", "landmark"),
    words=("relation",),
    wordless=True,
)
event_set = partial(feature_set, types=("EVENT",), words=("relation", "goal"), wordless=True)
goal_set = partial(event_set, roles=("figure", "goal"))
theme_set = partial(event_set, roles=("figure", "theme"))
"""They register what trajectories are to landmarks, to goals and to what is acted on."""

SHAPE_COLUMNS: Columns = (
    Column("forward", "1", -1, 1, 6),
    Column("leftward", "1", -1, 1, 6),
    Column("straight", "1", 0, 1, 5),
    Column("turn", "rad", -np.pi, np.pi, 8),
    Column("turning", "rad", 0, 3 * np.pi, 6),
    Column("reversing", "1", 0, 1, 5),
    Column("reverses_first", "bool"),
    Column("reverses_last", "bool"),
    Column("first_turn", "rad", -np.pi / 2, np.pi / 2, 6),
)


@short_repr
@dataclass(frozen=True, slots=True)
class Tracks:
    """n trajectories, evenly sampled: t (n, T), xyz (n, T, 3), yaw (n, T)."""

    t: FloatArray
    xyz: FloatArray
    yaw: FloatArray

    def take(self, rows: IntArray) -> Tracks:
        """Return some of the trajectories."""
        return Tracks(self.t[rows], self.xyz[rows], self.yaw[rows])


def tracks(batch: FactorBatch) -> Tracks:
    """Trajectories of the figures."""
    bodies, index = batch.bodies, batch.figure
    return Tracks(bodies.t[index], bodies.xyz[index], bodies.yaw[index])


def path_length(track: Tracks) -> FloatArray:
    """Lengths on the plane in metres, at least 0.1; shape (n,)."""
    step = np.linalg.norm(np.diff(track.xyz[..., :2], axis=1), axis=2)
    length: FloatArray = np.maximum(step.sum(axis=1), 0.1)
    return length


def shape(track: Tracks) -> FloatArray:
    """Shapes of trajectories, as `SHAPE_COLUMNS`; (n, len(SHAPE_COLUMNS))."""
    step = np.diff(track.xyz[..., :2], axis=1)
    length = np.linalg.norm(step, axis=2)
    total = np.maximum(length.sum(axis=1), 0.1)
    middle = (track.yaw[:, 1:] + track.yaw[:, :-1]) / 2
    ahead = step[..., 0] * np.cos(middle) + step[..., 1] * np.sin(middle)
    backwards = (ahead < -0.5 * length) & (length > 0.02 * total[:, None])
    net = rotate(track.xyz[:, -1, :2] - track.xyz[:, 0, :2], -track.yaw[:, 0])
    turns = np.diff(track.yaw, axis=1)
    third = SAMPLES // 3
    return np.column_stack(
        (
            net / total[:, None],
            np.linalg.norm(net, axis=1) / total,
            track.yaw[:, -1] - track.yaw[:, 0],
            np.abs(turns).sum(axis=1),
            (length * backwards).sum(axis=1) / total,
            backwards[:, :third].any(axis=1),
            backwards[:, -third:].any(axis=1),
            turns[:, :third].sum(axis=1),
        )
    )


@feature_set(
    "shape",
    types=("EVENT", "PATH"),
    roles=("figure",),
    words=("relation", "goal"),
    columns=SHAPE_COLUMNS,
    scale=0.1,
    alone=False,
    default=False,
    wordless=True,
)
def own_shape(batch: FactorBatch) -> FloatArray:
    """Shape of the trajectory in the frame of its own start: turns, reversing, straightness.

    Off by default: a corpus with one log per scenario has too few shapes, and the
    model learns which log it sees rather than what the words mean.
    """
    return shape(tracks(batch))


APPROACH_COLUMNS: Columns = (
    Column("start_gap", "1", 0, 6, 8),
    Column("end_gap", "1", 0, 4, 10),
    Column("nearest_gap", "1", 0, 3, 8),
    Column("mean_gap", "1", 0, 6, 8),
    Column("toward", "1", -1, 1, 8),
    Column("end_to_start", "1", 0, 2, 8),
    Column("end_to_nearest", "1", 0, 4, 6),
    Column("along", "1", 0, 1, 5),
    Column("facing_end", "1", -1, 1, 6),
    Column("facing_start", "1", -1, 1, 4),
    Column("beside_end", "1", -1, 1, 6),
)


def approach(track: Tracks, target: Boxes, reach: FloatArray) -> FloatArray:
    """Relation of n trajectories to n things that stand still, as `APPROACH_COLUMNS`.

    Parameters
    ----------
    reach
        Length in metres that distances are divided by, shape (n,).
    """
    distance = point_gap(track.xyz[..., :2], target.corners)
    scaled = distance / reach[:, None]
    offset = target.centre[:, None] - track.xyz[..., :2]
    facing = np.arctan2(offset[..., 1], offset[..., 0]) - track.yaw
    first, last, nearest = distance[:, 0], distance[:, -1], distance.min(axis=1)
    return np.column_stack(
        (
            scaled[:, 0],
            scaled[:, -1],
            scaled.min(axis=1),
            scaled.mean(axis=1),
            (first - last) / path_length(track),
            (last + 0.1) / (first + 0.1),
            (last - nearest) / reach,
            (scaled < 1).mean(axis=1),
            np.cos(facing[:, -1]),
            np.cos(facing[:, 0]),
            np.sin(facing[:, -1]),
        )
    )


def _approach(batch: FactorBatch, role: Role) -> FloatArray:
    target = batch.boxes(role)
    return approach(tracks(batch), target, size(target) + 1.0)


@path_set("path-landmark", columns=APPROACH_COLUMNS, scale=0.3)
def path_to_landmark(batch: FactorBatch) -> FloatArray:
    """Relation of a path to its landmark: displacement towards it, distances, passing along."""
    return _approach(batch, "landmark")


@goal_set("event-goal", columns=APPROACH_COLUMNS, scale=0.3)
def event_to_goal(batch: FactorBatch) -> FloatArray:
    """Relation of the agent's trajectory to the place or object that the event leads to."""
    return _approach(batch, "goal")


@theme_set("event-theme", words=("relation",), columns=APPROACH_COLUMNS, scale=0.1)
def event_to_theme(batch: FactorBatch) -> FloatArray:
    """Relation of the agent's trajectory to the first position of the object acted on."""
    return _approach(batch, "theme")


@short_repr
@dataclass(frozen=True, slots=True)
class Motion:
    """Motions of the themes of n events.

    Parameters
    ----------
    xyz, yaw
        Their poses at the events' samples, shapes (n, T, 3) and (n, T).
    moved
        True if the event moves them, shape (n,).
    moving
        True if they are on the move between one sample and the next, shape (n, T - 1).
    """

    xyz: FloatArray
    yaw: FloatArray
    moved: BoolArray
    moving: BoolArray


def theme_motion(batch: FactorBatch, theme: IntArray, track: Tracks) -> Motion:
    """Follow the themes, bodies of shape (n,), through n events.

    A theme moves in an event only if its log runs beside the event's and it moves with
    the agent near; otherwise it stays where it stood at first, as it does at inference
    when a candidate action leaves it alone. So a theme whose log belongs to another
    event is no different from one that nobody touches.
    """
    xyz, yaw = positions_at(batch.bodies, theme, track.t)
    step = np.linalg.norm(np.diff(xyz, axis=1), axis=2)
    moving = step > STILL_M / 3
    near = np.linalg.norm(xyz[..., :2] - track.xyz[..., :2], axis=2) < REACH_M
    together = (~moving | (near[:, 1:] & near[:, :-1])).all(axis=1)
    begin = batch.bodies.raw_t[batch.bodies.offsets[theme]]
    same_log = (begin <= track.t[:, -1]) & (
        batch.bodies.raw_t[batch.bodies.offsets[theme + 1] - 1] >= track.t[:, 0]
    )
    moved = (step.sum(axis=1) > STILL_M) & together & same_log & batch.bodies.moves[theme]
    rest = batch.bodies.xyz[theme, :1], batch.bodies.yaw[theme, :1]
    xyz = np.where(moved[:, None, None], xyz, rest[0])
    yaw = np.where(moved[:, None], yaw, rest[1])
    return Motion(xyz, yaw, moved, moving & moved[:, None])


def theme_boxes(batch: FactorBatch, motion: Motion, sample: int) -> Boxes:
    """Prisms of the themes at one sample of the events."""
    bodies, index = batch.bodies, batch.theme
    start = np.column_stack((bodies.xyz[index, 0, :2], bodies.yaw[index, 0]))
    pose = np.column_stack((motion.xyz[:, sample, :2], motion.yaw[:, sample]))
    rise = motion.xyz[:, sample, 2] - bodies.xyz[index, 0, 2]
    return measured(
        moved_corners(bodies.corners[index], start, pose),
        bodies.z_min[index] + rise,
        bodies.z_max[index] + rise,
    )


THEME_COLUMNS: Columns = (
    Column("moved", "bool"),
    Column("left_alone", "bool"),
    Column("lifted", "1", 0, 2, 6),
    Column("rise", "1", -1.5, 1.5, 8),
    Column("carried", "1", 0, 1, 6),
    Column("displacement", "1", 0, 1, 6),
    Column("held_at_start", "bool"),
    Column("held_at_end", "bool"),
    Column("released", "bool"),
    Column("agent_away_at_end", "1", 0, 6, 8),
)


@theme_set("theme-motion", columns=THEME_COLUMNS, scale=0.5)
def theme_moves(batch: FactorBatch) -> FloatArray:
    """Effect of the event on the object acted on: lifts, carries, puts down, leaves alone."""
    track = tracks(batch)
    motion = theme_motion(batch, batch.theme, track)
    prisms = theme_boxes(batch, motion, 0)
    height = np.maximum(prisms.z_max - prisms.z_min, 0.1)
    reach = size(prisms) + 1.0
    z = motion.xyz[..., 2]
    carried = motion.moving.mean(axis=1)
    net = np.linalg.norm(motion.xyz[:, -1, :2] - motion.xyz[:, 0, :2], axis=1)
    away = np.linalg.norm(motion.xyz[:, -1, :2] - track.xyz[:, -1, :2], axis=1)
    held_at_start, held_at_end = motion.moving[:, :2].all(axis=1), motion.moving[:, -2:].all(axis=1)
    return np.column_stack(
        (
            motion.moved,
            ~motion.moved,
            (z.max(axis=1) - z[:, 0]) / height,
            (z[:, -1] - z[:, 0]) / height,
            carried,
            net / path_length(track),
            held_at_start,
            held_at_end,
            motion.moved & ~held_at_end,
            away / reach,
        )
    )


@theme_set(
    "theme-goal",
    roles=("figure", "theme", "goal"),
    columns=(
        *(replace(c, name=f"{when}.{c.name}") for when in ("end", "start") for c in PRISM_COLUMNS),
        Column("toward", "1", -1, 1, 8),
    ),
    scale=0.1,
)
def theme_to_goal(batch: FactorBatch) -> FloatArray:
    """Relation of the object acted on to the goal before and after the event."""
    track = tracks(batch)
    motion = theme_motion(batch, batch.theme, track)
    goal = batch.boxes("goal")
    first, last = (theme_boxes(batch, motion, sample) for sample in (0, SAMPLES - 1))
    before, after = (length(b.centre - goal.centre) for b in (first, last))
    toward = (before - after) / path_length(track)
    pairs = prism_pair(stacked((last, first)), stacked((goal, goal)))
    return np.column_stack((*np.split(pairs, 2), toward))


MOMENTS = ("start", "end", "mean")

AVERAGED = (0, SAMPLES // 4, SAMPLES // 2, 3 * SAMPLES // 4, SAMPLES - 1)
"""Samples whose mean stands for the average during the trajectory."""

MOMENT_COLUMNS: Columns = tuple(
    replace(c, name=f"{moment}.{c.name}") for moment in MOMENTS for c in PRISM_COLUMNS
)

FRAME_COLUMNS: Columns = tuple(
    Column(f"{moment}.{direction}", "1", 0, 1, 6) for moment in MOMENTS for direction in DIRECTIONS
)


def agent_boxes(batch: FactorBatch, track: Tracks, sample: int) -> Boxes:
    """Prisms of the context's agent carried to one sample of the trajectories."""
    bodies, index = batch.bodies, batch.agent_body
    start = np.column_stack((bodies.xyz[index, 0, :2], bodies.yaw[index, 0]))
    pose = np.column_stack((track.xyz[:, sample, :2], track.yaw[:, sample]))
    return measured(
        moved_corners(bodies.corners[index], start, pose), bodies.z_min[index], bodies.z_max[index]
    )


def prism_moments(batch: FactorBatch, target: Boxes) -> FloatArray:
    """Prism features of the moving agent and a target, as `MOMENT_COLUMNS`."""
    track = tracks(batch)
    agents = stacked([agent_boxes(batch, track, sample) for sample in AVERAGED])
    pairs = prism_pair(agents, stacked([target] * len(AVERAGED)))
    pairs = pairs.reshape(len(AVERAGED), len(batch), -1)
    return np.column_stack((pairs[0], pairs[-1], pairs.mean(axis=0)))


def frame_moments(batch: FactorBatch, target: Role) -> FloatArray:
    """AVS of the trajectory's end from a target in its first, last and mean heading."""
    track = tracks(batch)
    end = track.xyz[:, -1, :2]
    mean = np.arctan2(np.sin(track.yaw).mean(axis=1), np.cos(track.yaw).mean(axis=1))
    return avs_directions(
        end, footprints_of(batch, target), np.stack((track.yaw[:, 0], track.yaw[:, -1], mean))
    )


@path_set("path-prisms", columns=MOMENT_COLUMNS, scale=0.1)
def path_prisms(batch: FactorBatch) -> FloatArray:
    """Prisms of agent and landmark compared, at the start, at the end and on average."""
    return prism_moments(batch, batch.boxes("landmark"))


@goal_set("event-prisms", columns=MOMENT_COLUMNS, scale=0.1)
def event_prisms(batch: FactorBatch) -> FloatArray:
    """Prisms of agent and goal compared, at the start, at the end and on average."""
    return prism_moments(batch, batch.boxes("goal"))


@path_set("path-frames", columns=FRAME_COLUMNS, scale=0.1)
def path_frames(batch: FactorBatch) -> FloatArray:
    """On which side of the landmark the path ends, in its first, last and mean heading."""
    return frame_moments(batch, "landmark")


@goal_set("event-frames", words=("goal",), columns=FRAME_COLUMNS, scale=0.1)
def event_frames(batch: FactorBatch) -> FloatArray:
    """On which side of the goal the event ends, in its first, last and mean heading."""
    return frame_moments(batch, "goal")


artefact = partial(feature_set, default=False, wordless=True)


@artefact(
    "start-pose",
    types=("EVENT", "PATH"),
    roles=("figure",),
    words=(),
    columns=(Column("away", "m", 0, 10, 10), Column("turned", "rad", 0, np.pi, 6)),
)
def start_pose(batch: FactorBatch) -> FloatArray:
    """Artefact: a random trajectory from another log doesn't start at this command's robot."""
    track = tracks(batch)
    away = np.linalg.norm(track.xyz[:, 0, :2] - batch.agent[:, :2], axis=1)
    return np.column_stack((away, np.abs(wrap(track.yaw[:, 0] - batch.agent[:, 2]))))


@artefact(
    "scene-motion",
    types=("EVENT", "PATH"),
    roles=("figure",),
    words=("relation",),
    columns=(Column("carries", "bool"), Column("carries_nothing", "bool")),
)
def scene_motion(batch: FactorBatch) -> FloatArray:
    """Artefact: a random trajectory comes without the load that its own log moved."""
    carries = np.zeros(len(batch), dtype=bool)
    track = tracks(batch)
    for peer in batch.peers.T:
        rows = np.flatnonzero(peer >= 0)
        carries[rows] |= theme_motion(batch.take(rows), peer[rows], track.take(rows)).moved
    return np.column_stack((carries, ~carries))


@artefact(
    "landmark-words",
    types=("OBJECT", "PLACE", "PATH"),
    roles=("landmark",),
    words=("landmark",),
    columns=label_columns,
    alone=False,
)
def landmark_words(batch: FactorBatch) -> FloatArray:
    """Artefact: a random negative's landmarks are random too and don't fit their own words."""
    return batch.bodies.shared_labels[batch.landmark].astype(float)


@artefact(
    "robot-pose",
    types=("OBJECT",),
    roles=("figure",),
    words=(),
    columns=(Column("away", "m", 0, 10, 10),),
)
def robot_pose(batch: FactorBatch) -> FloatArray:
    """Artefact: a random robot from another log isn't where this command's robot is."""
    start = batch.bodies.xyz[batch.figure, 0, :2]
    away: FloatArray = np.linalg.norm(start - batch.agent[:, :2], axis=1)[:, None]
    return away
