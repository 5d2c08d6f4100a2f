"""Inputs from public reports of similar programs, in a folder beside the checkout."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def case(name: str) -> Path:
    """Return the folder of an input, or skip the test where the folder isn't there."""
    for folder in ROOT.parents:
        found = folder / "shared" / "cases" / name
        if found.exists():
            return found
    pytest.skip("the folder shared/cases is not there")
