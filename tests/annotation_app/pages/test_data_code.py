"""The code by which people ask for their data, where they see it."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, expect
from sqlalchemy import update

from annotation_app.store.database import transaction
from annotation_app.store.models import Slot
from tests.annotation_app.in_browser import violations, width_of
from tests.annotation_app.pages.conftest import Site

pytestmark = pytest.mark.slow

PICTURES = os.environ.get("CT_TEST_PICTURES")
"""A folder for pictures of the pages, to look at."""


@pytest.mark.parametrize("width", [390, 1280])
def test_the_code_is_on_the_studys_page_and_at_the_end(
    site: Site, context: BrowserContext, width: int
) -> None:
    site.sign_in(context)
    with transaction(site.engine) as session:
        session.execute(update(Slot).values(answered=True))  # there is nothing left to do
    page = context.new_page()
    page.set_viewport_size({"width": width, "height": 900})
    for name in ("", "/rate"):
        page.goto(f"{site.url}/s/{site.study.name}{name}")
        expect(page.locator(".data-code code")).to_have_text(re.compile(r"^(\w{4}-){2}\w{4}$"))
        page.locator(".data-code summary").click()
        expect(page.get_by_text("erase what you have sent")).to_be_visible()
        assert violations(page) == []
        assert width_of(page) <= width
        if PICTURES:
            file = Path(PICTURES) / f"code{name.replace('/', '-')}-{width}.png"
            page.screenshot(path=str(file), full_page=True)
