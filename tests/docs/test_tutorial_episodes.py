"""The tutorial of robot episodes, step by step as it stands there, in an empty folder."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database
from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import persistent_rows
from eval.cli.forklift_episodes import EPISODES
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.real_server import started
from tests.corpus_tools.lerobot.test_lerobot_itself import PYTHON, lerobot
from tests.docs.blocks import ROOT, shown

PAGE = "docs/tutorial-episodes.md"
STUDY = "forklift-episodes"


def send(person: Browser, page: Any, body: dict[str, Any]) -> None:
    answered = person.answer(page["item"], body | person.watched(page))
    assert answered.status_code == 200, answered.text


@pytest.mark.slow
def test_it_works_as_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    demo, export = (call for step in shown() if step.page == PAGE for call in step.calls)
    assert run([*demo, "--no-serve"]) == 0
    with started(tmp_path / "log", *demo, "--port", "0") as server:  # nothing is made again
        assert f"/s/{STUDY}\n" in server.told
        assert "it is there: demo-episodes/dataset" in server.told
        assert server.end(signal.SIGINT) == 0
    answer_all()
    assert run(export) == 0

    source, copy = Path("demo-episodes/dataset"), Path(export[2])
    assert subtasks(source) == [list(episode.written) for episode in EPISODES.values()]
    assert subtasks(copy) == [list(episode.steps) for episode in EPISODES.values()]
    mistakes = json.loads(Path("demo-episodes/planted.json").read_text())["mistakes"]
    found = [
        {"dataset": sorted(set(before) - set(after)), "truth": sorted(set(after) - set(before))}
        for before, after in zip(subtasks(source), subtasks(copy), strict=True)
    ]
    for mistake in mistakes:
        if mistake["style"] == "subtask":
            for where, steps in found[mistake["episode_index"]].items():
                one = mistake[where]
                assert steps == ([(one["start_s"], one["content"])] if one else [])
    (wrong,) = (mistake for mistake in mistakes if mistake["style"] == "task")
    lines = (copy / "meta/verdicts.jsonl").read_text().splitlines()
    agreed = {(v["episode_index"], v["content"]): v["agree"] for v in map(json.loads, lines)}
    tasks = {episode.index: episode.tasks[0] for episode in open_dataset(source).episodes()}
    assert tasks[wrong["episode_index"]] == wrong["dataset"]
    for index, task in tasks.items():
        assert agreed[index, task] == (index != wrong["episode_index"])
    if PYTHON:
        (program,) = re.findall(r"```python\n(.*?)```", (ROOT / PAGE).read_text(), re.DOTALL)
        assert "19.2 s: subtask back away from the tires" in lerobot(program)


def subtasks(folder: Path) -> list[list[tuple[float, str]]]:
    return [
        [(round(row["timestamp"], 3), row["content"]) for row in rows if row["style"] == "subtask"]
        for _, rows in persistent_rows(open_dataset(folder))
    ]


def answer_all() -> None:
    """Answer as one person who sees what is true of each episode."""
    config = open_instance(Path("demo-episodes/annotation"))
    engine = open_database(config.database)
    app = create_app(config, engine)
    person = Browser(app, study=STUDY)
    shown_s = {
        episode.frames / 10: (episode.tasks[0], true)
        for episode, true in zip(
            open_dataset(Path("demo-episodes/dataset")).episodes(), EPISODES.values(), strict=True
        )
    }
    for task in ("describe", "subtasks", "rate"):
        while (taken := person.lease(task, STUDY)).status_code == 200:
            page = taken.json
            duration = page["payload"]["duration_s"]
            near = min(shown_s, key=lambda length: abs(length - duration))
            written, true = shown_s[near]
            is_right = page["payload"].get("command") == written and not true.wrong_task
            steps = [{"start_s": start_s, "text": text} for start_s, text in true.steps]
            body = {
                "describe": described(f"Work for {near} seconds."),
                "subtasks": {"subtasks": steps, "played_to_end": True},
                "rate": {"rating": 5 if is_right else 1},
            }[task]
            answered = person.answer(page["item"], body | person.watched(page))
            assert answered.status_code == 200, answered.text
    engine.dispose()
