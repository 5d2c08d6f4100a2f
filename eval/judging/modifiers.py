"""Modifiers of an OBJECT's noun: "second from the left", "by the truck"."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from eval.judging.grounded_command import GroundedCommand
from g3.inference.problem.phrases import unstressed
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import Concept, concepts
from g3.language.lexicon.field_words import bare, field_words, normalise
from g3.language.lexicon.word_sets import EXTREMES, ORDINALS, SELVES, TOWARD
from g3.sdc.clauses import SDC, Span
from g3.short_repr import short_repr

_ORDINALS = {normalise(word): number for word, number in ORDINALS.items()}


@short_repr
@dataclass(frozen=True, slots=True)
class Modifier:
    """Words that state the position of a thing."""

    words: tuple[str, ...]
    """In their normal form."""
    landmarks: tuple[int, ...] = ()
    """The clauses of its landmarks."""
    negative: bool = False
    """True if they exclude a position."""

    @property
    def concepts(self) -> frozenset[Concept]:
        """The concepts that the words name."""
        return concepts(self.words)

    @property
    def side(self) -> Concept | None:
        """The left or the right, if it is one of them."""
        sides: tuple[Concept, ...] = ("left", "right")
        found = [side for side in sides if side in self.concepts]
        return found[0] if len(found) == 1 else None

    @property
    def ordinal(self) -> int | None:
        """Place in an order, counted from its side; 1 for the leftmost."""
        number = next((_ORDINALS[w] for w in self.words if w in _ORDINALS), None)
        extreme = EXTREMES.intersection(self.words) or {"last", "far", "first"} & self.concepts
        return number or (1 if self.side and extreme else None)


def modifiers_of(words: GroundedCommand, node: int, also: tuple[Span, ...] = ()) -> list[Modifier]:
    """Return an OBJECT's modifiers; those of order are merged: "the second" "from the right".

    `also` are words elsewhere that modify the OBJECT.
    """
    found = [_modifier(words, n) for n in _same_thing(words, node)]
    found.append(Modifier(unstressed(field_words(also))))
    order = [m for m in found if m and (m.side or m.ordinal)]
    rest = [m for m in found if m and m not in order]
    if order:
        rest.append(
            Modifier(
                tuple(w for m in order for w in m.words),
                tuple(n for m in order for n in m.landmarks),
            )
        )
    return rest


def is_reflexive(sdc: SDC) -> bool:
    """Check that a clause is "itself"."""
    return any(bare(word.text) in SELVES for word in sdc.words)


def unplaced(words: GroundedCommand, marks: Iterable[int]) -> tuple[str, ...]:
    """Return landmarks' words that name no things but relations: "the middle"."""
    leaves = (n for n in marks if not words.annotated[n] and words.tree.nodes[n].is_leaf)
    return tuple(w for n in leaves for w in unstressed(field_words(words.tree.nodes[n].words)))


def _same_thing(words: GroundedCommand, node: int) -> list[int]:
    """Return an OBJECT and the ones in it that name the same thing in fewer words."""
    tree, found = words.tree, [node]
    for n in found:
        figures = (c for c in tree.children[n].get("f", ()) if tree.nodes[c].type == "OBJECT")
        found.extend(list(figures)[:1])
    return found


def _modifier(words: GroundedCommand, node: int) -> Modifier | None:
    tree = words.tree
    sdc = tree.nodes[node]
    marks = tuple(n for f in ("l", "l2") for n in tree.children[node].get(f, ()))
    own = words.annotated[node]
    renaming = (words.annotated[n] == own and not is_reflexive(tree.nodes[n]) for n in marks)
    if own and marks and all(renaming):
        return None
    spoken = unstressed(field_words(sdc.relation if sdc.figure else sdc.words)) + unplaced(
        words, marks
    )
    if TOWARD.intersection(spoken) and not marks:
        # What is to go towards a side needn't stand there.
        return None
    return Modifier(spoken, marks, negated(sdc))
