"""Hundreds of workers at once, on bad connections, and a server that is killed."""

from __future__ import annotations

from pathlib import Path

import pytest

from annotation_app.config import Config
from benchmarks.app import check, run_load
from tests.annotation_app.rendered import render


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "processes", "workers", "answers"),
    [("sqlite", 1, 60, 12), ("sqlite", 4, 200, 16), ("postgresql", 2, 500, 12)],
)
def test_nothing_is_lost_nor_doubled(
    config: Config, processes: int, workers: int, answers: int, tmp_path: Path
) -> None:
    videos = render(tmp_path / "videos", ("one", "two"))
    tally = run_load(
        config,
        videos,
        workers=workers,
        answers=answers,
        processes=processes,
        think_s=0.5,
        kill=True,
    )
    states = check(config, tally)
    assert set(states) <= {"accepted", "surplus", "repeated"}
    described = 2 * answers
    assert states["accepted"] >= described + 2 * described
    assert tally.broken["cut off"] > 0
    assert tally.broken["doubled"] > 0
    assert tally.broken["tried again"] > 0
