"""Static word embeddings, which come inside a package and need no network (extra *embeddings*)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from g3.groundings import FloatArray

MISSING = "needs the extra embeddings: pip install 'corpus-tools-g3[embeddings]'"


def is_installed() -> bool:
    """Check that there are embeddings."""
    return find_spec("wordllama") is not None


def identity() -> str:
    """Return an identity of the embeddings: the package and its version."""
    return f"wordllama {version('wordllama')}"


def vectors(texts: Sequence[str]) -> FloatArray:
    """Vectors of words or phrases, each of length 1, shape (texts, dimensions)."""
    found: FloatArray = np.array([_vector(text) for text in texts], dtype=np.float64)
    return found


@cache
def _vector(text: str) -> FloatArray:
    found: FloatArray = _model().embed([text], norm=True)[0]
    return found


@cache
def _model() -> Any:
    import wordllama  # noqa: PLC0415 - an extra

    # Without the folder it looks in another one, and then wants to download.
    folder = Path(wordllama.__file__).parent
    return wordllama.WordLlama.load(cache_dir=folder, disable_download=True)
