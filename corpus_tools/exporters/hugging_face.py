"""A corpus as Parquet files with a dataset card, for Hugging Face's ``datasets``.

Each file of the corpus format is a configuration: ``load_dataset(FOLDER)`` gives the commands,
``load_dataset(FOLDER, "annotations")`` the annotations. Ids and numbers of trajectories are those
of the corpus. Trees of clauses have no place in a table, so they are JSON (``sdcs``) and the
paper's notation (``notation``); ``clauses`` lists them breadth first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec
import yaml

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_records import AnnotationRecord, ObjectReference
from corpus_tools.corpus.corpus_tables import as_lists, encode
from corpus_tools.runtime.parquet import import_pyarrow, parquet_bytes
from g3.annotation import Annotation
from g3.sdc.clauses import all_words, breadth_first
from g3.sdc.sdc_notation import format_brackets

SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"))
"""Up to how many rows a size category of dataset cards goes."""
LICENCES = frozenset(
    (
        "agpl-3.0", "apache-2.0", "bsd-2-clause", "bsd-3-clause", "bsl-1.0", "cc0-1.0",
        "cc-by-3.0", "cc-by-4.0", "cc-by-nc-3.0", "cc-by-nc-4.0", "cc-by-nc-nd-4.0",
        "cc-by-nc-sa-3.0", "cc-by-nc-sa-4.0", "cc-by-nd-4.0", "cc-by-sa-3.0", "cc-by-sa-4.0",
        "cdla-permissive-2.0", "epl-2.0", "eupl-1.2", "gpl-2.0", "gpl-3.0", "isc", "lgpl-2.1",
        "lgpl-3.0", "mit", "mpl-2.0", "odbl", "odc-by", "pddl", "unlicense", "zlib",
    )
)  # fmt: skip
"""Licences that dataset cards have an id for: their SPDX ids in small letters."""
WHAT = {
    "commands": "every command that was typed",
    "contexts": "semantic maps: objects, places, the robot",
    "annotations": "clauses with groundings and labels",
    "judgments": "people's ratings of commands shown with videos",
    "outcomes": "what the robot did",
    "trajectories": "poses, which objects and paths refer to by number",
}

Row = dict[str, Any]


def hugging_face_files(corpus: Corpus) -> dict[str, bytes]:
    """Return a Parquet file a part and the card ``README.md``; FormatError without pyarrow."""
    pa, _ = import_pyarrow()
    schemas = _schemas(pa)
    tables = encode(corpus.content)
    rows: Mapping[str, Iterable[Row]] = {
        "commands": map(_with_all_fields, tables.commands),
        "contexts": map(_with_all_fields, tables.contexts),
        "annotations": map(_annotation, corpus.annotations, tables.annotations),
        "judgments": map(_with_all_fields, tables.judgments),
        "outcomes": map(_with_all_fields, tables.outcomes),
        "trajectories": (
            {"id": number, **row} for number, row in enumerate(as_lists(tables.trajectories))
        ),
    }
    files, counts = {}, {}
    for name, of_part in rows.items():
        table = pa.Table.from_pylist([_fitting(row) for row in of_part], schema=schemas[name])
        if not table.num_rows and name != "commands":
            continue  # datasets can't read files without rows
        content = parquet_bytes(table, compression="zstd")
        files[f"{name}.parquet"], counts[name] = content, table.num_rows
    return {**files, "README.md": _card(corpus, counts).encode()}


def _schemas(pa: Any) -> Mapping[str, Any]:
    text, number, flag = pa.string(), pa.float64(), pa.bool_()
    texts, numbers = pa.list_(text), pa.list_(number)
    prism = pa.struct([("xy", pa.list_(numbers)), ("z_min", number), ("z_max", number)])
    item = [
        ("id", text), ("labels", texts), ("prism", prism), ("trajectory", pa.int64()),
        ("liftable", flag), ("colours", texts),
    ]  # fmt: skip
    grounding = pa.struct(
        [
            ("kind", text), ("object", text), ("context", text), ("name", text), ("labels", texts),
            ("prism", prism), ("trajectory", pa.int64()),
        ]
    )  # fmt: skip
    clause = pa.struct(
        [("type", text), ("text", text), ("groundings", pa.list_(grounding)), ("correct", flag)]
    )
    assumed = pa.struct([("object", text), ("what", text)])
    columns: dict[str, list[tuple[str, Any]]] = {
        "commands": [(n, text) for n in ("id", "text", "scenario", "video", "subject")],
        "contexts": [
            ("id", text), ("agent_id", text), ("objects", pa.list_(pa.struct(item))),
            ("places", pa.list_(pa.struct([("name", text), ("prism", prism)]))),
            ("assumed", pa.list_(assumed)),
        ],
        "annotations": [
            ("id", text), ("command", text), ("context", text), ("source", text), ("text", text),
            ("notation", text), ("clauses", pa.list_(clause)), ("sdcs", text),
        ],
        "judgments": [
            (n, text)
            for n in ("id", "command", "command_video", "shown_video", "rating", "study", "subject")
        ],
        "outcomes": [
            *((n, text) for n in ("id", "scenario", "context", "command", "video")),
            ("picked", texts), ("put", text), ("on", texts), ("checkpoint", pa.int64()),
            ("unknown", texts), ("log", text),
        ],
        "trajectories": [
            ("id", pa.int64()), ("t", numbers), ("xyz", pa.list_(numbers)), ("yaw", numbers),
        ],
    }  # fmt: skip
    return {name: pa.schema(fields) for name, fields in columns.items()}


def _with_all_fields(record: msgspec.Struct) -> Row:
    """Convert a record to a row: files leave defaults out, tables don't."""
    names = record.__struct_fields__
    return {name: msgspec.to_builtins(getattr(record, name)) for name in names}


def _fitting(row: Row) -> Row:
    if row.get("assumed"):
        row["assumed"] = [{"object": name, "what": what} for name, what in row["assumed"]]
    return row


def _annotation(annotation: Annotation, record: AnnotationRecord) -> Row:
    clauses = [
        {
            "type": sdc.type,
            "text": " ".join(word.text for word in all_words(sdc)),
            "groundings": [_grounding(grounding) for grounding in groundings],
            "correct": correct,
        }
        for sdc, groundings, correct in zip(
            breadth_first(annotation.sdcs), record.groundings, record.correct, strict=True
        )
    ]
    return {
        "id": record.id,
        "command": record.command,
        "context": record.context,
        "source": record.source,
        "text": annotation.command.text,
        "notation": format_brackets(annotation.sdcs),
        "clauses": clauses,
        "sdcs": msgspec.json.encode(record.sdcs).decode(),
    }


def _grounding(record: msgspec.Struct) -> Row:
    row: Row = msgspec.to_builtins(record)
    if not isinstance(record, ObjectReference) and "id" in row:
        row["object"] = row["id"]
    return row


def _card(corpus: Corpus, counts: Mapping[str, int]) -> str:
    most = max(counts.values())
    licence = corpus.licence.strip().lower()
    head = {
        "pretty_name": corpus.name,
        **(
            {"license": licence}
            if licence in LICENCES
            else {"license": "other", "license_name": corpus.licence or "unknown"}
        ),
        "language": ["en"],
        "task_categories": ["robotics"],
        "tags": ["robotics", "grounded language", "spatial description clauses"],
        "size_categories": [next((name for n, name in SIZES if most < n), "100K<n<1M")],
        "configs": [
            {"config_name": name, "data_files": f"{name}.parquet"}
            | ({"default": True} if name == "commands" else {})
            for name in counts
        ],
    }
    parts = "\n".join(f"| `{name}` | {count} | {WHAT[name]} |" for name, count in counts.items())
    return f"""---
{yaml.safe_dump(head, sort_keys=False)}---

# {corpus.name}

Source: {corpus.source.rstrip(". ") or "not told"}. Licence: {corpus.licence or "not told"}.
Hash of the content: `{corpus.hash}`.

| configuration | rows | what |
| --- | ---: | --- |
{parts}

```python
from datasets import load_dataset

commands = load_dataset("FOLDER", split="train")
annotations = load_dataset("FOLDER", "annotations", split="train")
```

Clauses are spatial description clauses (SDCs) after Tellex et al. 2011. `correct` is empty where
nobody said whether a grounding is right. `source` tells how groundings came about: `positive` from
an annotator, `random`, `easy` and `hard` from programs. Lengths are in metres, angles in radians
counter-clockwise from +x, times in seconds.
"""
