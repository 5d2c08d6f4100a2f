"""Words and clauses of commands in the form of pages, and the order of questions about them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from annotation_app.store.models import Record
from g3.sdc.clauses import SDC, Field, all_words, breadth_first, child_indices

if TYPE_CHECKING:
    from g3.language.discourse.anaphora import Anaphor

WORD = re.compile(r"\w+(?:[-'’]\w+)*|[^\w\s]")
HAPPENING = ("EVENT", "PATH")
"""The types of clauses that say what happens, which videos show."""
INDEFINITE = {"a", "an", "another", "one", "some", "something"}
"""First words of phrases that mean another thing each time."""


def words_of(text: str) -> Iterator[dict[str, Any]]:
    """Yield the words of a command and their starts."""
    return ({"start": m.start(), "text": m[0]} for m in WORD.finditer(text))


def phrase_of(sdc: SDC) -> str:
    """Return all words of a clause."""
    return " ".join(word.text for word in all_words(sdc))


def clauses_of(sdcs: tuple[SDC, ...]) -> list[Record]:
    """Return the clauses that words name: ``node`` (breadth first), ``type`` and ``phrase``."""
    return [
        {"node": node, "type": sdc.type, "phrase": phrase_of(sdc)}
        for node, sdc in enumerate(breadth_first(sdcs))
        if not sdc.is_implicit
    ]


def asked_clauses(sdcs: tuple[SDC, ...]) -> list[Record]:
    """Return the clauses that words name, in the order of the questions about them.

    Things and places come first, as the command names them: the parts of a clause before the
    clause, and a pronoun's possible referents before the pronoun. EVENTs and PATHs follow, each
    EVENT before its PATHs.

    Each record has the fields of :func:`clauses_of`, and

    - ``several``: true if its words name several things;
    - ``follows``: an OBJECT that probably is the same thing, so that nobody need be asked;
    - ``at``: the OBJECT that a PLACE is described by, which is all that a picture shows of it;
    - ``during``: the EVENT that a PATH or an EVENT is within.

    The last three are None where there is none.
    """
    from g3.language.discourse.anaphora import anaphors  # noqa: PLC0415 - slow to import
    from g3.language.discourse.groups import group  # noqa: PLC0415 - as above

    nodes = list(breadth_first(sdcs))
    known = {clause["node"]: clause for clause in clauses_of(sdcs)}
    references = anaphors(sdcs)
    events, sources = _events(sdcs, nodes), _sources(sdcs, nodes, known, references)
    return [
        {
            **known[node],
            "several": nodes[node].type == "OBJECT" and group(nodes[node]).number == "plural",
            "follows": sources.get(node),
            "at": _told_by(node, nodes, child_indices(sdcs)[node]),
            "during": events.get(node),
        }
        for node in (*_things(sdcs, nodes, known, references), *_happenings(nodes, known))
    ]


def _sources(
    sdcs: tuple[SDC, ...],
    nodes: Sequence[SDC],
    known: Mapping[int, Record],
    references: Sequence[Anaphor],
) -> Mapping[int, int]:
    """Return the OBJECT from whose thing that of another one follows.

    It is the OBJECT around a thing that is described, the antecedent of "it", or the first of
    several with the same words.
    """
    found: dict[int, int] = {}

    def add(node: int, source: int) -> None:
        chain = source
        while chain in found:
            chain = found[chain]
        if {node, source} <= known.keys() and node not in found and chain != node:
            found[node] = source

    objects = [node for node in known if nodes[node].type == "OBJECT"]
    for node, children in enumerate(child_indices(sdcs)):
        figures = children.get("f", ())
        if nodes[node].type == "OBJECT" and len(figures) == 1:
            add(figures[0], node)
    for anaphor in references:
        if anaphor.kind == "same" and anaphor.antecedents:
            add(anaphor.index, anaphor.antecedents[0].index)
    first: dict[str, int] = {}
    for node in sorted(objects, key=lambda node: _extent(nodes[node])):
        words = phrase_of(nodes[node]).casefold()
        if words.split(" ")[0] not in INDEFINITE and first.setdefault(words, node) != node:
            add(node, first[words])
    return found


def _told_by(
    node: int, nodes: Sequence[SDC], children: Mapping[Field, Sequence[int]]
) -> int | None:
    landmarks = [*children.get("l", ()), *children.get("l2", ())]
    is_told = nodes[node].type == "PLACE" and "f" not in children and len(landmarks) == 1
    return landmarks[0] if is_told and nodes[landmarks[0]].type == "OBJECT" else None


def _things(
    sdcs: tuple[SDC, ...],
    nodes: Sequence[SDC],
    known: Mapping[int, Record],
    references: Sequence[Anaphor],
) -> Iterator[int]:
    """Yield things and places, by their words' ends; each after the clauses that it needs."""
    parts = [[c for group in of.values() for c in group] for of in child_indices(sdcs)]
    needed = {a.index: [one.index for one in a.antecedents] for a in references}
    order = sorted(
        (node for node in known if nodes[node].type not in HAPPENING),
        key=lambda node: _extent(nodes[node])[1:],
    )
    begun: set[int] = set()

    def before_and(node: int) -> Iterator[int]:
        if node in begun:
            return
        begun.add(node)
        for other in (*parts[node], *needed.get(node, ())):
            yield from before_and(other)
        if node in known and nodes[node].type not in HAPPENING:
            yield node

    for node in order:
        yield from before_and(node)


def _happenings(nodes: Sequence[SDC], known: Mapping[int, Record]) -> list[int]:
    """Return the nodes of EVENTs and PATHs by their words' starts, the longer first if equal."""
    found = [node for node in known if nodes[node].type in HAPPENING]
    extents = {node: _extent(nodes[node]) for node in found}
    return sorted(found, key=lambda node: (extents[node][0], -extents[node][2]))


def _extent(sdc: SDC) -> tuple[int, int, int]:
    """Return the beginning and end of a clause's words, and their number."""
    words = all_words(sdc)
    starts, ends = [word.start for word in words], [word.end for word in words]
    return min(starts, default=0), max(ends, default=0), len(words)


def _events(sdcs: tuple[SDC, ...], nodes: Sequence[SDC]) -> Mapping[int, int]:
    """Return the EVENT that each PATH, and each other EVENT, is within."""
    inside: dict[int, int] = {}
    for node, of in enumerate(child_indices(sdcs)):
        event = node if nodes[node].type == "EVENT" else inside.get(node)
        if event is not None:
            inside |= {child: event for children in of.values() for child in children}
    return {node: event for node, event in inside.items() if nodes[node].type in HAPPENING}
