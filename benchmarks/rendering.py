"""Videos against gymnasium's MujocoRenderer with imageio, and several jobs against one.

``python -m benchmarks.rendering`` compares where the extra ``bench`` is installed. For figures of
one core, run it under ``taskset -c 0`` with ``--jobs 1``.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.timing import aim, compare, heading, show
from corpus_tools.video.drawing.gl import choose_back_end

if TYPE_CHECKING:
    from corpus_tools.world.state.recording import Recording

SIZE = (640, 480)
SCENARIO = "dock_pick_up_tires"
FPS = 25
FRAMES = 250
PEER = "gymnasium's MujocoRenderer, imageio"
WHY_SLOW = "there is no GPU; fewer rows draw in 26 ms, but thin lines break (docs/videos.md)"
CAMERAS = ("overview", "follow", "operator")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rendering", description=__doc__)
    parser.add_argument("--scenario", default=SCENARIO)
    parser.add_argument("--jobs", type=int, default=2, help="how many at a time (default: 2)")
    parser.add_argument("--frames", type=int, default=FRAMES, help=f"drawn ({FRAMES})")
    arguments = parser.parse_args()
    choose_back_end()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    print(f"{cores} cores, load {os.getloadavg()[0]:.1f}, {os.environ['MUJOCO_GL']}")
    run(arguments.scenario, arguments.frames)
    if arguments.jobs > 1:
        _jobs(arguments.jobs)


def run(scenario: str = SCENARIO, count: int = FRAMES) -> None:
    from corpus_tools.logs.log_writing import to_bytes  # noqa: PLC0415 - after the back end's choice
    from corpus_tools.video.drawing.drawn_moments import sampled  # noqa: PLC0415
    from corpus_tools.video.items import scenario_items, story_of  # noqa: PLC0415

    heading(f"Drawing and encoding {scenario}, {SIZE[0]} x {SIZE[1]}, {FPS} frames per second")
    story = story_of(scenario_items("warehouse", (scenario,))[0])
    whole = story.record()
    recording = _first_seconds(whole, count / FPS)
    shown = sampled(recording, FPS)
    seconds: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video.mp4"
        ways: dict[str, Callable[[], None]] = {
            f"{camera}, {quality}": lambda camera=camera, quality=quality: _ours(  # type: ignore[misc]
                shown, path, camera, quality
            )
            for camera in CAMERAS
            for quality in ("draft", "standard", "high")
        }
        if all(map(find_spec, ("gymnasium", "imageio"))):
            ways[PEER] = lambda: _gymnasium(shown, path)
        else:
            print(f"  left out: {PEER} (extra bench)")
        for name, way in ways.items():
            start, cpu = time.perf_counter(), time.process_time()
            way()
            seconds[name] = time.process_time() - cpu
            wall = time.perf_counter() - start
            rate = len(shown.t_ns) / seconds[name]
            show(name, rate, "frames/s", f"{seconds[name]:.1f} s of processor, {wall:.1f} s")
        start = time.process_time()
        to_bytes(recording, name=scenario, metadata={})
        log = time.process_time() - start
    for camera in ("follow", "operator"):
        each = 1000 * seconds[f"{camera}, standard"] / len(shown.t_ns)
        aim(
            f"a frame of the camera {camera}, standard",
            f"{each:.0f} ms",
            "30 ms",
            reached=each <= 30,
            reason=WHY_SLOW,
        )
    slower = [c for c in CAMERAS if seconds[f"{c}, draft"] > seconds[f"{c}, standard"]]
    aim(
        "cameras whose draft is slower than standard",
        ", ".join(slower) or "none",
        "none",
        reached=not slower,
    )
    ours = seconds["overview, standard"]
    if PEER in seconds:
        limit = "encoding, and filling pixels without a GPU"
        compare("drawing and encoding", "gymnasium with imageio", ours / seconds[PEER], limit)
    show("10 s of video and its log", (ours + log) * FRAMES / len(shown.t_ns), "s of processor")


def _first_seconds(recording: Recording, duration_s: float) -> Recording:
    n = int(np.searchsorted(recording.t_s, duration_s))
    return replace(
        recording,
        t_ns=recording.t_ns[:n],
        position=recording.position[:n],
        orientation=recording.orientation[:n],
        fork_height_m=recording.fork_height_m[:n],
    )


def _ours(recording, path: Path, camera: str, quality: str) -> None:  # type: ignore[no-untyped-def]
    from corpus_tools.video.encode import encode  # noqa: PLC0415
    from corpus_tools.video.frame_renderers import open_frames  # noqa: PLC0415
    from corpus_tools.world.physics.build import build_world  # noqa: PLC0415

    world = build_world(recording.start)
    with open_frames(world, recording, camera, SIZE, quality) as frames:  # type: ignore[arg-type]
        pictures = map(frames.frame, range(len(recording.t_ns)))
        encode(pictures, path, size=SIZE, fps=FPS, quality=quality)  # type: ignore[arg-type]


def _gymnasium(recording, path: Path) -> None:  # type: ignore[no-untyped-def]
    """The same view, with shadows and four samples a pixel, as MuJoCo draws them.

    The encoder is set as for ``standard``.
    """
    import imageio.v3 as iio  # noqa: PLC0415
    import mujoco  # noqa: PLC0415
    from gymnasium.envs.mujoco.mujoco_rendering import MujocoRenderer  # noqa: PLC0415

    from corpus_tools.video.drawing.camera import overview  # noqa: PLC0415
    from corpus_tools.video.encode import OPTIONS  # noqa: PLC0415
    from corpus_tools.world.physics.build import build_world, set_state  # noqa: PLC0415

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


def _jobs(jobs: int) -> None:
    heading(f"ct render-videos, {jobs} jobs against one")
    seconds = {}
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, jobs):
            out = Path(folder) / str(count)
            command = [sys.executable, "-m", "corpus_tools", "render-videos", "--only", "[dh]*"]
            start = time.perf_counter()
            subprocess.run(
                [*command, "--out", str(out), "--jobs", str(count)],
                check=True,
                stdout=subprocess.DEVNULL,
                env={**os.environ, "LP_NUM_THREADS": "1"},
            )
            seconds[count] = time.perf_counter() - start
            show(f"{count} at a time", seconds[count], "s", f"{len(list(out.iterdir()))} videos")
    show(f"{jobs} jobs / one", seconds[1] / seconds[jobs], "times as fast")


if __name__ == "__main__":
    main()
