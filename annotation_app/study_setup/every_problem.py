"""All that is wrong with the form of a value, where msgspec stops at the first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import msgspec

from corpus_tools.world.scenarios.documents import Field, Problem, convert
from g3.errors import CorpusError, ManyError, unknown_name


def every_problem(value: Any, form: Any, field: Field, manual: str) -> Iterator[Problem]:
    """Yield the faults of a value of a form, with its fields and its elements.

    `field` and `manual` are as :func:`~corpus_tools.world.scenarios.documents.convert` has them.
    """
    parts = list(_parts(value, form, field))
    for inner, of_part, where in parts:
        yield from every_problem(inner, of_part, where, manual)
    if isinstance(value, dict) and (record := _record(form)) is not None:
        fields = msgspec.structs.fields(record)
        names = {known.encode_name for known in fields}
        for name in value.keys() - names:
            _, fix = unknown_name("field", name, sorted(names))
            yield Problem((*field, name), "there is no such field", fix)
        for known in fields:
            if known.required and known.encode_name not in value:
                what = f"the field {known.encode_name!r} is missing"
                yield Problem(field, what, f"see {manual} for the form")
    elif not parts and isinstance(problem := convert(value, form, field, manual), Problem):
        yield problem


def together(errors: Iterable[CorpusError]) -> CorpusError:
    """Return several errors as one."""
    every = [one for error in errors for one in apart(error)]
    return every[0] if len(every) == 1 else ManyError(every)


def apart(error: CorpusError) -> Sequence[CorpusError]:
    """Return the errors that an error combines, else only itself."""
    return error.errors if isinstance(error, ManyError) else (error,)


@contextmanager
def gathering(errors: list[CorpusError]) -> Iterator[None]:
    """Keep what goes wrong, and continue."""
    try:
        yield
    except CorpusError as error:
        errors += apart(error)


def _parts(value: Any, form: Any, field: Field) -> Iterator[tuple[Any, Any, Field]]:
    """Yield the fields or elements of a value that have a type."""
    form = _plain(form)
    if isinstance(value, dict) and (record := _record(form)) is not None:
        for known in msgspec.structs.fields(record):
            if known.encode_name in value:
                name = known.encode_name
                yield value[name], known.type, (*field, name)
    elif isinstance(value, dict) and get_origin(form) is dict:
        of_value = get_args(form)[1]
        yield from ((inner, of_value, (*field, key)) for key, inner in value.items())
    elif isinstance(value, list) and get_origin(form) is tuple and get_args(form)[1:] == (...,):
        of_element = get_args(form)[0]
        yield from ((inner, of_element, (*field, i)) for i, inner in enumerate(value))


def _record(form: Any) -> type[msgspec.Struct] | None:
    """Return the struct that a type is, or may be."""
    plain = _plain(form)
    options = get_args(plain) if get_origin(plain) in (Union, UnionType) else (plain,)
    for one in options:
        if isinstance(one, type) and issubclass(one, msgspec.Struct):
            return one
    return None


def _plain(form: Any) -> Any:
    return get_args(form)[0] if get_origin(form) is Annotated else form
