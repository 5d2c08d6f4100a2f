"""Texts at moments of episodes: from a LeRobot dataset to all styles of language in a copy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from annotation_app.dashboard.consensus import agreement
from annotation_app.store.database import reading
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import event_rows, persistent_rows
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export, study_of
from tests.lerobot_datasets import CAMERA, HEIGHT, WIDTH

EVERY = ["interjection", "vqa", "trace", "memory", "motion", "plan"]


def said(style: str, time_s: float, text: str = "Go on.", **more: Any) -> dict[str, Any]:
    return {"style": style, "time_s": time_s, "text": text, **more}


def answered(kind: str, *texts: str, shapes: Any = ()) -> dict[str, Any]:
    return {"answer": {"kind": kind, "texts": texts, "shapes": shapes}}


def sent(*moments: dict[str, Any]) -> dict[str, Any]:
    return {"moments": moments, "played_to_end": True, "watched_s": 1.2}


def moments_study(tmp_path: Path, answers: int = 1, styles: Any = EVERY) -> Path:
    tasks = {"moments": {"answers": answers, "practice": False, "styles": styles}}
    return study_of(tmp_path, tasks=tasks)


POINT = answered("point", "cube", shapes=[{"points": [[9.6, 3.2]]}])
BOXES = answered("boxes", shapes=[{"points": [[30, 20], [10, 5]], "label": "cube"}])
PATH = answered("path", shapes=[{"points": [[0, 0], [WIDTH, HEIGHT]]}])


def test_texts_of_several_people_get_into_a_copy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """Events of all are kept; of two on a frame that of the person who agrees with more others."""
    alone = sent(
        said("vqa", 0.3, "Is it far?", **answered("words", "no")),
        said("memory", 1.15, "I slept."),
        said("interjection", 0.0, "Begin.", reply="OK."),
    )
    agreed = sent(
        said("vqa", 0.31, "Where is it?", **POINT),
        said("trace", 0.6, "hand", **PATH),
        said("memory", 0.5, "I reached it."),
        said("motion", 0.0, "move left"),
        said("plan", 0.5, " 1. lift \n\n2. put "),
    )
    other = sent(
        said("vqa", 0.71, "What is there?", **BOXES),
        said("trace", 0.8, "hand", **PATH),
        said("memory", 0.6, "I am there."),
    )
    with set_up(moments_study(tmp_path, answers=3)) as app:
        for body in (alone, agreed, other):
            person = Browser(app, study="robot")
            for _ in range(3):
                page = person.lease("moments", "robot").json
                is_first = page["payload"]["duration_s"] > 1.1
                given = body if is_first else sent(said("interjection", 0.2))
                reply = person.answer(page["item"], given)
                assert reply.status_code == 200, reply.text
        with reading(engine_of(app)) as session:
            every = agreement(session, find_study(session, "robot").id)
            (measured,) = [one for one in every if one.task == "moments"]
            assert measured.measure == "moments within 0.5 s, F, mean over pairs"
            assert (measured.items, measured.reason) == (3, "few items")
    capsys.readouterr()
    copy = export(tmp_path)
    told = capsys.readouterr()
    assert "15 moments" in told.out
    assert "vqa 'Is it far?' isn't written: there is another one at 0.3 s" in told.err
    events = {(e, f): rows for e, f, rows in event_rows(open_dataset(copy)) if e == 0}
    contents = {
        frame: [(row["style"], row["role"], row["camera"], row["content"]) for row in rows]
        for (_, frame), rows in events.items()
    }
    line = '{"label": "hand", "point_format": "xy", "points": [[0, 0], [64, 48]]}'
    box = '{"detections": [{"bbox": [10, 5, 30, 20], "bbox_format": "xyxy", "label": "cube"}]}'
    point = '{"label": "cube", "point": [10, 3], "point_format": "xy"}'
    assert contents == {
        0: [(None, "assistant", None, None), ("interjection", "user", None, "Begin.")],
        1: [("vqa", "user", CAMERA, "where?")],  # the dataset's own
        3: [("vqa", "assistant", CAMERA, point), ("vqa", "user", CAMERA, "Where is it?")],
        6: [("trace", "assistant", CAMERA, line)],
        7: [("vqa", "assistant", CAMERA, box), ("vqa", "user", CAMERA, "What is there?")],
        8: [("trace", "assistant", CAMERA, line)],
    }
    (call,) = events[0, 0][0]["tool_calls"]
    assert call["function"] == {"name": "say", "arguments": {"text": "OK."}}
    rows = [
        (row["style"], round(row["timestamp"], 6), row["content"])
        for row in dict(persistent_rows(open_dataset(copy)))[0]
        if row["style"] != "subtask"
    ]
    assert rows == [
        ("motion", 0.0, "move left"), ("memory", 0.5, "I reached it."),
        ("plan", 0.5, "1. lift\n2. put"),
    ]  # fmt: skip
    lines = (copy / "meta/people.jsonl").read_text().splitlines()
    kept = [row for row in map(json.loads, lines) if row["episode_index"] == 0]
    memory = next(row for row in kept if row["style"] == "memory")
    assert (memory["answers"], memory["agreement"]) == (3, pytest.approx(0.5))
    vqa = {row["content"]: row for row in kept if row["style"] == "vqa"}
    assert (vqa["Where is it?"]["reply"], vqa["Where is it?"]["camera"]) == (point, CAMERA)
    assert vqa["Is it far?"]["timestamp"] is None
    assert {row["study"] for row in kept} == {"robot"}
    # The same for programs that don't read LeRobot's copies.
    call = ["annotate", "export", str(tmp_path / "said.jsonl"), "--format", "language"]
    assert run([*call, "--instance", str(tmp_path / "instance")]) == 0
    said_lines = map(json.loads, (tmp_path / "said.jsonl").read_text().splitlines())
    replies = {row["content"]: row.get("reply") for row in said_lines}
    assert (replies["Where is it?"], replies["Begin."], replies["hand"]) == (point, "OK.", line)


def test_what_breaks_a_rule_is_refused_in_plain_words(tmp_path: Path):
    outside = answered("point", "cube", shapes=[{"points": [[WIDTH + 1, 3]]}])
    unnamed = answered("boxes", shapes=[{"points": [[0, 0], [9, 9]]}])
    with set_up(moments_study(tmp_path, styles=["vqa", "trace", "memory"])) as app:
        person = Browser(app, study="robot")
        item = person.lease("moments", "robot").json["item"]
        for moments, message in (
            ((), "Write at least one text."),
            ((said("memory", 0.1, "…"),), "Type a text at number 1."),
            ((said("vqa", 0.1),), "Answer the question at number 1."),
            ((said("vqa", 0.1, **answered("words", " ")),), "Answer the question at number 1."),
            ((said("vqa", 0.1, **answered("count", "cube", "a few")),), "as a whole number"),
            ((said("vqa", 0.1, **answered("point", "cube")),), "Draw in the picture at number 1."),
            ((said("vqa", 0.1, **unnamed),), "Name each box at number 1."),
            ((said("vqa", 0.1, **outside),), "drawn at number 1 is outside of the picture"),
            ((said("trace", 0.1, **answered("words", "yes")),), "Number 1 doesn't fit here."),
            ((said("memory", 0.1, **POINT),), "Number 1 doesn't fit here."),
            ((said("motion", 0.1),), "Number 1 doesn't fit here."),  # not asked for
            ((said("memory", 9.0),), "Number 1 is after the video's end."),
            ((said("memory", 0.1, "x" * 501),), "at most 500 characters"),
            ((said("memory", 0.1), said("memory", 0.13)), "Numbers 1 and 2 are of one kind"),
        ):
            refused = person.answer(item, sent(*moments))
            assert refused.status_code == 422
            assert message in " ".join(p["message"] for p in refused.json["problems"])
        unknown = person.answer(item, sent(said("poem", 0.1)))
        assert unknown.status_code == 422
        good = person.answer(item, sent(said("memory", 0.1), said("vqa", 0.1, **POINT)))
        assert good.status_code == 200


def test_a_study_chooses_styles_and_words_their_prompts(tmp_path: Path):
    prompts = {"vqa": "Ask about <colours>.", "memory": None}
    with set_up(moments_study(tmp_path, styles=prompts)) as app:
        page = Browser(app, study="robot").client.get("/s/robot/moments").text
    assert "Ask about &lt;colours&gt;." in page
    assert "What has the robot done so far?" in page
    assert 'data-style="interjection"' not in page


def test_styles_that_are_unknown_are_named_with_their_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "robot.yaml"
    study = {"name": "robot", "title": "Robot", "tasks": {"rate": {}, "moments": {}}}
    study["tasks"]["rate"]["styles"] = ["vqa"]
    study["tasks"]["moments"]["styles"] = {"poem": "Rhyme."}
    file.write_text(json.dumps(study))
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 2
    told = capsys.readouterr().err
    assert "there is no style poem" in told
    assert "use interjection, vqa, trace, memory, motion, plan" in told
    assert "this task has no styles" in told
