"""``ct annotate`` without anything, as the first thing that somebody tries."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
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
from corpus_tools.world.scenarios.library import dataset_folder, scenario_files
from g3.storage.cache_folder import CACHE
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
    # Videos of one task each have no steps to tell.
    assert tuple(study.tasks) == tuple(name for name in task_names() if name != "subtasks")
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
    first = start_and_interrupt(cache, tmp_path)
    second = start_and_interrupt(cache, tmp_path)
    for told in (first, second):
        assert re.search(r"study demo: http://localhost:\d+/s/demo\n", told)
        assert re.search(
            r"make the first admin, once, within a day: http://localhost:\d+/setup/\S+\n", told
        )
        assert "Ctrl-C" in told
    assert list(tmp_path.iterdir()) == []


def start_and_interrupt(cache: Path, folder: Path) -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with subprocess.Popen(
        [sys.executable, "-m", "corpus_tools", "annotate", "--port", str(port)],
        cwd=folder,
        env={**os.environ, "XDG_CACHE_HOME": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as server:
        try:
            assert b"Commands for a robot forklift" in get(f"http://127.0.0.1:{port}/")
        finally:
            server.send_signal(signal.SIGINT)
        told, errors = server.communicate()
    assert errors == ""
    assert server.returncode == 0
    return told


def get(address: str) -> bytes:
    for _ in range(600):
        try:
            with urllib.request.urlopen(address) as reply:
                return bytes(reply.read())
        except OSError:
            time.sleep(0.1)
    raise TimeoutError(address)
