"""A command's clauses as inference looks at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from g3.examples import factor_words
from g3.inference.phrases import is_area, is_complement, told
from g3.sdc import SDC, Field, breadth_first, child_indices


@dataclass(frozen=True)
class Tree:
    """A command's clauses with what is looked up again and again.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    """

    sdcs: tuple[SDC, ...]

    @cached_property
    def nodes(self) -> list[SDC]:
        """All clauses, breadth first."""
        return list(breadth_first(self.sdcs))

    @cached_property
    def children(self) -> list[dict[Field, tuple[int, ...]]]:
        """The clauses in the fields of each."""
        return child_indices(self.sdcs)

    @cached_property
    def words(self) -> list[dict]:  # type: ignore[type-arg]
        """Words of each clause's factor; those of an area say where it is, as a PLACE's do."""
        spoken = [{f: told(w) for f, w in factor_words(sdc).items()} for sdc in self.nodes]
        return [
            {**words, "figure": (), "name": ()} if is_area(sdc) else words
            for sdc, words in zip(self.nodes, spoken, strict=True)
        ]

    @cached_property
    def parts(self) -> frozenset[int]:
        """OBJECTs of which another clause says more without a landmark: "the pallet" of tires."""
        return frozenset(
            child
            for node, sdc in enumerate(self.nodes)
            if sdc.type == "OBJECT" and (is_complement(sdc) or not sdc.landmark1)
            for child in (*self.children[node].get("f", ()), *self.children[node].get("l", ()))
        )

    def all_below(self, node: int) -> list[int]:
        """A clause and all clauses in it."""
        found = [node]
        for n in found:
            found.extend(c for group in self.children[n].values() for c in group)
        return found

    def below(self, node: int, fields: Sequence[Field], *types: str) -> list[int]:
        """Clauses of some types in some fields of another, in the order of the fields."""
        return [
            child
            for name in fields
            for child in self.children[node].get(name, ())
            if self.nodes[child].type in types and not self.nodes[child].is_implicit
        ]
