"""SDC trees as SVG."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from hypothesis import given
from hypothesis import strategies as st

from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_drawing import to_svg
from g3.sdc.sdc_notation import parse_brackets
from tests.strategies import sdc_trees

SVG = "{http://www.w3.org/2000/svg}"


def boxes(svg):
    rects = ET.fromstring(svg).findall(f"{SVG}rect")[1:]
    return [tuple(float(r.get(k)) for k in ("x", "y", "width", "height")) for r in rects]


def test_a_box_a_clause_and_the_field_on_each_line():
    svg = to_svg(parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"))
    texts = [element.text for element in ET.fromstring(svg).findall(f"{SVG}text")]
    assert sorted(texts) == sorted(
        ["f", "l", "l", "EVENT_1", "Go", "the robot", "PATH_3", "to", "OBJECT_4", "the truck"]
    )
    assert len(boxes(svg)) == 4


@given(st.lists(sdc_trees(), max_size=3))
def test_boxes_are_apart_and_inside(sdcs):
    svg = to_svg(sdcs)
    root = ET.fromstring(svg)
    width, height = float(root.get("width")), float(root.get("height"))
    found = boxes(svg)
    assert len(found) == sum(1 for _ in breadth_first(sdcs))
    for i, (x, y, w, h) in enumerate(found):
        assert 0 <= x <= x + w <= width + 1
        assert 0 <= y <= y + h <= height + 1
        for other_x, other_y, other_w, other_h in found[:i]:
            apart = x + w <= other_x or other_x + other_w <= x
            assert apart or y + h <= other_y or other_y + other_h <= y
