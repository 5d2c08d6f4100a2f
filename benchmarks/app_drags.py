"""Drags over ten minutes of video: ``python -m benchmarks.app_drags``.

A page of 60 proposed steps and one of 14 curves at 50 Hz, in Chromium. The processor time of the
page's thread for each move of the pointer shows whether a drag keeps up with a screen, which
draws a frame each 16.7 ms. It needs the extra ``test``, and Chromium.
"""

from __future__ import annotations

import json
import logging
import tempfile
from pathlib import Path

import numpy as np
from playwright.sync_api import BrowserContext, Locator, Page, expect

from benchmarks.timing import row
from corpus_tools.tables.curve_file import Curve, write_curves
from tests.annotation_app.browser import Browser
from tests.annotation_app.in_browser import launched, serving, sign_in
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.lerobot_datasets import FPS, film

SECONDS, STEPS, MOVES = 600, 60, 150
CURVES, RATE_HZ = 14, 50
TASK = {"answers": 1, "practice": False}


def steps_of(folder: Path) -> Path:
    """Write a study of a video with many proposed steps."""
    film(folder / "films/long.mp4", [20 + i % 200 for i in range(SECONDS * FPS)])
    rows = "".join(f"long,{SECONDS // STEPS * i},lift cup {i}\n" for i in range(STEPS))
    (folder / "steps.csv").write_text(f"video,start_s,command\n{rows}")
    tasks = {"subtasks": TASK}
    return _study(folder, videos="films", subtasks="steps.csv", tasks=tasks)


def curves_of(folder: Path) -> Path:
    """Write a study of a video with many curves."""
    film(folder / "long.mp4", [100] * (SECONDS * FPS))
    samples = SECONDS * RATE_HZ
    t = np.arange(samples) / RATE_HZ
    noise = np.random.default_rng(0).normal(0, 0.1, (samples, CURVES))
    waves = np.sin(t[:, None] * (0.3 + 0.1 * np.arange(CURVES))) + noise
    curves = [Curve(f"group {n // 7}", f"joint {n % 7}") for n in range(CURVES)]
    file = folder / "long.safetensors"
    write_curves(file, curves, RATE_HZ, samples, [waves.astype(np.float32)])
    (folder / "episodes.csv").write_text("video,curves\nlong.mp4,long.safetensors\n")
    return _study(folder, videos="episodes.csv", tasks={"describe": TASK})


def _study(folder: Path, **settings: object) -> Path:
    file = folder / "robot.yaml"
    file.write_text(json.dumps({"name": "robot", "title": "Robot", **settings}))
    return file


def spent_ms(context: BrowserContext, page: Page, start: Locator, way_px: float) -> float:
    """Return the milliseconds of the page's thread for a move of the pointer, on average."""
    start.scroll_into_view_if_needed()
    box = start.bounding_box()
    assert box is not None
    x, y = box["x"] + min(box["width"] / 2, 10), box["y"] + box["height"] / 2
    session = context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return float(next(m["value"] for m in metrics if m["name"] == "TaskDuration"))

    page.mouse.move(x, y)
    page.mouse.down()
    before = spent()
    page.mouse.move(x + way_px, y, steps=MOVES)
    after = spent()
    page.mouse.up()
    return 1000 * (after - before) / MOVES


def main() -> None:
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    with tempfile.TemporaryDirectory() as name, launched() as browser:
        for what, made in (("steps", steps_of), ("curves", curves_of)):
            folder = Path(name) / what
            folder.mkdir()
            context = browser.new_context(viewport={"width": 1280, "height": 800})
            with set_up(made(folder)) as app, serving(app) as url:
                sign_in(context, Browser(app, study="robot"), url)
                page = context.new_page()
                task = "subtasks" if what == "steps" else "describe"
                page.goto(f"{url}/s/robot/{task}")
                if what == "steps":
                    expect(page.locator(".boundary")).to_have_count(STEPS)
                    start = page.get_by_role("slider", name="Beginning of step 4", exact=True)
                    ms = spent_ms(context, page, start, 20)
                    row(f"a drag over ten minutes of {STEPS} steps", f"{ms:.1f} ms a move")
                else:
                    page.locator(".curves summary").click()
                    plot = page.locator(".curve-plot").first
                    ms = spent_ms(context, page, plot, 900)
                    row(f"a drag over ten minutes of {CURVES} curves", f"{ms:.1f} ms a move")
                    for _ in range(5):
                        page.get_by_role("button", name="Show less time").click()
                    ms = spent_ms(context, page, plot, -40)  # out of it: each move draws all anew
                    row("a drag beyond the 20 seconds that are shown", f"{ms:.1f} ms a move")
            context.close()


if __name__ == "__main__":
    main()
