"""Grounding graphs as pictures and text: DOT for Graphviz, SVG laid out here, plain text, records.

As in Figures 2b and 3b, φ and γ are circles, and factors are small filled squares. The words λ are
boxes, shaded because they are always observed.
"""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

from g3.graph.grounding_graph import Factor, GroundingGraph, Variable

_NAMES = {"φ": "phi", "λ": "lambda", "γ": "gamma"}

_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _xml(text: str) -> str:
    """Escape a text for XML, which can't hold most control characters at all."""
    return escape(_NOT_XML.sub("\ufffd", text))


# Text


def to_text(graph: GroundingGraph) -> str:
    """Write the factorisation of Equation 3, a factor a line."""
    lines = []
    for factor in graph.factors:
        arguments = ", ".join(
            f'{variable} = "{variable.text}"' if variable.words else str(variable)
            for variable in factor.variables
        )
        lines.append(f"Ψ_{factor.number}({arguments})")
    return "\n".join(lines)


# Records


def to_record(graph: GroundingGraph) -> dict[str, list[dict[str, object]]]:
    """Return the variables and factors as JSON values; factors name their variables."""
    return {
        "variables": [
            {
                "name": str(variable),
                "kind": variable.kind,
                "node": variable.node,
                "field": variable.field,
                "text": variable.text if variable.words else None,
            }
            for variable in graph.variables
        ],
        "factors": [
            {
                "name": f"Ψ_{factor.number}",
                "type": factor.type,
                "node": factor.node,
                "phi": str(factor.phi),
                "words": str(factor.words) if factor.words else None,
                "figure": [str(variable) for variable in factor.figure],
                "landmark1": [str(variable) for variable in factor.landmark1],
                "landmark2": [str(variable) for variable in factor.landmark2],
            }
            for factor in graph.factors
        ],
    }


# DOT


def to_dot(graph: GroundingGraph) -> str:
    """Write the graph in Graphviz's DOT language; the same graph always gives the same text."""
    lines = [
        "graph grounding_graph {",
        '  graph [rankdir=TB, fontname="sans-serif"];',
        '  node [fontname="sans-serif", fontsize=12];',
    ]
    for variable in graph.variables:
        style = 'shape=box, style=filled, fillcolor="#eef1f5"' if variable.words else "shape=circle"
        lines.append(f"  {_dot_id(variable)} [{style}, label=<{_dot_label(variable)}>];")
    lines += [
        f"  psi_{factor.number} [shape=square, style=filled, fillcolor=black, "
        f'width=0.12, fixedsize=true, label="", tooltip="Ψ_{factor.number}"];'
        for factor in graph.factors
    ]
    lines += [
        f"  psi_{factor.number} -- {_dot_id(variable)};" for factor, variable in graph.edges()
    ]
    return "\n".join([*lines, "}", ""])


def _dot_id(variable: Variable) -> str:
    return f"{_NAMES[variable.kind]}_{variable.number}"


def _dot_label(variable: Variable) -> str:
    superscript = f"<SUP>{variable.field}</SUP>" if variable.field else ""
    words = f"<BR/>{_xml(variable.text)}" if variable.words else ""
    return f"{variable.kind}<SUB>{variable.number}</SUB>{superscript}{words}"


# SVG

_RADIUS = 19.0
_SQUARE = 11.0
_ARM = 30.0  # from a factor's centre to the rim of its φ and the edge of its words
_LINE = 18.0
_GAP = 26.0
_ROW_GAP = 36.0
_MARGIN = 16.0
_WRAP = 28  # characters
_INK = 'stroke="none" fill="#1f2933"'


@dataclass(slots=True)
class _Node:
    """A γ or a factor in the tree that is drawn.

    ``left`` and ``right`` say how far it reaches from its x; its height becomes that of
    its row.
    """

    item: Variable | Factor
    children: list[_Node]
    left: float
    right: float
    height: float
    x: float = 0.0
    y: float = 0.0


def to_svg(graph: GroundingGraph) -> str:
    """Draw the graph as an SVG picture.

    The γ and the factors hang below each other in rows, every factor with its φ on the
    left and its words on the right. Where the graph has a cycle (a relation whose figure
    is several things), the rows follow a spanning tree and the rest are curves.
    """
    roots = _forest(graph)
    extent = _MARGIN
    for root in roots:
        left, right = _spread(root)
        root.x = extent + left
        extent += left + right + _GAP
    width = max(extent - _GAP, 0.0) + _MARGIN
    placed = list(_place(roots))
    height = max((node.y + node.height / 2 for node in placed), default=0.0) + _MARGIN
    position = {node.item: node for node in placed}

    edges = [
        _curve(position[factor], position[variable])
        for factor, variable in graph.edges()
        if variable.kind == "γ"
    ]
    shapes = [
        _svg_factor(node.item, node) if isinstance(node.item, Factor) else _circle(node.item, node)
        for node in placed
    ]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
            f'viewBox="0 0 {width:.1f} {height:.1f}" font-family="sans-serif" role="img">',
            f"<title>Grounding graph</title>\n<desc>{_xml(to_text(graph))}</desc>",
            f'<rect width="{width:.1f}" height="{height:.1f}" fill="white"/>',
            '<g fill="none" stroke="#5b6470" stroke-width="1.4">',
            *edges,
            "</g>",
            '<g stroke="#1f2933" stroke-width="1.4" text-anchor="middle" font-size="15">',
            *shapes,
            "</g>",
            "</svg>",
            "",
        ]
    )


def _forest(graph: GroundingGraph) -> list[_Node]:
    """Hang the factors below the γ that they describe, and their other γ below them."""
    seen: set[Variable | Factor] = set()

    def claim(items: Iterable[Variable | Factor]) -> list[Variable | Factor]:
        new = [item for item in items if item not in seen]
        seen.update(new)
        return new

    def hang(item: Variable | Factor) -> _Node:
        below: list[Variable | Factor]
        if isinstance(item, Factor):
            below = claim(v for v in item.variables if v.kind == "γ")
            lines = _wrapped(item)
            return _Node(
                item,
                [hang(child) for child in below],
                left=_ARM + 2 * _RADIUS,
                right=_ARM + _box_width(lines) if lines else _SQUARE,
                height=max(2 * _RADIUS, _box_height(lines)),
            )
        below = claim(f for f in graph.factors if item in f.figure)
        return _Node(item, [hang(child) for child in below], _RADIUS, _RADIUS, 2 * _RADIUS)

    return [hang(root) for factor in graph.factors for root in claim(factor.figure[:1])]


def _spread(node: _Node) -> tuple[float, float]:
    """Place the tree below a node; how far it reaches to the left and to the right of the node."""
    reach = 0.0
    for child in node.children:
        left, right = _spread(child)
        child.x = reach + left
        reach += left + right + _GAP
    if not node.children:
        return node.left, node.right
    middle = (node.children[0].x + node.children[-1].x) / 2
    for child in node.children:
        child.x -= middle
    return max(node.left, middle), max(node.right, reach - _GAP - middle)


def _place(roots: list[_Node]) -> Iterable[_Node]:
    """Make all positions absolute, row by row."""
    row, top = roots, _MARGIN
    while row:
        height = max(node.height for node in row)
        for node in row:
            node.y = top + height / 2
            node.height = height
            for child in node.children:
                child.x += node.x
            yield node
        row = [child for node in row for child in node.children]
        top += height + _ROW_GAP


def _curve(a: _Node, b: _Node) -> str:
    """Draw a line that is straight in the rows of its ends and bends only between the rows."""
    upper, lower = sorted((a, b), key=lambda node: node.y)
    top, bottom = upper.y + upper.height / 2, lower.y - lower.height / 2
    middle = (top + bottom) / 2
    return (
        f'<path d="M {upper.x:.1f} {upper.y:.1f} V {top:.1f} C {upper.x:.1f} {middle:.1f} '
        f'{lower.x:.1f} {middle:.1f} {lower.x:.1f} {bottom:.1f} V {lower.y:.1f}"/>'
    )


def _circle(variable: Variable, node: _Node, offset: float = 0.0) -> str:
    x = node.x + offset
    return (
        f'<circle cx="{x:.1f}" cy="{node.y:.1f}" r="{_RADIUS:.1f}" fill="white"/>'
        f"{_symbol(variable, x, node.y + 5)}"
    )


def _symbol(variable: Variable, x: float, y: float) -> str:
    """Draw a letter with its scripts; placed one by one, for not all viewers centre them as one."""
    scripts = [(str(variable.number), 4.0), (variable.field or "", -6.0)]
    return f'<text x="{x - 4:.1f}" y="{y:.1f}" {_INK}>{variable.kind}</text>' + "".join(
        f'<text x="{x + 1:.1f}" y="{y + dy:.1f}" {_INK} font-size="10" text-anchor="start">'
        f"{script}</text>"
        for script, dy in scripts
        if script
    )


def _svg_factor(factor: Factor, node: _Node) -> str:
    lines = _wrapped(factor)
    x, y = node.x, node.y
    reach = _ARM if factor.words else 0.0
    parts = [
        f'<path d="M {x - _ARM:.1f} {y:.1f} H {x + reach:.1f}" stroke="#5b6470"/>',
        f'<rect x="{x - _SQUARE / 2:.1f}" y="{y - _SQUARE / 2:.1f}" width="{_SQUARE}" '
        f'height="{_SQUARE}" fill="#1f2933"><title>{_xml(str(factor))}</title></rect>',
        _circle(factor.phi, node, -_ARM - _RADIUS),
    ]
    if factor.words:
        width, height = _box_width(lines), _box_height(lines)
        left, top = x + _ARM, y - height / 2
        parts += [
            f'<rect x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}" '
            'rx="4" fill="#eef1f5"/>',
            _symbol(factor.words, left + width / 2, top + _LINE),
        ]
        parts += [
            f'<text x="{left + width / 2:.1f}" y="{top + (i + 2) * _LINE + 1:.1f}" '
            f"{_INK}>{_xml(line)}</text>"
            for i, line in enumerate(lines)
        ]
    return "\n".join(parts)


def _wrapped(factor: Factor) -> list[str]:
    if factor.words is None:
        return []
    return textwrap.wrap(factor.words.text, _WRAP, break_long_words=False, break_on_hyphens=False)


def _box_height(lines: list[str]) -> float:
    return (len(lines) + 1) * _LINE + 10.0 if lines else 0.0


def _box_width(lines: list[str]) -> float:
    """Width of a box around lines set in 15 px; wide letters are counted twice."""
    columns = max(
        sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in line) for line in lines
    )
    return max(44.0, columns * 8.4 + 18.0)
