"""A study on the bundled scenarios, for trying the app."""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from annotation_app.studies.study_file import KnownCommand, Question, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import FILES, Rendered
from corpus_tools.world.scenarios.documents import read_document
from corpus_tools.world.scenarios.scenario_reading import dataset_folder, scenario_files

DATASET = "warehouse"
CHECKS = 6
FIRST = 2
"""Number of videos made before the demo opens: negatives come from another video."""
FPS = 15
NICENESS = 10
LOOK_S = 1.0


def demo_study(videos: list[Rendered]) -> StudyConfig:
    """Return a study with the five tasks of commands, open to everybody, one answer each."""
    known = tuple(_known_commands(videos))
    return StudyConfig(
        name="demo",
        title="Commands for a robot forklift",
        tasks={
            "describe": TaskConfig(answers=3),
            "segment": TaskConfig(),
            "ground": TaskConfig(),
            "check": TaskConfig(),
            "rate": TaskConfig(answers=5),
        },
        questions=(
            Question("english", "Is English your first language?", ("Yes", "No")),
            Question("forklift", "Have you driven a forklift?", ("Yes", "No")),
        ),
        attention_checks=0.2 if known else 0.0,
        known_commands=known,
    )


def _known_commands(videos: list[Rendered]) -> Iterator[KnownCommand]:
    """Yield a scenario's first command, with the video of another layout's scenario."""
    scenarios = _documents()
    documents = {item.video: scenarios[item.video] for item in videos if item.video in scenarios}
    pairs = [
        (one, other)
        for one, other in combinations(sorted(documents), 2)
        if documents[one]["layout"] != documents[other]["layout"]
    ]
    used: set[str] = set()
    for one, other in pairs:
        commands = documents[one].get("commands") or []
        if one not in used and other not in used and commands and len(used) < 2 * CHECKS:
            used |= {one, other}
            yield KnownCommand(str(commands[0]["text"]), one, other)


def _documents() -> Mapping[str, Any]:
    files = scenario_files(dataset_folder(DATASET))
    return {name: read_document(file).value for name, file in files.items()}


def demo_scenarios() -> tuple[str, ...]:
    """Return two scenarios in each layout: few enough to be rendered while people look around."""
    return tuple(sorted(name for names in _by_layout() for name in names[:2]))


def _by_layout() -> Collection[Sequence[str]]:
    """Return the names of the scenarios in each layout, in order."""
    by_layout: dict[str, list[str]] = {}
    for name, document in sorted(_documents().items()):
        by_layout.setdefault(str(document["layout"]), []).append(name)
    return by_layout.values()


def ready(folder: Path) -> list[Rendered]:
    """Return the demo's existing videos."""
    there = (name for name in demo_scenarios() if (folder / name / FILES["manifest"]).exists())
    return [Rendered(name, (folder / name).resolve()) for name in there]


def render_first(folder: Path) -> None:
    """Make as many videos as it takes to begin, if there are none, quickly rather than well."""
    if len(ready(folder)) >= FIRST:
        return
    from corpus_tools.video.drawing.gl import choose_back_end  # noqa: PLC0415 - before MuJoCo

    choose_back_end()
    from corpus_tools.runtime.parallel import Workers  # noqa: PLC0415 - heavy, only to render
    from corpus_tools.runtime.progress import progress_bar  # noqa: PLC0415
    from corpus_tools.video.items import scenario_items  # noqa: PLC0415
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415
    from corpus_tools.video.production import produce_all  # noqa: PLC0415
    from g3.errors import CorpusError  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    of_layouts = tuple(names[0] for names in _by_layout())[:FIRST]
    items = scenario_items(DATASET, of_layouts)
    what = f"making the demo's first {len(items)} videos"
    problems = []
    with progress_bar(what) as progress:
        jobs = min(os.cpu_count() or 1, len(items))
        outcomes = produce_all(
            items, folder, Settings(fps=FPS, quality="draft"), workers=Workers(jobs), force=False
        )
        for done, outcome in enumerate(outcomes, start=1):
            progress(what, done, len(items))
            if outcome.problem:
                problems.append(f"{outcome.name}: {outcome.problem}")
    if problems:
        raise CorpusError(problems[0], fix="run `ct render-videos` to see more")


def render_rest(folder: Path, put: Callable[[list[Rendered]], None]) -> int:
    """Make and count the other videos while the demo is open, in a process that gives way to it.

    `put` is given all the videos that are there, when there is a new one.
    """
    there = {item.video for item in ready(folder)}
    missing = [name for name in demo_scenarios() if name not in there]
    if missing:
        command = [sys.executable, "-m", "corpus_tools", "render-videos", *missing]
        command += ["--dataset", DATASET, "--out", str(folder)]
        command += ["--fps", str(FPS), "--quality", "draft"]
        arguments = command, folder, put
        threading.Thread(target=add_as_they_come, args=arguments, daemon=True).start()
    return len(missing)


def add_as_they_come(
    command: Sequence[str], folder: Path, put: Callable[[list[Rendered]], None]
) -> None:
    """Run a command that makes videos, and hand on all that are there after each new one."""
    known = len(ready(folder))
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdout=quiet, stderr=quiet) as process:  # noqa: S603 - our own
        atexit.register(process.terminate)  # a server that is asked to end is asked alone
        if hasattr(os, "setpriority"):  # there is none on Windows
            os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
        is_over = False
        while not is_over:
            is_over = process.poll() is not None
            found = ready(folder)
            if len(found) > known:
                known = len(found)
                put(found)
            time.sleep(LOOK_S)
        atexit.unregister(process.terminate)
