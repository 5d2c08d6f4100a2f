"""One thread for linear algebra: the parser's matrices are short."""

from __future__ import annotations

from contextlib import AbstractContextManager

import numpy as np  # noqa: F401 - its BLAS is looked for below
from threadpoolctl import ThreadpoolController

_BLAS = ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Limit NumPy's BLAS to one thread: more cost more than they bring on a busy machine."""
    limiter: AbstractContextManager[object] = _BLAS.limit(limits=1, user_api="blas")
    return limiter
