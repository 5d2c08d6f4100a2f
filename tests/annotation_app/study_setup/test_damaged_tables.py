"""Damaged tables of videos, things and studies: each is refused in words, or read.

``CT_DAMAGES=20`` tries twenty times as many.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.own_videos import given_commands, own_videos
from annotation_app.study_setup.study_reading import read_study
from g3.errors import CorpusError
from tests.annotation_app.study_setup.test_tables_of_others import coco, study_of
from tests.damage import damaged

ROWS = [
    ["video", "id", "start_s", "end_s", "command", "room"],
    ["push.mp4", "a", "0", "1.5", "Push the “cup”, then stop.", "kitchen"],
    ["push.mp4", "b", "1.5", "2", 'Say "stop".', "Küche"],
    ["push.mp4", "c", "2", "3", "", "7"],
]


def csv_table(folder: Path) -> Path:
    out = io.StringIO()
    csv.writer(out).writerows(ROWS)
    (folder / "t.csv").write_bytes(out.getvalue().encode("utf-8-sig"))
    return folder / "t.csv"


def jsonl_table(folder: Path) -> Path:
    rows = (dict(zip(ROWS[0], row, strict=True)) for row in ROWS[1:])
    text = "".join(f"{json.dumps(row, ensure_ascii=False)}\n" for row in rows)
    (folder / "t.jsonl").write_text(text, "utf-8")
    return folder / "t.jsonl"


@pytest.mark.parametrize(
    ("made", "read", "count"),
    [
        (csv_table, lambda file: given_commands(file, own_videos(file), has_videos=True), 300),
        (jsonl_table, lambda file: given_commands(file, own_videos(file), has_videos=True), 300),
        (
            lambda folder: coco(folder, "push.jpg", "1/90fbb0c7-lift.png"),
            lambda file: read_things(file, {"push": file, "lift": file.parent}),
            300,
        ),
        (lambda folder: study_of(folder, videos="clips", seed=3), read_study, 100),
    ],
)
def test_damage_is_named(
    tmp_path: Path, made: Callable[[Path], Path], read: Callable[[Path], object], count: int
) -> None:
    (tmp_path / "push.mp4").touch()
    file = made(tmp_path)
    read(file)
    problems = []
    for _, content in damaged(file.read_bytes(), count, seed=5):
        file.write_bytes(content)
        try:
            read(file)
        except CorpusError as error:
            problems.append(str(error))
    assert len(problems) > count // 10
    assert all(str(tmp_path) in problem for problem in problems)
    assert max(map(len, problems)) < 20_000
