"""What pages look like comes from one file, which docs/design.md describes; no page is heavy."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import pytest
from flask import Flask
from flask.testing import FlaskClient

from tests.annotation_app.browser import Browser
from tests.annotation_app.signing_in import signed_in

ROOT = Path(__file__).resolve().parents[3]
APP = ROOT / "annotation_app"
TOKENS = APP / "static" / "tokens.css"
SHEETS = sorted(path for path in APP.rglob("*.css") if path != TOKENS)
NAMED = re.compile(r"var\((--[\w-]+)")
MADE = re.compile(r"(--[\w-]+)\s*:")
COLOUR = re.compile(r"#[0-9a-fA-F]{3,8}\b|\b(?:rgb|hsl|oklch)a?\(")
DECLARED = re.compile(r"(?<![\w-])({})\s*:\s*([^;}}]+)")
SPACES = "|".join(
    f"{name}(?:-[a-z-]+)?" for name in ("margin", "padding", "gap", "row-gap", "column-gap")
)
STEPS_REM = {"0.125", "0.25", "0.5", "0.75", "1", "1.25", "1.5"}
BUDGET_BYTES = 300_000


def blocks() -> tuple[set[str], set[str]]:
    """The tokens by day, and those that are others by night."""
    day, night = TOKENS.read_text().split("@media (prefers-color-scheme: dark)")
    return set(MADE.findall(day)), set(MADE.findall(night))


def declared(names: str) -> Iterator[tuple[str, str]]:
    """Where something is declared, and its value."""
    for sheet in SHEETS:
        found = re.finditer(DECLARED.pattern.format(names), sheet.read_text())
        yield from ((f"{sheet.name}: {match[0]}", match[2].strip()) for match in found)


def test_there_are_sheets() -> None:
    assert {"app.css", "dashboard.css", "making.css"} <= {sheet.name for sheet in SHEETS}


def test_what_is_named_is_there_and_is_used() -> None:
    day, night = blocks()
    used = NAMED.findall("".join(sheet.read_text() for sheet in [*SHEETS, TOKENS]))
    scripts = "".join(path.read_text() for path in APP.rglob("*.js"))
    made = set().union(*(MADE.findall(sheet.read_text()) for sheet in SHEETS))
    assert set(used) - day - made - set(re.findall(r"--[\w-]+", scripts)) == set()
    assert day - set(used) == set()
    assert night <= day


def test_every_colour_of_a_page_has_another_by_night() -> None:
    day, night = blocks()
    fixed = ("--picture", "--mark", "--picked", "--film", "--veil", "--face", "--size", "--space")
    sizes = ("--target", "--round", "--focus", "--quick")
    assert {name for name in day if not name.startswith((*fixed, *sizes))} == night


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: path.name)
def test_colours_are_tokens(sheet: Path) -> None:
    assert COLOUR.findall(sheet.read_text()) == []


def test_sizes_of_text_are_tokens() -> None:
    """But in drawings, whose units are their own, and parts of a line, which go with it."""
    other = [
        where for where, v in declared("font-size") if not re.search(r"var\(--size|px$|em$", v)
    ]
    rem = [where for where, value in declared("font-size") if value.endswith("rem")]
    assert other + rem == []


def test_corners_are_tokens() -> None:
    bare = re.compile(r"(?<![\w.-])(?!0\b|50%|0\.\d)[\d.]+(?:px|rem)")
    wrong = [
        where
        for where, value in declared(r"border(?:-[a-z]+)*-radius")
        if any(
            float(re.sub("[a-z]", "", one)) < 30 and one[-1] == "x" for one in bare.findall(value)
        )
    ]
    assert wrong == []


def test_spaces_are_tokens() -> None:
    wrong = [
        where
        for where, value in declared(SPACES)
        if set(re.findall(r"(?<![\w.(-])0?(\.?\d[\d.]*)rem", value))
        & {s.lstrip("0") for s in STEPS_REM}
    ]
    assert wrong == []


def test_the_page_on_design_names_what_is_there() -> None:
    day, _ = blocks()
    text = (ROOT / "docs" / "design.md").read_text()
    named = set(re.findall(r"`(--[a-z][\w-]*)`", text))
    assert named <= day
    assert {f"--{word}" for word in ("good", "bad", "warn", "event", "path")} <= named
    families = (*(f"{name}-" for name in named), "--series-")
    assert {name for name in day if name not in named and not name.startswith(families)} == set()
    for name, value in re.findall(r"\| `(--size-\w+)` \| ([\d.]+) \|", text):
        assert f"{name}: {value}rem;" in TOKENS.read_text()


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
