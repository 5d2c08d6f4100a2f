"""What is written is what is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from annotation_app.study_setup.study_drafts import comments, to_yaml, write_study
from corpus_tools.world.scenarios.documents import parse_document

PRINTED = st.characters(exclude_categories=("Cs", "Cc", "Cn", "Co")) | st.sampled_from("\n#:-'\"|>")
TEXT = st.text(PRINTED, max_size=30) | st.sampled_from(
    [
        "yes",
        "null",
        "~",
        "1e5",
        "0x1",
        "1_0",
        "true",
        "- x",
        "a: b",
        "a #b",
        "  x\ny",
        "x\n\n",
        "1.",
    ]
)
VALUES = st.recursive(
    TEXT | st.booleans() | st.integers(-(10**9), 10**9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(TEXT, VALUES, max_size=4))
def test_whatever_is_written_is_read_again(value: dict[str, Any]) -> None:
    content = to_yaml(value)
    assert (parse_document(content, "study").value or {}) == value
    assert comments(content) == []


def test_comments_are_found_where_they_are_comments() -> None:
    content = b"# First\ntitle: a #b # second\ntext: |\n  # no comment\n  x # nor this\n"
    assert comments(content) == ["# First", "#b # second"]


def test_what_was_there_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "new" / "arm.yaml"
    assert write_study(file, {"name": "arm"}) == ""
    kept = write_study(file, {"name": "arm", "title": "An arm"})
    assert (file.parent / "versions" / kept).read_bytes() == to_yaml({"name": "arm"})
    assert b"An arm" in file.read_bytes()
