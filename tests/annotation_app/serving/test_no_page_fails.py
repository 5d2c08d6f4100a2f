"""No page fails, whoever opens it with whatever in its address and its form."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

import pytest
from flask import Flask
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from werkzeug.routing import Rule

from tests.annotation_app.browser import Browser, described
from tests.annotation_app.rendered import VIDEOS

EXAMPLES = int(os.environ.get("CT_FUZZ_EXAMPLES", "6"))
"""Of each page and method, each sent by everybody: set it higher to look longer."""

ROLES = (None, "worker", "annotator", "adjudicator", "admin")
TEMPLATES = Path(__file__).parents[3] / "annotation_app"
FIELDS = sorted(
    {
        name
        for page in TEMPLATES.rglob("*.html")
        for name in re.findall(r'\bname="([\w-]+)"', page.read_text(encoding="utf-8"))
    }
    - {"csrf_token", "viewport"}
)
TEXT = st.text(max_size=40) | st.text(alphabet="0123456789abcdef-.:/\\%<>'\"", max_size=40)


def pages(app: Flask) -> list[tuple[Rule, str]]:
    return [
        (rule, method)
        for rule in sorted(app.url_map.iter_rules(), key=lambda rule: (_ends(rule), rule.rule))
        for method in sorted((rule.methods or set()) & {"GET", "POST"})
        if not rule.rule.startswith("/api/") and not rule.endpoint.endswith("static")
    ]


@pytest.mark.slow
def test_no_page_fails(app: Flask) -> None:
    people = [None if role is None else Browser(app, role) for role in ROLES]
    signed_in = [person for person in people if person is not None]
    items = [person.take("describe")["item"] for person in signed_in[:2]]
    signed_in[0].answer(items[0], described())
    known = {
        "study_name": ("tests",),
        "task_name": ("describe", "segment", "ground", "check", "rate"),
        "item_id": tuple(items),
        "video": VIDEOS,
        "person_id": tuple(person.person.id for person in signed_in),
    }
    failed = [
        failure
        for rule, method in pages(app)
        for failure in failures(app, people, rule, method, known)
    ]
    assert not failed, failed


def _ends(rule: Rule) -> bool:
    """Whether somebody may be signed out by it: such pages come last."""
    return any(word in rule.rule for word in ("logout", "account", "logins"))


def failures(
    app: Flask,
    people: Sequence[Browser | None],
    rule: Rule,
    method: str,
    known: Mapping[str, Sequence[str]],
) -> list[object]:
    """What was sent where the server failed."""
    found: list[object] = []
    stranger = next(
        person for person in people if person is not None
    ).client.application.test_client()
    arguments = {
        name: st.sampled_from(known[name]) | TEXT if name in known else TEXT
        for name in rule.arguments
    }
    fields = st.dictionaries(st.sampled_from(FIELDS), TEXT, max_size=5)

    @settings(
        max_examples=EXAMPLES,
        phases=(Phase.explicit, Phase.generate),
        suppress_health_check=list(HealthCheck),
        deadline=None,
    )
    @given(parts=st.fixed_dictionaries(arguments), form=fields, query=fields)
    def check(parts: dict[str, str], form: dict[str, str], query: dict[str, str]) -> None:
        path = re.sub(r"<(?:\w+:)?(\w+)>", lambda m: quote(parts[m[1]], safe=""), rule.rule)
        for role, person in zip(ROLES, people, strict=True):
            client = stranger if person is None else person.client
            response = client.open(
                path,
                method=method,
                query_string=query,
                data=form if method == "POST" else None,
                headers={} if person is None else {"X-CSRFToken": person.csrf},
                buffered=True,
            )
            if response.status_code >= 500:
                found.append((role, method, path, form, query))

    check()
    return found
