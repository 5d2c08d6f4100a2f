"""Folders like those of ct render-videos, with small worlds and without real pictures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.logs.log_writing import write_log
from corpus_tools.world.state.recording import NS_PER_S, Recording, Step, upright
from g3.groundings import Context, PhysicalObject, Place, Prism
from tests.worlds import prism, still

VIDEOS = ("hall_fetch_tires", "yard_load_truck", "dock_drive_to_boxes")
FPS = 4
DURATION_S = 10.0
FILM_S = 1.0
"""So short that nobody waits for its end."""
WORDS = ("hall", "fetch", "tire", "yard", "load", "truck", "dock", "boxes", "pallet", "forklift")
"""What no page may tell of the videos."""


def box(x: float, y: float, height: float = 1.0) -> Prism:
    return prism(x, y, (2, 1), (0.0, height))


def context(name: str, number: int) -> Context:
    objects = (
        PhysicalObject("tires-1", ("tire", "pallet"), box(6, number), still(6, number)),
        PhysicalObject("boxes-1", ("box", "pallet"), box(6, 5 + number), still(6, 5 + number)),
        PhysicalObject("truck", ("truck",), box(-6, number, 1.4), still(-6, number)),
        PhysicalObject("robot", ("forklift",), box(0, 0), still(0, 0)),
    )
    places = (Place(box(0, -6, 0.3), "receiving"), Place(box(4, -6, 0.3), "storage"))
    return Context(name, objects, places, "robot")


World = Callable[[str, int], Context]
"""What is where when a video of this name and number begins."""


def recording(name: str, number: int, world: World = context) -> Recording:
    """The robot drives to the right, or to the left in every other video."""
    start = world(name, number)
    t = np.arange(0, DURATION_S, 1 / FPS)
    position = np.zeros((len(t), len(start.objects), 3))
    position[:] = [o.trajectory.xyz[0] for o in start.objects]
    position[:, -1, 0] = np.linspace(0, 4 if number % 2 == 0 else -4, len(t))
    steps = (Step("drive_to", (("object", "tires-1"),), 0.0, 5.0), Step("wait", (), 5.0, 10.0))
    return Recording(
        start,
        (t * NS_PER_S).astype(np.int64),
        position,
        upright(np.zeros(position.shape[:2])),
        np.full(len(t), 0.1),
        steps,
    )


def render(folder: Path, videos: tuple[str, ...] = VIDEOS, world: World = context) -> Path:
    for number, name in enumerate(videos):
        target = folder / name
        target.mkdir(parents=True)
        made = recording(name, number, world)
        write_log(made, target / "log.mcap", name=name, metadata={})
        outlines = [
            {
                "id": o.id,
                "value": i + 1,
                "labels": list(o.labels),
                "pixels": 100,
                "box": [10 * i, 10, 9, 9],
                "polygons": [[[10 * i, 10], [10 * i + 9, 10], [10 * i + 9, 19]]],
            }
            for i, o in enumerate(made.start.objects)
        ]
        segmentation = {"width": 64, "height": 48, "objects": outlines, "places": []}
        steps = [
            {"action": s.action, "arguments": {}, "start_s": s.start_s, "end_s": s.end_s}
            for s in made.steps
        ]
        manifest = {"id": name, "title": name, "duration_s": FILM_S, "steps": steps}
        (target / "segmentation.json").write_text(json.dumps(segmentation))
        (target / "manifest.json").write_text(json.dumps(manifest))
        for file in ("video.mp4", "poster.png", "segmentation.png"):
            (target / file).write_bytes(f"{name} {file} ".encode() * 100)
    return folder


def render_contexts(folder: Path, corpus: Corpus) -> Path:
    """A video for each context of a corpus, whose name it has."""
    names = tuple(f"video{i:03}" for i in range(len(corpus.contexts)))
    render(folder, names)
    for name, context in zip(names, corpus.contexts, strict=True):
        file = folder / name / "manifest.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), "id": context}))
    return folder
