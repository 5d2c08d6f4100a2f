"""LeRobot's datasets, through a study with three people, into a copy that LeRobot reads."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow.compute as pc
import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.study_input import study_input
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_moments import answered, said
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import STUDY, cut, export, study_of
from tests.corpus_tools.lerobot.test_lerobot_itself import pytestmark as needs_lerobot
from tests.lerobot_itself import (
    FPS,
    LENGTHS,
    QUESTIONS,
    TASKS,
    read_dataset,
    write_dataset,
)

PEOPLE = 3
TASK = {"answers": PEOPLE, "practice": False}
STUDY_TASKS = {
    **dict.fromkeys(("describe", "subtasks", "rate"), TASK),
    **{key: {**TASK, "adoption": "majority"} for key in ("correct", "mark")},
    "moments": {**TASK, "styles": ["interjection", "vqa"]},
}
WRONG, RIGHT = 3, "Nudge."
"""An episode whose task two people correct, and what they write."""
ASKED = 4
"""The frame about which somebody asks."""
pytestmark = needs_lerobot


def without_the_last_episode(folder: Path) -> Path:
    """Take the last episode out of data and metadata; its part of the videos stays as a rest."""
    last = len(LENGTHS) - 1
    for file in [*folder.glob("data/*/*.parquet"), *folder.glob("meta/episodes/*/*.parquet")]:
        table = pq.read_table(file)
        kept = table.filter(pc.less(table["episode_index"], last))
        if len(kept):
            pq.write_table(kept, file)
        else:
            file.unlink()
    info = json.loads((folder / "meta/info.json").read_text())
    info |= {"total_episodes": last, "total_frames": sum(LENGTHS[:last])}
    info["splits"] = {"train": f"0:{last}"}
    (folder / "meta/info.json").write_text(json.dumps(info))
    return folder


def steps(frames: int) -> list[tuple[float, str]]:
    """The steps that two of the people set: the second and third are nearest to adjacent frames."""
    middle = frames // 2 / FPS
    return [(0.0, "reach"), (middle + 0.04, "take"), (middle + 0.06, "lift")]


def subtask_at(frame: int, frames: int) -> str:
    middle = frames // 2
    return "reach" if frame < middle else "take" if frame == middle else "lift"


def send(person: Browser, page: Any, body: dict[str, Any]) -> None:
    answered = person.answer(page["item"], body | person.watched(page))
    assert answered.status_code == 200, answered.text


def work(app: Any, lengths: list[int]) -> dict[int, list[str]]:
    """Three people do all tasks; return what they typed for the episodes, by number of frames."""
    texts: dict[int, list[str]] = defaultdict(list)
    for number in range(PEOPLE):
        person = Browser(app, study="robot")

        def frames(page: Any) -> int:
            return round(page["payload"]["duration_s"] * FPS)

        for _ in lengths:
            page = person.lease("describe", "robot").json
            text = f"Work for {frames(page)} frames, says {number}."
            texts[frames(page)].append(text)
            send(person, page, described(text))
        for _ in lengths:
            page = person.lease("subtasks", "robot").json
            n = frames(page)
            body = cut(*steps(n)) if number else cut((0.0, "wait"), ((n - 1) / FPS, "go"))
            send(person, page, body)
        for _ in lengths:
            page = person.lease("moments", "robot").json
            moments = [said("interjection", (number + 1) / FPS + 0.02, f"Wait, says {number}.")]
            if number == 0:
                moments.append(said("vqa", ASKED / FPS, "Is it far?", **answered("words", "no")))
            send(person, page, {"moments": moments, "played_to_end": True})
        verdicts = {LENGTHS[WRONG]: {"verdict": "wrong", "text": RIGHT}} if number else {}
        while (taken := person.lease("correct", "robot")).status_code == 200:
            send(person, taken.json, verdicts.get(frames(taken.json), {"verdict": "right"}))
        while (taken := person.lease("mark", "robot")).status_code == 200:
            send(person, taken.json, {"success": "success" if number else "failure", "quality": 4})
        while (taken := person.lease("rate", "robot")).status_code == 200:
            send(person, taken.json, {"rating": (5, 4, 1)[number]})
    return texts


@pytest.mark.parametrize("kind", ["videos", "vqa", "depth", "images", "deleted", "rest"])
def test_every_sentence_is_on_its_frame_and_nothing_else_changes(kind: str, tmp_path: Path):
    source = write_dataset(tmp_path / "set", "videos" if kind == "rest" else kind)
    if kind == "rest":
        without_the_last_episode(source)
    before = read_dataset(source)
    kept = {"deleted": (0, 2, 3, 4, 5), "rest": range(6)}.get(kind, range(7))
    lengths, tasks = [LENGTHS[e] for e in kept], [TASKS[e] for e in kept]
    study = study_of(tmp_path, source=source)
    study.write_text(json.dumps(STUDY | {"tasks": STUDY_TASKS}))
    with set_up(study) as app:
        texts = work(app, lengths)
    copy = export(tmp_path)
    after = read_dataset(copy)

    assert (after["episodes"], after["depth"]) == (len(lengths), before["depth"])
    assert after["marks"] == ["success"] * len(lengths)
    wrong = list(kept).index(WRONG)
    assert [row["tensors"].keys() for row in after["rows"]] == [
        row["tensors"].keys() for row in before["rows"]
    ]
    for old, new in zip(before["rows"], after["rows"], strict=True):
        episode, frame = new["episode"], new["frame"]
        had = tasks[episode]
        typed = texts[lengths[episode]]
        changed = {key for key, digest in new["tensors"].items() if digest != old["tensors"][key]}
        assert changed == (set() if had and episode != wrong else {"task_index"})
        assert new["task"] == (RIGHT if episode == wrong else had or typed[0])
        wordings = [row for row in new["persistent"] if row["style"] == "task_aug"]
        assert wordings[0]["content"] == new["task"]
        assert {row["content"] for row in wordings} == {new["task"], *typed}
        assert {row["timestamp"] for row in wordings} == {0.0}
        rendered = new["rendered"]
        assert rendered["task"] in {new["task"], *typed}
        assert rendered["subtask"] == subtask_at(frame, lengths[episode])
        assert rendered["plan"].startswith(f"1. {rendered['subtask']}")
        waits = f"Wait, says {frame - 1}." if 0 < frame <= PEOPLE else ""
        assert rendered["interjection"] == waits
        camera = QUESTIONS.get((episode, frame)) if kind == "vqa" else None
        asked = {name: text for name, text in rendered.items() if "_" in name and text}
        short = (camera or "").rsplit(".")[-1]
        expected = {f"question_{short}": "Where?", f"answer_{short}": "There."} if camera else {}
        if frame == ASKED:
            expected = {"question_top": "Is it far?", "answer_top": "no"}
        assert asked == expected
    verdicts = [json.loads(x) for x in (copy / "meta/verdicts.jsonl").read_text().splitlines()]
    agreed = {(v["episode_index"], v["content"]): v["agree"] for v in verdicts}
    for episode, task in enumerate(tasks):
        if task:
            assert agreed[episode, task] == pytest.approx(2 / 3)
    again = study_input(open_dataset(copy), tmp_path / "again", scratch=tmp_path / "films")
    assert again.rows["subtasks.csv"] == 3 * len(lengths)
    assert again.rows["tasks.csv"] == len(lengths)
