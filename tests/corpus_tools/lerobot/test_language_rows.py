"""One row of a style at a frame, and the canonical task first: the rules of LeRobot's reader."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

import pyarrow as pa

from corpus_tools.lerobot.language_rows import (
    Language,
    column_types,
    placed,
    plans,
    rows_of,
    widened,
)

FPS = 10.0
TIMES = np.arange(12) / FPS


def frames(*starts: float, style: str = "subtask", times: np.ndarray = TIMES) -> list[int | None]:
    items = [Language(style, start, f"step {n}") for n, start in enumerate(starts)]
    return [item.frame for item in placed(items, times, 1 / FPS)]


@pytest.mark.parametrize(
    ("starts", "expected"),
    [
        ((0.0, 0.32, 0.78), [0, 3, 8]),  # the nearest frames
        ((0.51, 0.53), [5, 6]),  # the later one goes to the next frame
        ((0.53, 0.51), [6, 5]),  # also if it was given first
        ((0.5, 0.51, 0.6), [5, 6, 7]),  # and pushes the one after it on
        ((1.1, 1.12, 1.14), [9, 10, 11]),  # at the end the earlier ones go back
        ((0.0, 1.2), [0, 11]),  # the very end belongs to the last frame
        ((0.0, 1.3, -0.2), [0, None, None]),  # outside of the episode
    ],
)
def test_steps_have_frames_of_their_own(starts: tuple[float, ...], expected: list[int | None]):
    assert frames(*starts) == expected


def test_moved_and_missing_steps_are_named():
    items = [Language("subtask", start, "go") for start in (0.51, 0.53, 9.0)]
    kept, moved, outside = placed(items, TIMES, 1 / FPS)
    assert kept.note == ""
    assert "0.53 s" in moved.note
    assert "0.6 s" in moved.note
    assert "outside" in outside.note


def test_more_steps_than_frames_are_named():
    assert frames(0.0, 0.01, 0.02, times=np.array([0.0, 0.1])) == [0, 1, None]


def test_times_begin_with_the_first_frame():
    """The frames of a cut episode may begin later than 0."""
    assert frames(0.0, 0.3, 1.4, times=TIMES + 5.0) == [0, 3, None]


@given(st.lists(st.floats(-0.5, 1.7), max_size=20), st.integers(1, 12))
def test_no_two_rows_of_a_style_share_a_frame(starts: list[float], count: int):
    times = TIMES[:count]
    items = [Language("subtask", start, f"step {n}") for n, start in enumerate(starts)]
    result = placed(items, times, 1 / FPS)
    assert [one.language for one in result] == items
    written = [one for one in result if one.frame is not None]
    by_time = sorted(written, key=lambda one: one.language.start_s)
    assert [one.frame for one in by_time] == sorted({one.frame for one in written})
    assert len(written) == len({one.frame for one in written})
    inside = [s for s in starts if -0.05 <= s <= count / FPS + 0.05]
    assert len(written) == min(len(inside), count)
    assert all(one.note for one in result if one.frame is None)
    rows = rows_of([*result, *plans(result)], times.astype(np.float32), tasks=["Task."])
    assert max(Counter((r["style"], r["timestamp"]) for r in rows).values(), default=1) == 1
    stamps = {float(t) for t in times.astype(np.float32)}
    assert {row["timestamp"] for row in rows} <= stamps
    plan = [row["content"] for row in rows if row["style"] == "plan"]
    assert len(plan) == len(written)
    if plan:
        assert plan[0] == "\n".join(f"{n}. {o.language.text}" for n, o in enumerate(by_time, 1))


@pytest.mark.parametrize(
    ("wordings", "tasks", "expected"),
    [
        (["Take it.", "Grab it."], ["Push the cube."], ["Push the cube.", "Take it.", "Grab it."]),
        (["Take it.", "Push."], ["Push."], ["Push.", "Take it."]),  # somebody said just that
        (["Take it."], ["One.", "Two."], ["One.", "Two.", "Take it."]),
        (["Take it."], [], ["Take it."]),
        ([], ["Push the cube."], []),  # the task alone needs no row
    ],
)
def test_the_canonical_task_is_the_first_wording(
    wordings: list[str], tasks: list[str], expected: list[str]
):
    items = placed([Language("task_aug", 0.0, text) for text in wordings], TIMES, 0.1)
    rows = rows_of(items, TIMES.astype(np.float32), tasks=tasks)
    assert [row["content"] for row in rows if row["style"] == "task_aug"] == expected
    assert {row["role"] for row in rows} <= {"user"}


def test_wordings_of_the_dataset_follow_its_task():
    (own,) = placed([Language("task_aug", 0.0, "Shove it.")], TIMES, 0.1)
    stamps = TIMES.astype(np.float32)
    rows = rows_of([], stamps, tasks=["Push."], others=[own.row(stamps)])
    assert [row["content"] for row in rows] == ["Push.", "Shove it."]


def test_nulls_become_the_usual_types():
    usual = column_types()["language_persistent"]
    assert widened(pa.null(), usual) == usual
    assert widened(pa.list_(pa.null()), usual) == usual
    row = pa.struct([("role", pa.string()), ("content", pa.null()), ("style", pa.string()),
                     ("timestamp", pa.float64()), ("mine", pa.int8())])  # fmt: skip
    wide = widened(pa.list_(row), usual).value_type
    assert wide.field("content").type == pa.string()
    assert wide.field("timestamp").type == pa.float64()
    assert wide.field("mine").type == pa.int8()
    assert widened(usual, usual) is usual
