"""Several cameras in step, and state and action as curves below them, in a real browser."""

from __future__ import annotations

import json
import logging
import re
import statistics
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from corpus_tools.cli.console import run
from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.in_browser import SERIOUS, drawn_anew, errors_of, look, serving, sign_in
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import STUDY
from tests.lerobot_datasets import WRIST, film, new_dataset

pytestmark = pytest.mark.slow

log = logging.getLogger(__name__)
FRAMES = 40
NAMES = [f"{group} {name}" for group in ("observation.state", "action") for name in "abc"]
IN_STEP_S = 0.06
"""Less than a frame, and more than a busy browser needs for a correction."""
DRIFTS = """videos => new Promise(done => {
    const [first, ...others] = videos, found = [];
    const end = performance.now() + 2500;
    const look = () => {
        const gaps = others.map(other => Math.abs(other.currentTime - first.currentTime));
        if (!first.paused) found.push(Math.max(...gaps));
        performance.now() < end && !first.ended ? requestAnimationFrame(look) : done(found);
    };
    look();
})"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """The file of a study of an episode by two cameras, whose greys tell the frame."""
    folder = new_dataset(tmp_path / "set", lengths=(FRAMES, 8, 10))
    film(folder / f"videos/{WRIST}/chunk-000/file-000.mp4", [220 - 2 * n for n in range(58)])
    call = ["import", "lerobot", str(folder), "--first", "1", "--out", str(tmp_path / "tables")]
    assert run(call) == 0
    file = tmp_path / "robot.yaml"
    file.write_text(json.dumps(STUDY))
    return file


def opened(context: BrowserContext, app: Any, url: str, task: str = "describe") -> Page:
    """A task's page, all of whose videos have come."""
    sign_in(context, Known(app, study="robot"), url)
    page = context.new_page()
    page.goto(f"{url}/s/robot/{task}")
    for video in page.locator("video").all():
        expect(video).to_have_js_property("readyState", 4)
    return page


def frames(page: Page) -> list[int]:
    """The number of the frame that each camera shows, by its grey."""
    page.wait_for_timeout(100)
    for video in page.locator("video").all():
        expect(video).to_have_js_property("seeking", False)
    page.wait_for_timeout(100)
    greys = page.locator("video").evaluate_all(
        """videos => videos.map(video => {
            const canvas = Object.assign(document.createElement("canvas"), {width: 1, height: 1});
            const pen = canvas.getContext("2d");
            pen.drawImage(video, 0, 0, 1, 1);
            return pen.getImageData(0, 0, 1, 1).data[0];
        })"""
    )
    return [round((greys[0] - 20) / 2), round((220 - greys[1]) / 2)]


def width_of(element: Locator) -> float:
    box = element.bounding_box()
    assert box is not None
    return box["width"]


def test_cameras_go_in_step(context: BrowserContext, study: Path) -> None:
    with set_up(study) as app, serving(app) as url:
        page = opened(context, app, url)
        errors = errors_of(page)
        assert frames(page) == [0, 0]
        for _ in range(3):
            page.keyboard.press(".")
        assert frames(page) == [3, 3]
        page.keyboard.press(",")
        assert frames(page) == [2, 2]
        slider = page.get_by_label("Time in the video")
        slider.focus()
        slider.press("End")
        assert frames(page) == [FRAMES - 1] * 2
        slider.press("Home")
        assert frames(page) == [0, 0]
        page.get_by_role("button", name="Play").click()
        page.wait_for_timeout(300)
        page.locator("video").nth(1).evaluate("video => { video.currentTime += 0.25 }")
        drifts = page.locator("video").evaluate_all(DRIFTS)
        log.info("drift: median %.3f s, last %.3f s", statistics.median(drifts), drifts[-1])
        assert max(drifts) > 0.1  # the one that was put out of step
        assert statistics.median(drifts[-len(drifts) // 4 :]) < IN_STEP_S
        page.keyboard.press("k")
        first, second = frames(page)
        assert first == second
        page.get_by_label("Speed").select_option("2×")
        page.keyboard.press("Escape")
        page.locator("h1").click()
        page.keyboard.press("k")
        expect(page.get_by_text("You have watched it to the end.")).to_be_visible()
        assert frames(page) == [FRAMES - 1] * 2
        assert errors == []


def test_the_large_camera_is_chosen_and_remembered(context: BrowserContext, study: Path) -> None:
    with set_up(study) as app, serving(app) as url:
        page = opened(context, app, url)
        top, wrist = page.locator(".camera").all()
        assert width_of(top) > 1.5 * width_of(wrist)
        page.get_by_role("button", name="wrist").click()
        drawn_anew(page)
        assert width_of(wrist) > 1.5 * width_of(top)
        assert page.locator("video").first.evaluate("video => video.paused")
        page.goto(f"{url}/s/robot/rate")  # another task, the same person
        top, wrist = page.locator(".camera").all()
        assert width_of(wrist) > 1.5 * width_of(top)
        expect(page.get_by_role("button", name="wrist")).to_have_attribute("aria-pressed", "true")
        page.keyboard.press("v")
        drawn_anew(page)
        assert width_of(top) > 1.5 * width_of(wrist)
        page.get_by_role("button", name="All cameras alike").click()
        page.reload()
        top, wrist = page.locator(".camera").all()
        assert width_of(wrist) == pytest.approx(width_of(top), abs=2)
        page.get_by_role("button", name="top").click()
        page.set_viewport_size({"width": 390, "height": 844})
        drawn_anew(page)
        large, small = top.bounding_box(), wrist.bounding_box()
        assert large is not None
        assert small is not None
        assert small["y"] >= large["y"] + large["height"]
        assert small["width"] < large["width"] < 390


def values(page: Page) -> dict[str, str]:
    """What is told of each curve, by its group and name."""
    return {
        f"{group.get_attribute('aria-label')} {chip.locator('span').inner_text()}": (
            chip.locator("output").inner_text()
        )
        for group in page.locator(".curve-group").all()
        for chip in group.locator(".curve-chip").all()
    }


def test_curves_tell_the_moment_and_seek(context: BrowserContext, study: Path) -> None:
    rng = np.random.default_rng(0)  # as the dataset is made
    action, state = (rng.normal(size=(FRAMES, 3)) for _ in range(2))
    known = np.hstack((state, action))

    def expected(frame: int) -> dict[str, str]:
        return dict(zip(NAMES, known[frame], strict=True))

    def check(frame: int) -> None:
        page.wait_for_timeout(100)
        told = {name: float(value) for name, value in values(page).items()}
        assert told == pytest.approx(expected(frame), abs=0.01)

    with set_up(study) as app, serving(app) as url:
        page = opened(context, app, url)
        errors = errors_of(page)
        expect(page.locator(".curve-plot")).to_have_count(0)  # small windows are for the video
        page.locator(".curves summary").click()
        plot = page.get_by_role("slider", name="Time in the curves of action")
        check(0)
        page.keyboard.press(".")
        check(1)
        plot.focus()
        plot.press("ArrowRight")
        assert frames(page) == [2, 2]
        check(2)
        plot.press("Shift+ArrowRight")
        assert frames(page) == [12, 12]
        plot.press("Home")
        check(0)
        told = plot.get_attribute("aria-valuetext")
        assert told is not None
        assert told.startswith(f"0.0 seconds: a {known[0, 3]:.3f}, b")
        box = plot.bounding_box()
        assert box is not None
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + box["width"] * 0.751, middle)
        check(30)  # the pointer, while the video stays
        assert frames(page) == [0, 0]
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] * 0.501, middle, steps=4)
        page.mouse.up()
        page.mouse.move(0, 0)
        assert frames(page) == [20, 20]
        check(20)
        page.get_by_role("button", name="Show less time").click()
        expect(page.locator(".curves-tools")).to_contain_text("1.0 to 3.0 s")
        plot.press("End")
        expect(page.locator(".curves-tools")).to_contain_text("2.0 to 4.0 s")
        check(FRAMES - 1)
        page.get_by_role("group", name="action").get_by_label("b").focus()
        page.keyboard.press("Space")
        page.get_by_role("group", name="observation.state").get_by_text("Hide all").click()
        expect(plot).to_have_attribute("aria-valuetext", re.compile(r": a \S+, c \S+$"))
        page.reload()
        expect(page.locator(".curve-chip input")).to_have_count(len(NAMES))
        shown = page.locator(".curve-chip input").evaluate_all("all => all.map(i => i.checked)")
        assert shown == [False, False, False, True, False, True]
        page.locator(".curves summary").click()
        page.reload()
        expect(page.locator(".player-bar")).to_be_visible()
        expect(page.locator(".curve-plot").first).to_be_hidden()
        page.locator(".curves summary").click()
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            assert look(page, f"curves-{scheme}", SERIOUS) == []
        assert errors == []


def test_numbers_are_sent_in_parts_and_to_those_who_take_part(study: Path) -> None:
    with set_up(study) as app:
        worker = Known(app, study="robot")
        page = worker.lease("describe", "robot").json
        beside = page["payload"]["beside"]
        assert beside["cameras"] == ["top", "wrist"]
        file = study.parent / "tables/curves/episode-000000.safetensors"
        with worker.client.get(f"/media/{beside['curves']}", headers={"Range": "bytes=8-63"}) as r:
            assert (r.status_code, r.data) == (206, file.read_bytes()[8:64])
        for stranger in (Known(app, study=None), None):
            client = app.test_client() if stranger is None else stranger.client
            for name in (beside["curves"], *beside["views"]):
                assert client.get(f"/media/{name}").status_code in (401, 404)
        file.write_bytes(file.read_bytes()[:-4] + b"0000")
        assert worker.client.get(f"/media/{beside['curves']}").status_code == 404


@pytest.mark.parametrize("content", [b"root:x:0:0", None])
def test_other_files_than_curves_are_refused(content: bytes | None, study: Path, capsys) -> None:
    file = study.parent / "tables/curves/episode-000000.safetensors"
    file.unlink()
    if content is not None:
        file.write_bytes(content)
    call = ["annotate", "check", str(study), "--instance", str(study.parent / "instance")]
    assert run(call) == 2
    assert "no whole file of curves" in capsys.readouterr().out
