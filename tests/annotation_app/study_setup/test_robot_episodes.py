"""Robot episodes: from a LeRobot dataset to people's language in a copy of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import persistent_rows
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.lerobot_datasets import CAMERA, new_dataset

STUDY = {
    "name": "robot",
    "title": "Robot",
    "videos": "tables/episodes.csv",
    "commands": "tables/tasks.csv",
    "tasks": {
        "describe": {"answers": 1, "practice": False},
        "subtasks": {"answers": 3, "practice": False},
        "rate": {"answers": 2, "practice": False},
    },
}


def cut(*steps: tuple[float, str]) -> dict[str, Any]:
    return {
        "subtasks": [{"start_s": start, "text": text} for start, text in steps],
        "played_to_end": True,
        "watched_s": 1.2,
    }


def study_of(tmp_path: Path, source: Path | None = None, **changes: Any) -> Path:
    camera = [] if source else ["--camera", CAMERA]
    call = ["import", "lerobot", str(source or new_dataset(tmp_path / "set")), *camera]
    assert run([*call, "--out", str(tmp_path / "tables")]) == 0
    file = tmp_path / "robot.yaml"
    file.write_text(json.dumps(STUDY | changes))
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 0
    return file


def export(tmp_path: Path, *more: str) -> Path:
    call = ["annotate", "export", str(tmp_path / "copy"), "--format", "lerobot", "--force"]
    assert run([*call, "--instance", str(tmp_path / "instance"), *more]) == 0
    return tmp_path / "copy"


def test_people_describe_cut_and_rate_episodes(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    with set_up(study_of(tmp_path)) as app:
        texts: dict[float, str] = {}
        worker = Browser(app, study="robot")
        for _ in range(3):
            page = worker.lease("describe", "robot").json
            duration = page["payload"]["duration_s"]
            texts[duration] = f"Work for {duration:.1f} seconds."
            with worker.client.get(f"/media/{page['payload']['video']}") as video:
                assert (video.status_code, video.mimetype) == (200, "video/mp4")
            assert worker.answer(page["item"], described(texts[duration])).status_code == 200
        assert sorted(texts) == pytest.approx([0.8, 1.0, 1.2])
        # Two agree when the second step begins, the third doesn't.
        for second, word in ((0.3, "take"), (0.5, "lift"), (1.15, "drop")):
            person = Browser(app, study="robot")
            for _ in range(3):
                page = person.lease("subtasks", "robot").json
                whole = page["payload"]["duration_s"] > 1.1
                steps = [(0.0, "reach"), (second, word)] if whole else [(0.0, "push")]
                assert person.answer(page["item"], cut(*steps)).status_code == 200
        for rating in (5, 2):
            rater = Browser(app, study="robot")
            while (taken := rater.lease("rate", "robot")).status_code == 200:
                body = {"rating": rating, "watched_s": 1.2}
                assert rater.answer(taken.json["item"], body).status_code == 200
    capsys.readouterr()
    copy = export(tmp_path)
    assert "3 episodes, 3 wordings, 4 steps" in capsys.readouterr().out
    found = dict(persistent_rows(open_dataset(copy)))
    # The answer of the person in the middle agrees best with the two others.
    steps = [(r["timestamp"], r["content"]) for r in found[0] if r["style"] == "subtask"]
    assert steps == [(0.0, "reach"), (pytest.approx(0.3), "take")]
    plan = [r["content"] for r in found[0] if r["style"] == "plan"]
    assert plan == ["1. reach\n2. take", "1. take"]
    assert [r["content"] for r in found[0] if r["style"] == "memory"] == ["it was near"]
    wordings = {
        index: [r["content"] for r in rows if r["style"] == "task_aug"]
        for index, rows in found.items()
    }
    # LeRobot takes the task from these rows, so the dataset's own task is the first of them.
    assert {index: rows[0] for index, rows in wordings.items()} == {
        0: "Push the cube.", 1: "Push the cube.", 2: texts[max(d for d in texts if d < 1.1)],
    }  # fmt: skip
    every = {row for rows in wordings.values() for row in rows}
    assert every == {"Push the cube.", *texts.values()}
    # The episode that had no task has what somebody typed for it, the others keep theirs.
    tasks = [episode.tasks for episode in open_dataset(copy).episodes()]
    assert tasks == [
        ("Push the cube.",),
        ("Push the cube.",),
        (texts[max(d for d in texts if d < 1.1)],),
    ]
    lines = (copy / "meta/people.jsonl").read_text().splitlines()
    provenance = [json.loads(line) for line in lines]
    cuts = [row for row in provenance if row["style"] == "subtask" and row["episode_index"] == 0]
    assert {row["answers"] for row in cuts} == {3}
    assert [(row["start_s"], row["timestamp"]) for row in cuts] == [
        (0.0, 0.0), (0.3, pytest.approx(0.3)),
    ]  # fmt: skip
    assert cuts[0]["agreement"] == pytest.approx(0.5)
    assert all(len(row["subject"]) == 12 or row["subject"] for row in provenance)
    verdicts = [
        json.loads(line) for line in (copy / "meta/verdicts.jsonl").read_text().splitlines()
    ]
    given = [v for v in verdicts if v["content"] == "Push the cube."]
    assert [v["episode_index"] for v in given] == [0, 1]
    for verdict in given:
        assert (verdict["style"], verdict["agree"]) == ("task", 0.5)
        low, high = verdict["agree_95"]
        assert low == pytest.approx(0.0945, abs=1e-3)  # Wilson, 1 of 2
        assert high == pytest.approx(0.9055, abs=1e-3)


def test_marks_that_have_no_frame_of_their_own_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """Two steps near one frame are on two; one after the end is kept where it can be read."""
    with set_up(study_of(tmp_path)) as app:
        person = Browser(app, study="robot")
        for _ in range(3):
            page = person.lease("subtasks", "robot").json
            is_first = page["payload"]["duration_s"] > 1.1
            steps = ((0.0, "reach"), (0.51, "take"), (0.53, "lift"), (1.4, "late"))
            answer = cut(*steps) if is_first else cut((0.0, "push"))
            assert person.answer(page["item"], answer).status_code == 200
    capsys.readouterr()
    copy = export(tmp_path)
    notes = capsys.readouterr().err
    assert "episode 0: subtask 'lift' 0.53 s is written at 0.6 s" in notes
    assert "episode 0: subtask 'late' isn't written: 1.4 s is outside" in notes
    rows = dict(persistent_rows(open_dataset(copy)))[0]
    found = [(r["timestamp"], r["content"]) for r in rows if r["style"] == "subtask"]
    assert found == [(0.0, "reach"), (0.5, "take"), (pytest.approx(0.6), "lift")]
    provenance = [
        json.loads(line) for line in (copy / "meta/people.jsonl").read_text().splitlines()
    ]
    assert ("late", 1.4, None) in [
        (row["content"], row["start_s"], row["timestamp"]) for row in provenance
    ]


def test_a_models_subtasks_get_verdicts(tmp_path: Path):
    file = study_of(
        tmp_path,
        videos="tables/subtasks.csv",
        commands="tables/subtasks.csv",
        tasks={"rate": {"answers": 1, "practice": False}},
    )
    with set_up(file) as app:
        rater = Browser(app, study="robot")
        durations: dict[str, set[float]] = {}
        while (taken := rater.lease("rate", "robot")).status_code == 200:
            page = taken.json
            payload = page["payload"]
            durations.setdefault(payload["command"], set()).add(payload["duration_s"])
            assert rater.answer(page["item"], {"rating": 4, "watched_s": 1.2}).status_code == 200
    assert set(durations) == {"reach", "grasp", "push"}
    assert any(d == pytest.approx(0.7) for d in durations["grasp"])
    copy = export(tmp_path)
    lines = (copy / "meta/verdicts.jsonl").read_text().splitlines()
    verdicts = {v["content"]: v for v in map(json.loads, lines)}
    assert (verdicts["grasp"]["episode_index"], verdicts["grasp"]["timestamp"]) == (0, 0.5)
    assert verdicts["push"]["episode_index"] == 1
    assert {v["style"] for v in verdicts.values()} == {"subtask"}
    assert verdicts["reach"]["ratings"] == [4]
    # What the model wrote stays: nobody has cut the episodes.
    before = dict(persistent_rows(open_dataset(tmp_path / "set")))
    assert dict(persistent_rows(open_dataset(copy))) == before


def test_steps_of_a_part_are_none_of_the_episode(tmp_path: Path):
    """Their times begin with the part, and the rest of the episode isn't cut."""
    tasks = {"subtasks": {"answers": 1, "practice": False}}
    file = study_of(tmp_path, videos="tables/subtasks.csv", commands=None, tasks=tasks)
    with set_up(file) as app:
        person = Browser(app, study="robot")
        for _ in range(3):
            item = person.lease("subtasks", "robot").json["item"]
            assert person.answer(item, cut((0, "wait"))).status_code == 200
    before = dict(persistent_rows(open_dataset(tmp_path / "set")))
    assert dict(persistent_rows(open_dataset(export(tmp_path)))) == before


def test_answers_that_are_no_steps(tmp_path: Path):
    with set_up(study_of(tmp_path)) as app:
        person = Browser(app, study="robot")
        item = person.lease("subtasks", "robot").json["item"]
        for body, message in (
            (cut(), "at least one step"),
            (cut((0.2, "reach")), "begins with the video"),
            (cut((0, "reach"), (0.4, " ")), "done in step 2"),
            (cut((0, "reach"), (0.4, "a"), (0.4, "b")), "Step 3 must begin after"),
            (cut((0, "reach"), (60, "a")), "after the video's end"),
            (cut((0, "x" * 301)), "at most 300"),
            (cut((0, "reach")) | {"watched_s": 0.0}, "Watch the video"),
        ):
            refused = person.answer(item, body)
            assert refused.status_code == 422
            assert message in refused.text
        assert person.answer(item, cut((0, "reach"))).status_code == 200


def test_other_studies_are_no_datasets(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = study_of(tmp_path)
    with set_up(file):
        pass
    call = ["annotate", "export", str(tmp_path / "out"), "--format", "csv"]
    instance = ["--instance", str(tmp_path / "instance")]
    assert run([*call, "--episodes", str(tmp_path / "set"), *instance]) == 2
    assert "only lerobot, rlds, robomimic and rosbag take episodes" in capsys.readouterr().err
    (tmp_path / "set").rename(tmp_path / "moved")
    call = ["annotate", "export", str(tmp_path / "copy"), "--format", "lerobot"]
    assert run([*call, *instance]) == 2
    assert "no LeRobot dataset" in capsys.readouterr().err
    assert export(tmp_path, "--episodes", str(tmp_path / "moved")).is_dir()
