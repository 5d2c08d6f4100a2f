"""The two language columns of LeRobot's datasets.

``language_persistent`` holds what stays true from a time on, the same list on every frame of an
episode; ``language_events`` what happens on a frame. See
https://huggingface.co/docs/lerobot/language_and_recipes.

LeRobot takes one row of a style at a frame: with two, training stops at "Ambiguous resolver". Only
of ``task_aug`` there may be several, all at the first frame; one of them then stands for the task,
so the task itself has to be among them, and is the first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot.dataset_files import (
    content_of,
    damaged,
    is_text,
    parquet_file,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_reading import Dataset, data_files
from corpus_tools.runtime.parquet import import_pyarrow

PERSISTENT, EVENTS = "language_persistent", "language_events"
FEATURE: Mapping[str, Any] = {"dtype": "language", "shape": [1], "names": None}
"""The entry of both columns in ``meta/info.json``."""
SUBTASK, PLAN, TASK_AUG = "subtask", "plan", "task_aug"
USER, ASSISTANT = "user", "assistant"
FRAMES_AT_ONCE = 4096

Row = dict[str, Any]

_FIELDS = ("role", "content", "style", "timestamp", "camera", "tool_calls")


@dataclass(frozen=True, slots=True)
class Language:
    """A text about an episode, which is true from a time on."""

    style: str
    """``subtask``, ``plan`` or ``task_aug``."""
    start_s: float
    """The time in seconds from the episode's first frame."""
    text: str
    source: Mapping[str, Any] = field(default_factory=dict, compare=False)
    """Origin of the text; not written into the column."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A text with the frame at which it is written."""

    language: Language
    frame: int | None
    """None if it isn't written."""
    note: str = ""
    """Reason for not writing it, or for a frame other than the nearest to its time."""

    def row(self, timestamps: npt.NDArray[np.float32]) -> Row:
        """Return the row of the column; `timestamps` are those of the frames, shape (n,)."""
        return {
            "role": USER if self.language.style == TASK_AUG else ASSISTANT,
            "content": self.language.text,
            "style": self.language.style,
            "timestamp": float(timestamps[self.frame or 0]),
            "camera": None,
            "tool_calls": None,
        }


def placed(
    language: Sequence[Language], times: npt.NDArray[np.float64], frame_s: float
) -> list[Placed]:
    """Place texts at the frames of an episode, at most one of a style at each.

    Of texts that are nearest to the same frame, in the order of their times, the later ones go to
    the next frames, or at the episode's end the earlier ones to the frames before. A text outside
    the episode is not written, nor are the last ones where there are more texts than frames.

    Parameters
    ----------
    times
        The times of the frames, shape (n,), seconds, ascending.
    frame_s
        The time for which the last frame is seen, seconds.

    Returns
    -------
    list of Placed
        In the order of `language`.
    """
    since = times - times[0]
    end_s = float(since[-1]) + frame_s
    result: dict[int, Placed] = {}
    by_style: dict[str, list[int]] = {}
    for number, item in enumerate(language):
        if not -0.5 * frame_s <= item.start_s <= end_s + 0.5 * frame_s:
            why = f"{item.start_s:g} s is outside of the episode, which ends at {end_s:g} s"
            result[number] = Placed(item, None, why)
        elif item.style == TASK_AUG:
            result[number] = Placed(item, 0)
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


def plans(subtasks: Iterable[Placed]) -> list[Placed]:
    """Return a plan at the frame of each subtask: the subtasks that are left, numbered."""
    written = [subtask for subtask in subtasks if subtask.frame is not None]
    ordered = sorted(written, key=lambda subtask: subtask.frame or 0)
    texts = [subtask.language.text for subtask in ordered]
    return [
        Placed(
            Language(
                PLAN,
                subtask.language.start_s,
                "\n".join(f"{n}. {text}" for n, text in enumerate(texts[place:], start=1)),
            ),
            subtask.frame,
        )
        for place, subtask in enumerate(ordered)
    ]


def rows_of(
    items: Sequence[Placed],
    timestamps: npt.NDArray[np.float32],
    *,
    tasks: Sequence[str] = (),
    others: Sequence[Row] = (),
) -> list[Row]:
    """Return the rows of an episode in LeRobot's order.

    Parameters
    ----------
    items
        The texts that are added.
    timestamps
        The times of the frames as the data have them, shape (n,).
    tasks
        The episode's own tasks; the first rows of ``task_aug`` wherever there are any.
    others
        Rows that are there already.
    """
    rows = [*others, *(item.row(timestamps) for item in items if item.frame is not None)]
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


def column_types() -> Mapping[str, Any]:
    """Return the Arrow types of both columns, as LeRobot writes them."""
    pa, _ = import_pyarrow()
    text = pa.string()
    head = [("role", text), ("content", text), ("style", text)]
    tail = [("camera", text), ("tool_calls", pa.list_(text))]
    return {
        PERSISTENT: pa.list_(pa.struct([*head, ("timestamp", pa.float32()), *tail])),
        EVENTS: pa.list_(pa.struct([*head, *tail])),
    }


def check_language(schema: Any, file: Path) -> None:
    """Raise a FormatError if a table has persistent rows that are none of LeRobot's."""
    if PERSISTENT not in schema.names:
        return
    pa, _ = import_pyarrow()
    kind = schema.field(PERSISTENT).type
    row = kind.value_type if _is_list(kind) else kind
    if pa.types.is_null(row):
        return
    row = row if _is_list(kind) else pa.null()
    fields = {f.name: f.type for f in row} if pa.types.is_struct(row) else {}
    is_right = {
        "role": is_text, "content": is_text, "style": is_text, "timestamp": pa.types.is_floating,
    }  # fmt: skip
    for name, is_type in is_right.items():
        if name not in fields or not (pa.types.is_null(fields[name]) or is_type(fields[name])):
            where = f"{file}, column {PERSISTENT}"
            raise damaged(where, f"{kind!s:.120} has no {name} as LeRobot writes it")
    with content_of(file):  # what can't be written is named before anybody is asked
        row = Placed(Language(SUBTASK, 0.0, "reach"), 0).row(np.zeros(1, np.float32))
        language_array([row], widened(kind, column_types()[PERSISTENT]))


def widened(kind: Any, usual: Any) -> Any:
    """Return a type in which nulls have become those of `usual`, and the rest stays."""
    pa, _ = import_pyarrow()
    if pa.types.is_null(kind):
        return usual
    new = kind
    if _is_list(kind) and _is_list(usual):
        make = pa.large_list if pa.types.is_large_list(kind) else pa.list_
        new = make(widened(kind.value_type, usual.value_type))
    elif pa.types.is_struct(kind) and pa.types.is_struct(usual):
        names = {f.name: f.type for f in usual}
        new = pa.struct([f.with_type(widened(f.type, names.get(f.name, f.type))) for f in kind])
    return kind if new == kind else new


def language_array(rows: Sequence[Row], kind: Any) -> Any:
    """Return an array of one cell with the rows of an episode, of the type `kind`."""
    pa, _ = import_pyarrow()
    # Arrow builds no extension types, such as its JSON for tool calls, but converts to them.
    return pa.array([rows], _stored(kind)).cast(kind)


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


def persistent_rows(dataset: Dataset) -> Iterator[tuple[int, list[Row]]]:
    """Yield for each episode its number and its persistent rows, of datasets that have some.

    Only the first frame of an episode is made into objects of Python, so that memory stays flat.
    """
    for file in data_files(dataset):
        yield from persistent_rows_of(file)


def persistent_rows_of(file: Path) -> Iterator[tuple[int, list[Row]]]:
    """Yield the same for the episodes in a file.

    Raises
    ------
    FormatError
        If the file can't be read, or rows have other values than LeRobot's.
    """
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


def _checked(row: Row | None, where: str) -> Row:
    time = row.get("timestamp") if row is not None else None
    if row is None or not isinstance(time, float) or not np.isfinite(time):
        raise damaged(where, "a row of language has no time")
    return row
