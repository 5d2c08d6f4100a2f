"""Make the scene of the app's practice examples: draw its video and write ``tasks/practice.json``.

``python docs/make_practice.py`` does so after a change of the scene; it needs the extra ``render``.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import numpy.typing as npt

from annotation_app.tasks.clause_words import words_of

WIDTH, HEIGHT, FPS = 480, 360, 15
SCALE = 20.0
"""Pixels to a metre."""
SECONDS = 5.0
COMMAND = "Sail to the buoy by the lighthouse."
START, END = (4.0, 3.0), (14.6, 12.4)
BUOYS = {"thing-b": (9.0, 15.0), "thing-c": (16.6, 13.2), "thing-e": (18.0, 4.0)}
LIGHTHOUSE = (20.0, 14.4)
HARBOUR = ((1.0, 1.0), (7.0, 1.0), (7.0, 5.0), (1.0, 5.0))
APP = Path(__file__).resolve().parents[1] / "annotation_app"

SEA, FOAM, SAND, GRASS = (196, 150, 74), (220, 190, 140), (150, 205, 232), (96, 160, 98)
RED, WHITE, WOOD = (52, 56, 214), (248, 248, 248), (60, 96, 150)
"""Blue, green and red, as OpenCV has them."""

Polygon = npt.NDArray[np.float64]


def main() -> None:
    """Write the video, its first picture and what there is to make examples of."""
    target = APP / "static" / "practice"
    target.mkdir(exist_ok=True)
    _write_video(target / "practice.mp4")
    text = json.dumps(_example(), indent=1, ensure_ascii=False)
    (APP / "tasks" / "practice.json").write_text(text + "\n", encoding="utf-8")


def _boat_at(t: float) -> tuple[float, float, float]:
    share = min(max((t - 0.5) / (SECONDS - 1.2), 0.0), 1.0)
    smooth = share * share * (3 - 2 * share)
    bend = 2.2 * np.sin(np.pi * smooth)
    dx, dy = END[0] - START[0], END[1] - START[1]
    length = float(np.hypot(dx, dy))
    x = START[0] + smooth * dx + bend * dy / length
    y = START[1] + smooth * dy - bend * dx / length
    slope = 2.2 * np.pi * np.cos(np.pi * smooth)
    return x, y, float(np.arctan2(dy - slope * dx / length, dx + slope * dy / length))


def _boat(t: float) -> Polygon:
    x, y, yaw = _boat_at(t)
    hull = np.array([[-1.2, -0.5], [0.6, -0.5], [1.4, 0], [0.6, 0.5], [-1.2, 0.5]])
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    moved: Polygon = hull @ turn.T + np.array([x, y])
    return moved


def _disc(centre: tuple[float, float], radius: float, corners: int = 12) -> Polygon:
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    disc: Polygon = np.column_stack([np.cos(angles), np.sin(angles)]) * radius + np.array(centre)
    return disc


def _pixels(polygon: Polygon) -> npt.NDArray[np.int32]:
    return np.round(np.column_stack([polygon[:, 0], 18 - polygon[:, 1]]) * SCALE).astype(np.int32)


def _picture(t: float) -> npt.NDArray[np.uint8]:
    image = np.full((HEIGHT, WIDTH, 3), SEA, np.uint8)

    def fill(polygon: Polygon, colour: tuple[int, int, int]) -> None:
        cv2.fillPoly(image, [_pixels(polygon)], colour, cv2.LINE_AA)

    for i in range(40):
        x, y = (i * 7.3) % 24, (i * 4.7 + 0.4 * np.sin(t * 2 + i)) % 18
        fill(np.array([[x, y], [x + 0.9, y], [x + 0.9, y + 0.08], [x, y + 0.08]]), FOAM)
    fill(np.array(HARBOUR) + np.array([0.0, -0.1]), (172, 128, 60))
    cv2.polylines(image, [_pixels(np.array(HARBOUR))], True, WHITE, 2, cv2.LINE_AA)
    fill(_disc(LIGHTHOUSE, 2.0, 40), SAND)
    fill(_disc(LIGHTHOUSE, 1.5, 40), GRASS)
    fill(_disc(LIGHTHOUSE, 0.75, 30), WHITE)
    fill(_disc(LIGHTHOUSE, 0.45, 30), RED)
    for centre in BUOYS.values():
        fill(_disc(centre, 0.55, 30), WHITE)
        fill(_disc(centre, 0.42, 30), RED)
    fill(_boat(t), WOOD)
    x, y, _ = _boat_at(t)
    fill(_disc((x, y), 0.32, 20), WHITE)
    return image


def _write_video(path: Path) -> None:
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=FPS, options={"crf": "28"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = Fraction(1, FPS)
        for i in range(round(SECONDS * FPS)):
            frame = av.VideoFrame.from_ndarray(_picture(i / FPS), format="bgr24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _example() -> dict[str, Any]:
    words = _words(COMMAND)
    watched = {
        "video": "/static/practice/practice.mp4",
        "poster": None,
        "duration_s": SECONDS,
        "fps": FPS,
    }
    sdcs = [_tree(words)]
    scene = {**watched, "steps": [[0.5, SECONDS]], **_scene()}
    clauses = [
        {"node": 0, "type": "EVENT", "phrase": "Sail to the buoy by the lighthouse"},
        {"node": 2, "type": "PATH", "phrase": "to the buoy by the lighthouse"},
        {"node": 3, "type": "OBJECT", "phrase": "the buoy by the lighthouse"},
        {"node": 4, "type": "OBJECT", "phrase": "the buoy"},
        {"node": 5, "type": "OBJECT", "phrase": "the lighthouse"},
    ]
    return {
        "command": COMMAND,
        "words": words,
        "sdcs": sdcs,
        "clauses": clauses,
        "watched": watched,
        "scene": scene,
    }


def _words(text: str) -> list[dict[str, Any]]:
    return list(words_of(text))


def _tree(words: list[dict[str, Any]]) -> dict[str, Any]:
    sail, to, the, buoy, by, the2, lighthouse = ([w["text"], w["start"]] for w in words[:7])
    described = {
        "type": "OBJECT",
        "f": [{"type": "OBJECT", "f": [the, buoy]}],
        "r": [by],
        "l": [{"type": "OBJECT", "f": [the2, lighthouse]}],
    }
    path = {"type": "PATH", "r": [to], "l": [described]}
    return {"type": "EVENT", "f": [{"type": "OBJECT"}], "r": [sail], "l": [path]}


def _scene() -> dict[str, Any]:
    things = {
        "thing-a": _boat(0.0),
        **{name: _disc(centre, 0.55) for name, centre in BUOYS.items()},
        "thing-d": _disc(LIGHTHOUSE, 0.8),
    }
    moments = np.arange(0, SECONDS + 0.25, 0.25)
    track = [[round(float(v), 3) for v in (t, *_boat_at(float(t)))] for t in moments]
    outlines = []
    for i, (name, polygon) in enumerate(things.items()):
        corners = _pixels(polygon)
        low, high = corners.min(axis=0), corners.max(axis=0)
        box = [*low.tolist(), *(high - low).tolist()]
        outlines.append({"id": name, "value": i + 1, "box": box, "polygons": [corners.tolist()]})
    objects: list[dict[str, Any]] = [
        {"id": name, "footprint": np.round(polygon, 2).tolist(), "z": 1.0}
        for name, polygon in things.items()
    ]
    objects[0]["track"] = track
    return {
        "segmentation": {"image": None, "width": WIDTH, "height": HEIGHT, "objects": outlines},
        "map": {
            "bounds": [0, 0, 24, 18],
            "turn": 0.0,
            "robot": "thing-a",
            "objects": objects,
            "places": [{"id": "place-a", "polygon": [list(corner) for corner in HARBOUR]}],
        },
    }


if __name__ == "__main__":
    main()
