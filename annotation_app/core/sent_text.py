"""Text that people send, in one form that a database can keep."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from typing import Any

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem, Refusal

DEEPEST_JSON = 40


def check_json(value: Any, depth: int = 0) -> None:
    """Refuse what no database can keep: NUL characters, and nesting without end."""
    if depth > DEEPEST_JSON:
        raise Refusal(422, gettext("This is nested too deeply."))
    if isinstance(value, str) and "\0" in value:
        advice = gettext("Remove the invisible character NUL, or type the text again.")
        problems = [FieldProblem("text", advice)]
        raise Refusal(422, gettext("The text has a character that can't be kept (NUL)."), problems)
    parts: Iterable[Any] = ()
    if isinstance(value, dict):
        parts = (*value.keys(), *value.values())
    elif isinstance(value, list):
        parts = value
    for part in parts:
        check_json(part, depth + 1)


def clean_text(text: str) -> str:
    """Return text in Unicode's normal form C, in one line, without control characters."""
    joined = " ".join(text.split())
    kept = (c for c in joined if unicodedata.category(c) != "Cc")
    return unicodedata.normalize("NFC", "".join(kept)).strip()
