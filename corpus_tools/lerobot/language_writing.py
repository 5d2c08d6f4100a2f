"""Putting language into a copy of a LeRobot dataset.

Videos are linked, or copied where that can't be done. Of the frames only the two language columns
change, and ``task_index`` where an episode had no task. Files are read and written a group of rows
at a time, so that memory stays flat.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot import episode_reading
from corpus_tools.lerobot.language_rows import (
    EVENTS,
    FEATURE,
    PERSISTENT,
    Language,
    Row,
    column_types,
    persistent_rows_of,
    sorted_rows,
)
from corpus_tools.runtime.atomic_folder import write_folder
from corpus_tools.runtime.parquet import import_pyarrow
from g3.errors import FormatError
from g3.storage.system_errors import about

LINKED = ("videos", "images")
"""Folders whose files nothing here changes."""

_HUGGING_FACE = b"huggingface"


@dataclass(frozen=True, slots=True)
class EpisodeLanguage:
    """What is to be said of an episode."""

    said: tuple[Language, ...]
    """What is added to its persistent rows."""
    replaces: frozenset[str] = frozenset()
    """Styles of which the dataset's own rows go."""
    task: str = ""
    """Its task, if the dataset names none."""


def write_language(
    dataset: episode_reading.Dataset,
    target: Path,
    language: Mapping[int, EpisodeLanguage],
    *,
    attachments: Mapping[str, bytes],
    force: bool = False,
) -> None:
    """Write a copy of a dataset with language in it: the whole folder or, on any error, nothing.

    The parent of the copy's folder `target` must be there. `language` is by the numbers of
    episodes; the others keep what they have. `attachments` are further files by name. FormatError
    if the copy would lie in the dataset, or a file can't be read or written.
    """
    source = dataset.folder.resolve()
    if source == target.resolve() or source in target.resolve().parents:
        raise FormatError(
            "the copy would lie in the dataset itself",
            where=str(target),
            fix="name a folder elsewhere: the dataset stays as it is",
        )
    tasks = _new_tasks(dataset, language)
    with (
        about(target),
        tempfile.TemporaryDirectory(dir=target.parent, prefix=".lerobot-") as scratch,
        about(target, instead_of=scratch),
    ):
        files: dict[str, bytes | Path] = {}
        for file in sorted(source.rglob("*")):
            name = file.relative_to(source).as_posix()
            if not file.is_file() or name.startswith("."):
                continue
            is_linked = name.split("/")[0] in LINKED
            files[name] = file if is_linked else _copied(file, Path(scratch) / name)
        for file in episode_reading.data_files(dataset):
            name = file.relative_to(dataset.folder).as_posix()
            new = Path(scratch) / f"{name}.new"
            _rewrite(file, new, language, tasks.numbers)
            files[name] = new
        files |= _metadata(dataset, tasks, Path(scratch)) | dict(attachments)
        write_folder(target, files, force=force, marker=episode_reading.INFO)


def _copied(file: Path, target: Path) -> Path:
    """A copy on the target's disk, which then gets its name there."""
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, target)
    return target


@dataclass(frozen=True, slots=True)
class _Tasks:
    """Tasks that are new: the number and the text of each episode's, and all new ones in order."""

    numbers: Mapping[int, int]
    texts: Mapping[int, str]
    added: tuple[str, ...]


def _known_tasks(dataset: episode_reading.Dataset) -> dict[str, int]:
    if (dataset.folder / episode_reading.TASKS_PARQUET).is_file():
        _, pq = import_pyarrow()
        table = pq.read_table(dataset.folder / episode_reading.TASKS_PARQUET)
        (name,) = (n for n in table.column_names if n != "task_index")
        texts, numbers = table.column(name).to_pylist(), table.column("task_index").to_pylist()
        return dict(zip(texts, numbers, strict=True))
    lines = (dataset.folder / episode_reading.TASKS_JSONL).read_bytes().splitlines()
    rows = [msgspec.json.decode(line) for line in lines if line.strip()]
    return {row["task"]: row["task_index"] for row in rows}


def _new_tasks(dataset: episode_reading.Dataset, language: Mapping[int, EpisodeLanguage]) -> _Tasks:
    """The tasks of episodes that had none."""
    known, texts = _known_tasks(dataset), {}
    before = len(known)
    for episode in dataset.episodes():
        told = language.get(episode.index)
        if told is not None and told.task and not any(t.strip() for t in episode.tasks):
            texts[episode.index] = told.task
            known.setdefault(told.task, max(known.values(), default=-1) + 1)
    numbers = {index: known[text] for index, text in texts.items()}
    return _Tasks(numbers, texts, tuple(known)[before:])


def _rewrite(
    file: Path, target: Path, language: Mapping[int, EpisodeLanguage], tasks: Mapping[int, int]
) -> None:
    """Write the frames of a file anew with their language."""
    pa, pq = import_pyarrow()
    with pq.ParquetFile(file) as parquet:
        before = parquet.schema_arrow
        types = {
            name: before.field(name).type if name in before.names else kind
            for name, kind in column_types().items()
        }
        kept = [name for name in before.names if name not in types]
        fields = [before.field(name) for name in kept]
        fields += [pa.field(name, kind) for name, kind in types.items()]
        schema = pa.schema(fields, metadata=_told_of_columns(before.metadata))
        rows = _rows_by_episode(parquet, language, file)
        target.parent.mkdir(parents=True, exist_ok=True)
        with pq.ParquetWriter(target, schema) as writer:
            for group in range(parquet.num_row_groups):
                table = parquet.read_row_group(group)
                columns = {name: table.column(name) for name in kept}
                episodes = table.column("episode_index").to_numpy()
                if tasks and "task_index" in columns:
                    columns["task_index"] = _with_tasks(columns["task_index"], episodes, tasks)
                columns[PERSISTENT] = _spread(rows, episodes, types[PERSISTENT], table, file)
                columns[EVENTS] = (
                    table.column(EVENTS)
                    if EVENTS in before.names
                    else pa.array([[]], types[EVENTS]).take(pa.array(np.zeros(len(table), int)))
                )
                writer.write_table(pa.table(columns, schema=schema))


def _rows_by_episode(
    parquet: Any, language: Mapping[int, EpisodeLanguage], file: Path
) -> dict[int, list[Row] | None]:
    """The persistent rows of the episodes in a file; None for those that stay as they are."""
    times = parquet.read(columns=["episode_index", "timestamp"])
    episodes = times.column("episode_index").to_numpy()
    timestamps: npt.NDArray[np.float32] = times.column("timestamp").to_numpy()
    had = dict(persistent_rows_of(file)) if PERSISTENT in parquet.schema_arrow.names else {}
    found: dict[int, list[Row] | None] = {}
    for index in np.unique(episodes).tolist():
        told = language.get(index)
        if told is None:
            found[index] = None if index in had else []
            continue
        stays = [row for row in had.get(index, ()) if row["style"] not in told.replaces]
        mine = timestamps[episodes == index]
        found[index] = sorted_rows([*stays, *(said.row(mine) for said in told.said)])
    return found


def _spread(
    rows: Mapping[int, list[Row] | None],
    episodes: npt.NDArray[np.int64],
    kind: Any,
    table: Any,
    file: Path,
) -> Any:
    """An episode's rows on each of its frames."""
    pa, _ = import_pyarrow()
    pieces = []
    edges = [0, *(np.flatnonzero(np.diff(episodes)) + 1).tolist(), len(episodes)]
    for start, end in pairwise(edges):
        if start == end:
            continue
        of_episode = rows[int(episodes[start])]
        if of_episode is None:
            pieces.append(table.column(PERSISTENT).slice(start, end - start).combine_chunks())
            continue
        try:
            one = pa.array([of_episode], kind)
        except (pa.ArrowException, TypeError) as error:
            raise FormatError(
                f"the language can't be written as the dataset has it: {error}",
                where=str(file),
                fix="annotate a dataset without language, or write to LeRobot's own types",
            ) from error
        pieces.append(one.take(pa.array(np.zeros(end - start, int))))
    return pa.chunked_array(pieces, kind)


def _with_tasks(column: Any, episodes: npt.NDArray[np.int64], tasks: Mapping[int, int]) -> Any:
    pa, _ = import_pyarrow()
    numbers = column.to_numpy().copy()
    for index, number in tasks.items():
        numbers[episodes == index] = number
    return pa.chunked_array([pa.array(numbers, column.type)])


def _told_of_columns(metadata: Mapping[bytes, bytes] | None) -> dict[bytes, bytes]:
    """The file's metadata; what it tells Hugging Face's ``datasets`` of columns has these, too."""
    told = dict(metadata or {})
    if _HUGGING_FACE in told:
        content = json.loads(told[_HUGGING_FACE])
        features = content.get("info", {}).get("features")
        if features is not None:
            for name in (PERSISTENT, EVENTS):
                features.setdefault(name, _feature(name))
            told[_HUGGING_FACE] = json.dumps(content).encode()
    return told


def _feature(column: str) -> dict[str, Any]:
    text = {"dtype": "string", "_type": "Value"}
    row: dict[str, Any] = dict.fromkeys(("role", "content", "style"), text)
    if column == PERSISTENT:
        row["timestamp"] = {"dtype": "float32", "_type": "Value"}
    row |= {"camera": text, "tool_calls": {"feature": text, "_type": "List"}}
    return {"feature": row, "_type": "List"}


def _metadata(
    dataset: episode_reading.Dataset, tasks: _Tasks, scratch: Path
) -> dict[str, bytes | Path]:
    """The files of ``meta`` that change."""
    info = json.loads((dataset.folder / episode_reading.INFO).read_text("utf-8"))
    for name in (PERSISTENT, EVENTS):
        info["features"].setdefault(name, dict(FEATURE))
    files: dict[str, bytes | Path] = {}
    if tasks.added:
        info["total_tasks"] = info.get("total_tasks", 0) + len(tasks.added)
    if tasks.texts:
        files |= _old_tasks(dataset, tasks) if dataset.is_old else _tasks(dataset, tasks, scratch)
    files[episode_reading.INFO] = json.dumps(info, indent=4, ensure_ascii=False).encode()
    return files


def _old_tasks(dataset: episode_reading.Dataset, tasks: _Tasks) -> dict[str, bytes | Path]:
    known = _known_tasks(dataset)
    first = max(known.values(), default=-1) + 1
    lines = (dataset.folder / episode_reading.TASKS_JSONL).read_bytes().rstrip(b"\n").splitlines()
    lines += [
        msgspec.json.encode({"task_index": first + n, "task": text})
        for n, text in enumerate(tasks.added)
    ]
    episodes = []
    for line in (dataset.folder / episode_reading.EPISODES_JSONL).read_bytes().splitlines():
        row = msgspec.json.decode(line) if line.strip() else {}
        task = tasks.texts.get(row.get("episode_index", -1))
        episodes.append(line if task is None else msgspec.json.encode(row | {"tasks": [task]}))
    return {
        episode_reading.TASKS_JSONL: b"\n".join([*lines, b""]),
        episode_reading.EPISODES_JSONL: b"\n".join([*episodes, b""]),
    }


def _tasks(
    dataset: episode_reading.Dataset, tasks: _Tasks, scratch: Path
) -> dict[str, bytes | Path]:
    pa, pq = import_pyarrow()
    table = pq.read_table(dataset.folder / episode_reading.TASKS_PARQUET)
    first = max(_known_tasks(dataset).values(), default=-1) + 1
    added = {
        name: range(first, first + len(tasks.added)) if name == "task_index" else tasks.added
        for name in table.column_names
    }
    rows = pa.table({name: list(values) for name, values in added.items()}, schema=table.schema)
    new = scratch / "new-tasks.parquet"
    pq.write_table(pa.concat_tables([table, rows]), new)
    files: dict[str, bytes | Path] = {episode_reading.TASKS_PARQUET: new}
    for file in sorted((dataset.folder / episode_reading.EPISODES_FOLDER).glob("*/*.parquet")):
        name = file.relative_to(dataset.folder).as_posix()
        files[name] = _with_episode_tasks(file, scratch / f"{name}.new", tasks)
    return files


def _with_episode_tasks(file: Path, target: Path, tasks: _Tasks) -> Path:
    pa, pq = import_pyarrow()
    target.parent.mkdir(parents=True, exist_ok=True)
    with pq.ParquetFile(file) as parquet, pq.ParquetWriter(target, parquet.schema_arrow) as writer:
        for group in range(parquet.num_row_groups):
            table = parquet.read_row_group(group)
            rows = zip(
                table.column("episode_index").to_pylist(), table.column("tasks").to_pylist(),
                strict=True,
            )  # fmt: skip
            told = [[tasks.texts[n]] if n in tasks.texts else had for n, had in rows]
            place = table.column_names.index("tasks")
            field = table.schema.field("tasks")
            writer.write_table(table.set_column(place, field, pa.array(told, field.type)))
    return target
