"""Word vectors for the feature set that needs some; none come along."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from g3.language.similarity.resources import VECTORS_VARIABLE


@pytest.fixture(scope="package", autouse=True)
def vectors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    file = tmp_path_factory.mktemp("vectors") / "few.txt"
    file.write_text("pallet 4 3\ntruck -4 3\nbox 3 4\ntire 1 0\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VECTORS_VARIABLE, str(file))
        yield
