"""JSON Schemas of a corpus's files, made from the records.

``python -m corpus_tools.corpus.schemas docs/schemas`` writes them anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

import msgspec

from corpus_tools.corpus.records import LINE_RECORDS, MANIFEST, Manifest


def schemas() -> dict[str, bytes]:
    """The content of each schema file by name."""
    types: dict[str, type[msgspec.Struct]] = {MANIFEST: Manifest, **LINE_RECORDS}
    return {f"{name.split('.')[0]}.schema.json": _schema(kind) for name, kind in types.items()}


def _schema(record_type: type[msgspec.Struct]) -> bytes:
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **msgspec.json.schema(record_type),
    }
    return msgspec.json.format(msgspec.json.encode(schema, order="sorted"), indent=2) + b"\n"


if __name__ == "__main__":
    for name, content in schemas().items():
        (Path(sys.argv[1]) / name).write_bytes(content)
