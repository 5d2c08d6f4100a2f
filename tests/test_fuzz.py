"""A sample of the damaged files of `tests.fuzz`: no reader fails, or takes damage for sense."""

from __future__ import annotations

import os

import pytest

from tests.fuzz import READERS, fuzz

COUNT = int(os.environ.get("CT_FUZZ_FILES", "40"))
"""How many damaged files each reader gets."""


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_refused_by_name_or_mean_what_was_written(name: str) -> None:
    outcome = fuzz(name, COUNT, seed=3)
    assert outcome.failures == []
    assert outcome.unexpected == outcome.misread == 0
    assert outcome.refused > 0
    assert outcome.tried == outcome.refused + outcome.accepted >= COUNT // 2
