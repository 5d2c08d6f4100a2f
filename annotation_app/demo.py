"""A study on the bundled scenarios, for trying the app."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

from annotation_app.setup import FILES, Rendered
from annotation_app.study import KnownCommand, Question, StudyConfig, TaskConfig
from corpus_tools.world.scenarios.documents import read_document
from corpus_tools.world.scenarios.library import dataset_folder, scenario_files

DATASET = "warehouse"
CHECKS = 6


def demo_study(videos: list[Rendered]) -> StudyConfig:
    """All five tasks, open to everybody, one answer being enough to go on to the next."""
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
    """The first command of a scenario, with the video of another layout's scenario."""
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
    """Two scenarios in each layout: few enough to be rendered while somebody waits."""
    by_layout: dict[str, list[str]] = {}
    for name, document in sorted(_documents().items()):
        by_layout.setdefault(str(document["layout"]), []).append(name)
    return tuple(sorted(name for names in by_layout.values() for name in names[:2]))


def render_demo(folder: Path) -> None:
    """Make the videos that aren't there yet, quickly rather than well."""
    wanted = [name for name in demo_scenarios() if not (folder / name / FILES["manifest"]).exists()]
    if not wanted:
        return
    from corpus_tools.video.gl import choose_back_end  # noqa: PLC0415 - before MuJoCo

    choose_back_end()
    from corpus_tools.progress import progress_bar  # noqa: PLC0415 - heavy, only to render
    from corpus_tools.video.batch import produce_all  # noqa: PLC0415
    from corpus_tools.video.items import scenario_items  # noqa: PLC0415
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415
    from g3.errors import CorpusError  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    items = scenario_items(DATASET, tuple(wanted))
    settings = Settings(fps=15, quality="draft")
    jobs = min(os.cpu_count() or 1, len(items))
    problems = []
    with progress_bar("rendering the demo's videos") as progress:
        outcomes = produce_all(items, folder, settings, jobs=jobs, force=False)
        for done, outcome in enumerate(outcomes, start=1):
            if progress is not None:
                progress("rendering the demo's videos", done, len(items))
            if outcome.problem:
                problems.append(f"{outcome.name}: {outcome.problem}")
    if len(problems) == len(demo_scenarios()):
        raise CorpusError(problems[0], fix="`ct render-videos` tells more")
