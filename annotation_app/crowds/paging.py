"""Lists of platforms, read to their end: each entry once, and no rest forgotten."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any

from annotation_app.crowds.platform import PlatformError
from annotation_app.store.models import Record

MOST_EMPTY = 3
"""Number of empty pages in a row after which a list that promises more has ended."""


@dataclass(frozen=True, slots=True)
class Page:
    """A part of a list.

    Parameters
    ----------
    entries
        Entries as the platform sent them.
    place
        Place of the next page; None after the last one.
    count
        Number of entries of the list by the platform; None if it reports none.
    """

    entries: Sequence[Any]
    place: Hashable | None = None
    count: int | None = None


def read_pages(read: Callable[[Any], Page], key: str, where: str) -> list[Record]:
    """Read a list page by page.

    It ends where no page follows, where a page follows that was read before, and at a page whose
    entries were all there before.

    Parameters
    ----------
    read
        Gives the page at a place; the first one is at None.
    key
        The field that has an entry's id. Entries without one are other people's, and left out.
    where
        The list, for people.

    Returns
    -------
    list of Record
        The entries; of those with the same id the last.

    Raises
    ------
    PlatformError
        If fewer entries came than the platform counts.
    """
    entries: dict[str, Record] = {}
    places: set[Hashable] = {None}
    place: Hashable | None = None
    count, nameless, empty = 0, 0, 0
    while True:
        page = read(place)
        named = {e[key]: e for e in page.entries if isinstance(e, dict) and _is_id(e.get(key))}
        is_repeated = bool(page.entries) and bool(named) and named.keys() <= entries.keys()
        entries |= named
        nameless += sum(not (isinstance(e, dict) and _is_id(e.get(key))) for e in page.entries)
        count = count if page.count is None else page.count
        empty = 0 if page.entries else empty + 1
        place = page.place
        if place in places or is_repeated or empty == MOST_EMPTY:
            break
        places.add(place)
    if count > len(entries) + nameless:
        raise PlatformError(
            f"the list has {count} entries, and only {len(entries) + nameless} of them came",
            where=where,
            fix="nothing was done; try again in some minutes",
        )
    return list(entries.values())


def _is_id(value: Any) -> bool:
    return isinstance(value, str) and bool(value)
