"""Videos against gymnasium's MujocoRenderer with imageio: ``python -m benchmarks.rendering``.

The peer needs the extra ``bench``. Processor time; for figures of one core, run it under
``taskset -c 0``.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args

import numpy as np

from benchmarks.timing import row, show
from corpus_tools.video.drawing.gl import choose_back_end

choose_back_end()
# MuJoCo takes the back end that is chosen before its import.
import mujoco  # noqa: E402

from corpus_tools.video.drawing.camera import overview  # noqa: E402
from corpus_tools.video.drawing.drawn_moments import sampled  # noqa: E402
from corpus_tools.video.encode import OPTIONS, Quality, encode  # noqa: E402
from corpus_tools.video.films import open_frames  # noqa: E402
from corpus_tools.video.items import scenario_items, story_of  # noqa: E402
from corpus_tools.world.physics.build import build_world, set_state  # noqa: E402
from corpus_tools.world.state.recording import Recording  # noqa: E402

SIZE = (640, 480)
SCENARIO = "dock_pick_up_tires"
FPS = 25
FRAMES = 250
PEER = "gymnasium's MujocoRenderer, imageio"
CAMERAS = ("overview", "follow", "operator")


def main() -> None:
    print(f"Drawing and encoding {SCENARIO}, {SIZE[0]} x {SIZE[1]}, {FPS} frames per second")
    story = story_of(scenario_items("warehouse", (SCENARIO,))[0])
    shown = sampled(_first_seconds(story.record(), FRAMES / FPS), FPS)
    rates: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video.mp4"
        ways: dict[str, Callable[[], None]] = {
            f"{camera}, {quality}": partial(_ours, shown, path, camera, quality)
            for camera in CAMERAS
            for quality in get_args(Quality)
        }
        if all(map(find_spec, ("gymnasium", "imageio"))):
            ways[PEER] = partial(_gymnasium, shown, path)
        for name, way in ways.items():
            start = time.process_time()
            way()
            rates[name] = len(shown.t_ns) / (time.process_time() - start)
            show(name, rates[name], "frames/s")
    for camera in CAMERAS:
        ours = rates[f"{camera}, standard"]
        is_compared = camera == "overview" and PEER in rates
        ratio = f"{ours / rates[PEER]:.1f} times the frames of {PEER}" if is_compared else ""
        row(f"frames of the camera {camera}", f"{ours:.0f} frames/s", ratio)


def _first_seconds(recording: Recording, duration_s: float) -> Recording:
    n = int(np.searchsorted(recording.t_s, duration_s))
    parts = ("t_ns", "position", "orientation", "fork_height_m")
    return replace(recording, **{part: getattr(recording, part)[:n] for part in parts})


def _ours(recording: Recording, path: Path, camera: str, quality: Quality) -> None:
    world = build_world(recording.start)
    with open_frames(world, recording, camera, SIZE, quality) as frames:
        pictures = map(frames.frame, range(len(recording.t_ns)))
        encode(pictures, path, size=SIZE, fps=FPS, quality=quality)


def _gymnasium(recording: Recording, path: Path) -> None:
    """Render the same view, with shadows and four samples a pixel, as MuJoCo draws them.

    The encoder is set as for ``standard``.
    """
    import imageio.v3 as iio  # noqa: PLC0415 - may be missing
    from gymnasium.envs.mujoco.mujoco_rendering import MujocoRenderer  # noqa: PLC0415

    world = build_world(recording.start)
    (camera,) = overview(recording, SIZE)
    ahead = camera.axes[2]
    world.model.vis.global_.fovy = math.degrees(camera.fovy)
    world.model.vis.global_.offwidth, world.model.vis.global_.offheight = SIZE
    data = mujoco.MjData(world.model)
    view = {
        "lookat": camera.position + ahead,
        "distance": 1.0,
        "azimuth": math.degrees(math.atan2(ahead[1], ahead[0])),
        "elevation": math.degrees(math.asin(ahead[2])),
    }
    renderer: Any = MujocoRenderer(
        world.model, data, default_cam_config=view, width=SIZE[0], height=SIZE[1], max_geom=5000
    )
    with iio.imopen(path, "w", plugin="pyav") as video:
        video.init_video_stream("libx264", fps=FPS)
        # imageio has no public way to the encoder's options.
        stream: Any = video._video_stream
        stream.options = {**OPTIONS["standard"], "threads": "1"}
        for k in range(len(recording.t_ns)):
            set_state(world, data, recording, k)
            mujoco.mj_camlight(world.model, data)
            video.write_frame(renderer.render("rgb_array"))
    renderer.close()


if __name__ == "__main__":
    main()
