"""Random scenarios that can be done."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np

from corpus_tools.world.scenarios.random.random_drafts import Draft, NoRoomError
from corpus_tools.world.scenarios.random.random_tasks import TASKS, add_task
from corpus_tools.world.scenarios.scenario import Layout, Scenario
from corpus_tools.world.scenarios.scenario_validation import scenario_problems
from g3.errors import FormatError
from g3.groundings import Colour

ATTEMPTS = 200
"""Number of attempts at a scenario before the layout counts as full."""
BYSTANDERS = (3, 10)
"""Number of additional things around, from and up to."""
GAPS_M = (0.6, 2.5)
"""Smallest distances between things."""
PAINTED = 0.4
"""The share of crates and boxes that have a colour."""

_KINDS = {
    "tire-pallet": 4,
    "box-pallet": 4,
    "crate": 2,
    "barrel": 2,
    "person": 2,
    "cone": 1,
    "shelf": 1,
    "trailer": 1,
    "truck": 1,
}
"""Relative frequencies of the kinds of things around."""
_PAINTABLE = ("box-pallet", "crate")
_PAINTS: tuple[Colour, ...] = ("red", "blue", "green", "yellow", "white", "black")


def generate(seed: int, number: int, layouts: Mapping[str, Layout]) -> Scenario:
    """Generate the scenario with a number among those of a seed, in one of the layouts.

    It depends on the seed, the number and the layouts alone. The tasks take turns, so that
    scenarios with numbers in a row cover all of them. Nothing is in anything else. The robot has
    lanes to all that it enters or puts down. There is a way with room to turn between all places
    where it must be. FormatError if the layouts have no room.
    """
    rng = np.random.default_rng([seed, number])
    task = TASKS[number % len(TASKS)]
    for _ in range(ATTEMPTS):
        layout = layouts[sorted(layouts)[int(rng.integers(len(layouts)))]]
        draft = Draft(layout, rng)
        try:
            title, script = add_task(draft, task)
        except NoRoomError:
            continue
        _add_bystanders(draft)
        _paint(draft, np.random.default_rng([seed, number, 1]))
        scenario = Scenario(
            id=f"generated-{seed}-{number:04}",
            title=title,
            layout=layout,
            objects=draft.objects,
            places=draft.places,
            robot=draft.robot,
            script=script,
        )
        if not scenario_problems(scenario):
            return scenario
    raise FormatError(
        f"there is no room for scenario {number} ({task.name})",
        where=", ".join(sorted(layouts)),
        fix="use larger or emptier layouts",
    )


def _paint(draft: Draft, rng: np.random.Generator) -> None:
    """Give some loads a colour; where things stand doesn't depend on it."""
    for name, thing in draft.objects.items():
        if thing.kind in _PAINTABLE and rng.random() < PAINTED:
            colour = _PAINTS[int(rng.integers(len(_PAINTS)))]
            draft.objects[name] = msgspec.structs.replace(thing, colours=(colour,))


def _add_bystanders(draft: Draft) -> None:
    rng = draft.rng
    weights = np.array(list(_KINDS.values()), dtype=float)
    low, high = BYSTANDERS
    for _ in range(int(rng.integers(low, high + 1))):
        kind = list(_KINDS)[int(rng.choice(len(_KINDS), p=weights / weights.sum()))]
        gap = float(rng.uniform(*GAPS_M))
        try:
            name = draft.thing(kind, gap, margin_m=1.0)
        except NoRoomError:
            continue
        if not draft.passable():
            del draft.objects[name]
