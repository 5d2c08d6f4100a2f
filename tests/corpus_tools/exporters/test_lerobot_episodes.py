"""A corpus as a LeRobot dataset: its columns, its times, and LeRobot's own reader."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.exporters.export_registry import export_corpus_to
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import persistent_rows
from g3.annotation import Annotation, Command
from g3.errors import FormatError
from g3.groundings import Path as GroundedPath
from g3.groundings import Trajectory
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import parse_brackets
from tests.lerobot_datasets import HEIGHT, WIDTH, film
from tests.tiny_corpus import tiny_corpus


@pytest.fixture
def corpus() -> Corpus:
    return tiny_corpus()


@pytest.fixture
def folder(corpus: Corpus, tmp_path: Path) -> Path:
    export_corpus_to(corpus, "lerobot", tmp_path / "lerobot")
    return tmp_path / "lerobot"


def test_the_columns_are_those_that_the_format_documents(folder: Path):
    table = pq.read_table(folder / "data/chunk-000/file-000.parquet")
    kinds = {field.name: field.type for field in table.schema}
    text = pa.string()
    assert {n: kinds[n] for n in ("timestamp", "frame_index", "episode_index", "index")} == {
        "timestamp": pa.float32(),
        "frame_index": pa.int64(),
        "episode_index": pa.int64(),
        "index": pa.int64(),
    }
    assert kinds["task_index"] == pa.int64()
    assert kinds["observation.state"] == kinds["action"] == pa.list_(pa.float32(), 4)
    row = kinds["language_persistent"].value_type
    assert [field.name for field in row] == [
        "role", "content", "style", "timestamp", "camera", "tool_calls",
    ]  # fmt: skip
    assert row.field("timestamp").type == pa.float32()
    assert row.field("content").type == text
    events = kinds["language_events"].value_type
    assert [field.name for field in events] == ["role", "content", "style", "camera", "tool_calls"]
    info = json.loads((folder / "meta/info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    assert set(info["features"]) == set(kinds)
    assert info["features"]["language_events"]["dtype"] == "language"


def test_frames_count_on(folder: Path, corpus: Corpus):
    table = pq.read_table(folder / "data/chunk-000/file-000.parquet").to_pydict()
    episodes = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    info = json.loads((folder / "meta/info.json").read_text())
    assert len(episodes) == info["total_episodes"] == len(corpus.contexts)
    assert table["index"] == list(range(info["total_frames"]))
    tasks = pq.read_table(folder / "meta/tasks.parquet").to_pydict()
    for episode, context in zip(episodes, corpus.contexts.values(), strict=True):
        frames = slice(episode["dataset_from_index"], episode["dataset_to_index"])
        n = episode["length"]
        assert table["frame_index"][frames] == list(range(n))
        assert set(table["episode_index"][frames]) == {episode["episode_index"]}
        times = np.array(table["timestamp"][frames], dtype=np.float32)
        assert np.array_equal(times, (np.arange(n) / info["fps"]).astype(np.float32))
        state = np.array(table["observation.state"][frames])
        action = np.array(table["action"][frames])
        assert np.array_equal(state[1:], action[:-1])
        path = context.agent.trajectory
        assert state[0, :3] == pytest.approx(path.xyz[0], abs=1e-5)
        assert times[-1] <= path.t[-1] - path.t[0] < times[-1] + 1 / info["fps"]
        (number,) = set(table["task_index"][frames])
        assert [tasks["task"][number]] == episode["tasks"]
        assert episode["stats/observation.state/max"] == pytest.approx(state.max(0))


def test_what_people_said_is_in_the_language(folder: Path, corpus: Corpus):
    found = dict(persistent_rows(open_dataset(folder)))
    for number, context in enumerate(corpus.contexts.values()):
        said = {
            a.command.text for a in corpus.annotations if a.context.id == context.id
        }  # all are annotated
        styles = {row["style"] for row in found[number]}
        assert styles == {"task_aug", "subtask", "plan"}
        wordings = [row for row in found[number] if row["style"] == "task_aug"]
        assert {row["content"] for row in wordings} == said
        assert {row["role"] for row in wordings} == {"user"}
        assert {row["timestamp"] for row in found[number]} == {0.0}
    table = pq.read_table(folder / "data/chunk-000/file-000.parquet").to_pydict()
    for number, rows in zip(table["episode_index"], table["language_persistent"], strict=True):
        assert rows == found[number]


def of_two_steps(*starts: float) -> Corpus:
    """A corpus of one command with two EVENT clauses, which begin some time after the log does."""
    small = tiny_corpus(("to_truck",))
    (context,) = small.contexts.values()
    command = Command("two", "Go to the truck then wait", "to_truck", "to_truck video")
    clauses = ["EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))", "EVENT(r = wait)"]
    sdcs = parse_brackets("\n".join(clauses), command=command.text)
    log = context.agent.trajectory
    truck = next(o for o in context.objects if o.id == "truck")
    first, second = (
        (GroundedPath(Trajectory(log.t[:2] + start, log.xyz[:2], log.yaw[:2])),) for start in starts
    )
    by_type = {"OBJECT": (truck,), "PATH": first}
    events = iter((first, second))
    groundings = [
        next(events) if sdc.type == "EVENT" else by_type[sdc.type] for sdc in breadth_first(sdcs)
    ]
    annotation = Annotation(
        "two/positive", command, context, sdcs, tuple(groundings), (True,) * len(groundings),
        "positive",
    )  # fmt: skip
    return Corpus.build(
        "two", contexts=[context], commands=[command], annotations=[annotation], source="made up"
    )


@pytest.mark.parametrize(
    ("starts", "expected"),
    [
        ((0.0, 3.0), [(0.0, "Go to the truck"), (3.0, "wait")]),
        # Without times of their own all begin with the log: they are one subtask.
        ((0.0, 0.0), [(0.0, "Go to the truck then wait")]),
        # Those that are nearest to one frame are on two.
        ((0.51, 0.53), [(0.5, "Go to the truck"), (0.6, "wait")]),
    ],
)
def test_steps_have_frames_of_their_own(
    starts: tuple[float, float], expected: list[tuple[float, str]], tmp_path: Path
):
    export_corpus_to(of_two_steps(*starts), "lerobot", tmp_path / "out")
    ((_, rows),) = persistent_rows(open_dataset(tmp_path / "out"))
    found = [(row["timestamp"], row["content"]) for row in rows if row["style"] == "subtask"]
    assert found == [(pytest.approx(time), text) for time, text in expected]
    plans = [(row["timestamp"], row["content"]) for row in rows if row["style"] == "plan"]
    assert [time for time, _ in plans] == [time for time, _ in found]
    assert plans[0][1] == "\n".join(f"{n}. {text}" for n, (_, text) in enumerate(expected, 1))


def test_the_bundled_corpus_has_one_row_of_a_style_at_a_frame(tmp_path: Path):
    export_corpus_to(open_corpus("warehouse"), "lerobot", tmp_path / "out")
    dataset = open_dataset(tmp_path / "out")
    tasks = {episode.index: episode.tasks for episode in dataset.episodes()}
    for index, rows in persistent_rows(dataset):
        counts = Counter((r["style"], r["timestamp"]) for r in rows if r["style"] != "task_aug")
        assert max(counts.values()) == 1
        assert next(r["content"] for r in rows if r["style"] == "task_aug") == tasks[index][0]


def test_what_cannot_be_exported(corpus: Corpus, tmp_path: Path):
    (tmp_path / "films").mkdir()
    with pytest.raises(FormatError, match="there is no video"):
        export_corpus_to(corpus, "lerobot", tmp_path / "out", videos=[tmp_path / "films"])


def put_films(folder: Path, frames: dict[str, int], **settings: Any) -> Path:
    """What ``ct render-videos`` makes, as far as it is read: a folder for each context."""
    for number, (name, n) in enumerate(frames.items()):
        film(folder / str(number) / "video.mp4", [40 * number + 2 * i for i in range(n)])
        told = {"camera": "overview", "size": [WIDTH, HEIGHT], **settings}
        content = {"id": name, "frames": n, "fps": 10, "settings": told}
        (folder / str(number) / "manifest.json").write_text(json.dumps(content))
    return folder


def test_videos_of_each_camera_are_taken_as_they_are(corpus: Corpus, tmp_path: Path):
    # One context has no video.
    frames = {name: 15 + n for n, name in enumerate(list(corpus.contexts)[1:])}
    folders = {
        f"observation.images.{camera}": put_films(tmp_path / camera, frames, camera=camera)
        for camera in ("overview", "operator")
    }
    export_corpus_to(corpus, "lerobot", tmp_path / "out", videos=list(folders.values()))
    dataset = open_dataset(tmp_path / "out")
    assert dataset.cameras == tuple(folders)
    features = json.loads((tmp_path / "out/meta/info.json").read_text())["features"]
    stats = json.loads((tmp_path / "out/meta/stats.json").read_text())
    for camera, folder in folders.items():
        for number, episode in enumerate(dataset.episodes()):
            video = episode.videos[camera]
            assert video.file.samefile(folder / str(number) / "video.mp4")
            assert episode.frames == 15 + number
            assert (video.start_s, video.end_s) == (0.0, pytest.approx((15 + number) / 10))
        assert features[camera]["info"]["is_depth_map"] is False
        colours = np.array(stats[camera]["mean"])
        assert colours.shape == (3, 1, 1)
        assert 0 < colours.max() < 0.3  # dark greys


@pytest.mark.parametrize(
    ("frames", "settings", "message"),
    [
        ((15, 16), {}, "two folders have videos of one camera"),
        ((15,), {"camera": "track"}, "there is no video of"),
        ((15, 17), {"camera": "track"}, r"differ in their frames: \[16, 17\]"),
        ((15, 16), {"camera": "track", "speed": 2.0}, "other times than the log"),
        ((15, 16), {"camera": "../../up"}, "the manifest can't be read"),
    ],
)
def test_cameras_that_do_not_fit_together(
    frames: tuple[int, ...],
    settings: dict[str, Any],
    message: str,
    corpus: Corpus,
    tmp_path: Path,
):
    names = list(corpus.contexts)
    one = put_films(tmp_path / "one", dict(zip(names, (15, 16), strict=False)))
    other = put_films(tmp_path / "other", dict(zip(names, frames, strict=False)), **settings)
    with pytest.raises(FormatError, match=message):
        export_corpus_to(corpus, "lerobot", tmp_path / "out", videos=[one, other])


def test_a_video_that_is_cut_off_is_not_exported(corpus: Corpus, tmp_path: Path):
    films = put_films(tmp_path / "films", {next(iter(corpus.contexts)): 15})
    manifest, video = films / "0/manifest.json", films / "0/video.mp4"
    manifest.write_text(manifest.read_text().replace('"frames": 15', '"frames": 16'))
    with pytest.raises(FormatError, match="15 frames, and its manifest says 16"):
        export_corpus_to(corpus, "lerobot", tmp_path / "out", videos=[tmp_path / "films"])
    video.write_bytes(video.read_bytes()[:-300])
    with pytest.raises(FormatError, match=r"video\.mp4"):
        export_corpus_to(corpus, "lerobot", tmp_path / "out", videos=[tmp_path / "films"])
    assert not (tmp_path / "out").exists()


def test_version_2_1_for_programs_that_read_no_other(corpus: Corpus, tmp_path: Path):
    new, old = tmp_path / "new", tmp_path / "old"
    export_corpus_to(corpus, "lerobot", new)
    export_corpus_to(corpus, "lerobot-2.1", old)
    dataset = open_dataset(old)
    assert dataset.info.codebase_version == "v2.1"
    episodes = list(dataset.episodes())
    assert [e.tasks for e in episodes] == [e.tasks for e in open_dataset(new).episodes()]
    tables = [pq.read_table(episode.data) for episode in episodes]
    assert [len(table) for table in tables] == [episode.frames for episode in episodes]
    assert {*tables[0].column_names} == dataset.info.features.keys()
    every = pq.read_table(new / "data/chunk-000/file-000.parquet")
    assert pa.concat_tables(tables).equals(every.select(tables[0].column_names))
    lines = (old / "meta/language.jsonl").read_text().splitlines()
    said = [json.loads(line) for line in lines]
    rows = [(n, row) for n, some in persistent_rows(open_dataset(new)) for row in some]
    assert said == [{"episode_index": n, **row} for n, row in rows]
    stats = [json.loads(s) for s in (old / "meta/episodes_stats.jsonl").read_text().splitlines()]
    assert [s["stats"]["action"]["count"] for s in stats] == [[e.frames] for e in episodes]
