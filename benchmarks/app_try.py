"""From Enter to the plan at ``/try``: ``python -m benchmarks.app_try``.

A server of its own and Chromium. The first command is sent as soon as the page takes one, before
and after the server has had time to get the model ready; then come commands about one load and
about several. A plan is there when its steps are on the page. It needs the extra ``test``, and
Chromium.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page

from annotation_app.core.config import open_instance
from benchmarks.timing import row
from tests.annotation_app.in_browser import launched
from tests.annotation_app.load_servers import CT, Server

PATIENCE_MS = 180_000
WORLD = "court_take_tires_to_issue"
COMMANDS = {
    "one load": ("Pick up the tire pallet on the left", "Go to the truck", "Lift the tire pallet"),
    "several loads": (
        "Put both tire pallets on the truck",
        "Take all tire pallets to the truck",
        "Put the two pallets of tires onto the truck",
    ),
}


class TryServer(Server):
    """A server at which anybody may try commands."""

    def _start(self) -> subprocess.Popen[bytes]:
        place = ["--instance", str(self.config.instance), "--port", str(self.port)]
        command = [sys.executable, *CT, "annotate", "serve", "--open-trying", *place]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL)


@contextmanager
def started(instance: Path) -> Iterator[str]:
    """Start a server; yield the address of its page."""
    server = TryServer(open_instance(instance, ""), 8)
    try:
        server.wait()
        yield f"{server.address}/try"
    finally:
        server.process.terminate()
        server.process.wait()


def opened(browser: Browser, address: str) -> Page:
    """Open the page in the world of the commands."""
    page = browser.new_page()
    page.set_default_timeout(PATIENCE_MS)
    page.goto(address)
    page.locator("#go:not(:disabled)").wait_for()
    page.get_by_label("World").select_option(WORLD)
    return page


def seconds(page: Page, command: str) -> float:
    """Return the seconds from Enter to the plan."""
    page.get_by_label("What is the robot").fill(command)
    start = time.perf_counter()
    page.keyboard.press("Enter")
    page.locator("#found ol li").first.wait_for()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app_try")
    parser.add_argument("--ready", type=float, default=15.0, help="seconds to get ready in")
    given = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder, launched() as browser:
        for wait_s in (0.0, given.ready):
            with started(Path(folder) / f"{wait_s:g}") as address:
                time.sleep(wait_s)
                page = opened(browser, address)
                first = seconds(page, COMMANDS["one load"][0])
                row(f"/try, first plan {wait_s:g} s after the server's start", f"{first:.1f} s")
                if wait_s:
                    for what, commands in COMMANDS.items():
                        each = [seconds(page, command) for command in commands]
                        shown = ", ".join(f"{s:.1f}" for s in each)
                        row(f"/try, later plans, {what}", f"{shown} s")
                page.close()


if __name__ == "__main__":
    main()
