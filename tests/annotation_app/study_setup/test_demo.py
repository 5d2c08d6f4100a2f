"""``ct annotate`` without anything, as the first thing that somebody tries."""

from __future__ import annotations

import os
import re
import shutil
import signal
import sys
import urllib.request
from itertools import pairwise
from pathlib import Path

import pytest

from annotation_app.study_setup.demo_study import (
    DATASET,
    add_as_they_come,
    demo_scenarios,
    demo_study,
)
from annotation_app.study_setup.rendered_study import rendered_videos
from annotation_app.tasks.task_registry import task_names
from corpus_tools.world.scenarios.documents import read_document
from corpus_tools.world.scenarios.scenario_reading import dataset_folder, scenario_files
from g3.storage.cache_folder import CACHE
from tests.annotation_app.real_server import started
from tests.annotation_app.rendered import render


def layouts() -> dict[str, str]:
    files = scenario_files(dataset_folder(DATASET))
    return {name: read_document(file).value["layout"] for name, file in files.items()}


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache in which the demo's videos have been rendered."""
    folder = tmp_path_factory.mktemp("cache")
    render(folder / CACHE / "annotate-demo" / "videos", demo_scenarios())
    return folder


def test_the_demo_is_about_all_layouts_and_tasks(cache: Path) -> None:
    names, of = demo_scenarios(), layouts()
    assert {of[name] for name in names} == set(of.values())
    study = demo_study(rendered_videos(cache / CACHE / "annotate-demo" / "videos"))
    # Videos of one task each have no steps to tell, and all succeed.
    others = ("subtasks", "moments", "mark", "correct")
    assert tuple(study.tasks) == tuple(name for name in task_names() if name not in others)
    assert study.known_commands
    assert all(of[known.video] != of[known.wrong_video] for known in study.known_commands)


def test_videos_come_to_the_demo_one_by_one(cache: Path, tmp_path: Path) -> None:
    made = cache / CACHE / "annotate-demo" / "videos"
    first, second, third = demo_scenarios()[:3]
    shutil.copytree(made / first, tmp_path / first)
    copy = "import shutil, sys; [shutil.copytree(*sys.argv[i : i + 2]) for i in (1, 3)]"
    names = [str(part / name) for name in (second, third) for part in (made, tmp_path)]
    seen: list[list[str]] = []
    add_as_they_come(
        [sys.executable, "-c", copy, *names],
        tmp_path,
        lambda found: seen.append([item.video for item in found]),
    )
    assert seen[-1] == [first, second, third]
    assert all(before < after for before, after in pairwise(map(len, seen)))


@pytest.mark.slow
def test_it_opens_the_demo_ends_and_goes_on(cache: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache)}
    call = ("annotate", "--port", "0")
    for _ in range(2):
        with started(cache / "log", *call, cwd=tmp_path, env=environment) as server:
            address = f"http://localhost:{server.port}"
            with urllib.request.urlopen(address) as reply:
                assert b"Commands for a robot forklift" in reply.read()
            assert server.end(signal.SIGINT) == 0
        assert server.logged() == []
        assert f"study demo: {address}/s/demo\n" in server.told
        first = f"make the first admin, once, within a day: {address}/setup/"
        assert re.search(rf"{first}\S+\n", server.told)
    assert list(tmp_path.iterdir()) == []
