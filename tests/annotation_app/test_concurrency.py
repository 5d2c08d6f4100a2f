"""Two hundred workers at once, on bad connections, and a server that is killed."""

from __future__ import annotations

from pathlib import Path

import pytest

from annotation_app.config import Config
from benchmarks.app import check, run_load
from tests.annotation_app.rendered import render

WORKERS, ANSWERS = 200, 25


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 4])
@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_nothing_is_lost_nor_doubled(config: Config, processes: int, tmp_path: Path) -> None:
    videos = render(tmp_path / "videos", ("one", "two"))
    tally = run_load(
        config,
        videos,
        workers=WORKERS,
        answers=ANSWERS,
        processes=processes,
        think_s=1.0,
        kill=True,
    )
    states = check(config, tally)
    assert set(states) <= {"accepted", "surplus", "repeated"}
    described = 2 * ANSWERS
    assert states["accepted"] >= described + 2 * described
    assert tally.broken["cut off"] > 0
    assert tally.broken["doubled"] > 0
    assert tally.broken["tried again"] > 0
