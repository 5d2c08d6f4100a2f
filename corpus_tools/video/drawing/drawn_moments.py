"""The moments that a video shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from corpus_tools.world.state.recording import NS_PER_S, Recording


def sampled(recording: Recording, fps: int) -> Recording:
    """The recording at the times of a video's frames.

    Between moments positions and heights are interpolated, and orientations along the
    shorter arc. Where a recording was made at the video's rate, its moments come through
    unchanged.
    """
    last_ns = int(recording.t_ns[-1])
    count = last_ns * fps // NS_PER_S + 1
    t_ns = np.arange(count, dtype=np.int64) * NS_PER_S // fps
    after = np.clip(np.searchsorted(recording.t_ns, t_ns, side="right"), 1, None)
    after = np.minimum(after, len(recording.t_ns) - 1)
    before = np.maximum(after - 1, 0)
    span = np.maximum(recording.t_ns[after] - recording.t_ns[before], 1)
    part = np.clip((t_ns - recording.t_ns[before]) / span, 0.0, 1.0)
    share = part[:, None, None]
    q0, q1 = recording.orientation[before], recording.orientation[after]
    q1 = np.where((q0 * q1).sum(axis=-1, keepdims=True) < 0, -q1, q1)
    q = q0 * (1 - share) + q1 * share
    q = np.where(share == 0, q0, q / np.linalg.norm(q, axis=-1, keepdims=True))
    height = recording.fork_height_m
    return replace(
        recording,
        t_ns=t_ns,
        position=recording.position[before] * (1 - share) + recording.position[after] * share,
        orientation=q,
        fork_height_m=height[before] * (1 - part) + height[after] * part,
    )


def moving_objects(recording: Recording) -> list[int]:
    """Indices of the robot and of all objects that are not always where they were at first."""
    moved = (recording.position != recording.position[0]).any(axis=(0, 2))
    turned = (recording.orientation != recording.orientation[0]).any(axis=(0, 2))
    objects = recording.start.objects
    return [
        i
        for i, item in enumerate(objects)
        if moved[i] or turned[i] or item.id == recording.start.agent_id
    ]


def same_state(recording: Recording, j: int, k: int) -> bool:
    """Whether everything is at the k-th moment as at the j-th."""
    return bool(
        (recording.position[j] == recording.position[k]).all()
        and (recording.orientation[j] == recording.orientation[k]).all()
        and recording.fork_height_m[j] == recording.fork_height_m[k]
    )
