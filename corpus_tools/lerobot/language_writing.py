"""Putting language into a copy of a LeRobot dataset.

Videos are linked, or copied where that can't be done. Of the frames only the two language columns
change, and ``task_index`` where an episode had no task. Files are read and written a group of rows
at a time, so that memory stays flat.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot import episode_reading
from corpus_tools.lerobot.dataset_files import (
    check_is_file,
    content_of,
    file_inside,
    files_below,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_frames import EPISODE_INDEX, checked_episodes
from corpus_tools.lerobot.language_rows import (
    EVENTS,
    FEATURE,
    PERSISTENT,
    PLAN,
    SAY,
    Language,
    Placed,
    Row,
    column_types,
    events_of,
    language_array,
    persistent_rows_of,
    placed,
    plans,
    rows_of,
    widened,
    with_events,
)
from corpus_tools.lerobot.task_tables import TASK_INDEX, TaskTable, task_table
from corpus_tools.runtime.atomic_folder import write_folder
from corpus_tools.runtime.parquet import import_pyarrow
from g3.errors import CorpusError, FormatError
from g3.storage.system_errors import about

LINKED = ("videos", "images")
"""Folders whose files stay unchanged."""
PROVENANCE = "meta/people.jsonl"
"""The file of the copy with the source of each text."""

SAY_TOOL = {
    "type": "function",
    "function": {
        "name": SAY,
        "description": "Speak a short utterance to the user via the TTS executor.",
        "parameters": {
            "type": "object",
            "properties": {
                "text": {"type": "string", "description": "The verbatim text to speak."}
            },
            "required": ["text"],
        },
    },
}
"""The tool of the robot's replies, as LeRobot declares it in ``meta/info.json``."""

_HUGGING_FACE = b"huggingface"


@dataclass(frozen=True, slots=True)
class EpisodeLanguage:
    """The language of an episode."""

    said: tuple[Language, ...]
    """The texts that are added, and plans of the subtasks among them unless there are others."""
    replaces: frozenset[str] = frozenset()
    """Styles of which the dataset's own rows go."""
    task: str = ""
    """Its task, if the dataset names none."""


@dataclass(frozen=True, slots=True)
class _NewLanguage:
    """The language of an episode at its frames."""

    items: tuple[Placed, ...]
    timestamps: npt.NDArray[np.float32]
    tasks: tuple[str, ...]
    replaces: frozenset[str]


@dataclass(frozen=True, slots=True)
class _NewTasks:
    """The number and the text of the task of each episode that had none, and new texts in order."""

    numbers: Mapping[int, int]
    texts: Mapping[int, str]
    added: tuple[str, ...]


def write_language(
    dataset: episode_reading.Dataset,
    target: Path,
    language: Mapping[int, EpisodeLanguage],
    *,
    attachments: Mapping[str, bytes],
    force: bool = False,
) -> list[str]:
    """Write a copy of a dataset with language in it: the whole folder or, on any error, nothing.

    The source of each text that has one is written to ``meta/people.jsonl``, with the time of its
    frame, or null for a text that couldn't be placed.

    Parameters
    ----------
    target
        The copy's folder, whose parent must be there.
    language
        By the numbers of episodes; the others keep what they have.
    attachments
        Further files by name.

    Returns
    -------
    list of str
        The texts that are written at another frame than the nearest, or not at all, with reasons.

    Raises
    ------
    FormatError
        If the copy would lie in the dataset, or a file can't be read or written.
    """
    source = dataset.folder
    if source == target.resolve() or source in target.resolve().parents:
        raise FormatError(
            "the copy would lie in the dataset itself",
            where=str(target),
            fix="name a folder elsewhere: the dataset stays as it is",
        )
    table, notes, new = task_table(dataset), [], dict[int, _NewLanguage]()
    texts: dict[int, str] = {}
    wrong: list[CorpusError] = []
    numbers: set[int] = set()
    for framed in checked_episodes(dataset, (), on_error=wrong.append):
        numbers.update(framed.frames.tasks)
        episode, added = framed.episode, language.get(framed.episode.index)
        if added is None or not episode.frames:
            continue
        if added.task and not episode.tasks:
            texts[episode.index] = added.task
        items = placed(added.said, framed.frames.times, 1 / dataset.info.fps, dataset.pictures)
        if all(item.style != PLAN for item in added.said):
            items += plans(items)
        times = framed.frames.times.astype(np.float32)
        tasks = episode.tasks or ((added.task,) if added.task else ())
        new[episode.index] = _NewLanguage(tuple(items), times, tasks, added.replaces)
    notes += [str(error) for error in wrong]
    notes += [f"episode {i}: {note}" for i, one in new.items() for note in _notes(one.items)]
    left_out = sorted(language.keys() - new.keys())
    if left_out and not new:
        raise FormatError(
            f"the dataset has no episode {left_out[0]} with frames, nor any other of these",
            where=str(source),
            fix="name the dataset that the language is about",
        )
    notes += [f"episode {n}: its language isn't written: it is no episode here" for n in left_out]
    tasks_of = _new_tasks(table, texts, max(numbers, default=-1))
    has_speech = any(item.language.reply for one in new.values() for item in one.items)
    with (
        about(target),
        tempfile.TemporaryDirectory(dir=target.parent, prefix=".lerobot-") as scratch,
        about(target, instead_of=scratch),
    ):
        files = dict(_copies(source, Path(scratch)))
        for file in episode_reading.data_files(dataset):
            name = file.relative_to(source).as_posix()
            files[name] = Path(scratch) / f"{name}.new"
            notes += _rewrite(file, files[name], new, tasks_of.numbers, has_speech=has_speech)
        changed = _metadata(dataset, table, tasks_of, scratch, has_speech=has_speech)
        every: dict[str, bytes | Path] = {**files, **changed}
        every |= attachments
        if lines := _provenance(language, new):
            before = files.get(PROVENANCE)  # of those who were asked about this dataset earlier
            every[PROVENANCE] = (before.read_bytes() if before else b"") + lines
        write_folder(target, every, force=force, marker=episode_reading.INFO)
    return notes


def _notes(items: Sequence[Placed]) -> Iterator[str]:
    for item in items:
        if item.note:
            is_there = "" if item.frame is not None else " isn't written:"
            yield f"{item.language.style} {item.language.text!r:.60}{is_there} {item.note}"


def _provenance(language: Mapping[int, EpisodeLanguage], new: Mapping[int, _NewLanguage]) -> bytes:
    """Return the texts with a source, in their order, each with the time of its frame."""
    rows = []
    for index, added in language.items():
        one = new.get(index)
        items = one.items if one else [Placed(item, None) for item in added.said]
        for item in items:
            text, frame = item.language, item.frame
            if text.source:
                time = None if frame is None or one is None else float(one.timestamps[frame])
                rows.append(
                    {
                        "episode_index": index, "style": text.style, "start_s": text.start_s,
                        "timestamp": time, "content": text.text, **_more(text), **text.source,
                    }
                )  # fmt: skip
    return msgspec.json.Encoder().encode_lines(rows)


def _more(text: Language) -> dict[str, str]:
    """Return the other texts of an event's rows."""
    reply = text.answer.content() if text.answer is not None else text.reply
    more = {"camera": text.camera, "reply": reply}
    return {name: value for name, value in more.items() if value}


def _copies(source: Path, scratch: Path) -> Iterator[tuple[str, Path]]:
    """Yield the files of the copy by their names; hidden ones are left out."""
    for path in sorted(source.rglob("*")):
        name = path.relative_to(source).as_posix()
        is_link = path.is_symlink()
        if any(part.startswith(".") for part in name.split("/")) or (path.is_dir() and not is_link):
            continue
        file = file_inside(source, name, where=str(path))
        check_is_file(file)
        is_linked = name.split("/")[0] in LINKED
        yield name, file if is_linked else _copied(file, scratch / name)


def _copied(file: Path, target: Path) -> Path:
    """Copy a file to the target's disk, where it then gets its name."""
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, target)
    return target


def _new_tasks(table: TaskTable, texts: Mapping[int, str], last: int) -> _NewTasks:
    """Return the tasks to be added; `last` is the largest number in the frames.

    Numbers that frames have and the table hasn't get rows without a text, so that no episode gets
    another's task, and a task's number stays its place in the table, as LeRobot has it.
    """
    if not texts:
        return _NewTasks({}, {}, ())
    number_of: dict[str, int] = {}
    for number, text in table.texts.items():
        number_of.setdefault(text, number)
    added = [""] * (last + 1 - table.following)
    for text in texts.values():
        if text not in number_of:
            number_of[text] = table.following + len(added)
            added.append(text)
    numbers = {index: number_of[text] for index, text in texts.items()}
    return _NewTasks(numbers, texts, tuple(added))


def _rewrite(
    file: Path,
    target: Path,
    new: Mapping[int, _NewLanguage],
    tasks: Mapping[int, int],
    *,
    has_speech: bool,
) -> list[str]:
    """Write the frames of a file once more, with their language; return notes on events."""
    pa, pq = import_pyarrow()
    usual = column_types(has_speech=has_speech)
    rows = _rows_by_episode(file, new)
    events = _FileEvents({index: events_of(one.items) for index, one in new.items()})
    target.parent.mkdir(parents=True, exist_ok=True)
    with content_of(file):
        parquet = pq.ParquetFile(file)
    with parquet:
        before = parquet.schema_arrow
        kinds = dict(usual)
        if EVENTS in before.names:
            kind = before.field(EVENTS).type
            kinds[EVENTS] = widened(kind, usual[EVENTS]) if any(events.new.values()) else kind
        if PERSISTENT in before.names:
            kinds[PERSISTENT] = widened(before.field(PERSISTENT).type, usual[PERSISTENT])
        kept = [name for name in before.names if name not in kinds]
        fields = [before.field(name) for name in kept]
        fields += [pa.field(name, kind) for name, kind in kinds.items()]
        schema = pa.schema(fields, metadata=_with_columns(before, kinds))
        with pq.ParquetWriter(target, schema) as writer:
            for group in range(parquet.num_row_groups):
                with content_of(file):
                    table = parquet.read_row_group(group)
                    episodes = whole_numbers_of(table, EPISODE_INDEX, file, 0)
                    columns = {name: table.column(name) for name in kept}
                    if tasks and TASK_INDEX in columns:
                        columns[TASK_INDEX] = _with_tasks(columns[TASK_INDEX], episodes, tasks)
                    columns[PERSISTENT] = _spread(rows, episodes, kinds[PERSISTENT], table)
                    there = (
                        table.column(EVENTS)
                        if EVENTS in before.names
                        else pa.array([[]], kinds[EVENTS]).take(_zeros(len(table)))
                    )
                    columns[EVENTS] = events.added(there, episodes, kinds[EVENTS])
                writer.write_table(pa.table(columns, schema=schema))
    return events.notes


@dataclass(slots=True)
class _FileEvents:
    """The events that are added to a file, whose frames come a group of rows at a time."""

    new: Mapping[int, Mapping[int, list[Row]]]
    """By the numbers of episodes and of frames."""
    notes: list[str] = field(default_factory=list)
    frames: Counter[int] = field(default_factory=Counter)
    """Number of the frames so far, of each episode."""

    def added(self, column: Any, episodes: npt.NDArray[np.int64], kind: Any) -> Any:
        """Return a column with the new events of its frames, as the type `kind`."""
        pa, _ = import_pyarrow()
        column = column if column.type == kind else column.cast(kind)
        pieces, start = [], 0
        for place, index in enumerate(episodes.tolist()):
            rows = self.new.get(index, {}).get(self.frames[index])
            if rows:
                before = [row for row in column[place].as_py() or () if row is not None]
                every = with_events(before, rows)
                if gone := len(before) + len(rows) - len(every):
                    where = f"episode {index}, frame {self.frames[index]}"
                    self.notes.append(f"{where}: people's text replaces {gone} of the dataset's")
                pieces += [column.slice(start, place - start), language_array(every, kind)]
                start = place + 1
            self.frames[index] += 1
        if not pieces:
            return column
        pieces.append(column.slice(start))
        chunks = [chunk for piece in pieces for chunk in getattr(piece, "chunks", [piece])]
        return pa.chunked_array(chunks, kind)


def _rows_by_episode(file: Path, new: Mapping[int, _NewLanguage]) -> dict[int, list[Row] | None]:
    """Return the persistent rows of episodes; None for those that stay as they are."""
    result: dict[int, list[Row] | None] = {}
    had: dict[int, list[Row]] = {}
    for index, rows in persistent_rows_of(file):
        had.setdefault(index, rows)
        result[index] = None
    for index, one in new.items():
        others = [row for row in had.get(index, ()) if row["style"] not in one.replaces]
        result[index] = rows_of(one.items, one.timestamps, tasks=one.tasks, others=others)
    return result


def _spread(
    rows: Mapping[int, list[Row] | None], episodes: npt.NDArray[np.int64], kind: Any, table: Any
) -> Any:
    """Repeat an episode's rows on each of its frames."""
    pa, _ = import_pyarrow()
    pieces = []
    edges = [0, *(np.flatnonzero(np.diff(episodes)) + 1).tolist(), len(episodes)]
    for start, end in pairwise(edges):
        if start == end:
            continue
        of_episode = rows.get(int(episodes[start]), [])
        if of_episode is None:
            stays = table.column(PERSISTENT).slice(start, end - start).cast(kind)
            pieces.append(stays.combine_chunks())
        else:
            pieces.append(language_array(of_episode, kind).take(_zeros(end - start)))
    return pa.chunked_array(pieces, kind)


def _zeros(count: int) -> Any:
    pa, _ = import_pyarrow()
    return pa.array(np.zeros(count, int))


def _with_tasks(column: Any, episodes: npt.NDArray[np.int64], tasks: Mapping[int, int]) -> Any:
    pa, _ = import_pyarrow()
    numbers = column.to_numpy().copy()
    for index, number in tasks.items():
        numbers[episodes == index] = number
    return pa.chunked_array([pa.array(numbers, column.type)])


def _with_columns(before: Any, kinds: Mapping[str, Any]) -> dict[bytes, bytes]:
    """Return a file's metadata with the columns' types, for Hugging Face's ``datasets``."""
    metadata = dict(before.metadata or {})
    try:
        content = json.loads(metadata[_HUGGING_FACE])
        features = content["info"]["features"]
        for name, kind in kinds.items():
            if name not in before.names or before.field(name).type != kind:
                features[name] = _feature(name, kind)
    except (KeyError, TypeError, ValueError):  # it isn't from there
        return metadata
    return metadata | {_HUGGING_FACE: json.dumps(content).encode()}


def _feature(column: str, kind: Any) -> dict[str, Any]:
    text = {"dtype": "string", "_type": "Value"}
    row: dict[str, Any] = dict.fromkeys(("role", "content", "style"), text)
    if column == PERSISTENT:
        row["timestamp"] = {"dtype": "float32", "_type": "Value"}
    pa, _ = import_pyarrow()
    call: dict[str, Any] = text
    if pa.types.is_struct(kind.value_type.field("tool_calls").type.value_type):
        call = {"type": text, "function": {"name": text, "arguments": {"text": text}}}
    row |= {"camera": text, "tool_calls": {"feature": call, "_type": "List"}}
    return {"feature": row, "_type": "List"}


def _metadata(
    dataset: episode_reading.Dataset,
    table: TaskTable,
    tasks: _NewTasks,
    scratch: str,
    *,
    has_speech: bool,
) -> dict[str, bytes | Path]:
    """Return the files of ``meta`` that change."""
    info = msgspec.json.decode((dataset.folder / episode_reading.INFO).read_bytes())
    for name in (PERSISTENT, EVENTS):
        info["features"].setdefault(name, dict(FEATURE))
    tools = info.get("tools") or []
    if has_speech and isinstance(tools, list) and f'"{SAY}"' not in json.dumps(tools):
        info["tools"] = [*tools, SAY_TOOL]
    files: dict[str, bytes | Path] = {}
    if tasks.added:
        info["total_tasks"] = len(table.texts) + len(tasks.added)
        name = table.file.relative_to(dataset.folder).as_posix()
        files[name] = table.with_tasks(tasks.added)
    if tasks.texts and dataset.is_old:
        files[episode_reading.EPISODES_JSONL] = _old_episode_tasks(dataset, tasks.texts)
    elif tasks.texts:
        for file in files_below(dataset.folder, episode_reading.EPISODES_FOLDER):
            name = file.relative_to(dataset.folder).as_posix()
            files[name] = _episode_tasks(file, Path(scratch) / f"{name}.new", tasks.texts)
    files[episode_reading.INFO] = json.dumps(info, indent=4, ensure_ascii=False).encode()
    return files


def _old_episode_tasks(dataset: episode_reading.Dataset, texts: Mapping[int, str]) -> bytes:
    lines = []
    for line in (dataset.folder / episode_reading.EPISODES_JSONL).read_bytes().split(b"\n"):
        row = msgspec.json.decode(line) if line.strip() else {}
        task = texts.get(row.get(EPISODE_INDEX, -1))
        lines.append(line if task is None else msgspec.json.encode(row | {"tasks": [task]}))
    return b"\n".join(lines)


def _episode_tasks(file: Path, target: Path, texts: Mapping[int, str]) -> Path:
    """Write an episode index's file with new tasks; without a column for them, keep it."""
    pa, pq = import_pyarrow()
    with content_of(file):
        parquet = pq.ParquetFile(file)
    with parquet:
        before = parquet.schema_arrow
        if "tasks" not in before.names:
            return file
        place, kind = before.names.index("tasks"), before.field("tasks").type
        kind = widened(kind, pa.list_(pa.string()))
        is_list = pa.types.is_list(kind) or pa.types.is_large_list(kind)
        target.parent.mkdir(parents=True, exist_ok=True)
        schema = before.set(place, before.field(place).with_type(kind))
        with pq.ParquetWriter(target, schema) as writer:
            for group in range(parquet.num_row_groups):
                with content_of(file):
                    table = parquet.read_row_group(group)
                    had = table.column("tasks").to_pylist()
                    for row, index in enumerate(table.column(EPISODE_INDEX).to_pylist()):
                        if index in texts:
                            had[row] = [texts[index]] if is_list else texts[index]
                    column = pa.array(had, kind)
                writer.write_table(table.set_column(place, schema.field(place), column))
    return target
