"""Make README's pictures and those of the gallery.

``python docs/make_pictures.py`` runs ``ct graph`` and ``ct follow`` and writes ``docs/follow``.
``python docs/make_pictures.py frames`` draws frames of bundled logs into ``docs/frames``.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import av
from PIL import Image

from corpus_tools.logs.log_reading import read_log
from corpus_tools.video.drawing.drawn_moments import sampled
from corpus_tools.video.drawing.gl import choose_back_end
from corpus_tools.world.scenarios.scenario_logs import log_file
from corpus_tools.world.scenarios.scenario_reading import (
    dataset_folder,
    read_scenario,
    scenario_file,
)
from corpus_tools.world.state.onlookers import with_onlookers

FRAMES = {
    ("yard_unload_tires_from_trailer", "track"): 0.45,
    ("court_put_boxes_on_loaded_truck", "track"): 0.8,
    ("aisles_drive_past_person", "follow"): 0.35,
    ("hall_take_tires_to_truck", "track"): 0.75,
    ("depot_put_down_tires_by_barrel", "track"): 0.7,
    ("dock_pick_up_tires", "operator"): 0.4,
    ("aisles_put_tires_in_storage_e", "track"): 0.8,
    ("court_put_crate_on_trailer", "overview"): 0.5,
}
"""Scenarios and cameras of the gallery, with the share of the film at which the frame is."""
FRAME_QUALITY = 80
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


def draw_frames(out: Path) -> None:
    """Draw the gallery's frames from bundled logs, as ``ct render-videos`` draws them."""
    choose_back_end()
    from corpus_tools.video.films import open_frames  # noqa: PLC0415 - after the choice
    from corpus_tools.world.physics.build import build_world  # noqa: PLC0415

    dataset = dataset_folder("warehouse")
    for (name, camera), share in FRAMES.items():
        scenario = read_scenario(scenario_file(name, dataset))
        recording = with_onlookers(read_log(log_file(scenario, dataset)).recording)
        shown = sampled(recording, FRAMES_S)
        world = build_world(recording.start, site=scenario.layout.site)
        with open_frames(world, shown, camera, SIZE, "standard") as frames:
            picture = Image.fromarray(frames.frame(round(share * (len(shown.t_ns) - 1))))
        picture.save(out / f"{name}-{camera}.jpg", quality=FRAME_QUALITY, optimize=True)


def main() -> None:
    """Make README's pictures, or the gallery's."""
    if sys.argv[1:] == ["frames"]:
        draw_frames(OUT.with_name("frames"))
        return
    OUT.mkdir(exist_ok=True)
    ct("graph", CLAUSES, "--format", "svg", "--out", str(OUT / "graph.svg"))
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "follow.mp4"
        ct("follow", COMMAND, "--scenario", SCENARIO, "--video", str(video), "--yes")
        animate(video, OUT / "follow.webp")


if __name__ == "__main__":
    main()
