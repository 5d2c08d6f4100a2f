"""Features that read how the negatives were made; all off unless asked for.

They exist to be measured: adding one to a model shows how much of Table 1 could be won
without understanding anything (``ct eval --table 1 --with start-pose``). None of them
says anything at inference, where every candidate starts at the robot and in its scene.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, feature_set
from g3.features.sets.label_words import label_columns
from g3.features.sets.trajectories import theme_motion, tracks
from g3.geometry.plane import wrap
from g3.groundings import FloatArray

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
