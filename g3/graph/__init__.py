"""Grounding graphs: the factor graph that a command's clauses induce (section 3.2)."""

from g3.graph.grounding_graph import grounding_graph

__all__ = ["grounding_graph"]
