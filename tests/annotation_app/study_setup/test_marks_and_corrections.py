"""Marks and corrected tasks of robot episodes: from scripted people to the copy of the dataset."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

import pyarrow.parquet as pq
from flask import Flask
from sqlalchemy import select

from annotation_app.dashboard.consensus import agreement
from annotation_app.store.database import reading
from annotation_app.store.models import Answer, Item
from annotation_app.tasks.agreement import figures
from annotation_app.tasks.mark import MARK
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from tests.annotation_app.browser import Browser, engine_of, exported, rows_in
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export, study_of

DROPS, HITS = "Something falls", "It hits something"
MARKING: dict[str, Any] = {
    "commands": None,
    "reasons": [DROPS, HITS],
    "tasks": {"mark": {"answers": 3, "adoption": "majority", "practice": False}},
}
CORRECTING: dict[str, Any] = {
    "tasks": {"correct": {"answers": 3, "adoption": "majority", "practice": False}}
}
INDEX = "meta/episodes/chunk-000/file-000.parquet"


def study(tmp_path: Path, settings: dict[str, Any]) -> Path:
    file = study_of(tmp_path)
    kept = {k: v for k, v in (json.loads(file.read_text()) | settings).items() if v is not None}
    file.write_text(json.dumps(kept))
    return file


def marked(success: str, quality: int, *reasons: str, **more: Any) -> dict[str, Any]:
    return {"success": success, "quality": quality, "reasons": reasons, "watched_s": 1.2, **more}


def judged(verdict: str, text: str = "") -> dict[str, Any]:
    return {"verdict": verdict, "text": text, "watched_s": 1.2}


def number_of(page: dict[str, Any]) -> int:
    """The number of the episode on a page, by its length."""
    return {1.2: 0, 0.8: 1, 1.0: 2}[round(page["payload"]["duration_s"], 1)]


def answer_all(app: Flask, task: str, *people: dict[int, dict[str, Any]]) -> None:
    """Have people answer the episodes that they have answers to."""
    for bodies in people:
        person = Browser(app, study="robot")
        while (taken := person.lease(task, "robot")).status_code == 200:
            page = taken.json
            sent = person.answer(page["item"], bodies[number_of(page)])
            assert sent.status_code == 200, sent.text


def lines(file: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in file.read_text().splitlines()]


PEOPLE = (
    {
        0: marked("failure", 1, DROPS, moment_s=0.4, note="It slips."),
        1: marked("success", 5),
        2: marked("success", 4),
    },
    {
        0: marked("failure", 2, DROPS, HITS, moment_s=0.6),
        1: marked("success", 4),
        2: marked("partly", 3),
    },
    {0: marked("success", 4), 1: marked("success", 2, HITS), 2: marked("failure", 1)},
)


def test_marks_of_three_people(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with set_up(study(tmp_path, MARKING)) as app:
        answer_all(app, "mark", *PEOPLE)
        table = list(csv.DictReader(io.StringIO(exported(app, "marks.csv", "robot").decode())))
        with reading(engine_of(app)) as session:
            measures = {
                one.measure: one for one in agreement(session, find_study(session, "robot").id)
            }
    capsys.readouterr()
    copy = export(tmp_path)
    out = capsys.readouterr()
    assert "3 episodes, 3 marked, 1 to delete" in out.out
    rows = pq.read_table(copy / INDEX).to_pylist()
    marks = [{k: v for k, v in row.items() if k.startswith("marks/")} for row in rows]
    assert marks[0] == {
        "marks/success": "failure", "marks/quality": 2.0, "marks/reasons": [DROPS, HITS],
        "marks/moment_s": pytest.approx(0.5), "marks/people": 3,
        "marks/agree": pytest.approx(2 / 3),
    }  # fmt: skip
    assert (marks[1]["marks/success"], marks[1]["marks/reasons"]) == ("success", [])
    assert (marks[2]["marks/success"], marks[2]["marks/agree"]) == (None, pytest.approx(1 / 3))
    # Nothing else of the dataset is another, and nothing is deleted.
    before = {
        f: (tmp_path / "set" / f).read_bytes() for f in ("meta/info.json", "meta/tasks.parquet")
    }
    assert all((copy / name).read_bytes() == content for name, content in before.items())
    data = "data/chunk-000/file-000.parquet"
    assert (copy / data).read_bytes() == (tmp_path / "set" / data).read_bytes()
    listed = json.loads((copy / "meta/delete_episodes.json").read_text())
    assert listed == {"operation": {"type": "delete_episodes", "episode_indices": [0]}}
    assert "lerobot-edit-dataset --config_path=" in out.err
    given = lines(copy / "meta/marks.jsonl")
    assert [row["episode_index"] for row in given] == [0, 1, 2]
    assert given[0]["given"][0]["note"] == "It slips."
    assert len({one["subject"] for one in given[0]["given"]}) == 3
    call = ["annotate", "export", str(tmp_path / "said.jsonl"), "--format", "language"]
    assert run([*call, "--instance", str(tmp_path / "instance")]) == 0
    assert lines(tmp_path / "said.jsonl") == given
    report = json.loads((copy / "meta/people_report.json").read_text())
    assert report["collected"]["mark_success"] == {"success": 5, "partly": 1, "failure": 3}
    assert report["collected"]["mark_reasons"] == {DROPS: 2, HITS: 2}
    found = {row["measure"]: row for row in report["agreement"]}
    assert found.keys() == {name for name, one in measures.items() if one.items}
    assert found["success: Krippendorff's α, nominal"]["reason"] == "few items"
    assert [row["reasons"] for row in table] == [f"{DROPS}; {HITS}", "", ""]


def test_agreement_on_success_is_corrected_for_chance() -> None:
    items = [
        [{"success": one, "quality": 4}, {"success": other, "quality": 5}]
        for one, other in (("success", "success"), ("failure", "failure"), ("partly", "success"))
    ]
    units = [[measure.units(bodies) for measure in MARK.agreement] for bodies in items]
    found = {one.measure: one.value for one in figures(MARK.agreement, units)}
    assert found["success: share of pairs that agree"] == pytest.approx(2 / 3)
    assert found["success: Fleiss' κ"] == pytest.approx((2 / 3 - 7 / 18) / (1 - 7 / 18))
    assert found["quality: share of pairs that agree"] == 0


def test_thresholds_lengthen_the_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with set_up(study(tmp_path, MARKING)) as app:
        partly = {0: marked("partly", 3), 1: marked("success", 2), 2: marked("success", 4)}
        answer_all(app, "mark", partly, partly, partly)

    def listed(*options: str) -> list[int]:
        file = export(tmp_path, *options) / "meta/delete_episodes.json"
        found = json.loads(file.read_text()) if file.exists() else None
        return found["operation"]["episode_indices"] if found else []

    assert listed() == []
    assert listed("--keep-from", "success") == [0]
    assert listed("--keep-from", "2.5") == [1]
    assert listed("--keep-from", "success", "--keep-from", "5") == [0, 1, 2]
    call = ["annotate", "export", str(tmp_path / "x"), "--instance", str(tmp_path / "instance")]
    for least in ("6", "perfect", "", "0.5"):
        assert run([*call, "--format", "lerobot", "--keep-from", least]) == 2
        assert "no threshold" in capsys.readouterr().err
    assert run([*call, "--keep-from", "success"]) == 2
    assert "only lerobot" in capsys.readouterr().err


def test_marks_that_cannot_be(tmp_path: Path) -> None:
    with set_up(study(tmp_path, MARKING)) as app:
        person = Browser(app, study="robot")
        page = person.lease("mark", "robot").json
        assert page["payload"]["command"] in ("Push the cube.", "")
        for body, message in (
            (marked("well", 3), "can't be read"),
            (marked("success", 6), "can't be read"),
            (marked("failure", 1, "Other"), "reasons have changed"),
            (marked("failure", 1, moment_s=9), "after the video"),
            (marked("failure", 1, note="x" * 2001), "2000 characters"),
            (marked("failure", 1) | {"watched_s": 0.0}, "Watch the video"),
        ):
            refused = person.answer(page["item"], body)
            assert (refused.status_code, message in refused.text) == (422, True), refused.text
        assert person.answer(page["item"], marked("failure", 1, HITS, HITS)).status_code == 200
        (answer,) = rows_in(app, select(Answer))
        assert answer.body["reasons"] == [HITS]


def test_no_two_keys_of_the_page_are_the_same(tmp_path: Path) -> None:
    reasons = [f"Reason {number}" for number in range(20)]
    with set_up(study(tmp_path, {**MARKING, "reasons": reasons})) as app:
        page = Browser(app, study="robot").client.get("/practice/mark?study=robot").text
    keys = re.findall(r'data-press="(\w)"', page)
    players = ["K", "V", "M"]
    assert len({*keys, *players}) == len([*keys, *players]) == 3 + 5 + 20 + 3


def test_an_adjudicator_decides_on_marks(tmp_path: Path) -> None:
    with set_up(study(tmp_path, MARKING)) as app:
        answer_all(app, "mark", *PEOPLE)
        judge = signed_in(app, "grace", "adjudicator")
        queue = judge.client.get("/dashboard/robot/queue").text
        assert "episode-000002" in queue
        (item,) = rows_in(
            app, select(Item).where(Item.task == "mark", Item.video == "episode-000002")
        )
        page = judge.client.get(f"/dashboard/robot/queue/{item.id}").text
        assert "Quality" in page
        assert "4 of 5" in page
        sent = judge.adjudicate(item.id, marked("partly", 3, DROPS, moment_s=0.2))
        assert sent.status_code == 200, sent.text
    row = pq.read_table(export(tmp_path) / INDEX).to_pylist()[2]
    assert (row["marks/success"], row["marks/quality"], row["marks/reasons"]) == (
        "partly",
        3.0,
        [DROPS],
    )
    assert (row["marks/people"], row["marks/agree"]) == (3, pytest.approx(1 / 3))


LIFT = "Lift the cube."


def test_tasks_on_which_people_agree_are_corrected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with set_up(study(tmp_path, CORRECTING)) as app:
        assert {row.video for row in rows_in(app, select(Item).where(Item.task == "correct"))} == {
            "episode-000000", "episode-000001",
        }  # fmt: skip
        answer_all(
            app,
            "correct",
            {0: judged("wrong", "lift the  cube"), 1: judged("right")},
            {0: judged("right"), 1: judged("right", "dropped")},
            {0: judged("wrong", LIFT), 1: judged("wrong", "Wave.")},
        )
    capsys.readouterr()
    copy = export(tmp_path)
    assert "2 tasks judged, 1 corrected" in capsys.readouterr().out
    tasks = [episode.tasks for episode in open_dataset(copy).episodes()]
    assert tasks == [(LIFT,), ("Push the cube.",), ()]
    frames = pq.read_table(copy / "data/chunk-000/file-000.parquet").to_pylist()
    assert {(row["episode_index"], row["task_index"]) for row in frames} == {(0, 2), (1, 0), (2, 1)}
    first, second = lines(copy / "meta/task_corrections.jsonl")
    assert (first["task_was"], first["task"], first["decision"]) == (
        "Push the cube.",
        LIFT,
        "wrong",
    )
    assert first["votes"] == {"right": 1, "wrong": 2, "unclear": 0}
    assert first["agree"] == pytest.approx(2 / 3)
    assert [one["text"] for one in first["given"]] == ["lift the cube", "", LIFT]
    assert (second["task"], second["decision"]) == ("Push the cube.", "right")
    report = json.loads((copy / "meta/people_report.json").read_text())
    assert report["collected"]["tasks_corrected"] == 1


def test_different_new_texts_await_an_adjudicator(tmp_path: Path) -> None:
    with set_up(study(tmp_path, CORRECTING)) as app:
        right = judged("right")
        answer_all(
            app,
            "correct",
            {0: judged("wrong", "Nod."), 1: right},
            {0: judged("wrong", "Wave."), 1: right},
            {0: judged("unclear"), 1: right},
        )
        assert next(episode.tasks for episode in open_dataset(export(tmp_path)).episodes()) == (
            "Push the cube.",
        )
        (row, _) = lines(tmp_path / "copy/meta/task_corrections.jsonl")
        assert (row["decision"], row["task"]) == (None, "Push the cube.")
        judge = signed_in(app, "grace", "adjudicator")
        (item,) = rows_in(
            app, select(Item).where(Item.task == "correct", Item.video == "episode-000000")
        )
        assert "New text" in judge.client.get(f"/dashboard/robot/queue/{item.id}").text
        assert judge.adjudicate(item.id, judged("wrong", LIFT)).status_code == 200
    assert next(e.tasks for e in open_dataset(export(tmp_path)).episodes()) == (LIFT,)


def test_corrections_that_cannot_be(tmp_path: Path) -> None:
    with set_up(study(tmp_path, CORRECTING)) as app:
        person = Browser(app, study="robot")
        item = person.lease("correct", "robot").json["item"]
        for body, message in (
            (judged("wrong"), "Type what the task should be"),
            (judged("wrong", "push  THE cube"), "the same task"),
            (judged("wrong", "x" * 2001), "2001 characters"),
            (judged("perhaps"), "can't be read"),
            (judged("right") | {"watched_s": 0.0}, "Watch the video"),
        ):
            refused = person.answer(item, body)
            assert (refused.status_code, message in refused.text) == (422, True), refused.text
        assert person.answer(item, judged("unclear", "no matter")).status_code == 200
        (answer,) = rows_in(app, select(Answer).where(Answer.task == "correct"))
        assert answer.body["text"] == ""


def test_texts_about_parts_of_episodes_are_no_tasks(tmp_path: Path) -> None:
    tables = dict.fromkeys(("videos", "commands"), "tables/subtasks.csv")
    with set_up(study(tmp_path, {**tables, **CORRECTING})) as app:
        assert rows_in(app, select(Item).where(Item.task == "correct")) == []


def test_descriptions_by_people_are_not_corrected(tmp_path: Path) -> None:
    tasks = {**CORRECTING["tasks"], "describe": {"answers": 1, "practice": False}}
    with set_up(study(tmp_path, {"tasks": tasks})) as app:
        person = Browser(app, study="robot")
        page = person.lease("describe", "robot").json
        body = {"text": "Take it.", "played_to_end": True, "watched_s": 1.2}
        assert person.answer(page["item"], body).status_code == 200
        assert len(rows_in(app, select(Item).where(Item.task == "correct"))) == 2
