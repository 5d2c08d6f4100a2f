"""SDC trees as slu_core writes them, and the records' labels of their clauses.

An SDC (:class:`g3.sdc.clauses.SDC`) is ``{TYPE: {f: ..., r: ..., l: ..., l2: ...}}``. A field
holds an SDC, a list of SDCs, or words: one string that occurs exactly once in the command, or a
list of ``[token, [start, end]]``. The published groundings follow the clauses only after three
normalisations, in this order:

1. words in ``l`` or ``l2`` become OBJECT clauses;
2. words in the ``f`` of an EVENT, and of any other clause that has another field
   filled, become an OBJECT clause;
3. an EVENT without ``f`` gets an empty OBJECT as its figure: the implicit robot.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

from g3.errors import FormatError
from g3.groundings import Grounding
from g3.sdc.clauses import SDC, SDC_TYPES, SDCType, Span, breadth_first

FIELDS = ("f", "r", "l", "l2")


def read_trees(value: Any, text: str) -> tuple[SDC, ...]:
    """Read the clauses of a command, normalised, from a list of SDCs as parsed.

    FormatError if it isn't a list of SDCs, or their words are not in the text.
    """
    if not isinstance(value, list):
        raise _bad("the clauses are not a list", "command[1]", "write a list of SDCs")
    return tuple(_read_sdc(item, text, f"command[1][{i}]") for i, item in enumerate(value))


def _read_sdc(value: Any, text: str, where: str) -> SDC:
    if not isinstance(value, dict) or len(value) != 1:
        raise _bad("this is not an SDC", where, "write {TYPE: {f: ..., r: ..., l: ..., l2: ...}}")
    name, fields = next(iter(value.items()))
    where = f"{where}.{name}"
    if name not in SDC_TYPES:
        raise FormatError.unknown("type of SDC", name, SDC_TYPES, where=where)
    fields = {} if fields is None else fields
    if not isinstance(fields, dict) or not set(fields) <= set(FIELDS):
        raise _bad("the fields are not a mapping of f, r, l and l2", where, "correct their names")
    words, figure = _read_field(fields.get("f"), text, f"{where}.f")
    relation, inner = _read_field(fields.get("r"), text, f"{where}.r")
    if inner:
        raise _bad("a relation holds an SDC", f"{where}.r", "a relation is made of words")
    sdc = SDC(
        type=cast("SDCType", name),
        words=words,
        relation=relation,
        figure=figure,
        landmark1=_landmark(fields.get("l"), text, f"{where}.l"),
        landmark2=_landmark(fields.get("l2"), text, f"{where}.l2"),
    )
    return _with_figure(sdc)


def _landmark(value: Any, text: str, where: str) -> tuple[SDC, ...]:
    words, sdcs = _read_field(value, text, where)
    return (SDC("OBJECT", words=words),) if words else sdcs


def _with_figure(sdc: SDC) -> SDC:
    if sdc.words and (sdc.type == "EVENT" or not sdc.is_leaf):
        sdc = replace(sdc, words=(), figure=(SDC("OBJECT", words=sdc.words),))
    if sdc.type == "EVENT" and not sdc.figure:
        sdc = replace(sdc, figure=(SDC("OBJECT"),))
    return sdc


def _read_field(value: Any, text: str, where: str) -> tuple[tuple[Span, ...], tuple[SDC, ...]]:
    """Read the words or the clauses in a field: at most one of the two is not empty."""
    if value is None:
        return (), ()
    if isinstance(value, str):
        return _find_words(value, text, where), ()
    if isinstance(value, dict):
        return (), (_read_sdc(value, text, where),)
    if isinstance(value, list):
        if all(isinstance(item, dict) for item in value):
            sdcs = (_read_sdc(item, text, f"{where}[{i}]") for i, item in enumerate(value))
            return (), tuple(sdcs)
        spans = (_read_token(item, text, f"{where}[{i}]") for i, item in enumerate(value))
        return tuple(span for token in spans for span in token), ()
    raise _bad(
        f"the field holds a {type(value).__name__}", where, "write words, an SDC or a list of SDCs"
    )


def _find_words(value: str, text: str, where: str) -> tuple[Span, ...]:
    words = value.split()
    if not words:
        return ()
    # The white space between words may differ: YAML folds lines.
    found = list(re.finditer(r"\s+".join(map(re.escape, words)), text))
    if len(found) != 1:
        raise _bad(
            f"{value.strip()!r} occurs {len(found)} times in the command",
            where,
            "write its words as [token, [start, end]]",
        )
    return _split(found[0].group(), found[0].start())


def _read_token(item: Any, text: str, where: str) -> tuple[Span, ...]:
    match item:
        case [str(token), [int(start), int(end)]]:
            pass
        case _:
            raise _bad("this is neither a word nor an SDC", where, "write [token, [start, end]]")
    if start < 0 or text[start:end] != token:
        raise _bad(
            f"{token!r} doesn't stand at {start} to {end} in the command, "
            f"{text[max(start, 0) : end]!r} does",
            where,
            "correct the offsets",
        )
    return _split(token, start)


def _split(words: str, start: int) -> tuple[Span, ...]:
    return tuple(Span(start + m.start(), m.group()) for m in re.finditer(r"\S+", words))


def _bad(what: str, where: str, fix: str) -> FormatError:
    return FormatError(what, where=where, fix=fix)


Groundings = tuple[tuple[Grounding, ...], ...]


def read_groundings(
    record: Any, sdcs: Sequence[SDC], read: Callable[[Any, str], Grounding]
) -> Groundings:
    """Read a record's groundings; FormatError if they don't follow the clauses.

    `read` reads one of them; its second argument says where it stands.
    """
    lists = _aligned(record, "objectGroundings", sum(1 for _ in breadth_first(sdcs)))
    for i, values in enumerate(lists):
        if not isinstance(values, list | None):
            raise FormatError(
                "this is not a list of groundings", where=f"objectGroundings[{i}]", fix="[]"
            )
    return tuple(
        tuple(read(value, f"objectGroundings[{i}][{k}]") for k, value in enumerate(values or []))
        for i, values in enumerate(lists)
    )


def read_labels(
    record: Any, groundings: Groundings, unsaid: bool | None
) -> tuple[bool | None, ...]:
    """Read a record's labels; a missing one is `unsaid` if the clause is grounded at all.

    Raises FormatError if they don't follow the clauses.
    """
    labels = _aligned(record, "groundingIsCorrect", len(groundings))
    for i, label in enumerate(labels):
        if not isinstance(label, bool | None):
            raise FormatError(
                f"{label!r} is not a label",
                where=f"groundingIsCorrect[{i}]",
                fix="use true, false or null",
            )
    return tuple(
        unsaid if label is None and grounded else label
        for label, grounded in zip(labels, groundings, strict=True)
    )


def _aligned(record: Any, name: str, clauses: int) -> list[Any]:
    values = record.get(name)
    if not isinstance(values, list) or len(values) != clauses:
        found = f"{len(values)} entries" if isinstance(values, list) else "no list"
        raise FormatError(
            f"{found} for {clauses} clauses",
            where=name,
            fix="one entry for each clause, breadth first",
        )
    return values
