"""The table of a dataset's tasks, ``meta/tasks.parquet`` or ``meta/tasks.jsonl``.

Frames name their task by its number. Version 3 has a table of pandas, in which the texts are a
column or the index, and sometimes both.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.lerobot.dataset_files import (
    Record,
    damaged,
    file_inside,
    is_text,
    json_lines,
    parquet_file,
)
from corpus_tools.lerobot.episode_reading import Dataset
from corpus_tools.runtime.parquet import import_pyarrow, parquet_bytes

TASKS_JSONL, TASKS_PARQUET = "meta/tasks.jsonl", "meta/tasks.parquet"
TASK_INDEX, TASK = "task_index", "task"


@dataclass(frozen=True, slots=True)
class TaskTable:
    """The tasks of a dataset."""

    file: Path
    """It may be missing, where there are no tasks."""
    texts: Mapping[int, str]
    """By their numbers; empty where a number has no text."""

    @property
    def following(self) -> int:
        """The number of the next task."""
        return max(self.texts, default=-1) + 1

    def with_tasks(self, added: Sequence[str]) -> bytes:
        """Return the file's content with more tasks, of which the first is :attr:`following`."""
        numbers = range(self.following, self.following + len(added))
        if self.file.suffix != Path(TASKS_PARQUET).suffix:
            rows = [{TASK_INDEX: n, TASK: text} for n, text in zip(numbers, added, strict=True)]
            old = self.file.read_bytes() if self.file.exists() else b""
            gap = b"" if old.endswith(b"\n") or not old else b"\n"
            return old + gap + msgspec.json.Encoder().encode_lines(rows)
        if not self.file.exists():
            return tasks_parquet(added)
        pa, _ = import_pyarrow()
        with parquet_file(self.file) as parquet:
            table = parquet.read()
        columns: dict[str, Any] = {}
        for field in table.schema:
            is_number = field.name == TASK_INDEX or pa.types.is_integer(field.type)
            values = added if is_text(field.type) else [None] * len(added)
            columns[field.name] = list(numbers if is_number else values)
        return parquet_bytes(pa.concat_tables([table, pa.table(columns, schema=table.schema)]))


def task_table(dataset: Dataset) -> TaskTable:
    """Read the tasks of a dataset; one without a file of tasks has none."""
    name = TASKS_JSONL if dataset.is_old else TASKS_PARQUET
    file = file_inside(dataset.folder, name, where=str(dataset.folder / name))
    if not file.exists():
        return TaskTable(file, {})
    texts: dict[int, str] = {}
    for row in json_lines(file) if dataset.is_old else _rows(file):
        number, (text, *_) = row.whole(TASK_INDEX), (*row.texts(TASK), "")
        if number in texts:
            raise row.error(TASK_INDEX, f"two tasks have the number {number}")
        texts[number] = text
    return TaskTable(file, texts)


def _rows(file: Path) -> Iterator[Record]:
    with parquet_file(file) as parquet:
        column = _text_column(parquet.schema_arrow, file)
        table = parquet.read()
        texts = table.column(column).to_pylist()
        numbers: Sequence[Any] = range(len(table))
        if TASK_INDEX in table.column_names:
            numbers = table.column(TASK_INDEX).to_pylist()
    for row, (number, text) in enumerate(zip(numbers, texts, strict=True), start=1):
        yield Record(file, row, {TASK_INDEX: number, TASK: text})


def _text_column(schema: Any, file: Path) -> str:
    texts = [field.name for field in schema if is_text(field.type)]
    for name in (TASK, "__index_level_0__", *texts):
        if name in texts:
            return str(name)
    raise damaged(file, "there is no column with the texts of tasks")


def tasks_parquet(tasks: Sequence[str]) -> bytes:
    """Return a new table of tasks, which pandas reads with the texts as its index."""
    pa, _ = import_pyarrow()
    table = pa.table({TASK_INDEX: pa.array(range(len(tasks)), pa.int64()), TASK: list(tasks)})
    column = {"metadata": None}
    pandas = {
        "index_columns": [TASK],
        "column_indexes": [],
        "columns": [
            {"name": TASK_INDEX, "field_name": TASK_INDEX, "pandas_type": "int64",
             "numpy_type": "int64", **column},
            {"name": TASK, "field_name": TASK, "pandas_type": "unicode",
             "numpy_type": "object", **column},
        ],
        "pandas_version": "2.0.0",
    }  # fmt: skip
    return parquet_bytes(table.replace_schema_metadata({"pandas": json.dumps(pandas)}))
