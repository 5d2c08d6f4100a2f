"""Answers about the picture of a camera: the content of ``vqa`` and ``trace`` rows.

LeRobot's own ``lerobot-annotate`` answers questions as JSON of five forms, two of them with pixels
of the frame; :data:`FIELDS` has their fields. LeRobot names no form for ``trace``; it gets that of
a point, with several of them. An answer in plain words is written as it is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, TypeAlias

from g3.short_repr import short_repr

WORDS, COUNT, ATTRIBUTE, SPATIAL, POINT, BOXES, PATH = (
    "words", "count", "attribute", "spatial", "point", "boxes", "path",
)  # fmt: skip
FIELDS: Mapping[str, tuple[str, ...]] = {
    WORDS: ("answer",),
    COUNT: ("label", "count"),
    ATTRIBUTE: ("label", "attribute", "value"),
    SPATIAL: ("subject", "relation", "object"),
    POINT: ("label",),
    BOXES: (),
    PATH: ("label",),
}
"""The texts of each kind of answer, in their order."""
POINTS: Mapping[str, tuple[int, int]] = {POINT: (1, 1), BOXES: (2, 2), PATH: (2, 1000)}
"""The kinds that are drawn, with the least and the largest number of points of a shape."""

Size: TypeAlias = tuple[int, int]
"""Width and height of a picture, in pixels."""


class Fault(Enum):
    """A broken rule of LeRobot's language format; the value says which."""

    STYLE = "LeRobot has no such style"
    TEXT = "it has no text"
    ANSWER = "it has no answer"
    NUMBER = "its count is no whole number"
    DRAWING = "nothing is drawn"
    LABEL = "a box has no name"
    OUTSIDE = "it is drawn outside of the picture"
    CAMERA = "it is about a picture, and names no camera of the dataset"
    NO_PICTURE = "it names a camera, and isn't about a picture"


@dataclass(frozen=True, slots=True)
class Shape:
    """A point, a box by two opposite corners, or a path, in pixels from the upper left corner."""

    points: tuple[tuple[float, float], ...]
    label: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class Answer:
    """An answer of one of the kinds in :data:`FIELDS`, with its texts and with what is drawn."""

    kind: str
    texts: tuple[str, ...] = ()
    shapes: tuple[Shape, ...] = ()

    def fault(self, size: Size | None) -> Fault | None:
        """Return the first broken rule; `size` is the picture's, if it is known."""
        fields = FIELDS.get(self.kind)
        if fields is None or len(self.texts) != len(fields) or not all(map(_has_word, self.texts)):
            return Fault.ANSWER
        if self.kind == COUNT and not (self.texts[1].isdecimal() and len(self.texts[1]) < 10):
            return Fault.NUMBER
        if self.kind not in POINTS:
            return Fault.ANSWER if self.shapes else None
        return self._drawing_fault(size)

    def _drawing_fault(self, size: Size | None) -> Fault | None:
        fewest, most = POINTS[self.kind]
        counts = [len(shape.points) for shape in self.shapes]
        is_complete = bool(counts) and fewest <= min(counts) and max(counts) <= most
        if not is_complete or (self.kind != BOXES and len(counts) > 1):
            return Fault.DRAWING
        if self.kind == BOXES and not all(_has_word(shape.label) for shape in self.shapes):
            return Fault.LABEL
        width, height = size or (math.inf, math.inf)
        points = [point for shape in self.shapes for point in shape.points]
        is_inside = all(0 <= x <= width and 0 <= y <= height for x, y in points)
        return None if is_inside else Fault.OUTSIDE

    def content(self) -> str:
        """Return the content of the answer's row."""
        if self.kind == WORDS:
            return self.texts[0]
        value: dict[str, Any] = dict(zip(FIELDS[self.kind], self.texts, strict=True))
        if self.kind == COUNT:
            value["count"] = int(value["count"])
        elif self.kind == BOXES:
            value["detections"] = [
                {"label": shape.label, "bbox_format": "xyxy", "bbox": _corners(shape)}
                for shape in self.shapes
            ]
        elif self.kind in (POINT, PATH):
            (shape,) = self.shapes
            points = [[round(x), round(y)] for x, y in shape.points]
            value["point_format"] = "xy"
            value |= {"point": points[0]} if self.kind == POINT else {"points": points}
        return json.dumps(value, sort_keys=True, ensure_ascii=False)


def in_words(content: str) -> str | None:
    """Return the content of an answer's row in words; None if it needs the picture."""
    try:
        value = json.loads(content)
    except (ValueError, RecursionError):
        return content.strip()
    fields = value if isinstance(value, dict) else {}
    for kind in (COUNT, ATTRIBUTE, SPATIAL):
        if all(name in fields for name in FIELDS[kind]):
            texts = [str(fields[name]) for name in FIELDS[kind]]
            return " ".join(texts[::-1] if kind == COUNT else texts).replace("_", " ")
    is_drawn = {"detections", "point", "points"} & fields.keys()
    return None if is_drawn else content.strip()


def _has_word(text: str) -> bool:
    return any(character.isalnum() for character in text)


def _corners(shape: Shape) -> list[int]:
    xs, ys = zip(*shape.points, strict=True)
    return [round(value) for value in (min(xs), min(ys), max(xs), max(ys))]
