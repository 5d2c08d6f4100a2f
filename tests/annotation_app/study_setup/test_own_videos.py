"""A study of one's own robot: from a folder of videos to exported answers."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.cli import served_studies
from annotation_app.core.config import open_instance
from annotation_app.serving import server as serving
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.conftest import put_tables
from tests.annotation_app.study_setup.clips import clip

TREE = "EVENT(r = Push, l = OBJ(f = the cup))"


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    clip(tmp_path / "clips/push.mp4", 40)
    clip(tmp_path / "clips/lift.webm", 140)
    return tmp_path / "clips"


@contextmanager
def set_up(file: Path) -> Iterator[Flask]:
    """What `ct annotate FILE` sets up, without its server."""
    config = replace(open_instance(file.parent / "instance"), rate_limits=False)
    put_tables(config.database)
    serving.prepare(config)
    served_studies.put_file(config, file)
    with opened(config.database) as engine:
        yield create_app(config, engine)


def export(file: Path, form: str) -> Path:
    out = file.parent / f"out-{form}"
    call = ["annotate", "export", str(out), "--format", form, "--force"]
    assert run([*call, "--instance", str(file.parent / "instance")]) == 0
    return out


def test_from_a_folder_to_exported_answers(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "my-arm.yaml"
    assert run(["annotate", "init", str(file), "--videos", str(clips)]) == 0
    assert "for 2 videos" in capsys.readouterr().out
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "instance")]) == 0
    for _ in range(2):  # the second start changes nothing
        with set_up(file) as app:
            pass
    with set_up(file) as app:
        worker = Browser(app, study="my-arm")
        worker.practise("describe", "segment", "rate")
        seen = set()
        for _ in range(2):
            page = worker.lease("describe", "my-arm").json
            payload = page["payload"]
            assert payload["duration_s"] == pytest.approx(1, abs=0.11)
            with worker.client.get(f"/media/{payload['video']}") as film:
                seen.add(film.mimetype)
            with worker.client.get(f"/media/{payload['poster']}") as poster:
                assert poster.data.startswith(b"\x89PNG")
            assert worker.answer(page["item"], described("Push the cup.")).status_code == 200
        assert seen == {"video/mp4", "video/webm"}
        other = Browser(app, study="my-arm")
        other.practise("segment", "rate")
        page = other.lease("segment", "my-arm").json
        sdcs = to_json(parse_brackets(TREE, command="Push the cup."))
        assert other.answer(page["item"], {"sdcs": sdcs}).status_code == 200
        page = other.lease("rate", "my-arm").json
        assert other.answer(page["item"], {"rating": 4, "watched_s": 1.0}).status_code == 200
    rows = list(csv.DictReader(io.StringIO(export(file, "csv").read_text())))
    assert [row["task"] for row in rows] == ["describe", "describe", "segment", "rate"]
    assert {row["video"] for row in rows} == {"push", "lift"}
    corpus = Corpus.load(export(file, "corpus"))
    assert [command.text for command in corpus.commands.values()] == ["Push the cup."] * 2
    assert {command.video for command in corpus.commands.values()} == {"push", "lift"}
    assert len(corpus.judgments) == 1


@pytest.mark.parametrize("suffix", [".csv", ".jsonl"])
def test_tables_of_videos_and_commands(clips: Path, tmp_path: Path, suffix: str) -> None:
    rows = [
        {
            "video": "clips/push.mp4",
            "id": "a",
            "command": "Push it.",
            "subject": "Ann",
            "room": "7",
        },
        {"video": "clips/push.mp4", "id": "a", "command": "Shove it.", "subject": "", "room": "7"},
        {"video": "clips/lift.webm", "id": "b", "command": "", "subject": "", "room": "8"},
    ]
    table = tmp_path / f"videos{suffix}"
    if suffix == ".csv":
        with table.open("w", newline="") as out:
            writer = csv.DictWriter(out, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    else:
        table.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    file = tmp_path / "arm.yaml"
    assert run(["annotate", "init", str(file), "--videos", str(table)]) == 0
    for _ in range(2):
        with set_up(file) as app:
            pass
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        other = Browser(app, study="arm")
        for browser in (worker, other):
            browser.practise("describe", "segment", "rate")
        texts = set()
        for _ in range(2):
            page = other.lease("segment", "arm").json
            texts.add(text := page["payload"]["command"])
            verb = text.split()[0]
            sdcs = to_json(parse_brackets(f"EVENT(r = {verb}, l = OBJ(f = it))", command=text))
            assert other.answer(page["item"], {"sdcs": sdcs}).status_code == 200
        assert texts == {"Push it.", "Shove it."}
        # Nobody describes a video again because there are commands for it.
        for _ in range(2):
            page = worker.lease("describe", "arm").json
            assert worker.answer(page["item"], described()).status_code == 200
        assert worker.lease("describe", "arm").status_code != 200
    answers = [json.loads(line) for line in export(file, "jsonl").read_text().splitlines()]
    assert [a["body"]["text"] for a in answers[:2]] == ["Push it.", "Shove it."]
    assert {(a["video"], a["metadata"]["room"]) for a in answers} == {("a", "7"), ("b", "8")}
    assert answers[0]["body"]["metadata"] == {"room": "7"}
    assert "Ann" not in export(file, "jsonl").read_text()
    assert answers[0]["body"]["subject"]


def test_a_task_that_needs_a_scene_is_refused(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = {"name": "x", "title": "X", "videos": "clips", "tasks": {"ground": {}, "rate": {}}}
    file = tmp_path / "x.yaml"
    file.write_text(json.dumps(study))
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "i")]) == 2
    told = capsys.readouterr().out
    assert "the task ground asks about the things in videos" in told
    assert "leave out ground" in told
    assert run(["annotate", str(file), "--instance", str(tmp_path / "i"), "--port", "0"]) == 2
    assert "the task ground asks about" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("video\nno.mp4\nnor.mp4\n", ["v.csv:2:1: video: there is no file", "v.csv:3:1: video: "]),
        ("video,id\nclips/push.mp4,a\nclips/lift.webm,a\n", ["two files are called 'a'"]),
        ("file\nclips/push.mp4\n", ["v.csv:1:1: there is no column 'video'", "which has file"]),
        (
            "video\nclips/push.mp4,too,many\n",
            ["v.csv:2:16: this row has 3 cells and the first"],
        ),
        ("video\nvideo.avi\n", ["there is no file"]),
        ("video\nold.mp4\n", ["browsers don't play videos of the kind", "ffmpeg -i old.mp4"]),
        ("video\ntext.mp4\n", ["text.mp4: the video can't be read"]),
    ],
)
def test_what_is_wrong_with_a_table_is_told_with_its_line(
    clips: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], rows: str, told: list[str]
) -> None:
    clip(tmp_path / "old.mp4", codec="mpeg4")
    (tmp_path / "text.mp4").write_text("This is no video.")
    (tmp_path / "v.csv").write_text(rows)
    call = ["annotate", "init", str(tmp_path / "x.yaml"), "--videos", str(tmp_path / "v.csv")]
    assert run(call) == 2
    found = capfd.readouterr().err
    assert all(part in found for part in told), found
    assert not (tmp_path / "x.yaml").exists()


def test_a_command_for_no_video_is_refused(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "c.csv").write_text("video,command\npush,Push it.\npull,Pull it.\n")
    study = {"name": "x", "title": "X", "videos": "clips", "commands": "c.csv"}
    file = tmp_path / "x.yaml"
    file.write_text(json.dumps(study | {"tasks": {"segment": {}}}))
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "i")]) == 2
    assert re.search(r"c\.csv:3:1: video: the study has no video 'pull'", capsys.readouterr().out)


def test_an_empty_folder_tells_of_both_ways(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "clips").mkdir()
    call = ["annotate", "init", str(tmp_path / "x.yaml"), "--videos", str(tmp_path / "clips")]
    assert run(call) == 2
    assert "there are no videos" in capsys.readouterr().err
