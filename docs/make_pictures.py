"""Make README's pictures: a command's grounding graph, and the robot following it.

``python docs/make_pictures.py`` runs ``ct graph`` and ``ct follow`` and writes ``docs/follow``.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import av
from PIL import Image

OUT = Path(__file__).resolve().parent / "follow"
COMMAND = "Put both tire pallets on the truck"
CLAUSES = "EVENT(r = Put, l = OBJ(f = the tire pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
SCENARIO = "court_take_tires_to_issue"
SIZE = (640, 360)
SPEED_UP, FRAMES_S = 12, 10
QUALITY = 50


def ct(*args: str) -> None:
    """Run ``ct``."""
    subprocess.run([sys.executable, "-m", "corpus_tools", *args], check=True)  # noqa: S603 - ours


def animate(video: Path, out: Path) -> None:
    """Shorten a video to an animated picture."""
    with av.open(video) as container:
        stream = container.streams.video[0]
        rate = float(stream.average_rate or 25)
        step = round(rate * SPEED_UP / FRAMES_S)
        frames = [
            frame.to_image().resize(SIZE, Image.Resampling.LANCZOS)
            for k, frame in enumerate(container.decode(stream))
            if k % step == 0
        ]
    durations = [1000 // FRAMES_S] * (len(frames) - 1) + [2000]
    frames[0].save(
        out,
        save_all=True,
        append_images=frames[1:],
        duration=durations,
        loop=0,
        quality=QUALITY,
        method=6,
        minimize_size=True,
    )


def main() -> None:
    """Make both."""
    OUT.mkdir(exist_ok=True)
    ct("graph", CLAUSES, "--format", "svg", "--out", str(OUT / "graph.svg"))
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "follow.mp4"
        ct("follow", COMMAND, "--scenario", SCENARIO, "--video", str(video), "--yes")
        animate(video, OUT / "follow.webp")


if __name__ == "__main__":
    main()
