"""Short real videos for the rendered folders of the other tests."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from tests.annotation_app.rendered import VIDEOS, World, context, render

WIDTH, HEIGHT, FPS, SECONDS = 320, 240, 10, 1.0
BOXES = ((20, 150), (110, 60), (220, 170), (150, 120))


def film(folder: Path, videos: tuple[str, ...] = VIDEOS, world: World = context) -> Path:
    """Folders as `render` makes them, with videos that play for a second and differ."""
    render(folder, videos, world)
    for target in folder.iterdir():
        _write_video(target / "video.mp4", shade=10 * videos.index(target.name))
        _write_picture(target / "poster.png")
        manifest = json.loads((target / "manifest.json").read_text())
        manifest["duration_s"] = SECONDS
        manifest["fps"] = FPS
        manifest["steps"] = [
            {"action": "drive_to", "arguments": {}, "start_s": start, "end_s": start + SECONDS / 2}
            for start in (0.0, SECONDS / 2)
        ]
        (target / "manifest.json").write_text(json.dumps(manifest))
        segmentation = json.loads((target / "segmentation.json").read_text())
        segmentation |= {"width": WIDTH, "height": HEIGHT}
        for number, outline in enumerate(segmentation["objects"]):
            x, y = BOXES[number % len(BOXES)]
            y += 10 * (number // len(BOXES))
            outline["box"] = [x, y, 50, 40]
            outline["polygons"] = [[[x, y], [x + 50, y], [x + 50, y + 40], [x, y + 40]]]
        if target.name == videos[1]:
            segmentation["objects"][1] |= {"box": None, "polygons": []}  # hidden by another thing
        (target / "segmentation.json").write_text(json.dumps(segmentation))
    return folder


def _picture(number: int) -> np.ndarray:
    image = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    for i, (x, y) in enumerate(BOXES):
        shift = 4 * number if i == len(BOXES) - 1 else 0
        image[y : y + 40, x + shift : x + shift + 50] = (60 * i, 200 - 40 * i, 120)
    return image


def _write_video(path: Path, *, shade: int) -> None:
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=FPS)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = Fraction(1, FPS)
        for number in range(round(SECONDS * FPS)):
            image = _picture(number)
            image[:8, :8] = shade
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _write_picture(path: Path) -> None:
    with av.open(str(path), "w", format="image2") as container:
        stream = container.add_stream("png", rate=1)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "rgb24"
        container.mux(stream.encode(av.VideoFrame.from_ndarray(_picture(0), format="rgb24")))
        container.mux(stream.encode(None))
