"""The tutorial of robot episodes, step by step as it stands there, in an empty folder."""

from __future__ import annotations

import csv
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
from eval.cli import demo_commands
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
    monkeypatch.setattr(demo_commands, "SIZE", "96x64")  # as many pictures, drawn in less time
    demo, export, steps, errors = (
        call for step in shown() if step.page == PAGE for call in step.calls
    )
    assert run([*demo, "--no-serve"]) == 0
    with started(tmp_path / "log", *demo, "--port", "0") as server:  # nothing is made again
        assert f"/s/{STUDY}\n" in server.told
        assert "it is there: demo-episodes/dataset" in server.told
        assert server.end(signal.SIGINT) == 0
    mistakes = json.loads(Path("demo-episodes/planted.json").read_text())["mistakes"]
    (wrong,) = (mistake for mistake in mistakes if mistake["style"] == "task")
    answer_all(wrong)
    for call in (export, steps, errors):
        assert run(call) == 0

    source, copy = Path("demo-episodes/dataset"), Path(export[2])
    assert subtasks(source) == [list(episode.written) for episode in EPISODES.values()]
    assert subtasks(copy) == [list(episode.steps) for episode in EPISODES.values()]
    tasks = [[episode.tasks[0] for episode in open_dataset(f).episodes()] for f in (source, copy)]
    changed = [pair for pair in zip(*tasks, strict=True) if len(set(pair)) > 1]
    assert changed == [(wrong["dataset"], wrong["truth"])]
    planted = [
        (
            mistake["kind"],
            *(str(v) for step in (mistake["dataset"], mistake["truth"]) for v in cells(step)),
        )
        for mistake in mistakes
        if mistake["style"] == "subtask"
    ]
    found = [
        tuple(row[name] for name in ("state", "proposed_s", "proposed", "start_s", "text"))
        for row in table(steps)
        if row["state"] != "unchanged"
    ]
    assert sorted(found) == sorted(planted)
    shares = {row["measure"]: float(row["value"]) for row in table(errors)}
    assert shares["accepted"] == pytest.approx(15 / 18)
    for measure in ("text changed", "boundary moved", "removed", "added"):
        assert shares[measure] == pytest.approx(1 / 18)
    if PYTHON:
        (program,) = re.findall(r"```python\n(.*?)```", (ROOT / PAGE).read_text(), re.DOTALL)
        assert "19.2 s: subtask back away from the tires" in lerobot(program)


def cells(step: dict[str, Any] | None) -> tuple[object, object]:
    return (step["start_s"], step["content"]) if step else ("", "")


def table(call: list[str]) -> list[dict[str, str]]:
    """The rows of the table that a call has written."""
    with Path(call[2]).open(newline="") as file:
        return list(csv.DictReader(file))


def subtasks(folder: Path) -> list[list[tuple[float, str]]]:
    return [
        [(round(row["timestamp"], 3), row["content"]) for row in rows if row["style"] == "subtask"]
        for _, rows in persistent_rows(open_dataset(folder))
    ]


def answer_all(wrong: dict[str, Any]) -> None:
    """Answer as one person who sees what is true of each episode."""
    config = open_instance(Path("demo-episodes/annotation"))
    engine = open_database(config.database)
    app = create_app(config, engine)
    person = Browser(app, study=STUDY)
    frames = [episode.frames for episode in open_dataset(Path("demo-episodes/dataset")).episodes()]
    for task in ("describe", "subtasks", "correct", "mark"):
        while (taken := person.lease(task, STUDY)).status_code == 200:
            page = taken.json
            index = frames.index(round(page["payload"]["duration_s"] * 10))
            true = list(EPISODES.values())[index].steps
            steps = [{"start_s": start_s, "text": text} for start_s, text in true]
            right = {"verdict": "right"}
            better = {"verdict": "wrong", "text": wrong["truth"]}
            body = {
                "describe": described(f"Work for {frames[index]} frames."),
                "subtasks": {"subtasks": steps, "played_to_end": True},
                "correct": better if index == wrong["episode_index"] else right,
                "mark": {"success": "success", "quality": 4},
            }[task]
            answered = person.answer(page["item"], body | person.watched(page))
            assert answered.status_code == 200, answered.text
    engine.dispose()
