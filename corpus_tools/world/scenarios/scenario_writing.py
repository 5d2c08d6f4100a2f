"""Scenarios as the YAML that people would write."""

from __future__ import annotations

import json
import re
from typing import Any

import msgspec

from corpus_tools.world.scenarios.scenario import Region, Robot, Scenario, Thing

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9]*([ -][A-Za-z0-9]+)*")
_WORDS = {"null", "true", "false"}
_WHOLE = 1e15


def format_scenario(scenario: Scenario) -> str:
    """The text of a scenario's file; reading it gives the scenario again."""
    lines = [f"title: {_title(scenario.title)}", f"layout: {_scalar(scenario.layout.name)}"]
    for section, items in (("objects", scenario.objects), ("places", scenario.places)):
        if items:
            lines.append(f"{section}:")
            lines += [f"  {name}: {_flow(item)}" for name, item in items.items()]
    lines.append(f"robot: {_flow(scenario.robot)}")
    lines.append("script:")
    lines += [f"  - {step.action}: {_scalar(step.argument)}" for step in scenario.script]
    return "\n".join(lines) + "\n"


def _flow(item: Thing | Region | Robot) -> str:
    defaults = {field.name: field.default for field in msgspec.structs.fields(item)}
    values = msgspec.structs.asdict(item)
    written = (f"{k}: {_scalar(v)}" for k, v in values.items() if v != defaults[k])
    return "{" + ", ".join(written) + "}"


def _title(text: str) -> str:
    """A sentence without quotes where its words, commas and full stop need none."""
    words = text.removesuffix(".").replace(", ", " ")
    return text if _scalar(words) == words else json.dumps(text)


def _scalar(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_scalar, value)) + "]"
    if isinstance(value, float | int):
        # JSON's numbers are YAML's too.
        return f"{value:.0f}" if value == int(value) and abs(value) < _WHOLE else repr(value)
    text = str(value)
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if plain else json.dumps(text)
