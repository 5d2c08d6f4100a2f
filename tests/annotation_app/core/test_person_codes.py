"""Codes by which people ask for their data."""

from __future__ import annotations

from flask import Flask

from annotation_app.core.random_ids import new_code, read_code
from tests.annotation_app.browser import Browser
from tests.annotation_app.privacy.test_erasure import code_of


def test_codes_differ_and_are_read_as_people_type_them() -> None:
    codes = {new_code() for _ in range(1000)}
    assert len(codes) == 1000
    for code in codes:
        assert not set(code) & set("01OILU")
        assert read_code(code) == read_code(f" {code.lower().replace('-', '  ')}") == code
    for wrong in ("", "ABCD", "ABCD-EFGH-JKM0", "ABCD-EFGH-JKMNP"):
        assert read_code(wrong) is None


def test_the_code_is_on_the_pages(app: Flask) -> None:
    person = Browser(app)
    code = code_of(app, person)
    assert len(code) == 14
    for page in ("/s/tests", "/s/tests/ground"):
        text = person.client.get(page).text
        assert f"<code>{code}</code>" in text
        assert "erase what you have sent" in text
