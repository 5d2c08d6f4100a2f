"""SDC trees as pictures, like Figures 2a and 3a of the paper, laid out here as SVG."""

from __future__ import annotations

import textwrap
import unicodedata
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from g3.sdc.clauses import CHILD_FIELDS, SDC, Field

_LINE = 18.0
_PADDING = 9.0
_GAP = 18.0
_ROW_GAP = 40.0
_MARGIN = 16.0
_WRAP = 24  # characters
_FILLS = {"EVENT": "#dbe7f6", "OBJECT": "#eef1f5", "PLACE": "#e2f1e4", "PATH": "#f8ecd6"}


@dataclass(slots=True, eq=False)
class _Box:
    sdc: SDC
    number: int
    within: Field | None
    lines: list[str]
    children: list[_Box]
    x: float = 0.0
    y: float = 0.0

    @property
    def width(self) -> float:
        columns = max(map(_columns, self.lines))
        return columns * 7.8 + 2 * _PADDING

    @property
    def height(self) -> float:
        return len(self.lines) * _LINE + 2 * _PADDING - 4


def to_svg(sdcs: Sequence[SDC], marked: Collection[int] = ()) -> str:
    """Draw the clauses of a command as SVG; the same clauses give the same text.

    Those that are marked, by their numbers, depth first from 1, get a dashed border.
    """
    numbers = iter(range(1, 10**9))
    roots = [_box(sdc, None, numbers) for sdc in sdcs]
    right = _MARGIN
    for root in roots:
        right = _spread(root, right) + _GAP
    boxes = list(_place(roots))
    width = max(right - _GAP, _MARGIN) + _MARGIN
    height = max((box.y + box.height for box in boxes), default=_MARGIN) + _MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="14" '
        'text-anchor="middle">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    lines += [_edge(box, child) for box in boxes for child in box.children]
    lines += [_drawn(box, box.number in marked) for box in boxes]
    return "\n".join([*lines, "</svg>"])


def _box(sdc: SDC, within: Field | None, numbers: Iterator[int]) -> _Box:
    number = next(numbers)
    words = " ".join(span.text for span in sdc.words or sdc.relation)
    name = f"{sdc.type}_{number}" if not sdc.is_implicit else "the robot"
    children = [
        _box(child, field, numbers) for field in CHILD_FIELDS for child in sdc.children(field)
    ]
    return _Box(sdc, number, within, [name, *textwrap.wrap(words, _WRAP)], children)


def _spread(box: _Box, left: float) -> float:
    """Place a tree to the right of `left`; return where it ends."""
    right = left
    for child in box.children:
        right = _spread(child, right) + _GAP
    right -= _GAP if box.children else 0.0
    if box.width > right - left:
        _shift(box.children, (box.width - (right - left)) / 2)
        right = left + box.width
    box.x = (left + right) / 2
    return right


def _shift(boxes: list[_Box], by: float) -> None:
    for box in boxes:
        box.x += by
        _shift(box.children, by)


def _place(roots: list[_Box]) -> Iterator[_Box]:
    """Put the boxes in rows."""
    row, top = roots, _MARGIN
    while row:
        for box in row:
            box.y = top
            yield box
        top += max(box.height for box in row) + _ROW_GAP
        row = [child for box in row for child in box.children]


def _edge(box: _Box, child: _Box) -> str:
    top, bottom = box.y + box.height, child.y
    middle = (top + bottom) / 2
    return (
        f'<path d="M {box.x:.1f} {top:.1f} C {box.x:.1f} {middle:.1f} {child.x:.1f} '
        f'{middle:.1f} {child.x:.1f} {bottom:.1f}" fill="none" stroke="#5b6470"/>'
        f'<text x="{child.x + 12:.1f}" y="{bottom - 6:.1f}" font-size="12" fill="#5b6470">'
        f"{child.within}</text>"
    )


def _drawn(box: _Box, is_marked: bool) -> str:
    left = box.x - box.width / 2
    border = ' stroke="#a3201d" stroke-width="2.5" stroke-dasharray="6 3"' if is_marked else ""
    parts = [
        f'<rect x="{left:.1f}" y="{box.y:.1f}" width="{box.width:.1f}" '
        f'height="{box.height:.1f}" rx="5" fill="{_FILLS[box.sdc.type]}"{border}/>'
    ]
    for i, line in enumerate(box.lines):
        style = 'font-size="11" fill="#5b6470"' if i == 0 else 'fill="#1f2933"'
        y = box.y + _PADDING + (i + 0.65) * _LINE
        parts.append(f'<text x="{box.x:.1f}" y="{y:.1f}" {style}>{_xml(line)}</text>')
    return "".join(parts)


def _xml(text: str) -> str:
    """Escape a text for XML, which can't hold control characters."""
    return escape("".join(c if c.isprintable() else "\ufffd" for c in text))


def _columns(line: str) -> int:
    """Return the width of a line in letters; wide letters are counted twice."""
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in line)
