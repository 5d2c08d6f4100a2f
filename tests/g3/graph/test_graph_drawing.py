from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from g3.graph.graph_drawing import to_dot, to_svg, to_text
from g3.graph.grounding_graph import grounding_graph
from g3.sdc.clauses import SDC, Span
from g3.sdc.sdc_notation import parse_brackets
from tests.strategies import sdc_trees

SVG = "{http://www.w3.org/2000/svg}"

PUT = grounding_graph(
    parse_brackets(
        "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    )
)


def test_text_is_the_factorisation():
    assert to_text(PUT) == (
        'Ψ_1(φ_1, λ_1^r = "Put", γ_1, γ_2, γ_3)\n'
        'Ψ_2(φ_2, λ_2^f = "the pallet", γ_2)\n'
        'Ψ_3(φ_3, λ_3^r = "on", γ_3, γ_4)\n'
        'Ψ_4(φ_4, λ_4^f = "the truck", γ_4)'
    )


def test_dot_has_every_node_and_edge():
    dot = to_dot(PUT)
    assert len(re.findall(r"shape=circle", dot)) == 8
    assert len(re.findall(r"shape=box", dot)) == 4
    assert len(re.findall(r"shape=square", dot)) == 4
    assert len(re.findall(r" -- ", dot)) == len(list(PUT.edges())) == 15
    assert "  psi_1 -- gamma_3;" in dot


def test_words_are_escaped():
    graph = grounding_graph([SDC("OBJECT", (Span(0, '<b>&"\\'), Span(7, "\x00\ud800")))])
    assert "&lt;b&gt;&amp;&quot;\\ \ufffd\ufffd" in to_dot(graph)
    assert '<b>&"\\ \ufffd\ufffd' in "".join(ET.fromstring(to_svg(graph)).itertext())


def boxes(svg: ET.Element) -> list[tuple[float, float, float, float]]:
    found = []
    for circle in svg.iter(f"{SVG}circle"):
        x, y, r = (float(circle.attrib[key]) for key in ("cx", "cy", "r"))
        found.append((x - r, y - r, x + r, y + r))
    for rect in svg.iter(f"{SVG}rect"):
        if "x" in rect.attrib:
            x, y, w, h = (float(rect.attrib[key]) for key in ("x", "y", "width", "height"))
            found.append((x, y, x + w, y + h))
    return found


@given(st.lists(sdc_trees(), max_size=3))
def test_nothing_overlaps_or_leaves_the_picture(sdcs):
    graph = grounding_graph(sdcs)
    svg = ET.fromstring(to_svg(graph))
    drawn = boxes(svg)
    connected = {v for _, v in graph.edges()}
    assert len(drawn) == len(connected) + len(graph.factors)
    for a, b in combinations(drawn, 2):
        apart = a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]
        assert apart, (a, b)
    width, height = float(svg.attrib["width"]), float(svg.attrib["height"])
    assert all(x0 >= 0 and y0 >= 0 and x1 <= width and y1 <= height for x0, y0, x1, y1 in drawn)


@given(sdc_trees())
def test_drawings_are_deterministic(sdc):
    graph = grounding_graph([sdc])
    assert to_svg(graph) == to_svg(grounding_graph([sdc]))
    assert to_dot(graph) == to_dot(grounding_graph([sdc]))
