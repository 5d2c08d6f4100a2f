"""A program that asks a language model about many commands, to be killed: URL FOLDER COUNT."""

from __future__ import annotations

import sys

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


if __name__ == "__main__":
    url, folder, count = sys.argv[1:]
    endpoint = Endpoint(url, "test-model", folder, timeout_s=10)
    LanguageModelGrounder(endpoint).prepare(tasks(int(count)), lambda *told: None)
    sys.stdout.write("done\n")
