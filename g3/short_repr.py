"""Short reprs: what an object is, in a line, however much it holds.

A dataclass's own repr repeats all that is in it. Of a corpus that is megabytes, and a notebook that
shows one hangs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from itertools import islice
from pathlib import PurePath
from typing import Any, TypeVar

T = TypeVar("T")

LONGEST = 1000
"""Characters of a repr."""
TEXT = 60
"""Characters of a text in it."""
FEW = 3
"""Items that are shown one by one; more are counted."""


def short_repr(cls: type[T]) -> type[T]:
    """Give a class with fields a repr that is short, and is made without looking at all it holds.

    Fields that are at their default are left out, as are those that have no part in a repr. Put it
    above ``@dataclass``, or above a :class:`msgspec.Struct`.
    """
    cls.__repr__ = _repr  # type: ignore[method-assign]
    return cls


def _repr(self: Any) -> str:
    inside = ", ".join(f"{name}={brief(getattr(self, name))}" for name in _shown(self))
    return f"{type(self).__name__}({shortened(inside, LONGEST)})"


def _shown(self: Any) -> Iterator[str]:
    if not is_dataclass(self):
        yield from self.__struct_fields__
        return
    for field in fields(self):
        if field.repr and getattr(self, field.name) is not field.default:
            yield field.name


def brief(value: object, *, inside: bool = False) -> str:
    """Describe a value in a few words; of one `inside` another its own items aren't shown."""
    if value is None or isinstance(value, (bool, int, float, complex)):
        return shortened(repr(value), TEXT)
    if isinstance(value, (str, PurePath)):
        return shortened(repr(str(value)[: TEXT + 1]), TEXT)
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        return f"<{value.dtype} {value.shape}>" if value.shape else str(value)
    if isinstance(value, Collection) and not is_dataclass(value):
        return _of_items(value, inside=inside)
    if callable(value):
        return shortened(getattr(value, "__qualname__", type(value).__name__), TEXT)
    return f"{type(value).__name__}({_called(value)})"


def _of_items(value: Collection[object], *, inside: bool) -> str:
    count = len(value)
    if not count:
        return "{}" if isinstance(value, Mapping) else "()"
    if inside or count > FEW:
        kinds = {type(item).__name__ for item in islice(value, FEW)}
        what = kinds.pop() if len(kinds) == 1 and not isinstance(value, Mapping) else "items"
        return f"<{count} {what}>"
    if isinstance(value, Mapping):
        pairs = (f"{brief(k, inside=True)}: {brief(v, inside=True)}" for k, v in value.items())
        return f"{{{', '.join(pairs)}}}"
    return f"({', '.join(brief(item, inside=True) for item in value)})"


def _called(value: object) -> str:
    """Return the name of an object: the first of its fields, if that is a text."""
    if not is_dataclass(value) or not fields(value):
        return "..."
    first = getattr(value, fields(value)[0].name, None)
    return brief(first) if isinstance(first, str) else "..."


def shortened(text: str, longest: int) -> str:
    """Shorten a text that is longer than a limit."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
