"""A program that asks a language model about many commands, to be killed."""

from __future__ import annotations

from pathlib import Path

from eval.language_model.chat_endpoint import Endpoint
from eval.language_model.model_answers import LanguageModelGrounder
from eval.table_3.grounder_registry import PlanTask
from g3.actions.robot_state import loads_of_context, start_state
from tests.worlds import scene, thing


def tasks(count: int) -> list[PlanTask]:
    """Commands of which each is another request."""
    start = start_state(scene(thing("p1", "tire pallet", 6, 0, (1.2, 1.2))))
    loads = loads_of_context(start.context)
    return [PlanTask(f"Lift the tire pallet, {n}.", start, loads, f"c{n}") for n in range(count)]


def ask(url: str, folder: Path, count: int) -> None:
    """Prepare answers to so many commands."""
    endpoint = Endpoint(url, "test-model", str(folder), timeout_s=10)
    LanguageModelGrounder(endpoint).prepare(tasks(count), lambda *told: None)
