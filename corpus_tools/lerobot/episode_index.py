"""The index of a dataset's episodes in a copy: new tasks, and columns of one's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import msgspec

from corpus_tools.lerobot.dataset_files import content_of, files_below, with_features
from corpus_tools.lerobot.episode_frames import EPISODE_INDEX
from corpus_tools.lerobot.episode_reading import EPISODES_FOLDER, EPISODES_JSONL, Dataset
from corpus_tools.lerobot.language_rows import widened
from corpus_tools.runtime.parquet import import_pyarrow

Kind: TypeAlias = Literal["text", "texts", "number", "count"]
NewTasks: TypeAlias = Mapping[str, str]
"""New texts of an episode's tasks by the old ones; by the empty text where it had none."""
TASKS = "tasks"

_FEATURES: Mapping[Kind, Any] = {
    "text": {"dtype": "string", "_type": "Value"},
    "texts": {"feature": {"dtype": "string", "_type": "Value"}, "_type": "List"},
    "number": {"dtype": "float64", "_type": "Value"},
    "count": {"dtype": "int64", "_type": "Value"},
}


@dataclass(frozen=True, slots=True)
class IndexColumn:
    """A column of the index. Episodes without a value keep an earlier one, or get null."""

    name: str
    kind: Kind
    values: Mapping[int, Any]
    """By the numbers of episodes."""


def rewritten_index(
    dataset: Dataset,
    scratch: Path,
    tasks: Mapping[int, NewTasks],
    columns: Sequence[IndexColumn] = (),
) -> dict[str, bytes | Path]:
    """Return the files of the index that change, by their names.

    Parameters
    ----------
    scratch
        A folder for large files.
    tasks
        By the numbers of episodes.
    """
    tasks = {index: of_episode for index, of_episode in tasks.items() if of_episode}
    if not tasks and not columns:
        return {}
    if dataset.is_old:
        return {EPISODES_JSONL: _lines(dataset, tasks, columns)}
    files: dict[str, bytes | Path] = {}
    for file in files_below(dataset.folder, EPISODES_FOLDER):
        name = file.relative_to(dataset.folder).as_posix()
        files[name] = _rewritten(file, scratch / f"{name}.new", tasks, columns)
    return files


def _lines(
    dataset: Dataset, tasks: Mapping[int, NewTasks], columns: Sequence[IndexColumn]
) -> bytes:
    lines = []
    for line in (dataset.folder / EPISODES_JSONL).read_bytes().split(b"\n"):
        row = msgspec.json.decode(line) if line.strip() else {}
        index = row.get(EPISODE_INDEX, -1)
        new = {one.name: one.values[index] for one in columns if index in one.values}
        if index in tasks:
            new[TASKS] = _replaced(row.get(TASKS), tasks[index])
        lines.append(msgspec.json.encode(row | new) if new else line)
    return b"\n".join(lines)


def _replaced(had: Any, new: NewTasks) -> list[str]:
    """Return the tasks of a row with new ones among them."""
    listed = [had] if isinstance(had, str) else had or []
    texts = [text for text in listed if text and text.strip()]
    return list(dict.fromkeys(new.get(text, text) for text in texts)) or list(new.values())


def _rewritten(
    file: Path, target: Path, tasks: Mapping[int, NewTasks], columns: Sequence[IndexColumn]
) -> Path:
    """Write a file of the index once more; return the file itself if nothing changes."""
    pa, pq = import_pyarrow()
    kinds = {
        "text": pa.string(),
        "texts": pa.list_(pa.string()),
        "number": pa.float64(),
        "count": pa.int64(),
    }
    with content_of(file):
        parquet = pq.ParquetFile(file)
    with parquet:
        schema = parquet.schema_arrow
        has_tasks = bool(tasks) and TASKS in schema.names
        if has_tasks and not columns:
            with content_of(file):
                episodes = parquet.read([EPISODE_INDEX]).column(EPISODE_INDEX).to_pylist()
            has_tasks = not tasks.keys().isdisjoint(episodes)
        if not has_tasks and not columns:
            return file
        if has_tasks:
            place = schema.names.index(TASKS)
            kind = widened(schema.field(TASKS).type, pa.list_(pa.string()))
            schema = schema.set(place, schema.field(TASKS).with_type(kind))
        had = [one.name for one in columns if one.name in schema.names]
        stay = {n: schema.field(n).type == kinds[c.kind] for c in columns if (n := c.name) in had}
        for one in columns:
            new = pa.field(one.name, kinds[one.kind])
            place = schema.names.index(one.name) if one.name in had else len(schema)
            schema = schema.set(place, new) if one.name in had else schema.append(new)
        features = {one.name: _FEATURES[one.kind] for one in columns}
        schema = schema.with_metadata(with_features(schema.metadata, features) or None)
        target.parent.mkdir(parents=True, exist_ok=True)
        with pq.ParquetWriter(target, schema) as writer:
            for group in range(parquet.num_row_groups):
                with content_of(file):
                    table = parquet.read_row_group(group)
                    episodes = table.column(EPISODE_INDEX).to_pylist()
                    cells = {name: table.column(name) for name in table.column_names}
                    if has_tasks:
                        cells[TASKS] = _task_cells(
                            cells[TASKS], schema.field(TASKS), episodes, tasks
                        )
                    for one in columns:
                        before = (
                            cells[one.name].to_pylist()
                            if stay.get(one.name)
                            else [None] * len(episodes)
                        )
                        values = [
                            one.values.get(index, old)
                            for index, old in zip(episodes, before, strict=True)
                        ]
                        cells[one.name] = pa.array(values, kinds[one.kind])
                writer.write_table(pa.table(cells, schema=schema))
    return target


def _task_cells(
    column: Any, field: Any, episodes: Sequence[int], tasks: Mapping[int, NewTasks]
) -> Any:
    pa, _ = import_pyarrow()
    is_list = pa.types.is_list(field.type) or pa.types.is_large_list(field.type)
    cells = column.to_pylist()
    for row, index in enumerate(episodes):
        if index in tasks:
            new = _replaced(cells[row], tasks[index])
            cells[row] = new if is_list else "; ".join(new)
    return pa.array(cells, field.type)
