"""SDC trees as arcs between words, and back.

A clause is known by its *anchor*, its first word. Each word of a command has one arc: an anchor to
the anchor of the clause that holds its own, the other words of a clause to its anchor. The label
says which field of that clause it fills, and the type: ``l:OBJECT``, ``l2:PATH``. Three things need
more than that:

- A modifier hangs from the noun that it modifies (``mod``), not the other way round, so that
  a noun is the same whether or not it is modified.
- A clause without words ("tires to the truck" has no verb) is known by the anchor of the first
  clause in it, whose label then names both: ``l:OBJECT/root:EVENT``.
- What else belongs to a clause without words hangs from that anchor, and ``^1`` says how many
  clauses further out it belongs.

Arcs may cross. They hold 98 % of the annotated trees exactly; the others coordinate words in ways
that no reader would miss.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from dataclasses import field as default
from typing import NamedTuple

from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, SDCType, Span
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

ROOT = -1
"""Head of a word that hangs from no other."""
OUTSIDE, INSIDE = "out", "on"
"""Labels of a word in no clause, and of a further word of a clause."""
DEEPEST = 24
"""Arcs from a word to the root, at most: trees have a limited depth
(:data:`g3.sdc.sdc_notation.MAX_DEPTH`). What hangs deeper is a tree of its own."""
_FIELDS = ("f", "l", "l2", "m1", "m2")
"""Fields of a clause; m1 and m2 are those of a modifier without words."""


class Arcs(NamedTuple):
    """The arcs of n words.

    Parameters
    ----------
    heads
        For each word the one that it hangs from, or `ROOT`.
    labels
        For each word the label of its arc.
    """

    heads: tuple[int, ...]
    labels: tuple[str, ...]


@dataclass(slots=True, eq=False)
class _Clause:
    """A clause while it is read or built; `outer` counts the wordless clauses that it names."""

    type: str
    leaf: bool
    field: str
    parent: _Clause | None = None
    words: list[int] = default(default_factory=list)
    children: list[_Clause] = default(default_factory=list)
    anchor: int = ROOT
    outer: int = 0


def is_root(label: str) -> bool:
    """Return True for a label whose word hangs from no other."""
    return label == OUTSIDE or label.rpartition("/")[2].startswith("root:")


# From trees to arcs


def read_arcs(sdcs: Sequence[SDC], spans: Sequence[Span]) -> Arcs:
    """Return the arcs that the words of a command have in its annotated trees.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    spans
        The command's words.
    """
    reader = _Reader(spans)
    for sdc in sdcs:
        reader.read(sdc, "root", None)
    return reader.arcs()


class _Reader:
    def __init__(self, spans: Sequence[Span]) -> None:
        self.spans = spans
        self.owners: list[_Clause | None] = [None] * len(spans)
        self.clauses: list[_Clause] = []

    def read(self, sdc: SDC, field: str, parent: _Clause | None) -> _Clause | None:
        """Read a clause and those inside; return that of its noun."""
        if sdc.is_implicit:
            return None
        if _is_modified(sdc):
            noun = self.read(sdc.figure[0], field, parent)
            if sdc.relation:
                modifier = self._add("OBJECT", False, "mod", noun, sdc.relation)
                self._read_all(sdc, ("l", "l2"), ("l", "l2"), modifier)
            else:
                self._read_all(sdc, ("l", "l2"), ("m1", "m2"), noun)
            return noun
        clause = self._add(sdc.type, bool(sdc.words), field, parent, sdc.words or sdc.relation)
        self._read_all(sdc, ("f", "l", "l2"), ("f", "l", "l2"), clause)
        return clause

    def _read_all(
        self, sdc: SDC, fields: Sequence[str], named: Sequence[str], parent: _Clause | None
    ) -> None:
        for name, label in zip(fields, named, strict=True):
            for child in sdc.children(name):  # type: ignore[arg-type]
                self.read(child, label, parent)

    def _add(
        self, type_: str, leaf: bool, field: str, parent: _Clause | None, spans: Sequence[Span]
    ) -> _Clause:
        clause = _Clause(type_, leaf, field, parent)
        for i, word in enumerate(self.spans):
            taken = self.owners[i] is not None
            if not taken and any(s.start < word.end and word.start < s.end for s in spans):
                self.owners[i] = clause
                clause.words.append(i)
        if parent is not None:
            parent.children.append(clause)
        self.clauses.append(clause)
        return clause

    def arcs(self) -> Arcs:
        """Return the arcs of what was read."""
        heads, labels = [ROOT] * len(self.spans), [OUTSIDE] * len(self.spans)
        named: dict[int, list[_Clause]] = {}
        for clause in reversed(self.clauses):  # those inside come first
            if clause.words:
                clause.anchor = clause.words[0]
            else:
                inside = [child for child in clause.children if child.anchor != ROOT]
                if not inside:
                    continue
                first = min(inside, key=lambda child: child.anchor)
                clause.anchor, clause.outer = first.anchor, first.outer + 1
            named.setdefault(clause.anchor, []).append(clause)
        for anchor, clauses in named.items():
            parent = clauses[-1].parent
            label = "/".join(_part(clause) for clause in clauses)
            if parent is not None and parent.anchor != ROOT:
                heads[anchor] = parent.anchor
                label += f"^{parent.outer}" if parent.outer else ""
            labels[anchor] = label
            for i in clauses[0].words[1:]:
                heads[i], labels[i] = anchor, INSIDE
        return Arcs(tuple(heads), tuple(labels))


def _is_modified(sdc: SDC) -> bool:
    """Return True for a noun with a modifier: one OBJECT in the figure of another."""
    figure = sdc.figure
    return (
        sdc.type == "OBJECT"
        and not sdc.words
        and len(figure) == 1
        and figure[0].type == "OBJECT"
        and not figure[0].is_implicit
    )


def _part(clause: _Clause) -> str:
    """A clause's part of a label; OBJECTs mostly are leaves, and others never."""
    usual = clause.leaf == (clause.type == "OBJECT")
    return f"{clause.field}:{clause.type}{'' if usual else '=f' if clause.leaf else '=r'}"


# From arcs to trees


def build_trees(arcs: Arcs, spans: Sequence[Span]) -> tuple[SDC, ...]:
    """Return the top-level clauses that arcs between words make.

    Arcs must make no circle, and words hang from anchors only: what hangs from others is left out.

    Parameters
    ----------
    arcs
        The arcs of a command's words.
    spans
        The words.
    """
    named = {
        i: _clauses_of(i, label)
        for i, label in enumerate(arcs.labels)
        if label not in (OUTSIDE, INSIDE)
    }
    tops = []
    deep = _too_deep(arcs.heads)
    for i, (head, label) in enumerate(zip(*arcs, strict=True)):
        if label == INSIDE and head in named:
            named[head][0].words.append(i)
        elif i in named:
            clause = named[i][-1]
            _, _, further = label.partition("^")
            if head not in named or clause.field == "root" or i in deep:
                tops.append(clause)
            else:
                outwards = named[head]
                parent = outwards[min(int(further or 0), len(outwards) - 1)]
                parent.children.append(clause)
    return tuple([_built(clause, spans) for clause in tops])


def _too_deep(heads: Sequence[int]) -> set[int]:
    """Words that hang from the root by a multiple of `DEEPEST` arcs."""
    depths: dict[int, int] = {ROOT: 0}
    for word in range(len(heads)):
        path = [word]
        while path[-1] not in depths:
            path.append(heads[path[-1]])
        for below, above in zip(path[-2::-1], path[:0:-1], strict=True):
            depths[below] = depths[above] + 1
    return {word for word, depth in depths.items() if word != ROOT and depth % DEEPEST == 0}


def _clauses_of(anchor: int, label: str) -> list[_Clause]:
    """The clauses that an anchor's label names, the innermost first."""
    clauses: list[_Clause] = []
    for part in label.partition("^")[0].split("/"):
        name, _, form = part.partition("=")
        field, _, type_ = name.partition(":")
        leaf = form == "f" if form else type_ == "OBJECT"
        clause = _Clause(type_, leaf, field, anchor=anchor)
        clause.children += clauses[-1:]
        clauses.append(clause)
    clauses[0].words.append(anchor)
    return clauses


def _built(clause: _Clause, spans: Sequence[Span]) -> SDC:
    f, l1, l2, m1, m2 = (
        tuple([_built(child, spans) for child in _in_order(clause, name)]) for name in _FIELDS
    )
    words = tuple([spans[i] for i in sorted(clause.words)])
    while clause.leaf and len(words) > 1 and words[-1].text.lower() in WORDS["joining"]:
        words = words[:-1]
    sdc_type: SDCType = clause.type  # type: ignore[assignment]
    if clause.leaf and not (clause.type == "OBJECT" and (f or l1 or l2)):
        built = SDC(sdc_type, words)
    else:
        figure = f or (IMPLICIT_FIGURE if clause.type == "EVENT" else ())
        built = SDC(sdc_type, (), words, figure, l1, l2)
    for modifier in _modifiers(clause):
        if modifier is clause:
            built = SDC("OBJECT", (), (), (built,), m1, m2)
        else:
            relation = tuple([spans[i] for i in sorted(modifier.words)])
            inside = (
                tuple([_built(child, spans) for child in _in_order(modifier, name)])
                for name in ("l", "l2")
            )
            built = SDC("OBJECT", (), relation, (built,), *inside)
    return built


def _modifiers(clause: _Clause) -> Iterator[_Clause]:
    """A noun's modifiers from left to right; the clause itself stands for the one without words."""
    bare = [child for child in clause.children if child.field in ("m1", "m2")]
    modifiers = [(child.anchor, child) for child in clause.children if child.field == "mod"]
    if bare:
        modifiers.append((min(child.anchor for child in bare), clause))
    for _, modifier in sorted(modifiers, key=lambda item: item[0]):
        yield modifier


def _in_order(clause: _Clause, name: str) -> list[_Clause]:
    """The clauses in a field: things first, and what stands before the verb last."""
    return sorted(
        (child for child in clause.children if child.field == name),
        key=lambda child: (_RANK[child.type], child.anchor),
    )


_RANK = {"OBJECT": 0, "PLACE": 1, "PATH": 1, "EVENT": 2}
