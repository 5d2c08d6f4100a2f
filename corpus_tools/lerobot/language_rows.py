"""The two language columns of LeRobot's datasets.

``language_persistent`` holds what stays true from a time on, the same list on every frame of an
episode; ``language_events`` what happens on a frame. See
https://huggingface.co/docs/lerobot/language_and_recipes.

LeRobot takes one row of a style at a frame: with two, training stops at "Ambiguous resolver". Only
of ``task_aug`` there may be several, all at the first frame; one of them then stands for the task,
so the task itself has to be among them, and is the first. Styles that are about a picture
(:data:`STYLES`) have a row for each camera and role, and name the camera; the others name none.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot.dataset_files import (
    content_of,
    damaged,
    file_inside,
    is_text,
    json_lines,
    parquet_file,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_reading import Dataset, data_files
from corpus_tools.lerobot.grounded_answers import Answer, Fault, Size
from corpus_tools.runtime.parquet import import_pyarrow

PERSISTENT, EVENTS = "language_persistent", "language_events"
FEATURE: Mapping[str, Any] = {"dtype": "language", "shape": [1], "names": None}
"""The entry of both columns in ``meta/info.json``."""
SUBTASK, PLAN, TASK_AUG, MEMORY, MOTION = "subtask", "plan", "task_aug", "memory", "motion"
INTERJECTION, VQA, TRACE = "interjection", "vqa", "trace"
USER, ASSISTANT = "user", "assistant"
SAY = "say"
"""The tool whose call is what the robot says."""
LANGUAGE_JSONL = "meta/language.jsonl"
"""The file of version 2 with language: it has no columns for it, and its readers refuse others."""
FRAMES_AT_ONCE = 4096

Row = dict[str, Any]

_FIELDS = ("role", "content", "style", "timestamp", "camera", "tool_calls")


@dataclass(frozen=True, slots=True)
class Style:
    """The rule of a style: its column, the role of its text, and whether it is about a picture."""

    column: str
    role: str
    has_camera: bool = False


STYLES: Mapping[str, Style] = {
    TASK_AUG: Style(PERSISTENT, USER),
    SUBTASK: Style(PERSISTENT, ASSISTANT),
    PLAN: Style(PERSISTENT, ASSISTANT),
    MEMORY: Style(PERSISTENT, ASSISTANT),
    MOTION: Style(PERSISTENT, ASSISTANT),
    INTERJECTION: Style(EVENTS, USER),
    VQA: Style(EVENTS, USER, has_camera=True),
    TRACE: Style(EVENTS, ASSISTANT, has_camera=True),
}
"""The styles of LeRobot's ``lerobot/datasets/language.py``."""


@dataclass(frozen=True, slots=True)
class Language:
    """A text about an episode, which is true from a time on, or of an event at that time."""

    style: str
    """One of :data:`STYLES`."""
    start_s: float
    """The time in seconds from the episode's first frame."""
    text: str
    source: Mapping[str, Any] = field(default_factory=dict, compare=False)
    """Origin of the text; not written into the column."""
    camera: str | None = None
    """The camera whose picture it is about."""
    answer: Answer | None = None
    """The answer of a ``vqa``, the path of a ``trace``."""
    reply: str = ""
    """The robot's reply to an ``interjection``, if there is one."""

    def fault(self, cameras: Mapping[str, Size | None]) -> Fault | None:
        """Return the first broken rule of the format.

        Parameters
        ----------
        cameras
            The cameras of the dataset, with the sizes of their pictures.
        """
        style = STYLES.get(self.style)
        if style is None:
            return Fault.STYLE
        if not any(character.isalnum() for character in self.text):
            return Fault.TEXT
        if not style.has_camera:
            return Fault.NO_PICTURE if self.camera is not None or self.answer else None
        if self.camera is None or self.camera not in cameras:
            return Fault.CAMERA
        if self.answer is None:
            return Fault.ANSWER
        return self.answer.fault(cameras[self.camera])

    def of_event(self) -> dict[str, str]:
        """Return the ``camera`` and the ``reply`` of an event: the answer, path or speech."""
        reply = self.answer.content() if self.answer is not None else self.reply
        return {k: v for k, v in (("camera", self.camera), ("reply", reply)) if v}

    @property
    def is_event(self) -> bool:
        """True for a style that is on its exact frame alone."""
        return STYLES[self.style].column == EVENTS


@dataclass(frozen=True, slots=True)
class Placed:
    """A text with the frame at which it is written."""

    language: Language
    frame: int | None
    """None if it isn't written."""
    note: str = ""
    """Reason for not writing it, or for a frame other than the nearest to its time."""

    def row(self, timestamps: npt.NDArray[np.float32]) -> Row:
        """Return the row of a text that is no event; `timestamps` are those of the frames."""
        row = _row(STYLES[self.language.style].role, self.language.text, self.language.style)
        return row | {"timestamp": float(timestamps[self.frame or 0])}

    def event_rows(self) -> list[Row]:
        """Return the rows of an event: its text, and the answer or the reply to it."""
        item = self.language
        if item.style == TRACE and item.answer is not None:
            return [_row(ASSISTANT, item.answer.content(), item.style, item.camera)]
        rows = [_row(STYLES[item.style].role, item.text, item.style, item.camera)]
        if item.answer is not None:
            rows.append(_row(ASSISTANT, item.answer.content(), item.style, item.camera))
        if item.reply:
            call = {
                "type": "function",
                "function": {"name": SAY, "arguments": {"text": item.reply}},
            }
            rows.append(_row(ASSISTANT, None, None) | {"tool_calls": [call]})
        return rows


def _row(role: str, content: str | None, style: str | None, camera: str | None = None) -> Row:
    return {
        "role": role, "content": content, "style": style, "camera": camera, "tool_calls": None,
    }  # fmt: skip


def placed(
    language: Sequence[Language],
    times: npt.NDArray[np.float64],
    frame_s: float,
    cameras: Mapping[str, Size | None] | None = None,
) -> list[Placed]:
    """Place texts at the frames of an episode, at most one of a style at each.

    Of texts that are nearest to the same frame, in the order of their times, the later ones go to
    the next frames, or at the episode's end the earlier ones to the frames before. Events stay at
    the nearest frame: of several of a style and a camera there the first is written. A text that
    breaks a rule or is outside the episode is not written, nor are the last ones where there are
    more texts than frames.

    Parameters
    ----------
    times
        The times of the frames, shape (n,), seconds, ascending.
    frame_s
        The time for which the last frame is seen, seconds.
    cameras
        The cameras of the dataset, with the sizes of their pictures.

    Returns
    -------
    list of Placed
        In the order of `language`.
    """
    since = times - times[0]
    end_s = float(since[-1]) + frame_s
    result: dict[int, Placed] = {}
    by_style: dict[str, list[int]] = {}
    events: set[tuple[str, str | None, int]] = set()
    for number, item in enumerate(language):
        if (fault := item.fault(cameras or {})) is not None:
            result[number] = Placed(item, None, fault.value)
        elif not -0.5 * frame_s <= item.start_s <= end_s + 0.5 * frame_s:
            why = f"{item.start_s:g} s is outside of the episode, which ends at {end_s:g} s"
            result[number] = Placed(item, None, why)
        elif item.style == TASK_AUG:
            result[number] = Placed(item, 0)
        elif item.is_event:
            frame = int(np.abs(since - item.start_s).argmin())
            key = (item.style, item.camera, frame)
            taken = f"there is another one at {since[frame]:g} s" if key in events else ""
            result[number] = Placed(item, None if taken else frame, taken)
            events.add(key)
        else:
            by_style.setdefault(item.style, []).append(number)
    for numbers in by_style.values():
        ordered = sorted(numbers, key=lambda number: language[number].start_s)
        for number in ordered[len(since) :]:
            why = f"there are more texts of its style than the {len(since)} frames"
            result[number] = Placed(language[number], None, why)
        kept = ordered[: len(since)]
        nearest = [int(np.abs(since - language[number].start_s).argmin()) for number in kept]
        for number, wanted, frame in zip(kept, nearest, _apart(nearest, len(since)), strict=True):
            item = language[number]
            moved = f"{item.start_s:g} s is written at {since[frame]:g} s: its frame is taken"
            result[number] = Placed(item, frame, "" if frame == wanted else moved)
    return [result[number] for number in range(len(language))]


def _apart(wanted: Sequence[int], frames: int) -> list[int]:
    """Different numbers near to ascending ones, in their order, below `frames`."""
    result: list[int] = []
    for frame in wanted:
        result.append(max(frame, result[-1] + 1) if result else frame)
    last = frames
    for place in reversed(range(len(result))):
        result[place] = last = min(result[place], last - 1)
    return result


def plans(items: Iterable[Placed]) -> list[Placed]:
    """Return a plan at the frame of each subtask: the subtasks that are left, numbered.

    As in LeRobot's own pipeline, an interjection has the plan once more at its frame. Texts of
    other styles change nothing.
    """
    written = [item for item in items if item.frame is not None]
    subtasks = [item for item in written if item.language.style == SUBTASK]
    ordered = sorted(subtasks, key=lambda subtask: subtask.frame or 0)
    texts = [subtask.language.text for subtask in ordered]
    frames = [subtask.frame or 0 for subtask in ordered]
    starts = {item.frame: item.language.start_s for item in ordered}
    for item in written:
        if item.language.style == INTERJECTION and frames and (item.frame or 0) >= frames[0]:
            starts.setdefault(item.frame, item.language.start_s)
    result = []
    for frame in sorted(frame for frame in starts if frame is not None):
        left = texts[int(np.searchsorted(frames, frame, side="right")) - 1 :]
        text = "\n".join(f"{n}. {step}" for n, step in enumerate(left, start=1))
        result.append(Placed(Language(PLAN, starts[frame], text), frame))
    return result


def rows_of(
    items: Sequence[Placed],
    timestamps: npt.NDArray[np.float32],
    *,
    tasks: Sequence[str] = (),
    others: Sequence[Row] = (),
) -> list[Row]:
    """Return the persistent rows of an episode in LeRobot's order.

    Parameters
    ----------
    items
        The texts that are added; events among them are left out.
    timestamps
        The times of the frames as the data have them, shape (n,).
    tasks
        The episode's own tasks; the first rows of ``task_aug`` wherever there are any.
    others
        Rows that are there already.
    """
    written = [item for item in items if item.frame is not None and not item.language.is_event]
    rows = [*others, *(item.row(timestamps) for item in written)]
    if any(row["style"] == TASK_AUG for row in rows):
        own = (Placed(Language(TASK_AUG, 0.0, task), 0) for task in tasks)
        rows = [*(item.row(timestamps) for item in own), *rows]
    return sorted_rows(rows)


def sorted_rows(rows: Iterable[Row]) -> list[Row]:
    """Return rows in LeRobot's order, by time, style and role; equal ones once."""
    unique: dict[str, Row] = {}
    for row in rows:
        unique[repr([row.get(name) for name in _FIELDS])] = row
    return sorted(
        unique.values(),
        key=lambda row: (row["timestamp"], row["style"] or "", row["role"] or ""),
    )


def events_of(items: Iterable[Placed]) -> dict[int, list[Row]]:
    """Return the rows of an episode's events, by the frame, in LeRobot's order."""
    result: dict[int, list[Row]] = {}
    for item in items:
        if item.frame is not None and item.language.is_event:
            result.setdefault(item.frame, []).extend(item.event_rows())
    return {frame: sorted(rows, key=_event_order) for frame, rows in result.items()}


def with_events(there: Sequence[Row], new: Sequence[Row]) -> list[Row]:
    """Return a frame's events with new ones, which replace those that LeRobot can't tell apart."""
    taken = set(map(_event_order, new))
    kept = [row for row in there if _event_order(row) not in taken]
    return sorted([*kept, *new], key=_event_order)


def _event_order(row: Row) -> tuple[str, str, str]:
    return row["style"] or "", row["role"] or "", row.get("camera") or ""


def column_types(*, has_speech: bool = False) -> Mapping[str, Any]:
    """Return the Arrow types of both columns, as LeRobot writes them.

    Parameters
    ----------
    has_speech
        True if events have calls of the tool :data:`SAY`.
    """
    pa, _ = import_pyarrow()
    text = pa.string()
    head = [("role", text), ("content", text), ("style", text)]
    tail = [("camera", text), ("tool_calls", pa.list_(text))]
    persistent = pa.list_(pa.struct([*head, ("timestamp", pa.float32()), *tail]))
    if has_speech:
        function = [("name", text), ("arguments", pa.struct([("text", text)]))]
        call = pa.struct([("type", text), ("function", pa.struct(function))])
        tail = [tail[0], ("tool_calls", pa.list_(call))]
    return {PERSISTENT: persistent, EVENTS: pa.list_(pa.struct([*head, *tail]))}


def check_language(schema: Any, file: Path) -> None:
    """Raise a FormatError if a table has a column of language that isn't LeRobot's."""
    pa, _ = import_pyarrow()
    is_right = {"role": is_text, "content": is_text, "style": is_text}
    for column in (PERSISTENT, EVENTS):
        if column not in schema.names:
            continue
        kind = schema.field(column).type
        row = kind.value_type if _is_list(kind) else kind
        if pa.types.is_null(row):
            continue
        row = row if _is_list(kind) else pa.null()
        fields = {f.name: f.type for f in row} if pa.types.is_struct(row) else {}
        timed = {"timestamp": pa.types.is_floating} if column == PERSISTENT else {}
        for name, is_type in {**is_right, **timed}.items():
            if name not in fields or not (pa.types.is_null(fields[name]) or is_type(fields[name])):
                where = f"{file}, column {column}"
                raise damaged(where, f"{kind!s:.120} has no {name} as LeRobot writes it")
        with content_of(file):  # what can't be written is named before anybody is asked
            reach = Placed(Language(SUBTASK, 0.0, "reach"), 0).row(np.zeros(1, np.float32))
            language_array([reach], widened(kind, column_types()[column]))


def widened(kind: Any, usual: Any, *, is_complete: bool = False) -> Any:
    """Return a type in which nulls have become those of `usual`, and the rest stays.

    If it is to be complete, it gets the fields that its rows lack: a question without its camera
    is about no picture.
    """
    pa, _ = import_pyarrow()
    if pa.types.is_null(kind):
        return usual
    new = kind
    if _is_list(kind) and _is_list(usual):
        make = pa.large_list if pa.types.is_large_list(kind) else pa.list_
        new = make(widened(kind.value_type, usual.value_type, is_complete=is_complete))
    elif pa.types.is_struct(kind) and pa.types.is_struct(usual):
        names = {f.name: f.type for f in usual}
        fields = [f.with_type(widened(f.type, names.get(f.name, f.type))) for f in kind]
        fields += [f for f in usual if is_complete and kind.get_field_index(f.name) < 0]
        new = pa.struct(fields)
    return kind if new == kind else new


def language_array(rows: Sequence[Row], kind: Any) -> Any:
    """Return an array of one cell with the rows of an episode, of the type `kind`."""
    pa, _ = import_pyarrow()
    calls = {f.name: f.type for f in kind.value_type}.get("tool_calls")
    is_struct = calls is not None and _is_list(calls) and pa.types.is_struct(calls.value_type)
    written = rows if is_struct else [row | _as_json(row) for row in rows]
    # Arrow builds no extension types, such as its JSON for tool calls, but converts to them.
    return pa.array([written], _stored(kind)).cast(kind)


def _as_json(row: Row) -> Row:
    """Return the tool calls of a row as texts, where the column has no fields for them."""
    calls = row.get("tool_calls")
    texts = calls and [c if isinstance(c, str | None) else json.dumps(c) for c in calls]
    return {"tool_calls": texts}


def _stored(kind: Any) -> Any:
    """Return a type with the types that its extension types are stored as."""
    pa, _ = import_pyarrow()
    if isinstance(kind, pa.BaseExtensionType):
        return kind.storage_type
    if _is_list(kind):
        make = pa.large_list if pa.types.is_large_list(kind) else pa.list_
        return make(_stored(kind.value_type))
    if pa.types.is_struct(kind):
        return pa.struct([field.with_type(_stored(field.type)) for field in kind])
    return kind


def _is_list(kind: Any) -> bool:
    pa, _ = import_pyarrow()
    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind))


def persistent_rows(
    dataset: Dataset, files: Iterable[Path] | None = None
) -> Iterator[tuple[int, list[Row]]]:
    """Yield for each episode its number and its persistent rows, of datasets that have some.

    Only the first frame of an episode is made into objects of Python, so that memory stays flat.

    Parameters
    ----------
    files
        Files with the frames of the episodes; all of the dataset if None.
    """
    for file in data_files(dataset) if files is None else files:
        yield from persistent_rows_of(file)
    yield from language_lines(dataset)[0].items()


def language_lines(
    dataset: Dataset,
) -> tuple[dict[int, list[Row]], dict[tuple[int, int], list[Row]]]:
    """Return what a dataset of version 2 has in its file of language.

    That are the persistent rows by the numbers of episodes, and events by those of episodes and
    frames. Nothing without such a file.
    """
    persistent: dict[int, list[Row]] = {}
    events: dict[tuple[int, int], list[Row]] = {}
    file = file_inside(dataset.folder, LANGUAGE_JSONL, where=str(dataset.folder / LANGUAGE_JSONL))
    if not dataset.is_old or not file.exists():
        return persistent, events
    for record in json_lines(file):
        index, row = record.whole("episode_index"), {n: record.values.get(n) for n in _FIELDS}
        for name in ("role", "content", "style", "camera"):
            if not isinstance(row[name], str | None):
                raise record.error(name, f"{row[name]!r:.80} is no text")
        if record.values.get("frame_index") is None:
            row["timestamp"] = record.seconds("timestamp")
            persistent.setdefault(index, []).append(row)
        else:
            del row["timestamp"]
            events.setdefault((index, record.whole("frame_index")), []).append(row)
    return persistent, events


def persistent_rows_of(file: Path) -> Iterator[tuple[int, list[Row]]]:
    """Yield the same for the episodes in a file."""
    seen: int | None = None
    first_row = 0
    with parquet_file(file) as parquet:
        if PERSISTENT not in parquet.schema_arrow.names:
            return
        check_language(parquet.schema_arrow, file)
        columns = ["episode_index", PERSISTENT]
        for batch in parquet.iter_batches(FRAMES_AT_ONCE, columns=columns):
            episodes = whole_numbers_of(batch, "episode_index", file, first_row)
            changes = np.flatnonzero(np.diff(episodes, prepend=-1 if seen is None else seen))
            for place in changes.tolist():
                rows = batch.column(PERSISTENT)[place].as_py() or []
                where = f"{file}, row {first_row + place + 1}, column {PERSISTENT}"
                yield int(episodes[place]), [_checked(row, where) for row in rows]
            seen = int(episodes[-1]) if len(episodes) else seen
            first_row += len(episodes)


def event_rows(dataset: Dataset) -> Iterator[tuple[int, int, list[Row]]]:
    """Yield the number of an episode, that of a frame in it, and the events on the frame."""
    for file in data_files(dataset):
        seen: Counter[int] = Counter()
        first_row = 0
        with parquet_file(file) as parquet:
            if EVENTS not in parquet.schema_arrow.names:
                continue
            check_language(parquet.schema_arrow, file)
            for batch in parquet.iter_batches(FRAMES_AT_ONCE, columns=["episode_index", EVENTS]):
                episodes = whole_numbers_of(batch, "episode_index", file, first_row).tolist()
                for index, rows in zip(episodes, batch.column(EVENTS).to_pylist(), strict=True):
                    if rows:
                        yield index, seen[index], [row for row in rows if row is not None]
                    seen[index] += 1
                first_row += len(episodes)
    for (index, frame), rows in language_lines(dataset)[1].items():
        yield index, frame, rows


def _checked(row: Row | None, where: str) -> Row:
    time = row.get("timestamp") if row is not None else None
    if row is None or not isinstance(time, float) or not np.isfinite(time):
        raise damaged(where, "a row of language has no time")
    return row
