"""JSON Schemas of the files of corpora, scenarios, layouts, models and answers, from the records.

``python -m corpus_tools.cli.format_schemas docs/schemas`` rewrites them.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.corpus.answer_records import ANSWER_RECORDS
from corpus_tools.corpus.corpus_records import LINE_RECORDS, MANIFEST, Manifest
from corpus_tools.importers.report import REPORT, ImportReport
from corpus_tools.world.scenarios.scenario_files import LayoutFile, ScenarioFile, schema
from g3.learning.model_file import ModelCard


def schemas() -> dict[str, bytes]:
    """Return the content of each schema file by name."""
    types: dict[str, type[msgspec.Struct]] = {MANIFEST: Manifest, **LINE_RECORDS}
    types |= ANSWER_RECORDS
    types |= {REPORT: ImportReport, "model.json": ModelCard}
    made = {
        name.split(".")[0]: msgspec.json.schema(kind, schema_hook=_anything)
        for name, kind in types.items()
    }
    made |= {"scenario": schema(ScenarioFile), "layout": schema(LayoutFile)}
    return {f"{name}.schema.json": to_bytes(content) for name, content in made.items()}


def _anything(kind: type) -> dict[str, Any]:
    if kind is not object:
        raise NotImplementedError  # as msgspec asks for
    return {"description": "Any JSON."}


def to_bytes(content: dict[str, Any]) -> bytes:
    """Return the file of a schema, with its dialect and without the indentation of docstrings."""
    for part in content.get("$defs", {}).values():
        if "description" in part:
            part["description"] = inspect.cleandoc(part["description"])
    whole = {"$schema": "https://json-schema.org/draft/2020-12/schema", **content}
    return msgspec.json.format(msgspec.json.encode(whole, order="sorted"), indent=2) + b"\n"


if __name__ == "__main__":
    for name, content in schemas().items():
        (Path(sys.argv[1]) / name).write_bytes(content)
