"""The player, the manifest and the marks have one clock, whatever clock a film has."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.in_browser import errors_of, serving, sign_in
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.small_films import film

LENGTH_S = 2.0
FILMS: dict[str, dict[str, Any]] = {
    "recorded.webm": {"is_piped": True},
    "late.mp4": {"times": [1.5 + n / 10 for n in range(20)]},
    "sound.mp4": {"sound_s": 4},
    "turned.mp4": {"turned": 90},
}
SHOWN = """video => new Promise(shown => {
  video.requestVideoFrameCallback((_now, frame) => shown(frame.mediaTime));
  video.currentTime = 1.05;
})"""


def seen(page: Page) -> tuple[list[int], float, float]:
    """The size of what is shown, the browser's length, and the time of the frame at 1.05 s."""
    video = page.locator("video")
    expect(page.locator(".clock")).to_have_text(f"0.0 / {LENGTH_S:.1f} s")
    video.evaluate("v => v.readyState > 1 || new Promise(ok => v.oncanplay = () => ok())")
    size = video.evaluate("v => [v.videoWidth, v.videoHeight]")
    return size, video.evaluate("v => v.duration"), video.evaluate(SHOWN)


@pytest.mark.slow
def test_films_are_as_long_as_their_manifests_say(context: BrowserContext, tmp_path: Path):
    for name, how in FILMS.items():
        film(tmp_path / "clips" / name, **{"times": 20, "keys": 5, **how})
    task = {"practice": False, "answers": 1}
    study = {"name": "arm", "title": "An arm", "videos": "clips", "tasks": {"subtasks": task}}
    (tmp_path / "arm.yaml").write_text(json.dumps(study))
    sizes = []
    with set_up(tmp_path / "arm.yaml") as app, serving(app) as url:
        for _ in FILMS:
            sign_in(context, Known(app, study="arm"), url)  # each has another film
            page = context.new_page()
            errors = errors_of(page)
            page.goto(f"{url}/s/arm/subtasks")
            size, length_s, frame_s = seen(page)
            sizes.append(size)
            assert length_s == pytest.approx(LENGTH_S, abs=0.1)
            assert frame_s == pytest.approx(1.0, abs=0.002)
            page.locator("video").evaluate("v => { v.currentTime = 0; v.play(); }")
            expect(page.get_by_text("You have watched it to the end.")).to_be_visible()
            assert errors == []
            page.close()
    assert sorted(sizes) == [[48, 64], [64, 48], [64, 48], [64, 48]]
