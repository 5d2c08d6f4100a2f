from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

from corpus_tools.cli.format_schemas import schemas
from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.documents import parse_document, read_document

FOLDER = Path(__file__).parents[3] / "docs" / "schemas"


@pytest.mark.parametrize("name", schemas())
def test_the_schemas_in_the_documentation_are_current(name):
    assert (FOLDER / name).read_bytes() == schemas()[name], (
        "run python -m corpus_tools.cli.format_schemas docs/schemas"
    )


def test_every_file_has_a_schema_and_the_documentation_names_it():
    text = (FOLDER.parent / "formats.md").read_text()
    for path in FOLDER.iterdir():
        assert f"(schemas/{path.name})" in text


def test_the_schemas_name_the_fields():
    schema = json.loads(schemas()["annotations.schema.json"])
    record = schema["$defs"]["AnnotationRecord"]
    assert set(record["required"]) == {
        "id", "command", "context", "source", "sdcs", "groundings", "correct"
    }  # fmt: skip
    assert record["additionalProperties"] is False


@pytest.mark.parametrize("folder", ["scenarios", "layouts"])
def test_the_bundled_files_fit_their_schemas(folder):
    schema = json.loads(schemas()[f"{folder.removesuffix('s')}.schema.json"])
    validator = jsonschema.Draft202012Validator(schema)
    files = sorted((bundled()["warehouse"] / folder).glob("*.yaml"))
    assert len(files) >= 8
    for file in files:
        assert [*validator.iter_errors(read_document(file).value)] == [], file


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("drive_to", "fly_to"),
        ("receiving", "3"),
        ("[0, 0]", "[0, 0, 0]"),
        ("layout", "site"),
        ("script:\n", "script: []\nx:\n"),
    ],
)
def test_the_schema_of_scenarios_refuses_what_is_refused(tmp_path, old, new):
    text = "title: T\nlayout: dock\nrobot: {at: [0, 0]}\nscript:\n  - drive_to: receiving\n"
    schema = json.loads(schemas()["scenario.schema.json"])
    validator = jsonschema.Draft202012Validator(schema)
    assert validator.is_valid(parse_document(text.encode(), "x").value)
    assert not validator.is_valid(parse_document(text.replace(old, new).encode(), "x").value)
