"""People's language about episodes of other formats: JSON lines, and a copy of an RLDS dataset."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("google_crc32c", reason="the extra `rlds` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.episodes.rlds import open_steps
from corpus_tools.episodes.tf_records import example_of, records, values_of
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.rlds_datasets import LENGTHS, TASKS, dataset

TEXTS = ("Shove the cube.", "Do it again.")
STUDY = {
    "name": "robot",
    "title": "Robot",
    "videos": "tables/episodes.csv",
    "commands": "tables/tasks.csv",
    "tasks": {
        "describe": {"answers": 2, "practice": False},
        "subtasks": {"answers": 1, "practice": False},
        "rate": {"answers": 1, "practice": False},
    },
}


def answered(folder: Path) -> Path:
    """A study of an RLDS dataset at 5 frames a second, with answers; the dataset's folder."""
    tables = str(folder / "tables")
    source = dataset(folder / "toy")
    assert run(["import", "rlds", str(source), "--fps", "5", "--out", tables]) == 0
    file = folder / "robot.yaml"
    file.write_text(json.dumps(STUDY))
    with set_up(file) as app:
        for text in TEXTS:
            worker = Browser(app, study="robot")
            for _ in LENGTHS:
                page = worker.lease("describe", "robot").json
                assert worker.answer(page["item"], described(text)).status_code == 200
        cutter = Browser(app, study="robot")
        for _ in LENGTHS:
            page = cutter.lease("subtasks", "robot").json
            steps = [{"start_s": 0.0, "text": "reach"}, {"start_s": 0.41, "text": "grasp"}]
            answer = {"subtasks": steps, "played_to_end": True, "watched_s": 1.2}
            assert cutter.answer(page["item"], answer).status_code == 200
        rater = Browser(app, study="robot")
        while (taken := rater.lease("rate", "robot")).status_code == 200:
            body = {"rating": 5, "watched_s": 1.2}
            assert rater.answer(taken.json["item"], body).status_code == 200
    return source


def export(folder: Path, name: str, form: str, *more: str) -> Path:
    call = ["annotate", "export", str(folder / name), "--format", form, "--force"]
    assert run([*call, "--instance", str(folder / "instance"), *more]) == 0
    return folder / name


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rlds")
    answered(folder)
    return folder


def lines(file: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in file.read_text().splitlines()]


def test_json_lines_with_provenance(study: Path):
    every = lines(export(study, "language.jsonl", "language"))
    texts = [line for line in every if "ratings" not in line]
    assert [line["episode_index"] for line in texts] == [0] * 4 + [1] * 4 + [2] * 4
    wordings = {line["content"] for line in texts if line["style"] == "task_aug"}
    assert wordings == set(TEXTS)
    steps = [(line["content"], line["step"]) for line in texts if line["style"] == "subtask"]
    assert steps == [("reach", 0), ("grasp", 2)] * 3
    assert texts[0]["source"] == "toy-train.tfrecord-00000-of-00002, record 0"
    assert {"study", "answer", "subject", "at"} <= texts[0].keys()
    verdicts = [line for line in every if "ratings" in line]
    own = [(v["episode_index"], v["content"]) for v in verdicts if v["content"] in TASKS]
    assert own == [(0, TASKS[0]), (2, TASKS[2])]


def test_a_copy_of_the_dataset(study: Path):
    copy = export(study, "copy", "rlds")
    before, after = open_steps(study / "toy"), open_steps(copy)
    texts = {f.name for f in after.features if f.kind == "text"}
    assert texts == {
        "language_instruction", "language_instruction_2", "language_instruction_3",
        "language_subtask",
    }  # fmt: skip
    assert {f.name for f in before.features} < {f.name for f in after.features}
    for number, (old, new) in enumerate(zip(before.shards, after.shards, strict=True)):
        (was,), (now,) = ([example_of(c, "") for c in records(s.file)] for s in (old, new))
        for name in was.context.feature:
            if name != "steps/language_instruction":
                assert values_of(was, name) == values_of(now, name)
        said = {t.rpartition("/")[2]: values_of(now, f"steps/{t}") for t in texts}
        assert {len(values) for values in said.values()} == {LENGTHS[number]}
        wordings = [said[f"language_instruction{n}"][0].decode() for n in ("", "_2", "_3")]
        if TASKS[number]:
            assert wordings == [TASKS[number], *TEXTS]
        else:  # an empty task becomes the first description
            assert wordings == [*TEXTS, ""]
        subtasks = [value.decode() for value in said["language_subtask"]]
        assert subtasks == ["reach"] * 2 + ["grasp"] * (LENGTHS[number] - 2)
    splits = json.loads((copy / "dataset_info.json").read_text())["splits"]
    sizes = [sum(f.stat().st_size for f in copy.glob(f"toy-{s['name']}*")) for s in splits]
    assert [int(split["numBytes"]) for split in splits] == sizes
    assert len(lines(copy / "people.jsonl")) > len(TEXTS) * len(LENGTHS)


def test_a_copy_can_be_a_study_again(study: Path, tmp_path: Path):
    copy = export(study, "again", "rlds")
    assert run(["import", "rlds", str(copy), "--out", str(tmp_path / "tables")]) == 0
    tables = csv.DictReader((tmp_path / "tables/episodes.csv").read_text().splitlines())
    assert next(tables)["task"] == "; ".join([TASKS[0], *TEXTS])
    # Of a copy another copy can be made, which changes nothing but what people said.
    assert export(study, "twice", "rlds", "--episodes", str(copy)).is_dir()


def test_a_copy_has_no_files_from_elsewhere(study: Path, capsys: pytest.CaptureFixture[str]):
    (study / "private").write_text("root")
    link = study / "toy/README"
    link.symlink_to(study / "private")
    call = ["annotate", "export", str(study / "linked"), "--instance", str(study / "instance")]
    assert run([*call, "--format", "rlds"]) == 2
    assert "leads out of the dataset" in capsys.readouterr().err
    assert not (study / "linked").exists()
    link.unlink()


def test_what_is_refused(study: Path, capsys: pytest.CaptureFixture[str]):
    call = ["annotate", "export", "--instance", str(study / "instance"), "--format"]
    assert run([*call, "rlds", str(study / "toy/copy")]) == 2
    assert "in the dataset itself" in capsys.readouterr().err
    assert run([*call, "lerobot", str(study / "other")]) == 2
    assert "this is no LeRobot dataset" in capsys.readouterr().err
    assert run([*call, "language", str(study / "x"), "--episodes", str(study)]) == 2
    assert "only lerobot, rlds, robomimic and rosbag take" in capsys.readouterr().err
