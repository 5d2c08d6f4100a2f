"""Datasets by LeRobot's own writer, and what its reader and its renderer of samples see in them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.corpus_tools.lerobot.test_lerobot_itself import lerobot

FPS = 10
LENGTHS = (7, 12, 5, 9, 20, 6, 11)
TASKS = ("Push.", "Lift.", "", "Push.", "", "Turn.", "Lift.")
TOP, WRIST, DEPTH = (f"observation.images.{name}" for name in ("top", "wrist", "a_depth"))
QUESTIONS = {(0, 1): TOP, (0, 2): WRIST, (3, 8): TOP}
"""The cameras of the questions about a picture, by episode and frame."""

_WRITE = """
import json, sys
from pathlib import Path
import numpy as np
from lerobot.annotations.steerable_pipeline.executor import Executor
from lerobot.annotations.steerable_pipeline.reader import iter_episodes
from lerobot.annotations.steerable_pipeline.staging import EpisodeStaging
from lerobot.annotations.steerable_pipeline.writer import LanguageColumnsWriter
from lerobot.configs.video import RGBEncoderConfig
from lerobot.datasets.dataset_tools import delete_episodes
from lerobot.datasets.io_utils import write_info
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.video_utils import reencode_video

kind, told = sys.argv[2], json.loads(sys.argv[3])
root = Path(sys.argv[1] + ("-whole" if kind == "deleted" else ""))
top, wrist, depth = told["cameras"]

def camera(channels):
    return {"dtype": "image" if kind == "images" else "video", "shape": (48, 64, channels),
            "names": ["height", "width", "channels"]}

cameras = {top: camera(3), wrist: camera(3)}
if kind == "depth":
    cameras = {depth: {**camera(1), "info": {"is_depth_map": True}}, **cameras}
vector = {"dtype": "float32", "shape": (2,), "names": None}
features = {**cameras, "action": vector, "observation.state": vector}
made = LeRobotDataset.create("local/made", told["fps"], features, root=root,
                             use_videos=kind != "images")
made.meta.update_chunk_settings(
    chunks_size=2, video_files_size_in_mb=0.06, data_files_size_in_mb=0.002
)
rng = np.random.default_rng(0)
for episode, (length, task) in enumerate(zip(told["lengths"], told["tasks"])):
    for n in range(length):
        frame = {"action": rng.normal(size=2).astype(np.float32),
                 "observation.state": np.array([episode, n], np.float32), "task": task}
        for key, about in cameras.items():
            if key == depth:
                frame[key] = np.full((48, 64, 1), 500 + 100 * episode + n, np.uint16)
            else:
                frame[key] = rng.integers(0, 255, (48, 64, 3), dtype=np.uint8)
        made.add_frame(frame)
    made.save_episode()
made.finalize()

if kind == "videos":  # one camera AV1, the other H.264
    encoder = RGBEncoderConfig(vcodec="h264")
    for file in sorted((root / "videos" / wrist).rglob("*.mp4")):
        new = file.with_suffix(".new.mp4")
        reencode_video(file, new, encoder)
        new.replace(file)
    made.meta.update_video_info(video_key=wrist, video_encoder=encoder)
    write_info(made.meta.info, root)
if kind == "vqa":
    for episode, frame, key in told["questions"]:
        staging = EpisodeStaging(root / "staging", episode)
        rows = [{"role": role, "content": text, "style": "vqa", "camera": key,
                 "timestamp": float(np.float32(frame / told["fps"])), "tool_calls": None}
                for role, text in (("user", "Where?"), ("assistant", "There."))]
        staging.write("vqa", [*staging.read("vqa"), *rows])
    records = list(iter_episodes(root))
    LanguageColumnsWriter().write_all(records, root / "staging", root)
    Executor._ensure_annotation_metadata_in_info(root)
if kind == "deleted":
    whole = LeRobotDataset("local/made", root=root)
    delete_episodes(whole, [1, 6], output_dir=sys.argv[1], repo_id="local/kept")
"""

_READ = """
import hashlib, json, sys
from lerobot.configs.recipe import MessageTurn, TrainingRecipe
from lerobot.datasets.language_render import render_sample
from lerobot.datasets.lerobot_dataset import LeRobotDataset

data = LeRobotDataset("local/read", root=sys.argv[1], video_backend="pyav")
seen = "emitted_at(t, style=vqa, role={}, camera={})"
asked = {f"{who}_{camera.rsplit('.')[-1]}": seen.format(role, camera)
         for camera in data.meta.camera_keys
         for who, role in (("question", "user"), ("answer", "assistant"))}
names = ("task", "plan", "subtask", "interjection", *asked)
recipe = TrainingRecipe(
    bindings=asked,
    messages=[MessageTurn("user", name + ":${" + name + "}", stream="high_level") for name in names]
    + [MessageTurn("assistant", "done", stream="low_level", target=True)],
)
rows = []
for n in range(len(data)):
    one = data[n]
    said = render_sample(
        recipe=recipe, persistent=one.get("language_persistent"), events=one.get("language_events"),
        t=float(one["timestamp"]), sample_idx=n, dataset_ctx={"task": one["task"]},
    )
    texts = dict(turn["content"].split(":", 1) for turn in said["messages"][:-1])
    tensors = {key: hashlib.sha256(value.numpy().tobytes()).hexdigest()
               for key, value in one.items() if hasattr(value, "numpy")}
    rows.append({
        "episode": int(one["episode_index"]), "frame": int(one["frame_index"]),
        "time": round(float(one["timestamp"]), 6), "task": one["task"], "rendered": texts,
        "persistent": one.get("language_persistent") or [], "tensors": tensors,
    })
of_index = data.meta.episodes
marks = "marks/success"
print(json.dumps({"episodes": data.num_episodes, "language": data.meta.has_language_columns,
                  "depth": data.meta.depth_keys, "rows": rows,
                  "marks": list(of_index[marks]) if marks in of_index.column_names else []}))
"""


def write_dataset(folder: Path, kind: str) -> Path:
    """A dataset by LeRobot's writer: seven episodes, whose videos are in several files and chunks.

    ``videos`` has a camera in AV1 and one in H.264, ``vqa`` questions as its only language,
    ``depth`` a depth camera that comes first, ``images`` no videos; of ``deleted`` LeRobot's editor
    has deleted two episodes.
    """
    told = {
        "fps": FPS, "lengths": LENGTHS, "tasks": TASKS, "cameras": [TOP, WRIST, DEPTH],
        "questions": [[*place, camera] for place, camera in QUESTIONS.items()],
    }  # fmt: skip
    lerobot(_WRITE, folder, kind, json.dumps(told))
    return folder


def read_dataset(folder: Path) -> dict[str, Any]:
    """What a training on a dataset would see of each frame."""
    result: dict[str, Any] = json.loads(lerobot(_READ, folder).splitlines()[-1])
    return result
