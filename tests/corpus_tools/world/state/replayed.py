"""How true a replay is to its log."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.state.replay import replay


def deviations(context):
    """Largest distances in metres between moved objects in the replay and in the log."""
    recording = replay(context, 25.0)
    begin = min(item.trajectory.t[0] for item in context.objects if len(item.trajectory) > 1)
    for i, item in enumerate(context.objects):
        t = item.trajectory.t - begin
        columns = recording.position[:, i].T
        played = np.column_stack([np.interp(t, recording.t_s, column) for column in columns])
        yield float(np.abs(played - item.trajectory.xyz).max())
