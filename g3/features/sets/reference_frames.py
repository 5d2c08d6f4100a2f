"""Directions in a frame of reference: "left of", "in front of", "behind" (section 3.3)."""

from __future__ import annotations

from functools import partial

import numpy as np

from g3.features.avs.vector_sums import Footprints, avs_directions, footprints
from g3.features.factor_batch import FactorBatch, Role, distinct
from g3.features.feature_registry import Column, Columns
from g3.features.sets.prisms import relation_set
from g3.geometry.plane import following, length
from g3.groundings import FloatArray

DIRECTIONS = ("front", "left", "back", "right")
"""The four cardinal directions of a frame, a quarter turn counter-clockwise each."""


def speaker_yaw(agent: FloatArray, centre: FloatArray) -> FloatArray:
    """Heading of the line of sight from the agent's start (n, 3) to landmarks' centres; (n,)."""
    sight = centre - agent[:, :2]
    return np.arctan2(sight[:, 1], sight[:, 0])


LEAN_RAD = 1e-4
"""A side that lies straight across the agent's heading counts as pointing to its left."""


def intrinsic_yaw(landmarks: FloatArray, agent: FloatArray) -> FloatArray:
    """Heading of a landmark's longest side, of the two senses the one more along the agent's.

    Pallets and trailers have no front in the semantic map, so the sense is taken from how the agent
    meets them. Of sides that are as long, as a square's, the one more along the agent's heading
    counts. So the noise of its corners doesn't decide.
    """
    edges = following(landmarks) - landmarks
    side = length(edges)
    long = side >= 0.999 * side.max(axis=1, keepdims=True)
    yaw = np.arctan2(edges[..., 1], edges[..., 0])
    along = np.cos(yaw - agent[:, 2:] - LEAN_RAD)
    rows = np.arange(len(edges))
    best = np.where(long, np.abs(along), -1.0).argmax(axis=1)
    sense: FloatArray = np.where(along[rows, best] < 0, np.pi, 0.0)
    heading: FloatArray = yaw[rows, best] + sense
    return heading


def frame_columns(frame: str) -> Columns:
    """Columns of AVS in one frame."""
    return tuple(Column(f"{frame}.{d}", "1", 0, 1, 6) for d in DIRECTIONS)


def footprints_of(batch: FactorBatch, role: Role) -> Footprints:
    """Footprints of the bodies in a role, for all sets that need them."""

    def compute(batch: FactorBatch) -> Footprints:
        bodies = batch.role(role)
        first, row = distinct(bodies)
        return footprints(batch.bodies.corners[bodies[first]], row)

    return batch.once(("footprints", role), compute)


avs_set = partial(relation_set, scale=0.3)


@relation_set("avs-start", columns=frame_columns("start"), scale=0.2)
def avs_start(batch: FactorBatch) -> FloatArray:
    """AVS of figure and landmark in the frame of the agent's starting orientation."""
    return _in_frame("start", batch)


@avs_set("avs-speaker", columns=frame_columns("speaker"), optional=("PLACE",))
def avs_speaker(batch: FactorBatch) -> FloatArray:
    """AVS in the frame of the line of sight from the agent's start to the landmark."""
    return _in_frame("speaker", batch)


@avs_set("avs-intrinsic", columns=frame_columns("intrinsic"), optional=("PLACE",))
def avs_intrinsic(batch: FactorBatch) -> FloatArray:
    """AVS in the landmark's own frame, along its longest side."""
    return _in_frame("intrinsic", batch)


FRAMES = ("start", "speaker", "intrinsic")
"""Frames of reference for objects and places."""


def _in_frame(frame: str, batch: FactorBatch) -> FloatArray:
    first = len(DIRECTIONS) * FRAMES.index(frame)
    # One at a time, small batches would take three times as long.
    return batch.once(_in_frames, _in_frames)[:, first : first + len(DIRECTIONS)]


def _in_frames(batch: FactorBatch) -> FloatArray:
    yaw = batch.shared(_yaw, "landmark").T
    return avs_directions(
        batch.bodies.centre.take(batch.figure, axis=0), footprints_of(batch, "landmark"), yaw
    )


def _yaw(batch: FactorBatch) -> FloatArray:
    """Headings of the frames (n, 3)."""
    landmark = batch.boxes("landmark")
    yaw = (
        batch.agent[:, 2],
        speaker_yaw(batch.agent, landmark.centre),
        intrinsic_yaw(landmark.corners, batch.agent),
    )
    return np.column_stack(yaw)


@avs_set("avs-log", columns=(*frame_columns("end"), *frame_columns("mean")), default=False)
def avs_log(batch: FactorBatch) -> FloatArray:
    """AVS in the frames of the agent's ending and average orientation in the context's log.

    Off by default: when objects and places are grounded, no action has been
    chosen yet, so these orientations are not known.
    """
    yaw = np.stack((batch.agent_end_yaw, batch.agent_mean_yaw))
    return avs_directions(
        batch.bodies.centre.take(batch.figure, axis=0), footprints_of(batch, "landmark"), yaw
    )
