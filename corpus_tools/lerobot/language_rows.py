"""The two language columns of LeRobot's datasets.

``language_persistent`` holds what stays true from a time on, the same list on every frame of an
episode; ``language_events`` what happens on a frame. See
https://huggingface.co/docs/lerobot/language_and_recipes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot.episode_reading import Dataset, data_files
from corpus_tools.runtime.parquet import import_pyarrow

PERSISTENT, EVENTS = "language_persistent", "language_events"
FEATURE: Mapping[str, Any] = {"dtype": "language", "shape": [1], "names": None}
"""What ``meta/info.json`` says of both columns."""
SUBTASK, PLAN, TASK_AUG = "subtask", "plan", "task_aug"
USER, ASSISTANT = "user", "assistant"
FRAMES_AT_ONCE = 4096

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Language:
    """Something that is said of an episode from a time on."""

    style: str
    """``subtask``, ``plan`` or ``task_aug``."""
    start_s: float
    """From when on, in seconds from the episode's first frame."""
    text: str

    def row(self, timestamps: npt.NDArray[np.float32]) -> Row:
        """The row of the column, at the nearest of an episode's frames, shape (n,)."""
        nearest = int(np.abs(timestamps - np.float32(self.start_s)).argmin())
        return {
            "role": USER if self.style == TASK_AUG else ASSISTANT,
            "content": self.text,
            "style": self.style,
            "timestamp": float(timestamps[nearest]),
            "camera": None,
            "tool_calls": None,
        }


def plans(subtasks: Iterable[Language]) -> list[Language]:
    """A plan at the beginning of each subtask: what is left to do, numbered, as LeRobot has it."""
    ordered = sorted(subtasks, key=lambda subtask: subtask.start_s)
    return [
        Language(
            PLAN,
            subtask.start_s,
            "\n".join(f"{n}. {left.text}" for n, left in enumerate(ordered[i:], start=1)),
        )
        for i, subtask in enumerate(ordered)
    ]


def sorted_rows(rows: Iterable[Row]) -> list[Row]:
    """Rows in LeRobot's order: by time, style and role; those that are equal once."""
    unique = {repr(row): row for row in rows}
    return sorted(
        unique.values(),
        key=lambda row: (row["timestamp"], row["style"] or "", row["role"] or ""),
    )


def column_types() -> Mapping[str, Any]:
    """The Arrow types of both columns, as LeRobot writes them."""
    pa, _ = import_pyarrow()
    text = pa.string()
    head = [("role", text), ("content", text), ("style", text)]
    tail = [("camera", text), ("tool_calls", pa.list_(text))]
    return {
        PERSISTENT: pa.list_(pa.struct([*head, ("timestamp", pa.float32()), *tail])),
        EVENTS: pa.list_(pa.struct([*head, *tail])),
    }


def persistent_rows(dataset: Dataset) -> Iterator[tuple[int, list[Row]]]:
    """For each episode its number and its persistent rows, of datasets that have some.

    Only the first frame of an episode is made into objects of Python, so that memory stays flat.
    """
    for file in data_files(dataset):
        yield from persistent_rows_of(file)


def persistent_rows_of(file: Path) -> Iterator[tuple[int, list[Row]]]:
    """The same for the episodes in a file."""
    _, pq = import_pyarrow()
    seen: int | None = None
    with pq.ParquetFile(file) as parquet:
        if PERSISTENT not in parquet.schema_arrow.names:
            return
        columns = ["episode_index", PERSISTENT]
        for batch in parquet.iter_batches(FRAMES_AT_ONCE, columns=columns):
            episodes = batch.column("episode_index").to_numpy(zero_copy_only=False)
            changes = np.flatnonzero(np.diff(episodes, prepend=-1 if seen is None else seen))
            for place in changes.tolist():
                yield int(episodes[place]), batch.column(PERSISTENT)[place].as_py() or []
            seen = int(episodes[-1])
