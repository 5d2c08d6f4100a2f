"""SDC trees from the roles of words (:mod:`g3.language.parsing.word_roles`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from g3.language.lexicon.word_sets import (
    CONJUNCTIONS,
    COPULAS,
    PAIRED,
    SENTENCE_ENDS,
    SUBORDINATORS,
)
from g3.language.parsing.word_roles import BEGINS_EVENT, BEGINS_RELATION, Role
from g3.sdc.clauses import SDC, SDCType, Span
from g3.sdc.sdc_notation import IMPLICIT_FIGURE
from g3.short_repr import short_repr

DEEPEST = 24
"""How many clauses may follow a top-level EVENT before what follows begins anew: trees have a
limited depth (:data:`g3.sdc.sdc_notation.MAX_DEPTH`)."""


@short_repr
@dataclass(slots=True, eq=False)
class Clause:
    """A clause while the tree grows.

    Parameters
    ----------
    type
        Its type.
    begin
        The word that begins it.
    words, relation
        Its words, as indices.
    children
        The clauses in its fields.
    """

    type: SDCType
    begin: int
    words: list[int] = field(default_factory=list)
    relation: list[int] = field(default_factory=list)
    f: list[Clause] = field(default_factory=list)
    l: list[Clause] = field(default_factory=list)  # noqa: E741 - the paper's name
    l2: list[Clause] = field(default_factory=list)


Choose = Callable[[int, Sequence[Clause]], int]
"""Given the word that begins a modifier and the nouns that it could modify, from the
nearest outwards, which of them it modifies."""


def assemble(
    roles: Sequence[Role], spans: Sequence[Span], lower: Sequence[str], choose: Choose
) -> tuple[SDC, ...]:
    """Put the trees of a command together.

    Parameters
    ----------
    roles
        The role of each word.
    spans
        The words as they stand in the command.
    lower
        The words in lower case.
    choose
        Which noun a modifier modifies, where there are several.

    Returns
    -------
    tuple of SDC
        The top-level clauses.
    """
    assembler = _Assembler(lower, choose)
    for i, role in enumerate(roles):
        assembler.add(i, role)
    assembler.close()
    return tuple(_freeze(clause, spans) for clause in assembler.trees)


class _Noun(NamedTuple):
    """A noun that modifiers can modify, the list that holds it, and the clause of that list."""

    clause: Clause
    field: list[Clause]
    owner: Clause | None


class _Assembler:
    """Reads words from left to right and keeps what later words can attach to.

    `nouns` are the OBJECTs that a modifier can modify, from the outermost to the nearest;
    `owner` is the list that holds the outermost. `open` is the relation that waits for its
    landmark.
    """

    def __init__(self, lower: Sequence[str], choose: Choose) -> None:
        self.lower = lower
        self.choose = choose
        self.trees: list[Clause] = []
        self.event: Clause | None = None
        self.inner: Clause | None = None
        self.last_event: Clause | None = None
        self.last_relation: Clause | None = None
        self.last: Clause | None = None
        self.open: Clause | None = None
        self.nouns: list[_Noun] = []
        self.hosts: list[_Noun] = []
        self.governor: Clause | None = None
        self.subject: list[Clause] = []
        self.fronted: list[Clause] = []
        self.waiting: list[Clause] = []
        self.joined = False
        self.depth = 0

    def add(self, i: int, role: Role) -> None:
        """Read one word."""
        if role == "outside":
            self._outside(i)
            return
        if role.endswith("-on"):
            self._go_on(i, role)
            return
        if self.depth > DEEPEST:
            self.close()
            self.event = self.inner = None
            self.depth = 0
        if role == "event":
            self.depth = 0
        elif role != "noun":
            self.depth += 1
        if role in BEGINS_EVENT:
            self._begin_event(i, role)
        elif role in BEGINS_RELATION:
            self._begin_relation(i, role)
        else:
            self._begin_noun(i, role)
        self.joined = False

    def close(self) -> None:
        """End a sentence: what waits for a verb stands alone."""
        self.trees += [*self.waiting, *self.subject, *self.fronted]
        self.waiting, self.subject, self.fronted = [], [], []
        self.nouns, self.hosts = [], []
        self.open, self.governor, self.joined = None, None, False

    def _outside(self, i: int) -> None:
        word = self.lower[i]
        if word in SENTENCE_ENDS:
            self.close()
            self.event = self.inner = None
        elif word in CONJUNCTIONS:
            self.joined, self.open = True, None
        elif not word.isalnum():
            self.open = None

    def _go_on(self, i: int, role: Role) -> None:
        if role == "event-on":
            if self.last_event is None:
                return self._begin_event(i, "event")
            if self.subject:
                self.last_event.f, self.subject, self.nouns = self.subject, [], self.hosts
            self.last = self.last_event
            return self.last_event.relation.append(i)
        if role == "relation-on":
            if self.last_relation is None:
                return self._begin_relation(i, "place")
            return self.last_relation.relation.append(i)
        if self.last is None or not self.last.words:
            return self._begin_noun(i, "noun")
        return self.last.words.append(i)

    def _begin_event(self, i: int, role: Role) -> None:
        event = Clause("EVENT", i, relation=[i])
        if self.subject:
            event.f, self.subject, self.nouns = self.subject, [], self.hosts
        if role == "event" or self.event is None:
            event.l, self.waiting = self.waiting, []
            (event.l2 if event.l else event.l).extend(self.fronted)
            self.fronted = []
            self.trees.append(event)
            self.event, self.nouns = event, []
        elif role == "noun-event" and self.nouns:
            noun = self._modify(i)
            noun.l.append(event)
        elif event.f and self.governor is not None:
            self.governor.l.append(event)
        else:
            self._argue(self._host(), event)
            self.nouns = []
        self.inner = self.event if role == "noun-event" else event
        self.last_event = self.last = event
        self.open = None

    def _host(self) -> Clause | None:
        """The EVENT that another one is an argument of."""
        inner = self.inner
        if (
            inner is not None
            and not (inner.l or inner.l2)
            and all(self.lower[i] in SUBORDINATORS for i in inner.relation)
        ):
            return inner
        return self.event

    def _begin_relation(self, i: int, role: Role) -> None:
        if self.subject and role != "modifier":
            if self.hosts:  # a verb taken for a preposition: "the one you *dropped*"
                return self._begin_event(i, "noun-event")
            if self.inner is not None and not (self.inner.f or self.inner.l or self.inner.l2):
                self.inner.f, self.subject = self.subject, []
        if role == "modifier" and self.subject and self.hosts:
            subject, self.subject, self.nouns = self.subject, [], self.hosts
            clause = self._modify(i)
            clause.relation.append(i)
            clause.l = subject
        elif role == "modifier" and self.nouns:
            clause = self._modify(i)
            clause.relation.append(i)
        else:
            clause = Clause("PATH" if role == "path" else "PLACE", i, relation=[i])
            if self.open is not None and self.lower[self.open.relation[-1]] in COPULAS:
                self.open.l.append(clause)
            elif self.inner is None:
                self.fronted.append(clause)
            else:
                self._argue(self.inner, clause)
            self.nouns = []
        self.open = self.last = self.last_relation = clause
        return None

    def _modify(self, i: int) -> Clause:
        """Wrap the chosen noun in a new OBJECT."""
        outwards = [noun.clause for noun in reversed(self.nouns)]
        level = len(outwards) - 1 - (self.choose(i, outwards) if len(outwards) > 1 else 0)
        noun, field, owner = self.nouns[level]
        clause = Clause("OBJECT", noun.begin, f=[noun])
        field[field.index(noun)] = clause
        self.nouns = [*self.nouns[:level], _Noun(clause, field, owner)]
        return clause

    def _begin_noun(self, i: int, role: Role) -> None:
        noun = Clause("OBJECT", i, words=[i])
        if role == "subject":
            if not self.subject:
                self.hosts, self.governor = self.nouns, self.open
            self._put(noun, self.subject, None)
        elif self.open is not None:
            self.nouns.append(_Noun(noun, self.open.l, self.open))
            self.open.l.append(noun)
        elif self.last is not None and self.last is self.last_event:
            self._put(noun, _object_field(self.last), self.last)
        else:
            self._coordinate(noun)
        self.last, self.open = noun, None

    def _coordinate(self, noun: Clause) -> None:
        """A noun after another one: "between X and Y", "X, the one on the right"."""
        pair = self._incomplete_pair() if self.joined else None
        if pair is not None:
            level, owner = pair
            self._put(noun, owner.l2, owner, level)
        elif self.nouns:
            level = len(self.nouns) - 1 if self.joined else 0
            _, field, of = self.nouns[level]
            self._put(noun, field, of, level)
        elif self.inner is not None:
            self._put(noun, _object_field(self.inner), self.inner)
        else:
            self._put(noun, self.waiting, None)

    def _incomplete_pair(self) -> tuple[int, Clause] | None:
        """The nearest "between" with one landmark."""
        for level in range(len(self.nouns) - 1, -1, -1):
            _, field, owner = self.nouns[level]
            if owner is None or field is not owner.l or owner.l2 or len(field) > 1:
                continue
            if any(self.lower[i] in PAIRED for i in owner.relation):
                return level, owner
        return None

    def _put(self, noun: Clause, field: list[Clause], owner: Clause | None, level: int = 0) -> None:
        field.append(noun)
        self.nouns = [*self.nouns[:level], _Noun(noun, field, owner)]

    def _argue(self, event: Clause | None, clause: Clause) -> None:
        """Add an argument to an EVENT: beside its object, or first where it has none."""
        if event is None:
            self.trees.append(clause)
            return
        has_object = any(c.type == "OBJECT" for c in event.l)
        with_others = clause.type == "EVENT" and bool(event.l)
        (event.l2 if has_object or with_others else event.l).append(clause)


def _object_field(event: Clause) -> list[Clause]:
    """Where an EVENT's next object goes: first, also where places and paths stand before it."""
    if any(clause.type == "OBJECT" or clause.begin > event.begin for clause in event.l):
        return event.l2
    event.l, event.l2 = [], [*event.l, *event.l2]
    return event.l


def _freeze(clause: Clause, spans: Sequence[Span]) -> SDC:
    if clause.words:
        return SDC(clause.type, tuple([spans[i] for i in clause.words]))
    figure = tuple([_freeze(child, spans) for child in clause.f]) if clause.f else ()
    return SDC(
        clause.type,
        (),
        tuple([spans[i] for i in clause.relation]),
        figure if figure or clause.type != "EVENT" else IMPLICIT_FIGURE,
        tuple([_freeze(child, spans) for child in clause.l]) if clause.l else (),
        tuple([_freeze(child, spans) for child in clause.l2]) if clause.l2 else (),
    )
