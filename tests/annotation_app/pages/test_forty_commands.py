"""Forty commands of all kinds, segmented by people who do what the page says and no more."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext
from sqlalchemy import select

from annotation_app.store.models import Answer, Item
from g3.sdc.sdc_notation import format_brackets, from_json, parse_brackets
from tests.annotation_app.browser import row_in
from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.literal_users import Literal, Meaning

pytestmark = pytest.mark.slow

WRITTEN = Path(__file__).parents[3] / "benchmarks" / "written" / "17.jsonl"
EVERY = 8
"""Of each kind every eighth command is taken, from the first one on."""


def meanings() -> list[Meaning]:
    """Commands with trees that were made by hand, five of each of eight kinds."""
    found: list[Meaning] = []
    kinds: Counter[str] = Counter()
    for line in WRITTEN.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        if kinds[row["kind"]] % EVERY == 0:
            sdcs = parse_brackets("; ".join(row["trees"]), command=row["text"])
            found.append(Meaning(row["text"], sdcs))
        kinds[row["kind"]] += 1
    return found


@pytest.mark.parametrize("way", [Literal.build, Literal.accept])
def test_who_does_what_the_page_says_makes_no_wrong_tree(
    site: Site, context: BrowserContext, way: Callable[[Literal], None]
) -> None:
    commands = {meaning.text: meaning for meaning in meanings()}
    first, *others = commands
    site.only("segment", first)
    for text in others:
        site.add("segment", text)
    page = site.open(context, "segment")
    for _ in commands:
        page.wait_for_selector(".word[tabindex='0']")
        text = page.evaluate(
            "JSON.parse(document.querySelector('#item').textContent).payload.command"
        )
        way(Literal(page, commands[text]))
    made = {
        _text_of(site, answer): from_json(answer.body["sdcs"]) for answer in site.answers("segment")
    }
    assert {text: format_brackets(sdcs) for text, sdcs in made.items()} == {
        text: format_brackets(meaning.sdcs) for text, meaning in commands.items()
    }
    assert len(commands) == 40


def _text_of(site: Site, answer: Answer) -> str:
    return str(row_in(site.engine, select(Item).filter_by(id=answer.item_id)).payload["text"])
