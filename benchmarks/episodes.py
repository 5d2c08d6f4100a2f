"""A LeRobot dataset of 1 000 episodes in and out: ``python -m benchmarks.episodes``.

The dataset is made for it: version 3, 200 frames an episode, 50 episodes in a video file of 64 by
48 pixels, subtasks on every frame. Each step runs in a process of its own, whose largest memory is
told. To see whether memory is flat, the same is done with a tenth of the episodes.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import heading, in_own_process, show
from corpus_tools.lerobot.language_rows import column_types
from corpus_tools.video.drawing.canvas import Image
from corpus_tools.video.encode import encode

FRAMES, FPS, IN_FILE = 200, 20, 50
CAMERA = "observation.images.top"
STEPS = ("reach for the cube", "grasp the cube", "lift it", "put it into the box")

_STEP = """
import resource, sys, time
from pathlib import Path
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
source, target, what = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
import pyarrow.parquet
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
begin = time.perf_counter()
dataset = open_dataset(source)
if what == "import":
    made = study_input(dataset, target)
    rows = sum(made.rows.values())
else:
    said = EpisodeLanguage((Language("subtask", 0.0, "reach"), Language("subtask", 3.0, "put")),
                           frozenset({"subtask"}))
    language = {episode.index: said for episode in dataset.episodes()}
    write_language(dataset, target, language, attachments={})
    rows = len(language)
seconds = time.perf_counter() - begin
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
print([seconds, grown / 1024, rows])
"""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.episodes", description=__doc__)
    parser.add_argument("--episodes", type=int, default=1000, help="how many (default: 1000)")
    run(parser.parse_args().episodes)


def run(episodes: int = 1000) -> None:
    for count in (episodes // 10, episodes):
        heading(f"a LeRobot dataset of {count} episodes, {count * FRAMES} frames")
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "dataset"
            make(source, count)
            for what in ("import", "write"):
                target = str(Path(folder) / what)
                seconds, mb, rows = in_own_process("-c", _STEP, str(source), target, what)
                show(what, seconds, "s", f"{rows} rows, {mb:.0f} MB more memory")


def make(folder: Path, episodes: int) -> None:
    """Write a dataset."""
    import pyarrow as pa  # noqa: PLC0415 - an extra
    import pyarrow.parquet as pq  # noqa: PLC0415 - as above

    rng = np.random.default_rng(0)
    rows: list[dict[str, Any]] = []
    for file in range(-(-episodes // IN_FILE)):
        here = range(file * IN_FILE, min((file + 1) * IN_FILE, episodes))
        data = folder / f"data/chunk-000/file-{file:03d}.parquet"
        film = folder / f"videos/{CAMERA}/chunk-000/file-{file:03d}.mp4"
        for path in (data, film):
            path.parent.mkdir(parents=True, exist_ok=True)
        encode(_greys(file, len(here) * FRAMES), film, size=(64, 48), fps=FPS, quality="draft")
        tables = []
        for index in here:
            language = [
                {"role": "assistant", "content": text, "style": "subtask",
                 "timestamp": step * 2.0, "camera": None, "tool_calls": None}
                for step, text in enumerate(STEPS)
            ]  # fmt: skip
            types = column_types()
            numbers = pa.array(range(FRAMES), pa.int64())
            columns = {
                "action": pa.array(list(rng.normal(size=(FRAMES, 14)).astype(np.float32))),
                "timestamp": pa.array((np.arange(FRAMES) / FPS).astype(np.float32)),
                "frame_index": numbers,
                "episode_index": pa.array([index] * FRAMES, pa.int64()),
                "index": pa.array(range(index * FRAMES, (index + 1) * FRAMES), pa.int64()),
                "task_index": pa.array([0] * FRAMES, pa.int64()),
                "language_persistent": pa.array([language] * FRAMES, types["language_persistent"]),
                "language_events": pa.array([[]] * FRAMES, types["language_events"]),
            }
            tables.append(pa.table(columns))
            begin = (index - here.start) * FRAMES / FPS
            rows.append(
                {
                    "episode_index": index, "tasks": ["Put the cube into the box."],
                    "length": FRAMES, "data/chunk_index": 0, "data/file_index": file,
                    f"videos/{CAMERA}/chunk_index": 0, f"videos/{CAMERA}/file_index": file,
                    f"videos/{CAMERA}/from_timestamp": begin,
                    f"videos/{CAMERA}/to_timestamp": begin + FRAMES / FPS,
                }
            )  # fmt: skip
        pq.write_table(pa.concat_tables(tables), data, row_group_size=FRAMES * 10)
    meta = folder / "meta/episodes/chunk-000"
    meta.mkdir(parents=True)
    pq.write_table(pa.Table.from_pylist(rows), meta / "file-000.parquet")
    tasks = pa.table({"task_index": [0], "task": ["Put the cube into the box."]})
    pq.write_table(tasks, folder / "meta/tasks.parquet")
    files = "chunk-{chunk_index:03d}/file-{file_index:03d}"
    info = {
        "codebase_version": "v3.0", "fps": FPS, "total_episodes": episodes, "total_tasks": 1,
        "data_path": f"data/{files}.parquet", "video_path": f"videos/{{video_key}}/{files}.mp4",
        "features": {CAMERA: {"dtype": "video", "shape": [480, 640, 3], "names": None}},
    }  # fmt: skip
    (folder / "meta/info.json").write_text(json.dumps(info))


def _greys(seed: int, count: int) -> Iterator[Image]:
    """Frames of one grey each, which differ from file to file."""
    for number in range(count):
        yield np.full((48, 64, 3), (7 * seed + number) % 256, np.uint8)


if __name__ == "__main__":
    main()
