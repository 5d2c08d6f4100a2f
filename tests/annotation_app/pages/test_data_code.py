"""The code by which people ask for their data, where they see it."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import BrowserContext, expect
from sqlalchemy import update

from annotation_app.store.models import Slot
from tests.annotation_app.browser import execute
from tests.annotation_app.in_browser import look
from tests.annotation_app.pages.conftest import Site

pytestmark = pytest.mark.slow


def test_the_code_is_on_the_studys_page_and_at_the_end(site: Site, context: BrowserContext) -> None:
    site.sign_in(context)
    execute(site.engine, update(Slot).values(answered=True))  # there is nothing left to do
    page = context.new_page()
    for name in ("", "/rate"):
        page.goto(f"{site.url}/s/{site.study.name}{name}")
        expect(page.locator(".data-code code")).to_have_text(re.compile(r"^(\w{4}-){2}\w{4}$"))
        page.locator(".data-code summary").click()
        expect(page.get_by_text("erase what you have sent")).to_be_visible()
        assert look(page, f"code{name.replace('/', '-')}") == []
