"""Functions as machine code, for sums over many pairs of shapes.

A step on arrays reads and writes all of them; machine code keeps what it needs of a pair in
registers. Numba takes half a second to load: a module that compiles is imported where it is
first needed. Numba comes with the extra ``speed``; without it, such sums are made on arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, TypeVar, cast

HAS_COMPILER = find_spec("numba") is not None
"""True if Numba is installed."""

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(signature: str) -> Callable[[Function], Function]:
    """Compile a function of numbers and arrays. It runs without Python's lock; threads may call it.

    The machine code is kept beside the function's module, or in the user's folder for caches; where
    neither can be written to, each process makes its own. The signature has the types of result and
    arguments as Numba writes them: ``f8(f8[:, ::1], i8)``.
    """

    def decorate(function: Function) -> Function:
        try:
            return _compile(function, signature, keep=True)
        except RuntimeError:  # there is no folder to keep it in
            return _compile(function, signature, keep=False)

    return decorate


def _compile(function: Function, signature: str, *, keep: bool) -> Function:
    import numba  # noqa: PLC0415 - comes with the extra "speed"

    make = numba.njit(signature, cache=keep, nogil=True, error_model="numpy")
    return cast("Function", make(function))
