"""Pages are light, and load nothing from elsewhere."""

from __future__ import annotations

import re
from urllib.parse import urljoin, urlsplit

import pytest
from flask import Flask
from flask.testing import FlaskClient

from tests.annotation_app.browser import Browser
from tests.annotation_app.signing_in import signed_in

BUDGET_BYTES = 300_000


def loaded(client: FlaskClient, address: str) -> dict[str, int]:
    """What a page loads before anybody does anything, and how many bytes each has."""
    seen: dict[str, int] = {}
    waiting = [address]
    while waiting:
        here = waiting.pop()
        if here in seen:
            continue
        reply = client.get(here, follow_redirects=True, buffered=True)
        assert reply.status_code == 200, here
        seen[here] = len(reply.data)
        if reply.mimetype in ("text/html", "text/css", "text/javascript"):
            waiting += [urljoin(here, one) for one in wanted(reply.mimetype, reply.text)]
    return seen


def wanted(kind: str, text: str) -> list[str]:
    """The addresses of what a file needs."""
    tags = "link|script|img|video|source|iframe"
    forms = {
        "text/html": rf"<(?:{tags})\b[^>]*?\b(?:href|src|poster)=\"([^\"]+)",
        "text/css": r"url\(\s*[\"']?([^)\"']+)|@import\s+[\"']([^\"']+)",
        "text/javascript": r"(?:from|import)\s*\(?[\"']([^\"']+)",
    }
    found = re.findall(forms[kind], text)
    return [one if isinstance(one, str) else next(filter(None, one)) for one in found]


FIRST = ("/", "/login", "/s/tests/welcome")
"""What people see first: all but the task's video is there in no time."""


@pytest.mark.parametrize("path", FIRST)
def test_the_first_page_is_light_and_loads_nothing_from_elsewhere(app: Flask, path: str) -> None:
    sizes = loaded(app.test_client(), path)
    assert len(sizes) > 3
    assert sum(sizes.values()) < BUDGET_BYTES
    assert {urlsplit(one).netloc for one in sizes} == {""}


@pytest.mark.parametrize("task", ["describe", "segment", "ground"])
def test_a_tasks_page_without_its_video_is_light_too(app: Flask, task: str) -> None:
    browser = Browser(app)
    sizes = loaded(browser.client, f"/s/tests/{task}")
    assert {urlsplit(one).netloc for one in sizes} == {""}
    assert sum(size for one, size in sizes.items() if "/media/" not in one) < BUDGET_BYTES


def test_the_dashboard_is_light_too(app: Flask) -> None:
    sizes = loaded(signed_in(app, "ada", "admin").client, "/dashboard/tests")
    assert sum(sizes.values()) < BUDGET_BYTES
    assert {urlsplit(one).netloc for one in sizes} == {""}
