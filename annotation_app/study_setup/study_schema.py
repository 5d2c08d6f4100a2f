"""The JSON Schema of a study's file.

``python -m annotation_app.study_setup.study_schema docs/schemas/study.schema.json`` writes it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import msgspec

from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.task_registry import task_names
from corpus_tools.cli.format_schemas import to_bytes


def study_schema() -> bytes:
    """Return the content of the schema's file."""
    content = msgspec.json.schema(StudyConfig)
    tasks = content["$defs"]["StudyConfig"]["properties"]["tasks"]
    tasks["propertyNames"] = {"enum": list(task_names())}  # msgspec describes values, not keys
    return to_bytes(content)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(study_schema())
