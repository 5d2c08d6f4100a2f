"""One page has all hooks."""

from __future__ import annotations

import gc
import re
from pathlib import Path

import pytest

from ct import hooks
from g3.registry import Registry

ROOT = Path(__file__).parents[2]
OBJECTS = {"ct.commands", "ct.checks", "g3.models"}
"""Groups whose entry points are the objects themselves."""


@pytest.fixture(scope="module")
def groups() -> set[str]:
    return {group for group, _ in hooks.HOOKS.values()}


def test_each_hook_is_a_function():
    assert sorted(hooks.HOOKS) == hooks.__all__
    assert all(callable(getattr(hooks, name)) for name in hooks.__all__)
    with pytest.raises(AttributeError, match="no attribute 'smell'"):
        _ = hooks.smell


def test_each_registry_of_the_program_has_a_hook(groups):
    for name in hooks.__all__:
        getattr(hooks, name)
    registries = [thing for thing in gc.get_objects() if isinstance(thing, Registry)]
    assert {r.group for r in registries if r.group.startswith(("ct.", "g3."))} == groups


def test_the_documentation_lists_all_groups(groups):
    page = (ROOT / "docs/architecture.md").read_text()
    table = page[page.index("## How to add") : page.index("## Decisions")]
    named = set(re.findall(r"`((?:ct|g3)\.[a-z]+)`", table)) - {"ct.hooks"}
    assert named >= groups | (OBJECTS - {"g3.models"})
