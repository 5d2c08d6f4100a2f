"""LeRobot's own writer, reader and renderer of samples, in an environment of their own.

LeRobot needs torch and other versions of NumPy and PyAV than this program. These tests run where
``CT_LEROBOT_PYTHON`` names a Python that has it (0.6 or later), such as that of::

    python3.12 -m venv /tmp/lerobot-env
    /tmp/lerobot-env/bin/pip install 'lerobot[training,multi-task-dit]>=0.6' pytest
    CT_LEROBOT_PYTHON=/tmp/lerobot-env/bin/python pytest tests/corpus_tools/lerobot

The builds of torch for CPUs are enough, and the extra `dataset` for all but `test_training.py`.
`test_language_rows.py` has LeRobot's rules as tests of this program's own, which always run.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

from corpus_tools.exporters.export_registry import export_corpus_to
from corpus_tools.lerobot.episode_frames import checked_episodes
from corpus_tools.lerobot.episode_index import IndexColumn
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.grounded_answers import Answer, Shape
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
from corpus_tools.lerobot.task_tables import tasks_parquet
from tests.lerobot_datasets import CAMERA, TASKS, WRIST, image_dataset, new_dataset
from tests.tiny_corpus import tiny_corpus

PYTHON = os.environ.get("CT_LEROBOT_PYTHON", "")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PYTHON, reason="CT_LEROBOT_PYTHON names no Python with LeRobot"),
]

WRITE = """
import sys
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
root, use_videos = sys.argv[1], sys.argv[2] == "videos"
visual = {"dtype": "video" if use_videos else "image", "shape": (48, 64, 3),
          "names": ["height", "width", "channels"]}
features = {"observation.images.top": visual, "observation.images.wrist": visual,
            "action": {"dtype": "float32", "shape": (2,), "names": None}}
made = LeRobotDataset.create("local/made", 10, features, root=root, use_videos=use_videos)
for episode, (length, task) in enumerate([(7, "Push."), (12, "Lift."), (5, "Push.")]):
    for n in range(length):
        grey = np.full((48, 64, 3), 40 * episode + 3 * n, np.uint8)
        made.add_frame({"observation.images.top": grey, "observation.images.wrist": 255 - grey,
                        "action": np.array([episode, n], np.float32), "task": task})
    made.save_episode()
made.finalize()
"""

EDIT = """
import sys
from lerobot.scripts.lerobot_edit_dataset import main
main()
"""

CONVERT = """
import sys
from lerobot.scripts.convert_dataset_v21_to_v30 import convert_dataset
convert_dataset("local/made", root=sys.argv[1], push_to_hub=False)
"""

READ = """
import json, sys
from lerobot.configs.recipe import MessageTurn, TrainingRecipe
from lerobot.datasets.language_render import render_sample
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/read", root=sys.argv[1], video_backend="pyav")
turns = [MessageTurn("user", "${task}", stream="high_level"),
         MessageTurn("assistant", "${plan}", stream="high_level"),
         MessageTurn("assistant", "${subtask}", stream="low_level", target=True)]
recipe = TrainingRecipe(messages=turns)
rows = []
for n in range(len(data)):
    one = data[n]
    said = render_sample(
        recipe=recipe, persistent=one.get("language_persistent"), events=one.get("language_events"),
        t=float(one["timestamp"]), sample_idx=n, dataset_ctx={"task": one["task"]},
    )
    texts = [turn["content"] for turn in said["messages"]]
    rows.append([int(one["episode_index"]), round(float(one["timestamp"]), 6), one["task"], *texts])
columns = data.meta.episodes.column_names
marks = {n: list(data.meta.episodes[n]) for n in columns if n.startswith("marks/")}
print(json.dumps({"episodes": data.num_episodes, "language": data.meta.has_language_columns,
                  "depth": data.meta.depth_keys, "rows": rows, "marks": marks}))
"""

EVENTS = """
import json, sys
from lerobot.annotations.steerable_pipeline.validator import classify_vqa_answer
from lerobot.configs.recipe import MessageTurn, TrainingRecipe
from lerobot.datasets.language import column_for_style, validate_camera_field
from lerobot.datasets.language_render import render_sample
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/read", root=sys.argv[1], video_backend="pyav")
camera = sys.argv[2]
bindings = {"vqa_query": f"emitted_at(t, style=vqa, role=user, camera={camera})",
            "vqa": f"emitted_at(t, style=vqa, role=assistant, camera={camera})",
            "way": f"emitted_at(t, style=trace, camera={camera})",
            "motion": "active_at(t, style=motion)"}
turns = [MessageTurn("user", "${vqa_query}${interjection}", stream="high_level"),
         MessageTurn("assistant", "${vqa}${way}", stream="high_level", tool_calls_from="speech"),
         MessageTurn("assistant", "${plan}", stream="high_level"),
         MessageTurn("assistant", "${memory}", stream="high_level"),
         MessageTurn("assistant", "${motion}", stream="high_level", target=True)]
recipe = TrainingRecipe(messages=turns, bindings=bindings)
rows, kinds = [], []
for n in range(len(data)):
    one = data[n]
    persistent, events = one["language_persistent"], one["language_events"]
    for column, found in (("language_persistent", persistent), ("language_events", events)):
        for row in found:
            assert column_for_style(row["style"]) == column
            validate_camera_field(row["style"], row["camera"])
            if row["style"] == "vqa" and row["role"] == "assistant":
                kinds.append(classify_vqa_answer(json.loads(row["content"])))
    said = render_sample(recipe=recipe, persistent=persistent, events=events,
                         t=float(one["timestamp"]), sample_idx=n)["messages"]
    calls = [call["function"]["arguments"]["text"] for call in said[1].get("tool_calls", ())]
    rows.append([int(one["episode_index"]), *[turn.get("content") for turn in said], calls])
tools = [tool["function"]["name"] for tool in data.meta.tools]
print(json.dumps({"rows": rows, "kinds": kinds, "tools": tools}))
"""


def lerobot(program: str, *arguments: object) -> str:
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        [PYTHON, "-c", program, *map(str, arguments)],
        check=False,
        capture_output=True,
        text=True,
        env=environment | {"HF_HUB_OFFLINE": "1", "HF_DATASETS_OFFLINE": "1"},
        timeout=300,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def read(folder: Path) -> dict[str, Any]:
    """What a training on the dataset would see."""
    found: dict[str, Any] = json.loads(lerobot(READ, folder).splitlines()[-1])
    return found


def test_a_corpus_is_read_and_rendered(tmp_path: Path):
    export_corpus_to(tiny_corpus(), "lerobot", tmp_path / "out")
    seen = read(tmp_path / "out")
    assert (seen["episodes"], seen["language"], seen["depth"]) == (3, True, [])
    assert all(row[-1] for row in seen["rows"])  # each frame has a subtask


def test_version_2_is_converted_and_takes_language(tmp_path: Path):
    """LeRobot's converter leaves out version 2's file of language, so it comes afterwards."""
    export_corpus_to(tiny_corpus(), "lerobot-2.1", tmp_path / "out")
    before = [e.tasks for e in open_dataset(tmp_path / "out").episodes()]
    lerobot(CONVERT, tmp_path / "out")
    converted = open_dataset(tmp_path / "out")
    assert [e.tasks for e in converted.episodes()] == before
    said = {0: EpisodeLanguage((Language("subtask", 0.5, "reach"),))}
    assert write_language(converted, tmp_path / "copy", said, attachments={}) == []
    rows = [row for row in read(tmp_path / "copy")["rows"] if row[0] == 0]
    assert [row[-1] for row in rows] == [""] * 5 + ["reach"] * (len(rows) - 5)


def test_steps_of_people_on_one_frame_are_rendered(tmp_path: Path):
    """The frames' tasks, wordings and subtasks, where two steps were nearest to one frame."""
    source = open_dataset(new_dataset(tmp_path / "set"))
    # As LeRobot writes it, by pandas.
    (tmp_path / "set/meta/tasks.parquet").write_bytes(tasks_parquet(TASKS))
    steps = tuple(
        Language("subtask", start_s, text)
        for start_s, text in ((0.0, "reach"), (0.51, "take"), (0.53, "lift"))
    )
    wording = Language("task_aug", 0.0, "Shove it.")
    said = {
        0: EpisodeLanguage((*steps, wording), frozenset({"subtask"})),
        2: EpisodeLanguage((Language("task_aug", 0.0, "Wait."),), task="Wait."),
    }
    notes = write_language(source, tmp_path / "copy", said, attachments={})
    assert any("lift" in note for note in notes)
    rows = read(tmp_path / "copy")["rows"]
    first = [row for row in rows if row[0] == 0]
    assert [row[-1] for row in first] == ["reach"] * 5 + ["take"] + ["lift"] * 6
    assert {row[3] for row in first} == {"Push the cube.", "Shove it."}
    assert first[0][4] == "1. reach\n2. take\n3. lift"
    assert {(row[2], row[3]) for row in rows if row[0] == 2} == {("Wait.", "Wait.")}


def test_every_style_of_people_is_rendered(tmp_path: Path):
    """Its rules of columns, cameras and answers hold."""
    source = open_dataset(new_dataset(tmp_path / "set", language=False))
    (tmp_path / "set/meta/tasks.parquet").write_bytes(tasks_parquet(TASKS))
    answers = [
        Answer("count", ("cube", "2")),
        Answer("attribute", ("cube", "colour", "red")),
        Answer("spatial", ("cube", "left_of", "hand")),
        Answer("point", ("cube",), (Shape(((9.6, 3.2),)),)),
        Answer("boxes", (), (Shape(((0, 0), (9, 9)), "cube"), Shape(((5, 5), (9, 12)), "hand"))),
    ]
    asked = [
        Language("vqa", n / 10, f"What {n}?", camera=CAMERA, answer=answer)
        for n, answer in enumerate(answers)
    ]
    way = Answer("path", ("hand",), (Shape(((0, 0), (64, 48))),))
    said = (
        *asked,
        Language("vqa", 0.1, "And here?", camera=WRIST, answer=Answer("count", ("cube", "0"))),
        Language("trace", 0.6, "hand", camera=CAMERA, answer=way),
        Language("interjection", 0.8, "Faster, please.", reply="Sure."),
        Language("subtask", 0.0, "reach"),
        Language("memory", 0.5, "I reached it."),
        Language("motion", 0.4, "close the gripper"),
    )
    language = {0: EpisodeLanguage(said)}
    assert write_language(source, tmp_path / "copy", language, attachments={}) == []
    seen = json.loads(lerobot(EVENTS, tmp_path / "copy", CAMERA).splitlines()[-1])
    assert sorted(seen["kinds"]) == ["attribute", "bbox", "count", "count", "keypoint", "spatial"]
    assert seen["tools"] == ["say"]
    first = [row[1:] for row in seen["rows"] if row[0] == 0]
    state = ["1. reach", "I reached it.", "close the gripper"]
    assert [row[0] for row in first[:5]] == [f"What {n}?" for n in range(5)]
    assert [row[1] for row in first[:5]] == [answer.content() for answer in answers]
    assert first[6] == ["", way.content(), *state, []]
    assert first[8] == ["Faster, please.", "", *state, ["Sure."]]
    assert first[9][0] == ""
    assert all(row[1:] == ["", "", "", "", "", []] for row in seen["rows"] if row[0] != 0)


def test_marks_and_corrected_tasks_are_read_and_bad_episodes_deleted(tmp_path: Path):
    lerobot(WRITE, tmp_path / "made", "videos")
    dataset = open_dataset(tmp_path / "made")
    columns = (
        IndexColumn("marks/success", "text", {0: "success", 1: "failure"}),
        IndexColumn("marks/reasons", "texts", {0: [], 1: ["It drops"]}),
        IndexColumn("marks/quality", "number", {0: 4.0, 1: 1.5}),
    )
    said = {2: EpisodeLanguage((), corrected={"Push.": "Pull."})}
    listed = {"operation": {"type": "delete_episodes", "episode_indices": [1]}}
    files = {"meta/delete_episodes.json": json.dumps(listed).encode()}
    write_language(dataset, tmp_path / "copy", said, attachments=files, columns=columns)
    seen = read(tmp_path / "copy")
    assert seen["marks"] == {
        "marks/success": ["success", "failure", None],
        "marks/reasons": [[], ["It drops"], None],
        "marks/quality": [4.0, 1.5, None],
    }
    assert {(row[0], row[2]) for row in seen["rows"]} == {(0, "Push."), (1, "Lift."), (2, "Pull.")}
    assert not seen["language"]
    options = {
        "config_path": tmp_path / "copy/meta/delete_episodes.json", "repo_id": "me/all",
        "root": tmp_path / "copy", "new_repo_id": "me/kept", "new_root": tmp_path / "kept",
    }  # fmt: skip
    lerobot(EDIT, *(f"--{name}={value}" for name, value in options.items()))
    kept = read(tmp_path / "kept")
    assert {(row[0], row[2]) for row in kept["rows"]} == {(0, "Push."), (1, "Pull.")}
    assert read(tmp_path / "copy")["episodes"] == 3


@pytest.mark.parametrize("kind", ["videos", "images"])
def test_what_its_writer_makes_goes_in_and_out(kind: str, tmp_path: Path):
    lerobot(WRITE, tmp_path / "made", kind)
    dataset = open_dataset(tmp_path / "made")
    made = study_input(dataset, tmp_path / "tables", scratch=tmp_path / "films")
    assert made.rows == {"episodes.csv": 3, "tasks.csv": 3}
    episodes = [one.episode for one in checked_episodes(dataset)]
    assert [(e.frames, e.tasks) for e in episodes] == [
        (7, ("Push.",)), (12, ("Lift.",)), (5, ("Push.",)),
    ]  # fmt: skip
    if kind == "videos":
        table = bytes(made.files["episodes.csv"]).decode().splitlines()[1:]
        parts = [tuple(float(x) for x in line.split(",")[2:4]) for line in table]
        assert parts == [(0.0, 0.7), (0.7, 1.9), (1.9, 2.4)]
    said = {
        1: EpisodeLanguage((Language("subtask", 0.4, "grip"), Language("task_aug", 0.0, "Up.")))
    }
    assert write_language(dataset, tmp_path / "copy", said, attachments={}) == []
    rows = read(tmp_path / "copy")["rows"]
    assert len(rows) == 24
    second = [row for row in rows if row[0] == 1]
    assert [row[-1] for row in second] == [""] * 4 + ["grip"] * 8
    assert {row[3] for row in second} == {"Lift.", "Up."}
    assert {row[3] for row in rows if row[0] != 1} == {"Push."}


def test_pictures_keep_their_cells(tmp_path: Path):
    """Version 2 isn't read by LeRobot any more; ours is, and its copy has the pictures."""
    source = open_dataset(image_dataset(tmp_path / "set"))
    said = {0: EpisodeLanguage((Language("subtask", 0.0, "reach"),))}
    write_language(source, tmp_path / "copy", said, attachments={})
    again = study_input(
        open_dataset(tmp_path / "copy"), tmp_path / "tables", scratch=tmp_path / "films"
    )
    assert again.rows["subtasks.csv"] == 1
