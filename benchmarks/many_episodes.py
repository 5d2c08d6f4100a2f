"""10 000 episodes of LeRobot, listed and imported: ``python -m benchmarks.many_episodes``.

It has ten files of a thousand episodes, each of a second with a camera, state and action. Times are
those of the processor.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.timing import best, heading, row
from corpus_tools.episodes.films import Picture, write_film
from corpus_tools.lerobot.episode_reading import PATHS, open_dataset
from corpus_tools.lerobot.study_input import study_input

EPISODES, IN_FILE, FRAMES, FPS, NUMBERS = 10_000, 1000, 10, 10, 7
CLOCK = time.process_time
CAMERA = "observation.images.top"
MEASURES = ("min", "max", "mean", "std", "q01", "q10", "q50", "q90", "q99")


def main() -> None:
    heading(f"A LeRobot dataset of {EPISODES} episodes")
    with tempfile.TemporaryDirectory() as name:
        dataset, scratch = Path(name) / "dataset", Path(name) / "scratch"
        make(dataset)
        seconds, _ = best(lambda: list(open_dataset(dataset).episodes()), clock=CLOCK)
        row("list the episodes", f"{seconds:.2f} s", f"{EPISODES / seconds:,.0f} a second")
        opened = open_dataset(dataset)
        made = lambda: study_input(opened, scratch, scratch=scratch)  # noqa: E731
        seconds, _ = best(made, repeats=1, clock=CLOCK)
        row("import, with curves", f"{seconds:.1f} s", f"{EPISODES / seconds:,.0f} a second")


def make(folder: Path) -> None:
    """Write the dataset; all of its videos are copies of one."""
    grey = (Picture(np.full((48, 64, 3), n % 200, np.uint8), "") for n in range(IN_FILE * FRAMES))
    write_film(grey, folder / "film.mp4", FPS, "")
    vector, (data_path, video_path) = pa.list_(pa.float32(), NUMBERS), PATHS[False]
    for number in range(EPISODES // IN_FILE):
        count = IN_FILE * FRAMES
        index = number * IN_FILE + np.arange(count) // FRAMES
        values = np.random.default_rng(number).normal(size=(count, NUMBERS)).astype(np.float32)
        columns: dict[str, Any] = {
            **{n: pa.array(values.tolist(), vector) for n in ("observation.state", "action")},
            "timestamp": (np.arange(count) % FRAMES / FPS).astype(np.float32),
            "frame_index": np.arange(count) % FRAMES,
            "episode_index": index,
            "index": number * count + np.arange(count),
            "task_index": np.zeros(count, np.int64),
        }
        names = {"chunk_index": 0, "file_index": number}
        data = folder / data_path.format(**names)
        video = folder / video_path.format(**names, video_key=CAMERA)
        for file in (data, video):
            file.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.table(columns), data)
        shutil.copyfile(folder / "film.mp4", video)
    index_file = folder / "meta/episodes/chunk-000/file-000.parquet"
    index_file.parent.mkdir(parents=True)
    pq.write_table(pa.Table.from_pylist([_of_episode(n) for n in range(EPISODES)]), index_file)
    tasks = {"task_index": [0], "__index_level_0__": ["Push the cube."]}
    pq.write_table(pa.table(tasks), folder / "meta/tasks.parquet")
    floats = {"dtype": "float32", "shape": [NUMBERS], "names": None}
    film = {"dtype": "video", "shape": [48, 64, 3], "names": ["height", "width", "channels"]}
    features = {"observation.state": floats, "action": floats, CAMERA: film}
    info = {"codebase_version": "v3.0", "fps": FPS, "features": features}
    (folder / "meta/info.json").write_text(json.dumps(info))


def _of_episode(number: int) -> dict[str, Any]:
    file, place = divmod(number, IN_FILE)
    start_s = place * FRAMES / FPS
    of_video = {
        "chunk_index": 0, "file_index": file, "from_timestamp": start_s,
        "to_timestamp": start_s + FRAMES / FPS,
    }  # fmt: skip
    return {
        "episode_index": number,
        "length": FRAMES,
        "tasks": ["Push the cube."],
        "data/chunk_index": 0,
        "data/file_index": file,
        **{f"videos/{CAMERA}/{name}": value for name, value in of_video.items()},
        **{f"stats/{n}/{m}": [0.0] * NUMBERS for n in ("action", "state") for m in MEASURES},
    }


if __name__ == "__main__":
    main()
