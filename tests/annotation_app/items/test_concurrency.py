"""Hundreds of workers at once, on bad connections, while servers and the database are killed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from annotation_app.core.config import Config
from tests.annotation_app.conftest import new_database
from tests.annotation_app.load import Tally, check, run_load
from tests.annotation_app.postgres import running_cluster
from tests.annotation_app.rendered import render


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "processes", "workers", "films", "answers", "kills"),
    [("sqlite", 1, 60, 2, 12, 1), ("sqlite", 3, 200, 5, 60, 6), ("postgresql", 2, 500, 2, 12, 1)],
)
def test_nothing_is_lost_nor_doubled(
    config: Config,
    processes: int,
    workers: int,
    films: int,
    answers: int,
    kills: int,
    tmp_path: Path,
) -> None:
    tally = run_load(
        config,
        rendered(tmp_path, films),
        workers=workers,
        answers=answers,
        processes=processes,
        think_s=0.5,
        kills=kills,
    )
    check_all(config, tally, films * answers)
    assert tally.broken["tried again"] > 0


@pytest.mark.slow
def test_nothing_is_lost_when_the_database_is_killed(config: Config, tmp_path: Path) -> None:
    with running_cluster(durable=True) as cluster:

        def kill() -> None:
            cluster.stop("immediate")
            cluster.start()

        troubles: list[Callable[[], None]] = [kill] * 3
        own = replace(config, database=new_database(cluster.url))
        tally = run_load(
            own,
            rendered(tmp_path, 5),
            workers=200,
            answers=60,
            processes=2,
            think_s=0.5,
            kills=0,
            database_troubles=troubles,
        )
        check_all(own, tally, 5 * 60)
    assert tally.broken["put off"] > 0


def rendered(folder: Path, count: int) -> Path:
    return render(folder / "videos", tuple(f"video{i}" for i in range(count)))


def check_all(config: Config, tally: Tally, described: int) -> None:
    states = check(config, tally)
    assert set(states) <= {"accepted", "surplus", "repeated"}
    assert states["accepted"] >= described + 2 * described
    assert tally.broken["cut off"] > 0
    assert tally.broken["doubled"] > 0
