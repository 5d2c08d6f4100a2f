"""The pictures of all pages are of all pages."""

from __future__ import annotations

import re
from pathlib import Path

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.serving.server import prepare
from annotation_app.store.database import opened
from docs.make_screenshots import DOCS, NO_PAGES, PAGES

WORD = re.compile(r"<[^>]+>")


def test_every_page_has_its_picture(tmp_path: Path) -> None:
    config = open_instance(tmp_path / "instance")
    prepare(config)
    with opened(config.database) as engine:
        app = create_app(config, engine)
        rules = {
            rule.rule
            for rule in app.url_map.iter_rules()
            if "GET" in (rule.methods or ()) and not rule.rule.startswith("/api/")
        }
        taken = {
            app.url_map.bind("")
            .match(WORD.sub("1", path.partition("?")[0]), return_rule=True)[0]
            .rule
            for _, path in PAGES.values()
        }
    pages = {rule for rule in rules if not rule.endswith("<path:filename>")}
    assert pages >= NO_PAGES
    assert pages - NO_PAGES == taken
    assert set(DOCS) <= set(PAGES)
