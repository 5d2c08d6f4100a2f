"""A model's steps: proposed to people, corrected by them, and counted against the model."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import pytest
from flask import Flask

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import persistent_rows
from tests.annotation_app.browser import Browser, exported
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import cut, export, study_of
from tests.lerobot_datasets import film

TASKS = {"subtasks": {"answers": 2, "practice": False}}
SECONDS, FPS = 4.0, 10
RIGHT = ((0.0, "reach for the cup"), (1.0, "grasp the cup"), (3.0, "lift the cup"))
"""What a person sees in every film."""


def proposed(page: dict[str, Any]) -> list[tuple[float, str]]:
    steps = page["payload"]["suggestion"]
    return [(step["start_s"], step["text"]) for step in steps or ()]


def study_with(tmp_path: Path, rows: str, films: int = 1, **changes: Any) -> Path:
    """A study of films of four seconds with a table of proposed steps."""
    for number in range(films):
        greys = [20 + 2 * number + i for i in range(int(SECONDS * FPS))]
        film(tmp_path / f"films/clip{number:02d}.mp4", greys)
    (tmp_path / "steps.csv").write_text(rows)
    study = {
        "name": "robot", "title": "Robot", "videos": "films", "subtasks": "steps.csv",
        "tasks": TASKS,
    }  # fmt: skip
    file = tmp_path / "robot.yaml"
    file.write_text(json.dumps({k: v for k, v in (study | changes).items() if v is not None}))
    return file


def send(person: Browser, page: dict[str, Any], *steps: tuple[float, str], **more: Any) -> None:
    answer = cut(*steps) | person.watched(page) | more
    sent = person.answer(page["item"], answer)
    assert sent.status_code == 200, sent.text


def fates(app: Flask) -> list[tuple[str, str, str]]:
    table = csv.DictReader(io.StringIO(exported(app, "proposed-steps.csv", "robot").decode()))
    return [(row["proposed"], row["state"], row["decided"]) for row in table]


def test_the_datasets_own_steps_are_corrected_and_written_back(tmp_path: Path) -> None:
    """Of "reach" at 0 s and "grasp" at 0.5 s one is accepted, and one is moved and reworded."""
    tables = {"subtasks": "tables/subtasks.csv", "commands": "tables/tasks.csv"}
    file = study_of(tmp_path, tasks={"subtasks": {"answers": 1, "practice": False}}, **tables)
    with set_up(file) as app:
        person = Browser(app, study="robot")
        seen = {}
        for _ in range(3):
            page = person.lease("subtasks", "robot").json
            steps = proposed(page)
            seen[round(page["payload"]["duration_s"], 1)] = steps
            if len(steps) == 2:
                send(person, page, steps[0], (0.7, "grasp the cube"), decided=[0])
            else:
                send(person, page, *(steps or [(0.0, "rest")]))
        assert seen == {1.2: [(0.0, "reach"), (0.5, "grasp")], 0.8: [(0.0, "push")], 1.0: []}
        assert sorted(fates(app)) == [
            ("grasp", "text changed, boundary moved", "True"),
            ("push", "unchanged", "False"),
            ("reach", "unchanged", "True"),
        ]
    copy = export(tmp_path)
    found = dict(persistent_rows(open_dataset(copy)))
    steps = [(r["timestamp"], r["content"]) for r in found[0] if r["style"] == "subtask"]
    assert steps == [(0.0, "reach"), (pytest.approx(0.7), "grasp the cube")]
    lines = (copy / "meta/people.jsonl").read_text().splitlines()
    became = {
        row["content"]: (row.get("model"), row.get("became"))
        for row in map(json.loads, lines)
        if row["style"] == "subtask"
    }
    assert became == {
        "reach": ("dataset", "unchanged"),
        "grasp the cube": ("dataset", "text changed, boundary moved"),
        "push": ("dataset", "unchanged"),
        "rest": (None, None),
    }


def test_steps_of_another_copy_are_timed_by_the_episode(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A model's own copy has other files; rows of episodes that aren't shown are named."""
    rows = "video,start_s,command,episode,timestamp\nother.mp4,7.3,grasp,0,0.3\nother.mp4,0,x,9,0\n"
    (tmp_path / "copy.csv").write_text(rows)
    file = study_of(tmp_path, tasks=TASKS, commands="tables/tasks.csv", subtasks={"m": "copy.csv"})
    assert "steps of episodes that the study doesn't show" in capsys.readouterr().err
    with set_up(file) as app:
        person = Browser(app, study="robot")
        seen = []
        for _ in range(3):
            page = person.lease("subtasks", "robot").json
            seen += proposed(page)
            send(person, page, (0.0, "rest"))
    assert seen == [(0.0, "grasp")]  # the first step begins with the video


def test_models_take_turns_over_episodes(tmp_path: Path) -> None:
    rows = "video,start_s,command,model\n" + "".join(
        f"clip{n:02d},0,{model} says,{model}\n" for n in range(12) for model in ("a", "b", "c")
    )
    tasks = {"subtasks": {"answers": 1, "practice": False}}
    with set_up(study_with(tmp_path, rows, 12, tasks=tasks)) as app:
        person = Browser(app, study="robot")
        seen = set()
        for _ in range(12):
            page = person.lease("subtasks", "robot").json
            seen |= {text for _, text in proposed(page)}
            send(person, page, *RIGHT)
    # Which comes first is drawn for each episode: one of three may never come, hardly two.
    assert 1 < len(seen & {"a says", "b says", "c says"}) == len(seen)


def test_what_became_of_steps_is_found_by_the_server(tmp_path: Path) -> None:
    """Whatever a page says that it accepted, the steps themselves are compared."""
    rows = "video,start_s,command\n" + "".join(
        f"clip00,{start},{text}\n"
        for start, text in ((0.5, "reach"), (1.0, "grasp"), (1.0, "hold"), (2.0, "lift"), (9, "x"))
    )
    with set_up(study_with(tmp_path, rows)) as app:
        person = Browser(app, study="robot")
        page = person.lease("subtasks", "robot").json
        # The first begins with the video, no two on one frame, none after the end.
        assert proposed(page) == [(0.0, "reach"), (1.0, "grasp"), (1.1, "hold"), (2.0, "lift")]
        send(
            person, page, (0.0, "reach"), (1.0, "take hold"), (2.5, "lift"), (3.0, "turn over"),
            decided=[0, 1, 2, 3, 77],
        )  # fmt: skip
        table = exported(app, "proposed-steps.csv", "robot").decode()
        rows_ = list(csv.DictReader(io.StringIO(table)))
    assert [(r["proposed"], r["state"], r["moved_s"]) for r in rows_] == [
        ("reach", "unchanged", ""),
        ("grasp", "removed", ""),
        ("hold", "text changed, boundary moved", "-0.1"),
        ("lift", "boundary moved", "0.5"),
        ("", "added", ""),
    ]
    assert rows_[-1]["text"] == "turn over"


def test_models_are_compared_by_their_errors(tmp_path: Path) -> None:
    """The one has a wrong text in each of 12 films; the other a late step, and one too many."""
    films = 12
    wrong = {
        "words": ((0.0, "reach for the cup"), (1.0, "grasp the cap"), (3.0, "lift the cup")),
        "times": (
            (0.0, "reach for the cup"), (1.5, "grasp the cup"), (3.0, "lift the cup"),
            (3.6, "paint it blue"),
        ),
    }  # fmt: skip
    tables = {}
    for model, steps in wrong.items():
        lines = (f"clip{n:02d},{start},{text}\n" for n in range(films) for start, text in steps)
        (tmp_path / f"{model}.csv").write_text("video,start_s,command\n" + "".join(lines))
        tables[model] = f"{model}.csv"
    tasks = {"subtasks": {"answers": 4, "practice": False, "suggestions": "half"}}
    file = study_with(tmp_path, "", films, subtasks=tables, tasks=tasks)
    with set_up(file) as app:
        for _ in range(4):
            person = Browser(app, study="robot")
            for _ in range(films):
                page = person.lease("subtasks", "robot").json
                send(person, page, *RIGHT, decided=[0, 1, 2])
        found = json.loads(exported(app, "model-errors.json", "robot"))["models"]
        (tmp_path / "proposed.csv").write_bytes(exported(app, "proposed-steps.csv", "robot"))
        reader = Browser(app, "adjudicator", study="robot")
        page = reader.client.get("/dashboard/robot").text
        agreed = reader.client.get("/api/dashboard/studies/robot/agreement").json["data"]
        served = reader.client.get("/api/dashboard/studies/robot/model-errors").json["data"]
    assert served == found
    out = tmp_path / "figures.json"
    assert (
        run(["eval", "subtasks", str(tmp_path / "proposed.csv"), "--json", "--out", str(out)]) == 0
    )
    measured = json.loads(out.read_text())["models"]
    counts = {"model": "source", "episodes": "items", "steps": "parts", "answers": "answers"}
    counts |= {"proposal": "proposal", "undecided": "undecided"}
    for by_command, on_dashboard in zip(measured, found, strict=True):
        for name, other in counts.items():
            assert by_command[name] == on_dashboard[other]
        for one, other in zip(by_command["measures"], on_dashboard["measures"], strict=True):
            assert one == {name: other[name] for name in one}
    assert [(m["source"], m["proposal"]) for m in found] == [
        ("times", "shown"), ("times", "not shown"), ("words", "shown"), ("words", "not shown"),
    ]  # fmt: skip
    assert sum(m["answers"] for m in found) == 4 * films
    # Everybody saw the same in all films, so each of the two models was compared equally often.
    assert {m["answers"] for m in found if m["source"] == "times"} == {
        m["answers"] for m in found if m["source"] == "words"
    }
    for model in found:
        value = {one["measure"]: one["value"] for one in model["measures"]}
        if model["source"] == "words":
            assert value["text changed"] == pytest.approx(1 / 3)
            assert value["removed"] == 0
            assert value["boundary error, s"] == 0
        else:
            assert value["accepted"] == pytest.approx(2 / 4)
            assert value["removed"] == pytest.approx(1 / 4)
            assert value["boundary error where moved, s"] == pytest.approx(0.5)
        assert value["added"] == 0
    assert "grasp the cap" not in page
    assert "Errors of models" in page
    measures = {one["measure"]: one["value"] for one in agreed if one["answers"] == "all"}
    assert measures["time in the same step, share, mean over pairs"] == 1
    assert measures["texts of steps that overlap by half, likeness, mean over pairs"] == 1


def test_intervals_come_from_episodes_and_from_ten_on(tmp_path: Path) -> None:
    rows = "video,start_s,command,model\n" + "".join(
        f"clip{n:02d},{start},{text},one\n" for n in range(12) for start, text in RIGHT
    )
    tasks = {"subtasks": {"answers": 1, "practice": False}}
    with set_up(study_with(tmp_path, rows, 12, tasks=tasks)) as app:
        person = Browser(app, study="robot")
        for number in range(12):
            page = person.lease("subtasks", "robot").json
            steps = RIGHT[:2] if number % 2 else RIGHT  # every other film has no third step
            send(person, page, *steps)
            if number == 5:
                few = json.loads(exported(app, "model-errors.json", "robot"))["models"]
        (model,) = json.loads(exported(app, "model-errors.json", "robot"))["models"]
    assert model["undecided"] == 12 * 3 - 6
    removed = next(one for one in model["measures"] if one["measure"] == "removed")
    assert removed["value"] == pytest.approx(1 / 6)
    assert 0 <= removed["low"] < 1 / 6 < removed["high"] <= 1 / 3
    removed = next(one for one in few[0]["measures"] if one["measure"] == "removed")
    assert (removed["low"], removed["reason"]) == (None, "few clusters")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("video,start_s,command\nclip07,0,reach\n", "no video 'clip07'"),
        ("video,start_s,command\nclip00,soon,reach\n", "steps.csv:2:8: start_s"),
        ("video,start_s,command\nclip00,-1,reach\n", "'-1' is no time in the video"),
        ("video,start_s,command\nclip00,nan,reach\n", "'nan' is no time"),
        ("video,start_s,command\nclip00,0,...\n", "a step needs a text"),
        (f"video,start_s,command\nclip00,0,{'x' * 301}\n", "at most 300 characters"),
        ("video,command\nclip00,reach\n", "'' is no time"),
    ],
)
def test_wrong_rows_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: str, message: str
) -> None:
    file = study_with(tmp_path, rows)
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 2
    assert message in capsys.readouterr().out


def test_a_study_without_the_task_needs_no_steps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = study_with(tmp_path, "video,start_s,command\n", tasks={"describe": {}})
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 2
    assert "add the task subtasks" in capsys.readouterr().err


def test_steps_come_from_a_closed_list(tmp_path: Path) -> None:
    rows = "video,start_s,command\nclip00,0,reach over\n"
    file = study_with(tmp_path, rows, vocabulary=["Reach", "Grasp the cup"])
    with set_up(file) as app:
        person = Browser(app, study="robot")
        page = person.lease("subtasks", "robot").json
        assert page["payload"]["vocabulary"] == {
            "steps": ["Reach", "Grasp the cup"],
            "closed": True,
        }
        refused = person.answer(page["item"], cut((0, "reach over")) | person.watched(page))
        assert "Choose step 1 from the list" in refused.text
        send(person, page, (0, "reach."), (1, "grasp  the cup"))
        answer = json.loads(exported(app, "jsonl", "robot"))
    assert [step["text"] for step in answer["body"]["subtasks"]] == ["Reach", "Grasp the cup"]


def test_a_list_grows_by_what_several_people_use(tmp_path: Path) -> None:
    tasks = {"subtasks": {"answers": 4, "practice": False}}
    more = {"vocabulary": ["Reach"], "vocabulary_grows": 2, "tasks": tasks}
    file = study_with(tmp_path, "", subtasks=None, **more)
    offered = []
    with set_up(file) as app:
        for text in ("turn around", "Turn around.", "reach", "wave"):
            person = Browser(app, study="robot")
            page = person.lease("subtasks", "robot").json
            offered.append(page["payload"]["vocabulary"]["steps"])
            send(person, page, (0, text))
    assert offered == [["Reach"], ["Reach"], ["Reach", "turn around"], ["Reach", "turn around"]]
