"""Putting a command's text and its SDC trees together, a word at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from g3.sdc.clauses import SDC, SDCType, Span
from g3.short_repr import short_repr

Spell: TypeAlias = Callable[[str], str]
"""What somebody types for a word."""


@short_repr
@dataclass(slots=True)
class Wording:
    """A command as it is typed."""

    spell: Spell = str
    """What is typed for each word."""
    capitals: bool = False
    """Whether sentences begin with one."""
    text: str = ""
    """What has been typed."""
    groundings: dict[int, tuple[SDC, tuple[str, ...]]] = field(default_factory=dict)
    """Ids of what clauses are grounded in, by the identity of the clause, which is kept too."""

    def say(self, words: str) -> tuple[Span, ...]:
        """Type words, and return where they stand."""
        spans = []
        for word in words.split():
            typed = self.spell(word)
            if self.capitals and (not self.text or self.text.endswith(".")):
                typed = typed[0].upper() + typed[1:]
            self.text += " " if self.text else ""
            spans.append(Span(len(self.text), typed))
            self.text += typed
        return tuple(spans)

    def mark(self, sign: str) -> None:
        """Type a punctuation mark right after the last word."""
        self.text += sign

    def ground(self, clause: SDC, *ids: str) -> SDC:
        """Note what a clause is grounded in, and return it."""
        self.groundings[id(clause)] = (clause, ids)
        return clause

    def grounding(self, clause: SDC) -> tuple[str, ...] | None:
        """Ids of what a clause is grounded in; None if nothing was said of it."""
        found = self.groundings.get(id(clause))
        return None if found is None else found[1]

    def leaf(self, words: str, *ids: str) -> SDC:
        """Type a leaf OBJECT."""
        return self.ground(SDC("OBJECT", words=self.say(words)), *ids)


def clause(
    type_: SDCType,
    relation: tuple[Span, ...],
    *landmarks: SDC,
    figure: SDC | None = None,
) -> SDC:
    """An internal clause; an EVENT without a figure is an imperative, whose agent is unnamed."""
    if figure is None and type_ == "EVENT":
        figure = SDC("OBJECT")
    return SDC(
        type_,
        relation=relation,
        figure=() if figure is None else (figure,),
        landmark1=landmarks[:1],
        landmark2=landmarks[1:],
    )
