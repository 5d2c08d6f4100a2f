"""Drawing on a picture by mouse, touch and keys."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.annotation_app.in_browser import errors_of, violations
from tests.annotation_app.pages.conftest import Site

PAGE = """<!doctype html><html lang="en"><head><title>Drawing</title>
<link rel="stylesheet" href="/static/tokens.css"><link rel="stylesheet" href="/static/app.css">
<link rel="stylesheet" href="/static/drawing.css"></head>
<body><main><h1>Drawing</h1><div id="picture"></div></main><script type="module">
import { drawing } from "/static/js/drawing.js";
const picture = document.getElementById("picture");
picture.style.cssText = "position: relative; width: 640px; height: 360px; background: #385";
const surface = window.surface = drawing({
  width: 1280, height: 720, kinds: ["box", "outline", "point", "line"],
  shapes: [{ id: "5", kind: "box", name: "truck", points: [[700, 300], [1000, 600]] }],
  named: (id) => { window.named = id; },
});
picture.append(surface.element);
picture.after(surface.tools, surface.help);
</script></body></html>"""


class Surface:
    """The surface on a page, whose picture has half of its pixels' size."""

    def __init__(self, page: Page) -> None:
        self.page = page
        box = page.locator("#picture").bounding_box()
        assert box is not None
        self._left, self._top = box["x"], box["y"]

    def at(self, x: float, y: float) -> tuple[float, float]:
        return self._left + x / 2, self._top + y / 2

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        mouse = self.page.mouse
        mouse.move(*self.at(*start))
        mouse.down()
        mouse.move(*self.at(*end), steps=4)
        mouse.up()

    def click(self, *spots: tuple[float, float]) -> None:
        for spot in spots:
            self.page.mouse.click(*self.at(*spot))

    def tool(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()

    @property
    def shapes(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.page.evaluate("surface.shapes")
        return found

    @property
    def last(self) -> Any:
        return self.shapes[-1]["points"]


@pytest.fixture
def surface(site: Site, chromium: Browser) -> Iterator[Surface]:
    context = chromium.new_context(viewport={"width": 1280, "height": 900}, has_touch=True)
    page = context.new_page()
    page.route("**/drawing", lambda route: route.fulfill(body=PAGE, content_type="text/html"))
    errors = errors_of(page)
    page.goto(f"{site.url}/drawing")
    page.wait_for_function("window.surface")
    yield Surface(page)
    assert not violations(page)
    assert not errors
    context.close()


@pytest.mark.firefox
def test_boxes_are_drawn_moved_and_resized_with_a_mouse(surface: Surface) -> None:
    surface.tool("Box")
    surface.drag((100, 100), (400, 300))
    assert surface.last == [[100, 100], [400, 300]]
    surface.drag((250, 200), (350, 260))
    assert surface.last == [[200, 160], [500, 360]]
    surface.drag((200, 160), (100, 60))
    assert surface.last == [[100, 60], [500, 360]]
    surface.drag((300, 200), (2, 200))
    assert surface.last == [[0, 60], [400, 360]], "it stays in the picture"
    surface.tool("Undo")
    assert surface.last == [[100, 60], [500, 360]]
    surface.tool("Redo")
    surface.tool("Delete")
    assert [shape["id"] for shape in surface.shapes] == ["5"]


@pytest.mark.firefox
def test_two_clicks_make_a_box_for_people_who_cannot_drag(surface: Surface) -> None:
    surface.tool("Box")
    surface.click((600, 500), (200, 700))
    assert surface.last == [[200, 500], [600, 700]]
    surface.click((850, 450))
    assert surface.page.evaluate("surface.chosen") == "5", "a click chooses what is there"


@pytest.mark.firefox
def test_an_outline_is_closed_at_its_first_corner(surface: Surface) -> None:
    surface.tool("Outline")
    surface.click((100, 100), (300, 100), (300, 250), (104, 102))
    assert surface.last == [[100, 100], [300, 100], [300, 250]]
    surface.drag((300, 250), (320, 280))
    assert surface.last == [[100, 100], [300, 100], [320, 280]]


def test_a_line_ends_at_the_second_click_on_a_corner(surface: Surface) -> None:
    surface.tool("Line")
    surface.click((100, 100), (300, 100), (300, 250))
    surface.page.wait_for_timeout(600)  # no double click
    surface.click((300, 250))
    assert surface.last == [[100, 100], [300, 100], [300, 250]]
    surface.click((150, 620), (250, 620))
    surface.tool("End the line")
    assert surface.last == [[150, 620], [250, 620]]
    keys = surface.page.keyboard
    surface.page.locator(".surface .drawn").last.focus()
    for key in ("c", "c", "+", "ArrowDown", "ArrowDown"):
        keys.press(key)
    assert surface.last[:2] == [[150, 620], [250, 620]]
    assert surface.last[2][0] == 350
    assert surface.last[2][1] > 620
    for key in ("-", "-", "-"):
        keys.press(key)
    assert len(surface.last) == 2
    surface.tool("Line")  # no tool any more
    surface.click((270, 140))  # inside of the first, if it were an outline
    assert surface.page.evaluate("surface.chosen") is None


@pytest.mark.firefox
def test_keys_alone_suffice(surface: Surface) -> None:
    page, keys = surface.page, surface.page.keyboard
    page.locator(".surface").focus()
    keys.press("b")
    (left, top), (right, bottom) = surface.last
    keys.press("ArrowRight")
    keys.press("ArrowUp")
    (left_2, top_2), (right_2, _) = surface.last
    assert (left_2 > left, top_2 < top, right_2 - left_2) == (True, True, right - left)
    keys.press("Shift+ArrowDown")
    assert surface.last[1][1] - surface.last[0][1] > bottom - top
    keys.press("Shift+Tab")
    told = page.evaluate("document.activeElement.getAttribute('aria-label')")
    assert told == "1 truck: 55 % from the left, 42 % from the top, 23 % wide, 42 % high"
    keys.press("Enter")
    assert page.evaluate("window.named") == "5"
    keys.press("Delete")
    assert len(surface.shapes) == 1
    assert page.evaluate("document.activeElement.getAttribute('aria-label')").startswith("1 Box")
    keys.press("Control+z")
    assert surface.shapes[0]["id"] == "5"
    keys.press("o")
    before = surface.last
    keys.press("c")
    keys.press("ArrowLeft")
    keys.press("+")
    corner, added, *others = surface.last
    assert corner[0] < before[0][0]
    assert others == before[1:]
    assert corner[0] < added[0] < before[1][0]


def test_fingers_draw_too(surface: Surface) -> None:
    surface.tool("Box")
    for spot in ((100, 100), (300, 200)):
        surface.page.touchscreen.tap(*surface.at(*spot))
    assert surface.last == [[100, 100], [300, 200]]
    surface.tool("Point")
    surface.page.touchscreen.tap(*surface.at(600, 600))
    assert surface.last == [[600, 600]]
