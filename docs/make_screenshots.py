"""Make pictures of every page of the app, and of a report, at three widths, by day and by night.

``python docs/make_screenshots.py --out screenshots`` fills a study with the bundled corpus, opens
each page in Chromium and writes ``PAGE-WIDTH-light.png`` and ``PAGE-WIDTH-dark.png``. It needs what
the tests need. Videos and a report that are there already, in ``videos`` and ``report``, aren't
made again. ``--only ground`` takes the pages whose names begin so. ``--docs`` also writes the
pictures that the documentation shows.

Each page of the app is also looked at by axe, at each width and, for its contrast, in both schemes.
What it finds, and what is wider than the window, is listed at the end; then the exit status is 1.
"""

from __future__ import annotations

import argparse
import logging
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Literal, TypeAlias

from axe_playwright_python.sync_playwright import Axe
from PIL import Image, ImageChops
from playwright.sync_api import Browser, Page
from playwright.sync_api import TimeoutError as Late

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from docs.example_study import SCENARIOS, example, tasks  # noqa: E402 - runs as a script
from tests.annotation_app.in_browser import (  # noqa: E402
    ANY,
    launched,
    serving,
    violations,
    width_of,
)

SIZES = ((390, 844), (768, 1024), (1280, 800))
Scheme: TypeAlias = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = ("light", "dark")
OF_SCHEME: dict[Scheme, dict[str, object]] = {"light": {}, "dark": {"runOnly": ["color-contrast"]}}
"""Options of axe: a scheme changes colours alone."""
DOCS = ("ground", "segment")
"""Pages that the documentation shows, at the last size and by day."""
PATIENCE_MS = 300_000
"""Longest time until a page, or its picture, has come."""
IDLE_MS = 10_000
"""Longest time until a page without videos asks for nothing more."""
DOCS_WIDTH, MARGIN, COLOURS = 900, 16, 256
STEPS = ("videos", "tasks", "people", "texts", "consent")
PAGES = {
    "home": ("", "/"),
    "login": ("", "/login"),
    "setup": ("", "/setup/<setup>"),
    "welcome": ("", "/s/<study_name>/welcome"),
    "not-there": ("", "/s/nothing"),
    "not-for-you": ("worker", "/dashboard/<study_name>"),
    "offline": ("", "/offline"),
    "crowd-preview": (
        "",
        "/crowd/<provider_name>/<offer>?assignmentId=ASSIGNMENT_ID_NOT_AVAILABLE",
    ),
    "crowd-finish": ("crowd", "/crowd/finish"),
    "study": ("worker", "/s/<study_name>"),
    **{f"practice-{name}": ("worker", f"/practice/{name}") for name in tasks()},
    **{name: ("worker", f"/s/<study_name>/{name}") for name in tasks()},
    "stopped": ("typist", "/s/<study_name>/describe"),
    "try": ("admin", "/try"),
    "account": ("admin", "/account"),
    "dashboard": ("admin", "/dashboard/"),
    "overview": ("admin", "/dashboard/<study_name>"),
    "exports": ("admin", "/dashboard/<study_name>/exports"),
    "answers": ("admin", "/dashboard/<study_name>/answers"),
    "answer": ("admin", "/dashboard/<study_name>/answers/<segment answer>"),
    "answer-ground": ("admin", "/dashboard/<study_name>/answers/<ground answer>"),
    "reports": ("admin", "/dashboard/<study_name>/reports"),
    "disputes": ("admin", "/dashboard/<study_name>/queue"),
    "dispute-segment": ("admin", "/dashboard/<study_name>/queue/<segment item>"),
    "dispute-ground": ("admin", "/dashboard/<study_name>/queue/<ground item>"),
    **{
        f"dispute-edit-{task}": (
            "admin",
            f"/dashboard/<study_name>/queue/<{task} item>/edit?answer=<{task} answer>",
        )
        for task in ("segment", "ground")
    },
    "assign": ("admin", "/dashboard/<study_name>/assign"),
    "disagreements": ("admin", "/dashboard/<study_name>/disagreements"),
    "people": ("admin", "/dashboard/<study_name>/people"),
    "person": ("admin", "/dashboard/<study_name>/people/<person_id>"),
    "logins": ("admin", "/admin/logins"),
    "a-login": ("admin", "/admin/logins/<person_id>"),
    "block": ("admin", "/admin/logins/<person_id>/block"),
    "remove": ("admin", "/admin/logins/<person_id>/remove"),
    "tokens": ("admin", "/admin/tokens"),
    "revoke": ("admin", "/admin/tokens/revoke?name=robot-lab"),
    "audit": ("admin", "/admin/audit"),
    "making-new": ("admin", "/admin/studies/new"),
    **{f"making-{step}": ("admin", f"/admin/studies/<name>/{step}") for step in STEPS},
    "making-preview": ("admin", "/admin/studies/<name>/preview/<page>"),
    "making-draw": ("admin", "/admin/studies/<name>/video/<int:number>/draw"),
    "making-review": ("admin", "/admin/studies/<name>/review"),
    "making-started": ("admin", "/admin/studies/<study_name>/started"),
}
"""Each page: who opens it, and its address. What is in brackets is in `example_study`."""
NO_PAGES = {
    "/dashboard/<study_name>/export/<form>", "/dashboard/<study_name>/queue/next",
    "/admin/studies/<name>/video/<int:number>", "/admin/studies/<name>/video/<int:number>/picture",
    "/admin/studies/<name>/video/<int:number>/still",
    "/admin/studies/<name>/upload/<file>", "/media/<media_id>", "/try/<name>/<file>",
    "/try/scenes/<scenario>", "/offline-worker.js",
    "/s/<study_name>/invitation/<token>",
}  # fmt: skip
"""Addresses of files, or of redirects."""


def main() -> None:
    """Make the selected pictures."""
    parser = argparse.ArgumentParser(description="Make pictures of all pages.")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--only", default="", help="pages whose names begin so")
    parser.add_argument("--docs", action="store_true", help="write those of the documentation too")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    films = asked.out / "videos"
    ct("render-videos", *SCENARIOS, "--out", str(films), "--fps", "15", "--quality", "draft")
    wrong: list[str] = []
    with launched() as browser:
        for name, cookie, address in addresses(films, asked.only):
            for scheme in SCHEMES:
                context = browser.new_context(color_scheme=scheme, reduced_motion="reduce")
                context.set_default_timeout(PATIENCE_MS)
                if cookie is not None:
                    site = "/".join(address.split("/")[:3])
                    context.add_cookies([{"name": "session", "value": cookie, "url": site}])
                wrong += take(context.new_page(), address, asked.out, name, scheme)
                context.close()
        if "report".startswith(asked.only):
            take_report(browser, asked.out)
    if asked.docs:
        for name in (name for name in DOCS if name.startswith(asked.only)):
            smaller(name, asked.out)
    if wrong:
        sys.exit("\n".join(wrong))


def take(page: Page, address: str, out: Path, name: str, scheme: Scheme) -> list[str]:
    """Take pictures of a page at each width; return its problems."""
    wrong: list[str] = []
    page.add_init_script(Axe().axe_script)  # sent once
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.goto(address)
        settle(page, name)
        page.screenshot(path=out / f"{name}-{width}-{scheme}.png", full_page=True)
        found = violations(page, ANY, **OF_SCHEME[scheme])
        if width_of(page) > width:
            found.append(f"it is {width_of(page)} pixels wide")
        wrong += [f"{name}, {width}, {scheme}: {what}" for what in found]
    return wrong


def ct(*args: str) -> None:
    """Run ``ct``."""
    subprocess.run([sys.executable, "-m", "corpus_tools", *args], check=True, cwd=ROOT)  # noqa: S603


def settle(page: Page, name: str) -> None:
    """Wait until all is drawn, and take a task's page to where its work begins."""
    if name == "try":
        page.locator("#picture img").wait_for()
    page.wait_for_load_state("load")
    if not page.locator("video").count():
        with suppress(Late):  # the browser may never tell that a request has ended
            page.wait_for_load_state("networkidle", timeout=IDLE_MS)
    page.evaluate(
        "Promise.all([...document.querySelectorAll('video')].map(video => new Promise(done => {"
        " if (video.readyState > 1) done(); video.addEventListener('loadeddata', done);"
        " video.addEventListener('error', done); setTimeout(done, 3000); })))"
    )
    if name == "ground" and page.locator('[data-key="play"]').count():
        page.evaluate(
            "const video = document.querySelector('video');"
            "video.muted = true; video.playbackRate = 16; video.play();"
        )
        page.get_by_text("You have watched it to the end").wait_for()
    if name == "segment" and page.get_by_text("start from nothing").count():
        page.get_by_text("start from nothing").click()
        page.locator(".word").first.click()
        page.get_by_role("button", name="What to do?").click()
        page.locator(".word").nth(2).click()
        page.locator(".word").nth(3).click()
        page.locator(".place").first.click()
    page.evaluate("scrollTo(0, 0)")


def smaller(name: str, out: Path) -> None:
    """Put a picture into the documentation: without what is empty below, and in few colours."""
    with Image.open(out / f"{name}-{SIZES[-1][0]}-light.png") as opened:
        picture = opened.convert("RGB")
    ground = Image.new("RGB", picture.size, picture.getpixel((0, picture.height - 1)))
    box = ImageChops.difference(picture, ground).getbbox()
    if box is not None:
        picture = picture.crop((0, 0, picture.width, min(box[3] + MARGIN, picture.height)))
    picture.thumbnail((DOCS_WIDTH, picture.height), Image.Resampling.LANCZOS)
    few = picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=3)
    few.save(ROOT / "docs" / "annotation" / f"{name}.png", optimize=True)


def take_report(browser: Browser, out: Path) -> None:
    """Make a report on the bundled corpus, and pictures of it."""
    made = out / "report" / "report.html"
    if not made.exists():
        quick = ("--draws", "100", "--repeats", "0")
        videos = ("--videos", str(out / "videos"))
        ct("eval", "--report", str(made.parent), "--corpus", "warehouse", *quick, *videos)
    for scheme in SCHEMES:
        page = browser.new_page(color_scheme=scheme)
        take(page, made.resolve().as_uri(), out, "report", scheme)
        page.close()


def addresses(films: Path, only: str) -> Iterator[tuple[str, str | None, str]]:
    """Yield each page's name, the cookie of its user, and its address while it is served."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    with (
        tempfile.TemporaryDirectory() as folder,
        example(Path(folder), films) as made,
        serving(made.app) as site,
    ):
        for name, (who, path) in PAGES.items():
            if name.startswith(only):
                said = re.sub("<[^>]+>", lambda word: made.words[word[0]], path)
                yield name, made.cookies[who], site + said


if __name__ == "__main__":
    main()
