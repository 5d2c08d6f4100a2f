from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

from annotation_app.studies.study_template import TEMPLATE
from annotation_app.study_setup.study_schema import study_schema
from corpus_tools.world.scenarios.documents import parse_document

FILE = Path(__file__).parents[3] / "docs/schemas/study.schema.json"


def test_the_schema_in_the_documentation_is_current() -> None:
    assert FILE.read_bytes() == study_schema(), (
        "run python -m annotation_app.study_setup.study_schema docs/schemas/study.schema.json"
    )


@pytest.mark.parametrize(
    ("old", "new", "fits"),
    [
        ("", "", True),
        ("access: open", "access: everybody", False),
        ("describe:", "dance:", False),
        ("answers: 13", "answers: 0", False),
        ("title:", "titel:", False),
    ],
)
def test_it_accepts_and_refuses_as_the_program_does(old: str, new: str, fits: bool) -> None:
    text = TEMPLATE.format(name="mine").replace(old, new)
    validator = jsonschema.Draft202012Validator(json.loads(study_schema()))
    assert validator.is_valid(parse_document(text.encode(), "x").value) is fits
