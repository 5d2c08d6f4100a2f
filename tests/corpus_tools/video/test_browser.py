"""The videos in the browser that people use: the system's Chromium."""

from __future__ import annotations

import http.server
import threading
from functools import partial

import pytest
from playwright.sync_api import sync_playwright

from corpus_tools.video.encode import encode
from corpus_tools.video.films import open_frames
from corpus_tools.world.physics.build import build_world
from tests.chromium import CHROMIUM
from tests.corpus_tools.video.recordings import drive

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--no-first-run",
    "--autoplay-policy=no-user-gesture-required",
]
PAGE = """<!doctype html><video src="video.mp4" muted></video>"""
PLAY = """async () => {
  const video = document.querySelector("video");
  const times = [];
  video.addEventListener("timeupdate", () => times.push(video.currentTime));
  await video.play();
  await new Promise(resolve => video.addEventListener("ended", resolve));
  return {times, width: video.videoWidth, height: video.videoHeight, duration: video.duration,
          error: video.error && video.error.message};
}"""


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *args):
        pass


@pytest.fixture
def site(tmp_path):
    recording = drive(rate_hz=10)
    size = (320, 240)
    with open_frames(build_world(recording.start), recording, "overview", size, "draft") as frames:
        pictures = map(frames.frame, range(len(recording.t_ns)))
        encode(pictures, tmp_path / "video.mp4", size=size, fps=10, quality="draft")
    (tmp_path / "index.html").write_text(PAGE)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=tmp_path))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()
    thread.join()


def test_the_video_plays_in_chromium_to_its_end(site, tmp_path):
    assert CHROMIUM, "install the system package chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, headless=True, args=FLAGS)
        page = browser.new_page()
        page.goto(site)
        played = page.evaluate(PLAY)
        browser.close()
    assert played["error"] is None
    assert (played["width"], played["height"]) == (320, 240)
    assert played["duration"] == pytest.approx(3.1, abs=0.01)
    assert played["times"] == sorted(played["times"])
    assert played["times"][-1] == pytest.approx(3.1, abs=0.05)
