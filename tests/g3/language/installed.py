"""What the tests of word similarity need beyond the package."""

from __future__ import annotations

import pytest

from g3.errors import ModelError
from g3.language.similarity.resources import wordnet_identity


def _missing() -> str:
    try:
        wordnet_identity()
    except ModelError as error:
        return str(error)
    return ""


needs_wordnet = pytest.mark.skipif(bool(_missing()), reason=_missing())
