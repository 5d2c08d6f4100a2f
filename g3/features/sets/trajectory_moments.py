"""Prism and direction features at the start, at the end and over a trajectory (section 3.3).

"We compute the same set of features as for OBJECTs and PLACEs using the state at the beginning of
the trajectory, the end of the trajectory, and the average during the trajectory." A binary feature
is true on average where it holds for more than half of the time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from g3.features.avs.vector_sums import avs_directions
from g3.features.bodies import SAMPLES, moved_corners
from g3.features.factor_batch import Boxes, FactorBatch, Role, measured, stacked
from g3.features.feature_registry import Column, Columns
from g3.features.sets.prisms import PRISM_COLUMNS, prism_pair
from g3.features.sets.reference_frames import DIRECTIONS, footprints_of
from g3.features.sets.trajectories import Tracks, goal_set, path_set, tracks
from g3.groundings import FloatArray

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
    """The agent's prism and the landmark's, at the start, at the end and on average."""
    return prism_moments(batch, batch.boxes("landmark"))


@goal_set("event-prisms", columns=MOMENT_COLUMNS, scale=0.1)
def event_prisms(batch: FactorBatch) -> FloatArray:
    """The agent's prism and the goal's, at the start, at the end and on average."""
    return prism_moments(batch, batch.boxes("goal"))


@path_set("path-frames", columns=FRAME_COLUMNS, scale=0.1)
def path_frames(batch: FactorBatch) -> FloatArray:
    """On which side of the landmark the path ends, in its first, last and mean heading."""
    return frame_moments(batch, "landmark")


@goal_set("event-frames", words=("goal",), columns=FRAME_COLUMNS, scale=0.1)
def event_frames(batch: FactorBatch) -> FloatArray:
    """On which side of the goal the event ends, in its first, last and mean heading."""
    return frame_moments(batch, "goal")
