"""Putting language, tasks and columns of the episodes' index into a copy of a LeRobot dataset.

Videos are linked, or copied where that can't be done. Of the frames only the two language columns
change, and ``task_index`` where an episode gets a new task. Version 2 has no such columns: there
language is in a file of its own, unless somebody has added the columns already. A file in which
nothing changes is copied byte for byte. Files are read and written a group of rows at a time, so
that memory stays flat.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
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
    json_lines,
    whole_numbers_of,
    with_features,
)
from corpus_tools.lerobot.episode_frames import EPISODE_INDEX, FramedEpisode, checked_episodes
from corpus_tools.lerobot.episode_index import IndexColumn, rewritten_index
from corpus_tools.lerobot.language_rows import (
    EVENTS,
    FEATURE,
    LANGUAGE_JSONL,
    PERSISTENT,
    PLAN,
    SAY,
    TASK_AUG,
    Language,
    Placed,
    Row,
    column_types,
    events_of,
    language_array,
    language_lines,
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


@dataclass(frozen=True, slots=True)
class EpisodeLanguage:
    """The language of an episode."""

    said: tuple[Language, ...]
    """The texts that are added, and plans of the subtasks among them unless there are others."""
    replaces: frozenset[str] = frozenset()
    """Styles of which the dataset's own rows go."""
    task: str = ""
    """Its task, if the dataset names none."""
    corrected: Mapping[str, str] = field(default_factory=dict)
    """New texts of its tasks, by the replaced ones. The dataset's own wordings of these
    tasks go, too; people's stay."""


@dataclass(frozen=True, slots=True)
class _NewLanguage:
    """The language of an episode at its frames."""

    items: tuple[Placed, ...]
    timestamps: npt.NDArray[np.float32]
    tasks: tuple[str, ...]
    replaces: frozenset[str]
    new_tasks: Mapping[str, str]
    """New texts by the replaced ones; by the empty text where the episode had none."""
    numbers: tuple[int, ...]
    """The numbers of the tasks of its frames."""

    @property
    def is_language(self) -> bool:
        """True if there is more than tasks."""
        return bool(self.items or self.replaces)


@dataclass(frozen=True, slots=True)
class _NewTasks:
    """New numbers of tasks by the old ones of each episode, and new texts in their order."""

    numbers: Mapping[int, Mapping[int, int]]
    added: tuple[str, ...]


def write_language(
    dataset: episode_reading.Dataset,
    target: Path,
    language: Mapping[int, EpisodeLanguage],
    *,
    attachments: Mapping[str, bytes],
    columns: Sequence[IndexColumn] = (),
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
        Further files by name. The lines of a ``.jsonl`` follow those that the dataset has.
    columns
        Columns of the episodes' index.

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
    data: dict[int, Path] = {}
    wrong: list[CorpusError] = []
    numbers: set[int] = set()
    there: set[int] = set()
    for framed in checked_episodes(dataset, (), on_error=wrong.append):
        numbers.update(framed.frames.tasks)
        index, added = framed.episode.index, language.get(framed.episode.index)
        if not framed.episode.frames:
            continue
        there.add(index)
        if added is not None:
            new[index], gone = _new_language(framed, added, dataset)
            data[index] = framed.episode.data
            notes += [
                f"episode {index}: the task {text!r:.60} is no longer its own" for text in gone
            ]
    notes += [str(error) for error in wrong]
    notes += [f"episode {i}: {note}" for i, one in new.items() for note in _notes(one.items)]
    asked = language.keys() | {index for column in columns for index in column.values}
    left_out = sorted(asked - there)
    if left_out and not asked & there:
        raise FormatError(
            f"the dataset has no episode {left_out[0]} with frames, nor any other of these",
            where=str(source),
            fix="name the dataset that the language is about",
        )
    notes += [f"episode {n}: its language isn't written: it is no episode here" for n in left_out]
    tasks_of = _new_tasks(table, new, max(numbers, default=-1))
    is_said = any(one.is_language for one in new.values())
    in_lines = dataset.is_old and not any(map(_has_columns, episode_reading.data_files(dataset)))
    with_language = is_said and not in_lines
    changed = {data[index] for index in (tasks_of.numbers if in_lines else data)}
    peoples = _peoples_wordings(source / PROVENANCE)
    events = {index: events_of(one.items) for index, one in new.items()}
    usual = column_types(has_speech=_has_speech(new))
    with (
        about(target),
        tempfile.TemporaryDirectory(dir=target.parent, prefix=".lerobot-") as scratch,
        about(target, instead_of=scratch),
    ):
        files = dict(_copies(source, Path(scratch)))
        for file in episode_reading.data_files(dataset):
            kinds = _language_kinds(
                file, usual, is_added=with_language, has_events=any(events.values())
            )
            if file not in changed and not (with_language and _is_wider(file, kinds)):
                continue
            name = file.relative_to(source).as_posix()
            files[name] = Path(scratch) / f"{name}.new"
            rows = _rows_by_episode(persistent_rows_of(file), new, peoples, notes)
            of_file = _FileEvents(events)
            _rewrite(file, files[name], rows, of_file, kinds=kinds, tasks=tasks_of.numbers)
            notes += of_file.notes
        every: dict[str, bytes | Path] = {
            **files,
            **_metadata(
                dataset,
                table,
                tasks_of,
                with_language=with_language,
                has_speech=_has_speech(new),
            ),
            **rewritten_index(
                dataset, Path(scratch), {i: one.new_tasks for i, one in new.items()}, columns
            ),
        }
        if is_said and in_lines:
            every[LANGUAGE_JSONL] = _lines(dataset, new, events, peoples, notes)
        _attach(every, [*attachments.items(), (PROVENANCE, _provenance(language, new))])
        write_folder(target, every, force=force, marker=episode_reading.INFO)
    return notes


def _attach(every: dict[str, bytes | Path], further: Iterable[tuple[str, bytes]]) -> None:
    """Add files, and lines behind those of people who were asked about the dataset earlier."""
    for name, content in further:
        before = every.get(name, b"") if name.endswith(".jsonl") else b""
        if content:
            every[name] = (before.read_bytes() if isinstance(before, Path) else before) + content


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
                        "timestamp": time, "content": text.text, **text.of_event(), **text.source,
                    }
                )  # fmt: skip
    return msgspec.json.Encoder().encode_lines(rows)


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


def _new_language(
    framed: FramedEpisode, added: EpisodeLanguage, dataset: episode_reading.Dataset
) -> tuple[_NewLanguage, list[str]]:
    """Place the language of an episode; also return the corrected tasks that it hasn't."""
    episode, times = framed.episode, framed.frames.times
    items = placed(added.said, times, 1 / dataset.info.fps, dataset.pictures)
    if all(item.style != PLAN for item in added.said):
        items += plans(items)
    corrected = {_spaced(old): new for old, new in added.corrected.items()}
    new_tasks = {old: new for old in episode.tasks if (new := corrected.get(_spaced(old)))}
    if added.task and not episode.tasks:
        new_tasks = {"": added.task}
    own = {_spaced(task) for task in episode.tasks}
    gone = [old for old in added.corrected if _spaced(old) not in own]
    tasks = tuple(dict.fromkeys(new_tasks.get(task, task) for task in episode.tasks or ("",)))
    language = _NewLanguage(
        tuple(items),
        times.astype(np.float32),
        tuple(task for task in tasks if task),
        added.replaces,
        new_tasks,
        framed.frames.tasks,
    )
    return language, gone


def _spaced(text: str) -> str:
    return " ".join(text.split())


def _new_tasks(table: TaskTable, new: Mapping[int, _NewLanguage], last: int) -> _NewTasks:
    """Return the tasks to be added; `last` is the largest number in the frames.

    Numbers that frames have and the table hasn't get rows without a text, so that no episode gets
    another's task, and a task's number stays its place in the table, as LeRobot has it.
    """
    number_of: dict[str, int] = {}
    for number, text in table.texts.items():
        number_of.setdefault(text, number)
    added = [""] * (last + 1 - table.following)
    numbers: dict[int, dict[int, int]] = {}
    for index, one in new.items():
        for old, text in one.new_tasks.items():
            if text not in number_of:
                number_of[text] = table.following + len(added)
                added.append(text)
            is_only = len(one.new_tasks) == len(one.tasks) == 1
            numbers.setdefault(index, {}).update(
                (number, number_of[text])
                for number in one.numbers
                if is_only or table.texts.get(number) == old
            )
    is_new = any(added)
    return _NewTasks(numbers, tuple(added) if is_new else ())


def _peoples_wordings(provenance: Path) -> set[tuple[int, str]]:
    """Return the episodes and texts of wordings that an earlier copy had from people."""
    if not provenance.exists():
        return set()
    return {
        (record.whole(EPISODE_INDEX), text)
        for record in json_lines(provenance)
        if record.values.get("style") == TASK_AUG
        for text in record.texts("content")
    }


def _has_speech(new: Mapping[int, _NewLanguage]) -> bool:
    """Check whether the robot replies in an event."""
    return any(item.language.reply for one in new.values() for item in one.items)


def _language_kinds(
    file: Path, usual: Mapping[str, Any], *, is_added: bool, has_events: bool
) -> dict[str, Any]:
    """Return the types of a file's language columns, also of added ones."""
    before = _schema(file)
    kinds = {name: kind for name, kind in usual.items() if is_added or name in before.names}
    if EVENTS in before.names:
        kind = before.field(EVENTS).type
        kinds[EVENTS] = widened(kind, usual[EVENTS], is_complete=True) if has_events else kind
    if PERSISTENT in before.names:
        kinds[PERSISTENT] = widened(before.field(PERSISTENT).type, usual[PERSISTENT])
    return kinds


def _has_columns(file: Path) -> bool:
    return not {PERSISTENT, EVENTS}.isdisjoint(_schema(file).names)


def _schema(file: Path) -> Any:
    _, pq = import_pyarrow()
    with content_of(file):
        return pq.read_schema(file)


def _is_wider(file: Path, kinds: Mapping[str, Any]) -> bool:
    """Return True if language columns are missing, or have narrower types."""
    before = _schema(file)
    return any(n not in before.names or before.field(n).type != k for n, k in kinds.items())


def _rewrite(
    file: Path,
    target: Path,
    rows: Mapping[int, list[Row] | None],
    events: _FileEvents,
    *,
    kinds: Mapping[str, Any],
    tasks: Mapping[int, Mapping[int, int]],
) -> None:
    """Write the frames of a file once more, with their language and their tasks."""
    pa, pq = import_pyarrow()
    target.parent.mkdir(parents=True, exist_ok=True)
    with content_of(file):
        parquet = pq.ParquetFile(file)
    with parquet:
        before = parquet.schema_arrow
        kept = [name for name in before.names if name not in kinds]
        fields = [before.field(name) for name in kept]
        fields += [pa.field(name, kind) for name, kind in kinds.items()]
        added = {
            name: _feature(name, kind)
            for name, kind in kinds.items()
            if name not in before.names or before.field(name).type != kind
        }
        schema = pa.schema(fields, metadata=with_features(before.metadata, added))
        with pq.ParquetWriter(target, schema) as writer:
            for group in range(parquet.num_row_groups):
                with content_of(file):
                    table = parquet.read_row_group(group)
                    episodes = whole_numbers_of(table, EPISODE_INDEX, file, 0)
                    columns = {name: table.column(name) for name in kept}
                    if tasks and TASK_INDEX in columns:
                        columns[TASK_INDEX] = _with_tasks(columns[TASK_INDEX], episodes, tasks)
                    if PERSISTENT in kinds:
                        columns[PERSISTENT] = _spread(rows, episodes, kinds[PERSISTENT], table)
                    if EVENTS in kinds:
                        there = (
                            table.column(EVENTS)
                            if EVENTS in before.names
                            else pa.array([[]], kinds[EVENTS]).take(_zeros(len(table)))
                        )
                        columns[EVENTS] = events.added(there, episodes, kinds[EVENTS])
                writer.write_table(pa.table(columns, schema=schema))


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


def _lines(
    dataset: episode_reading.Dataset,
    new: Mapping[int, _NewLanguage],
    new_events: Mapping[int, Mapping[int, list[Row]]],
    peoples: Collection[tuple[int, str]],
    notes: list[str],
) -> bytes:
    """Return the file of language of a dataset of version 2."""
    had, events = language_lines(dataset)
    lines: list[dict[str, Any]] = []
    for index, changed in sorted(_rows_by_episode(had.items(), new, peoples, notes).items()):
        rows = had[index] if changed is None else changed
        lines += [{"episode_index": index, **row} for row in rows]
    for index, of_episode in new_events.items():
        for frame, rows in of_episode.items():
            events[index, frame] = with_events(events.get((index, frame), ()), rows)
    for (index, frame), rows in sorted(events.items()):
        about: dict[str, Any] = {"episode_index": index, "frame_index": frame}
        if index in new:
            about["timestamp"] = float(new[index].timestamps[frame])
        lines += [{**about, **row} for row in rows]
    return msgspec.json.Encoder().encode_lines(lines)


def _rows_by_episode(
    before: Iterable[tuple[int, list[Row]]],
    new: Mapping[int, _NewLanguage],
    peoples: Collection[tuple[int, str]],
    notes: list[str],
) -> dict[int, list[Row] | None]:
    """Return the persistent rows of episodes; None for those that stay as they are."""
    result: dict[int, list[Row] | None] = {}
    had: dict[int, list[Row]] = {}
    for index, rows in before:
        had.setdefault(index, rows)
        result[index] = None
    for index, one in new.items():
        others = [row for row in had.get(index, ()) if row["style"] not in one.replaces]
        items = one.items
        if any(one.new_tasks) and any(row["style"] == TASK_AUG for row in others):
            stay = [r for r in others if r["style"] != TASK_AUG or (index, r["content"]) in peoples]
            gone = {row["content"] for row in others if row not in stay} - one.new_tasks.keys()
            notes += [
                f"episode {index}: {text!r:.60} rewords a wrong task: left out" for text in gone
            ]
            others = [row for row in stay if row["content"] not in one.new_tasks]
            items = (*(Placed(Language(TASK_AUG, 0.0, task), 0) for task in one.tasks), *items)
        result[index] = rows_of(items, one.timestamps, tasks=one.tasks, others=others)
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


def _with_tasks(
    column: Any, episodes: npt.NDArray[np.int64], tasks: Mapping[int, Mapping[int, int]]
) -> Any:
    pa, _ = import_pyarrow()
    before = column.to_numpy()
    numbers = before.copy()
    for index, new in tasks.items():
        for old, number in new.items():
            numbers[(episodes == index) & (before == old)] = number
    return pa.chunked_array([pa.array(numbers, column.type)])


def _feature(column: str, kind: Any) -> dict[str, Any]:
    text = {"dtype": "string", "_type": "Value"}
    row: dict[str, Any] = dict.fromkeys(("role", "content", "style"), text)
    if column == PERSISTENT:
        row["timestamp"] = {"dtype": "float32", "_type": "Value"}
    pa, _ = import_pyarrow()
    call: dict[str, Any] = text
    of_row = kind.value_type
    has_calls = of_row.get_field_index("tool_calls") >= 0
    if has_calls and pa.types.is_struct(of_row.field("tool_calls").type.value_type):
        call = {"type": text, "function": {"name": text, "arguments": {"text": text}}}
    row |= {"camera": text, "tool_calls": {"feature": call, "_type": "List"}}
    return {"feature": row, "_type": "List"}


def _metadata(
    dataset: episode_reading.Dataset,
    table: TaskTable,
    tasks: _NewTasks,
    *,
    with_language: bool,
    has_speech: bool,
) -> dict[str, bytes | Path]:
    """Return the files of ``meta`` that change, without the episodes' index."""
    files: dict[str, bytes | Path] = {}
    info = msgspec.json.decode((dataset.folder / episode_reading.INFO).read_bytes())
    if with_language:
        for name in (PERSISTENT, EVENTS):
            info["features"].setdefault(name, dict(FEATURE))
    tools = info.get("tools") or []
    if has_speech and isinstance(tools, list) and f'"{SAY}"' not in json.dumps(tools):
        info["tools"] = [*tools, SAY_TOOL]
    if tasks.added:
        info["total_tasks"] = len(table.texts) + len(tasks.added)
        name = table.file.relative_to(dataset.folder).as_posix()
        files[name] = table.with_tasks(tasks.added)
    if with_language or tasks.added:
        files[episode_reading.INFO] = msgspec.json.format(msgspec.json.encode(info), indent=4)
    return files
