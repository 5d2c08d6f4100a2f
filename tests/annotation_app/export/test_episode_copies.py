"""People's language in copies of robomimic's files and of recordings, read by others' readers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("h5py", reason="the extra `hdf5` is not installed")
pytest.importorskip("rosbags", reason="the extra `ros` is not installed")

import h5py
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from corpus_tools.cli.console import run
from corpus_tools.episodes.bag_reading import Recording, opened
from corpus_tools.episodes.bag_writing import write_recordings
from corpus_tools.episodes.copies import LanguageCopy
from corpus_tools.episodes.robomimic import open_demonstrations
from corpus_tools.episodes.robomimic_writing import write_robomimic
from corpus_tools.episodes.rosbag import open_recordings
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import CorpusError
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.corpus_tools.episodes import test_robomimic as hdf5_files
from tests.corpus_tools.episodes import test_rosbag as bags

STEP_S = 0.1


def answered(folder: Path, importer: str, source: Path, episodes: int) -> None:
    """A study of episodes, which one person describes and cuts."""
    call = ["import", importer, str(source), "--out", str(folder / "tables")]
    assert run(call) == 0
    study = {
        "name": "robot", "title": "Robot", "videos": "tables/episodes.csv",
        "tasks": {n: {"answers": 1, "practice": False} for n in ("describe", "subtasks")},
    }  # fmt: skip
    (folder / "robot.yaml").write_text(json.dumps(study))
    with set_up(folder / "robot.yaml") as app:
        worker = Browser(app, study="robot")
        for _ in range(episodes):
            page = worker.lease("describe", "robot").json
            assert worker.answer(page["item"], described("Lift the cube.")).status_code == 200
            page = worker.lease("subtasks", "robot").json
            steps = [{"start_s": 0.0, "text": "reach"}, {"start_s": STEP_S, "text": "grasp"}]
            answer = {"subtasks": steps, "played_to_end": True, "watched_s": 1.2}
            assert worker.answer(page["item"], answer).status_code == 200


def export(folder: Path, form: str) -> Path:
    call = ["annotate", "export", str(folder / "copy"), "--format", form]
    assert run([*call, "--instance", str(folder / "instance")]) == 0
    lines = [json.loads(line) for line in (folder / "copy/people.jsonl").read_text().splitlines()]
    assert {"study", "answer", "subject"} <= lines[0].keys()
    return folder / "copy"


def test_attributes_of_episodes(tmp_path: Path):
    (tmp_path / "set/deeper").mkdir(parents=True)
    source = hdf5_files.dataset(tmp_path / "set/deeper/lift.hdf5")
    before = source.read_bytes()
    answered(tmp_path, "robomimic", tmp_path / "set", len(hdf5_files.LENGTHS))
    copy = export(tmp_path, "robomimic") / "deeper/lift.hdf5"
    assert source.read_bytes() == before
    with h5py.File(copy) as after, h5py.File(source) as own:
        for name in hdf5_files.LENGTHS:
            demo, was = after["data"][name], own["data"][name]
            assert json.loads(demo.attrs["ep_meta"]) == {"lang": "Lift the cube."}
            assert "language_descriptions" not in demo.attrs
            assert json.loads(demo.attrs["language_subtasks"]) == [
                {"start_s": 0.0, "step": 0, "content": "reach"},
                {"start_s": STEP_S, "step": 2, "content": "grasp"},
            ]
            assert demo.attrs["num_samples"] == was.attrs["num_samples"]
            for place in ("actions", "obs/agentview_image", "obs/agentview_depth"):
                assert np.array_equal(demo[place][()], was[place][()])
    again = tmp_path / "again"
    assert run(["import", "robomimic", str(tmp_path / "copy"), "--out", str(again)]) == 0
    assert "Lift the cube." in (again / "tasks.csv").read_text()


def test_tasks_descriptions_and_moments(tmp_path: Path):
    file = hdf5_files.dataset(tmp_path / "lift.hdf5")
    with h5py.File(file, "a") as hdf5:
        hdf5["data/demo_0"].attrs["ep_meta"] = json.dumps({"lang": "Lift  it", "layout": 3})
        hdf5["data/demo_2"].attrs["ep_meta"] = json.dumps({"lang": "Stay."})
    long = "x" * 100_000  # more than an attribute holds by itself
    said = (
        Language("task_aug", 0.0, "Take it."), Language("memory", 0.2, long),
        Language("interjection", 0.1, "Wait!", reply="Yes."),
    )  # fmt: skip
    language = {0: EpisodeLanguage(said, corrected={"Lift it": "Push it."})}
    language[1] = EpisodeLanguage(said[:1])
    source = open_demonstrations(file)
    files = {"people.jsonl": b""}
    write_robomimic(source, LanguageCopy(tmp_path / "copy", language, files, {0: 10.0}))
    with h5py.File(tmp_path / "copy/lift.hdf5") as hdf5:
        first, second, third = (hdf5["data"][n].attrs for n in ("demo_0", "demo_2", "demo_10"))
        assert json.loads(first["ep_meta"]) == {"lang": "Push it.", "layout": 3}
        assert list(first["language_descriptions"]) == ["Take it."]
        assert json.loads(first["language_moments"]) == [
            {
                "style": "interjection",
                "start_s": 0.1,
                "step": 1,
                "content": "Wait!",
                "reply": "Yes.",
            },
            {"style": "memory", "start_s": 0.2, "step": 2, "content": long},
        ]
        assert json.loads(second["ep_meta"]) == {"lang": "Stay."}
        assert list(second["language_descriptions"]) == ["Take it."]
        assert "ep_meta" not in third


def test_links_are_not_followed(tmp_path: Path):
    """A file that an episode's link names isn't changed."""
    file, other = (hdf5_files.dataset(tmp_path / f"{name}.hdf5") for name in ("lift", "other"))
    with h5py.File(file, "a") as hdf5:
        del hdf5["data/demo_2"]
        hdf5["data/demo_2"] = h5py.ExternalLink(str(other), "/data/demo_2")
    before = other.read_bytes()
    language = {1: EpisodeLanguage((Language("task_aug", 0.0, "Take it."),))}
    source = open_demonstrations(tmp_path / "lift.hdf5")
    with pytest.raises(CorpusError, match="demo_2 is a link"):
        write_robomimic(source, LanguageCopy(tmp_path / "copy", language, {}))
    assert other.read_bytes() == before
    assert not (tmp_path / "copy").exists()


def texts_of(path: Path) -> tuple[list[tuple[int, dict[str, Any]]], list[tuple[str, int, bytes]]]:
    """The messages of a topic of language, and all others, by the readers of mcap and rosbags."""
    every: list[tuple[str, int, bytes]] = []
    if path.suffix == ".mcap":
        with path.open("rb") as stream:
            reader = make_reader(stream)
            schemas = {s.name for s in reader.get_summary().schemas.values()}
            assert schemas & {"Language", "std_msgs/msg/String"}
            every = [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages()]
    if path.suffix != ".mcap" or "std_msgs/msg/String" in schemas:
        with AnyReader([path]) as bag:
            decoded = [
                (c.topic, t, bag.deserialize(raw, c.msgtype).data.encode() if c.topic == "/language"
                 else bytes(raw))
                for c, t, raw in bag.messages()
            ]  # fmt: skip
            every = decoded
    said = [(t, json.loads(data)) for topic, t, data in every if topic == "/language"]
    return said, sorted(one for one in every if one[0] != "/language")


LANGUAGE = {
    0: EpisodeLanguage(
        (
            Language("subtask", STEP_S, "grasp"),
            Language("subtask", 0.0, "reach"),
            Language("interjection", 9.0, "Wait – ⏸!", reply="Yes."),
        )
    )
}


@pytest.mark.parametrize(
    ("write", "name"),
    [
        (bags.bag2, "run"), (bags.bag2_mcap, "run.mcap"), (bags.protobuf, "run.mcap"),
        (bags.in_json, "run.mcap"), (bags.FILE_ZSTD, "run"), (bags.MESSAGE_ZSTD, "run"),
        (bags.database, "run"),
    ],
)  # fmt: skip
def test_a_topic_of_language(tmp_path: Path, write: Callable[[Path], Path], name: str):
    source = open_recordings(write(tmp_path / "run"))
    starts = {0: bags.START_NS}
    first = LanguageCopy(tmp_path / "copy", LANGUAGE, {"people.jsonl": b""}, starts=starts)
    write_recordings(source, first)
    said, others = texts_of(tmp_path / "copy" / name)
    assert [(t - bags.START_NS, one["content"]) for t, one in said] == [
        (0, "reach"), (round(STEP_S * 1e9), "grasp"), (9_000_000_000, "Wait – ⏸!"),
    ]  # fmt: skip
    assert said[2][1] == {
        "style": "interjection", "start_s": 9.0, "content": "Wait – ⏸!", "reply": "Yes.",
    }  # fmt: skip
    before = [
        (m.topic, m.time_ns) for r in opened_all(source.files)
        for m in r.messages([bags.TOPIC, "/state"])
    ]  # fmt: skip
    assert sorted((topic, time_ns) for topic, time_ns, _ in others) == sorted(before)
    # A copy of the copy has what is said in a topic of its own.
    again = open_recordings(tmp_path / "copy" / name)
    write_recordings(again, replace(first, target=tmp_path / "again"))
    [file] = open_recordings(tmp_path / "again").files
    [recording] = opened_all([file])
    assert {"/language", "/language_2"} <= recording.types().keys()


def opened_all(files: Iterable[Path]) -> Iterator[Recording]:
    for file in files:
        with opened(file) as recording:
            yield recording


def test_recordings_by_the_command(tmp_path: Path):
    source = bags.bag2(tmp_path / "run")
    answered(tmp_path, "rosbag", source, 1)
    said, others = texts_of(export(tmp_path, "rosbag") / "run")
    assert [(t, one["style"], one["content"]) for t, one in said] == [
        (bags.START_NS, "task_aug", "Lift the cube."), (bags.START_NS, "subtask", "reach"),
        (bags.START_NS + round(STEP_S * 1e9), "subtask", "grasp"),
    ]  # fmt: skip
    assert others == texts_of(source)[1]


@pytest.mark.parametrize("write", [bags.bag1, bags.MESSAGE_MCAP])
def test_recordings_that_are_not_written(tmp_path: Path, write: Callable[[Path], Path]):
    source = open_recordings(write(tmp_path / "run"))
    language = {0: EpisodeLanguage((Language("subtask", 0.0, "reach"),))}
    with pytest.raises(CorpusError, match="convert"):
        write_recordings(source, LanguageCopy(tmp_path / "copy", language, {}, starts={0: 5}))
    assert not (tmp_path / "copy").exists()
    with pytest.raises(CorpusError, match="no episode 0"):
        write_recordings(source, LanguageCopy(tmp_path / "copy", language, {}, starts={7: 5}))
