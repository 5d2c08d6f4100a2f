"""Which part of a video shows what an EVENT or a PATH says."""

from __future__ import annotations

import pytest

from annotation_app.tasks.ground import must_be_chosen, read_parts, sent_parts
from g3.sdc.sdc_notation import parse_brackets

ONE = parse_brackets(
    "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))", command="Go to the truck"
)
# Breadth first: 0 Go, 1 stop, then the unnamed robots, and to.
TWO = parse_brackets(
    "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck))); EVENT(r = stop)",
    command="Go to the truck and stop",
)


def test_only_several_steps_are_asked_for() -> None:
    assert must_be_chosen(ONE) == {}
    assert sorted(must_be_chosen(TWO).values()) == ["Go to the truck", "stop", "to the truck"]


def test_one_step_is_the_whole_video_unless_somebody_says_otherwise() -> None:
    path = next(n for n in ("1", "2") if n in read_parts(ONE, {}, [], 9.0)[0]["whole"])
    kept, problems = read_parts(ONE, {}, [path], 9.0)
    assert (kept, problems) == ({"trims": {}, "whole": {"0": "preset", path: "chosen"}}, [])
    assert sent_parts(ONE, kept) == {"trims": {}, "whole": [path]}


@pytest.mark.parametrize(
    ("trims", "whole", "told"),
    [
        ({}, ["0"], "shows “stop”"),
        ({"9": (0.0, 1.0)}, ["0", "1"], "no such clause"),
        ({}, ["0", "1", "9"], "no such clause"),
        ({"1": (2.0, 1.0)}, ["0"], "begin before it ends"),
        ({"1": (0.0, 9.6)}, ["0"], "begin before it ends"),
        ({"1": (0.0, 1.0)}, ["0", "1"], "either the whole video or a part"),
    ],
)
def test_what_is_wrong_is_told(
    trims: dict[str, tuple[float, float]], whole: list[str], told: str
) -> None:
    _, problems = read_parts(TWO, trims, whole, 9.0)
    assert any(told in problem.message for problem in problems)


def test_old_answers_mean_the_whole_video() -> None:
    sent = sent_parts(TWO, {"trims": {"1": [0.0, 2.0]}})
    _, problems = read_parts(TWO, sent["trims"], sent["whole"], 9.0)
    assert problems == []
