"""JSON Schemas of the files of corpora, scenarios and layouts, made from the records.

``python -m corpus_tools.corpus.schemas docs/schemas`` writes them anew.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.corpus.records import LINE_RECORDS, MANIFEST, Manifest
from corpus_tools.world.scenarios.files import LayoutFile, ScenarioFile, schema


def schemas() -> dict[str, bytes]:
    """The content of each schema file by name."""
    types: dict[str, type[msgspec.Struct]] = {MANIFEST: Manifest, **LINE_RECORDS}
    made = {name.split(".")[0]: msgspec.json.schema(kind) for name, kind in types.items()}
    made |= {"scenario": schema(ScenarioFile), "layout": schema(LayoutFile)}
    return {f"{name}.schema.json": _to_bytes(content) for name, content in made.items()}


def _to_bytes(content: dict[str, Any]) -> bytes:
    whole = {"$schema": "https://json-schema.org/draft/2020-12/schema", **content}
    return msgspec.json.format(msgspec.json.encode(whole, order="sorted"), indent=2) + b"\n"


if __name__ == "__main__":
    for name, content in schemas().items():
        (Path(sys.argv[1]) / name).write_bytes(content)
