from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import SDCError
from g3.graph.grounding_graph import GroundingGraph, grounding_graph
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.sdc.sdc_notation import parse_brackets
from tests.strategies import sdc_trees

FIGURE_2A = "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
FIGURE_3A = (
    "EVENT(r = Go, l = PATH(r = to,"
    " l = OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the truck))))"
)


def graph_of(notation: str) -> GroundingGraph:
    return grounding_graph(parse_brackets(notation))


def factors(notation: str) -> list[str]:
    return [str(factor) for factor in graph_of(notation).factors]


def nodes_of(variables):
    """The breadth-first indices of the clauses whose groundings variables are."""
    return tuple(variable.node for variable in variables)


def test_figure_2b():
    graph = graph_of(FIGURE_2A)
    assert [str(factor) for factor in graph.factors] == [
        "Ψ_1(φ_1, λ_1^r, γ_1, γ_2, γ_3)",
        "Ψ_2(φ_2, λ_2^f, γ_2)",
        "Ψ_3(φ_3, λ_3^r, γ_3, γ_4)",
        "Ψ_4(φ_4, λ_4^f, γ_4)",
    ]
    assert [variable.text for variable in graph.variables if variable.words] == [
        "Put",
        "the pallet",
        "on",
        "the truck",
    ]


def test_figure_3b():
    graph = graph_of(FIGURE_3A)
    assert [str(factor) for factor in graph.factors] == [
        "Ψ_1(φ_1, λ_1^r, γ_1, γ_2)",
        "Ψ_2(φ_2, λ_2^r, γ_2, γ_4)",
        "Ψ_3(φ_3, λ_3^r, γ_4, γ_5)",  # "φ_3 is true if γ_4 is 'on' γ_5"
        "Ψ_4(φ_4, λ_4^f, γ_4)",
        "Ψ_5(φ_5, λ_5^f, γ_5)",  # "γ_5, φ_5 and λ_5^f"
    ]
    assert {str(variable) for variable in graph.variables} == (
        {f"φ_{i}" for i in range(1, 6)}
        | {"λ_1^r", "λ_2^r", "λ_3^r", "λ_4^f", "λ_5^f"}
        | {"γ_1", "γ_2", "γ_4", "γ_5"}
    )


def test_nodes_are_breadth_first_indices():
    sdcs = parse_brackets(FIGURE_3A)
    nodes = list(breadth_first(sdcs))
    by_number = {factor.number: factor for factor in grounding_graph(sdcs).factors}
    assert nodes[1].is_implicit  # the robot stands in the order but not in the graph
    assert [by_number[number].node for number in range(1, 6)] == [0, 2, 3, 4, 5]
    assert nodes_of(by_number[2].figure) == (2,)
    assert nodes_of(by_number[2].landmark1) == (4,)
    assert nodes_of(by_number[3].figure) == (4,)
    assert nodes_of(by_number[3].landmark1) == (5,)


def test_a_named_figure_of_an_event_is_an_argument_beside_its_state_sequence():
    assert factors("EVENT(f = OBJ(f = the forklift), r = stops)") == [
        "Ψ_1(φ_1, λ_1^r, γ_1, γ_2)",
        "Ψ_2(φ_2, λ_2^f, γ_2)",
    ]


def test_a_plural_figure_shares_all_its_groundings():
    assert factors(
        "PATH(r = to, l = OBJ(f = [OBJ(f = tires), OBJ(f = boxes)], r = on, l = OBJ(f = it)))"
    ) == [
        "Ψ_1(φ_1, λ_1^r, γ_1, γ_3, γ_4)",
        "Ψ_2(φ_2, λ_2^r, γ_3, γ_4, γ_5)",
        "Ψ_3(φ_3, λ_3^f, γ_3)",
        "Ψ_4(φ_4, λ_4^f, γ_4)",
        "Ψ_5(φ_5, λ_5^f, γ_5)",
    ]


def test_an_object_without_figure_has_its_own_grounding():
    assert factors("OBJ(r = nearest to, l = OBJ(f = you))") == [
        "Ψ_1(φ_1, λ_1^r, γ_1, γ_2)",
        "Ψ_2(φ_2, λ_2^f, γ_2)",
    ]


def test_an_empty_clause_has_a_grounding_but_no_factor():
    graph = graph_of("PLACE(r = beside, l = OBJ())")
    assert [str(factor) for factor in graph.factors] == ["Ψ_1(φ_1, λ_1^r, γ_1, γ_2)"]


def test_a_clause_without_relation_has_no_words():
    assert factors("OBJ(f = OBJ(f = boxes), l = OBJ(f = tires))")[0] == "Ψ_1(φ_1, γ_2, γ_3)"


def test_top_level_clauses_share_one_graph():
    assert factors("EVENT(r = Go); EVENT(r = Stop)") == [
        "Ψ_1(φ_1, λ_1^r, γ_1)",
        "Ψ_2(φ_2, λ_2^r, γ_2)",
    ]


def test_ill_formed_clauses_are_refused():
    with pytest.raises(SDCError, match="SDC 1: the figure holds words"):
        grounding_graph([SDC("OBJECT", (Span(0, "a"),), relation=(Span(2, "b"),))])


@given(st.lists(sdc_trees(), max_size=3))
def test_structure(sdcs):
    graph = grounding_graph(sdcs)
    nodes = list(breadth_first(sdcs))
    assert len(set(graph.variables)) == len(graph.variables)
    edges = list(graph.edges())
    assert {variable for _, variable in edges} <= set(graph.variables)
    assert [f.number for f in graph.factors] == sorted(f.number for f in graph.factors)
    assert all(not nodes[factor.node].is_implicit for factor in graph.factors)
    # "φ_i" belongs to Ψ_i alone, and so do its words.
    for factor in graph.factors:
        own = [v for v in factor.variables if v.kind != "γ"]
        assert all(variable.number == factor.number for variable in own)
    words = [span for variable in graph.variables for span in variable.words]
    assert len(words) == sum(len(node.words) + len(node.relation) for node in nodes)
