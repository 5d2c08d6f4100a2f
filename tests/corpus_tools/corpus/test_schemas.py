from __future__ import annotations

import json
from pathlib import Path

import pytest

from corpus_tools.corpus.schemas import schemas

FOLDER = Path(__file__).parents[3] / "docs" / "schemas"


@pytest.mark.parametrize("name", schemas())
def test_the_schemas_in_the_documentation_are_current(name):
    assert (FOLDER / name).read_bytes() == schemas()[name], (
        "run python -m corpus_tools.corpus.schemas docs/schemas"
    )


def test_every_file_has_a_schema_and_the_documentation_names_it():
    text = (FOLDER.parent / "corpus-format.md").read_text()
    for name in schemas():
        assert name in text


def test_the_schemas_name_the_fields():
    schema = json.loads(schemas()["annotations.schema.json"])
    record = schema["$defs"]["AnnotationRecord"]
    assert set(record["required"]) == {
        "id", "command", "context", "source", "sdcs", "groundings", "correct"
    }  # fmt: skip
    assert record["additionalProperties"] is False
