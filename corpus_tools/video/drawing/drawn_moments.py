"""The moments that a video shows."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from corpus_tools.world.state.recording import NS_PER_S, Recording
from g3.geometry.plane import BoolArray

SAME = 1e-6
"""Invisible difference in metres, or parts of a quaternion."""


SEEN = 0.002
"""Least visible difference in metres, or parts of a quaternion."""
STILL_S = 2.0
"""Longest idle stretch, in seconds; longer ones are cut to this."""


def sampled(
    recording: Recording, fps: int, *, speed: float = 1.0, skip_idle: bool = False
) -> Recording:
    """Sample the recording at the times of a video's frames, by its own clock.

    Between moments positions and heights are interpolated, and orientations along the shorter arc.
    Where a recording was made at the video's rate, its moments come through unchanged. A second of
    the video, with `fps` frames, shows `speed` seconds of the recording. With `skip_idle` the
    middle of stretches longer than :data:`STILL_S` in which nothing moves is left out.
    """
    t_ns = _frame_times(int(recording.t_ns[-1]), fps, speed)
    if skip_idle:
        t_ns = t_ns[~_idle(recording, t_ns)]
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


def _frame_times(last_ns: int, fps: int, speed: float) -> npt.NDArray[np.int64]:
    """Return times of frames from 0 to the last, nanoseconds."""
    if speed == 1.0:
        return np.arange(last_ns * fps // NS_PER_S + 1, dtype=np.int64) * NS_PER_S // fps
    step = speed * NS_PER_S / fps
    times: npt.NDArray[np.float64] = np.rint(np.arange(int(last_ns / step) + 1) * step)
    return times.astype(np.int64)


def _idle(recording: Recording, t_ns: npt.NDArray[np.int64]) -> BoolArray:
    """Mark the times in the middle of long stretches in which nothing moves, shape (n,)."""
    state = np.concatenate(
        (
            recording.position.reshape(len(recording.t_ns), -1),
            recording.orientation.reshape(len(recording.t_ns), -1),
            recording.fork_height_m[:, None],
        ),
        axis=1,
    )
    changes = recording.t_ns[:-1][(np.abs(np.diff(state, axis=0)) > SAME).any(axis=1)]
    ends = np.concatenate(([0], changes, recording.t_ns[-1:]))
    keep = int(STILL_S / 2 * NS_PER_S)
    idle = np.zeros(len(t_ns), dtype=bool)
    for start, end in pairwise(ends):
        if end - start > 2 * keep:
            idle |= (t_ns > start + keep) & (t_ns < end - keep)
    return idle


def clock(recording: Recording, fps: int) -> list[tuple[float, float]]:
    """Return the time of a log at each moment of its video, for a recording sampled at its frames.

    Seconds of the video and of the log at the beginning, where the pace changes, and at the end,
    when the last frame has been shown. Between two of them both grow evenly.
    """
    t_ns = recording.t_ns
    pace = np.diff(t_ns) if len(t_ns) > 1 else np.array([NS_PER_S // fps])
    # Times are rounded to nanoseconds.
    turns = np.flatnonzero(np.abs(np.diff(pace)) > 2) + 1
    knots = [(k / fps, int(t_ns[k]) / NS_PER_S) for k in (0, *turns.tolist())]
    return [*knots, (len(t_ns) / fps, int(t_ns[-1] + pace[-1]) / NS_PER_S)]


def moving_objects(recording: Recording) -> list[int]:
    """Return the indices of the robot and of all objects that leave their first pose.

    Physics lets loads settle by less than anybody can see; they count as standing still.
    """
    moved = (np.abs(recording.position - recording.position[0]) > SEEN).any(axis=(0, 2))
    turned = (np.abs(recording.orientation - recording.orientation[0]) > SEEN).any(axis=(0, 2))
    objects = recording.start.objects
    return [
        i
        for i, item in enumerate(objects)
        if moved[i] or turned[i] or item.id == recording.start.agent_id
    ]


def same_state(recording: Recording, j: int, k: int) -> bool:
    """Check that everything is at the k-th moment as at the j-th."""
    return bool(
        (recording.position[j] == recording.position[k]).all()
        and (recording.orientation[j] == recording.orientation[k]).all()
        and recording.fork_height_m[j] == recording.fork_height_m[k]
    )
