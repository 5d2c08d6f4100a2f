"""Groundings and labels of a record, which follow its clauses breadth first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from g3.errors import FormatError
from g3.groundings import Grounding
from g3.sdc.clauses import SDC, breadth_first

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
    """Read a record's labels; where nothing is said, `unsaid` if the clause is grounded at all.

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
