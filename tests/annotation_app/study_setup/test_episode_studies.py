"""Studies that ``ct annotate init`` makes of robot episodes."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

from annotation_app.dashboard.study_statistics import collected
from annotation_app.dashboard.workers import workers
from annotation_app.store.database import reading
from annotation_app.study_setup.study_reading import read_study
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.lerobot_datasets import new_dataset

TASKS = ("describe", "subtasks", "correct", "mark")


def init(file: Path, videos: Path) -> int:
    return run(["annotate", "init", str(file), "--videos", str(videos)])


def test_a_dataset_becomes_a_study_whose_tasks_can_be_done(tmp_path: Path) -> None:
    file = tmp_path / "arm.yaml"
    assert init(file, new_dataset(tmp_path / "set")) == 0
    assert sorted(read_study(file).tasks) == sorted(TASKS)
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 0
    with set_up(file) as app:
        person = Browser(app, study="arm")
        person.practise(*TASKS)
        pages = {task: person.lease(task, "arm").json["payload"] for task in TASKS}
    assert pages["correct"]["command"] == "Push the cube."
    assert pages["subtasks"]["suggestion"]


def test_tables_of_episodes_become_the_same_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dataset, tables = new_dataset(tmp_path / "set"), tmp_path / "arm-tables"
    (tmp_path / "by-tables").mkdir()
    assert run(["import", "lerobot", str(dataset), "--out", str(tables)]) == 0
    assert init(tmp_path / "by-tables/arm.yaml", tables / "episodes.csv") == 0
    made = (tmp_path / "by-tables/arm.yaml").read_text().replace("../arm-tables", "arm-tables")
    assert init(tmp_path / "arm.yaml", dataset) == 2  # the tables that are there stay
    assert f"--videos {tables / 'episodes.csv'}" in capsys.readouterr().err
    assert not (tmp_path / "arm.yaml").exists()
    shutil.rmtree(tables)
    assert init(tmp_path / "arm.yaml", dataset) == 0
    assert f"arm.yaml and {tables} for 3 videos" in capsys.readouterr().out
    assert (tmp_path / "arm.yaml").read_text() == made


def test_a_dataset_without_tasks_and_subtasks(tmp_path: Path) -> None:
    dataset = new_dataset(tmp_path / "set", language=False)
    assert run(["import", "lerobot", str(dataset), "--out", str(tmp_path / "tables")]) == 0
    (tmp_path / "tables/tasks.csv").unlink()
    file = tmp_path / "arm.yaml"
    assert init(file, tmp_path / "tables/episodes.csv") == 0
    study = read_study(file)
    assert sorted(study.tasks) == ["describe", "mark", "subtasks"]
    assert study.commands is None
    assert study.subtasks is None


def test_people_are_those_who_took_part(tmp_path: Path) -> None:
    """The dataset's tasks, which are in the study too, are nobody's work."""
    file = tmp_path / "arm.yaml"
    assert init(file, new_dataset(tmp_path / "set")) == 0
    with set_up(file) as app:
        person = Browser(app, study="arm")
        person.practise("mark")
        page = person.lease("mark", "arm").json
        body = {"success": "success", "quality": 4, **person.watched(page)}
        assert person.answer(page["item"], body).status_code == 200
        with reading(engine_of(app), one_state=True) as session:
            study = find_study(session, "arm")
            counts, people = collected(session, study.id), workers(session, study.id)
    assert (counts["commands"], counts["annotators"]) == (2, 1)
    assert [one.answers for one in people] == [1]


def test_other_tables_of_that_name_are_videos(tmp_path: Path) -> None:
    dataset = new_dataset(tmp_path / "set")
    video = next(dataset.rglob("*.mp4"))
    with (tmp_path / "episodes.csv").open("w", newline="") as table:
        csv.writer(table).writerows([["video", "episode"], [video, 1]])
    assert init(tmp_path / "arm.yaml", tmp_path / "episodes.csv") == 0
    assert sorted(read_study(tmp_path / "arm.yaml").tasks) == ["describe", "rate", "segment"]
