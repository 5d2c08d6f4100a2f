"""Grounding graphs: the factor graph that a command's SDC trees induce (section 3.2).

Each clause, unless it is empty, makes one factor Ψ_i and one correspondence variable φ_i:

* Ψ(φ_i, λ_i^f, γ_i) for a leaf,
* Ψ(φ_i, λ_i^r, γ_i^f, γ_i^l1) or Ψ(φ_i, λ_i^r, γ_i^f, γ_i^l1, γ_i^l2) for any other.

What the γ of a clause is follows from the factors drawn in Figures 2b and 3b:

* A leaf has a γ of its own, which its words describe.
* An OBJECT with a figure ("the pallet on the truck", OBJ_3 of Figure 3) refers to what
  its figure refers to ("the pallet"), so it has no γ of its own: γ_4 is γ_3^f, and the
  factor of "to" takes γ_4 too.
* An EVENT, PATH or PLACE is grounded in something that no clause inside it refers to: a
  state sequence, a path or a region. It has its own γ, which takes the figure's place
  (Ψ_3 of Figure 2 takes γ_3, "on the truck", and γ_4, "the truck"). Where such a clause
  names its figure ("the forklift should stop"), the factor takes the γ of both.
* The implicit figure of an imperative has no words, hence no factor; the EVENT's γ is the
  robot's state sequence already, so it has no γ either, as in both figures. Any other
  clause without words has a γ, which nothing describes, and no factor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from g3.sdc.clauses import SDC, Field, SDCType, Span, breadth_first, child_indices
from g3.sdc.sdc_notation import check_sdc, has_implicit_figure
from g3.short_repr import short_repr

VariableKind = Literal["φ", "λ", "γ"]


@short_repr
@dataclass(frozen=True, slots=True)
class Variable:
    """A random variable of the graph.

    Parameters
    ----------
    kind
        φ: whether a grounding corresponds to its clause; λ: words; γ: a grounding.
    number
        Subscript: the number that the clause has in the paper's notation.
    node
        Index of the clause in breadth-first order (:func:`g3.sdc.clauses.breadth_first`), by
        which groundings and labels are listed.
    field
        Superscript of a λ: which field the words are from.
    """

    kind: VariableKind
    number: int
    node: int
    field: Field | None = None
    words: tuple[Span, ...] = ()

    def __str__(self) -> str:
        return f"{self.kind}_{self.number}" + (f"^{self.field}" if self.field else "")

    @property
    def text(self) -> str:
        """The words, joined by spaces."""
        return " ".join(word.text for word in self.words)


@short_repr
@dataclass(frozen=True, slots=True)
class Factor:
    """A factor Ψ_i: how well the groundings of a clause's fields fit its words.

    Parameters
    ----------
    number, node
        As in :class:`Variable`.
    words
        λ_i^f or λ_i^r; none if the clause has no words of its own.
    figure, landmark1, landmark2
        The γ of each field; several where the command coordinates.
    """

    type: SDCType
    number: int
    node: int
    phi: Variable
    words: Variable | None
    figure: tuple[Variable, ...]
    landmark1: tuple[Variable, ...] = ()
    landmark2: tuple[Variable, ...] = ()

    def __str__(self) -> str:
        return f"Ψ_{self.number}({', '.join(map(str, self.variables))})"

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The arguments, in the paper's order."""
        words = (self.words,) if self.words else ()
        arguments = (self.phi, *words, *self.figure, *self.landmark1, *self.landmark2)
        return tuple(dict.fromkeys(arguments))


@short_repr
@dataclass(frozen=True, slots=True)
class GroundingGraph:
    """The bipartite factor graph of a command, without the values of its variables.

    Parameters
    ----------
    variables
        Every φ, λ and γ, clause by clause in the order of the paper's numbers.
    factors
        One for each clause that isn't empty, in the same order.
    """

    variables: tuple[Variable, ...]
    factors: tuple[Factor, ...]

    def edges(self) -> Iterator[tuple[Factor, Variable]]:
        """Each factor with each variable that it takes as an argument."""
        for factor in self.factors:
            for variable in factor.variables:
                yield factor, variable


def grounding_graph(sdcs: Sequence[SDC]) -> GroundingGraph:
    """Build the grounding graph of a command (section 3.2).

    Parameters
    ----------
    sdcs
        The top-level clauses; each is a component of the graph.

    Raises
    ------
    SDCError
        If a clause isn't well formed.
    """
    for i, sdc in enumerate(sdcs):
        check_sdc(sdc, where=f"SDC {i + 1}")
    nodes = list(breadth_first(sdcs))
    children = child_indices(sdcs)
    numbers = _numbers(sdcs)
    groundings: dict[int, tuple[Variable, ...]] = {}
    for i in reversed(range(len(nodes))):  # children before their parents
        figure = children[i].get("f", ())
        if i not in numbers:
            groundings[i] = ()
        elif nodes[i].type == "OBJECT" and figure:
            groundings[i] = tuple(gamma for child in figure for gamma in groundings[child])
        else:
            groundings[i] = (Variable("γ", numbers[i], i),)

    factors = []
    variables: dict[Variable, None] = {}
    for i, number in numbers.items():
        if not nodes[i].is_implicit:
            fields = {
                field: tuple(gamma for child in indices for gamma in groundings[child])
                for field, indices in children[i].items()
            }
            factor = _factor(nodes[i], number, i, groundings[i], fields)
            factors.append(factor)
            variables.update(dict.fromkeys(v for v in factor.variables if v.kind != "γ"))
        variables.update(dict.fromkeys(v for v in groundings[i] if v.node == i))
    return GroundingGraph(tuple(variables), tuple(factors))


def _factor(
    sdc: SDC,
    number: int,
    node: int,
    own: tuple[Variable, ...],
    fields: dict[Field, tuple[Variable, ...]],
) -> Factor:
    field: Field = "f" if sdc.is_leaf else "r"
    words = sdc.words if sdc.is_leaf else sdc.relation
    return Factor(
        type=sdc.type,
        number=number,
        node=node,
        phi=Variable("φ", number, node),
        words=Variable("λ", number, node, field, words) if words else None,
        figure=tuple(dict.fromkeys((*own, *fields.get("f", ())))),
        landmark1=fields.get("l", ()),
        landmark2=fields.get("l2", ()),
    )


def _numbers(sdcs: Sequence[SDC]) -> dict[int, int]:
    """Return the number of each clause in the paper's figures, by breadth-first index.

    The paper numbers depth-first, a clause before those in it; so is the result ordered.
    """
    children = child_indices(sdcs)
    nodes = list(breadth_first(sdcs))
    pending = list(reversed(range(len(sdcs))))
    numbers: dict[int, int] = {}
    while pending:
        i = pending.pop()
        numbers[i] = len(numbers) + 1
        shown = [
            child
            for field, indices in children[i].items()
            for child in indices
            if not (field == "f" and has_implicit_figure(nodes[i]))
        ]
        pending.extend(reversed(shown))
    return numbers
