"""Actions that move the forks alone, with what is on them."""

from __future__ import annotations

from corpus_tools.world.physics.controller import Simulation
from corpus_tools.world.physics.handling_actions import CARRY_M
from corpus_tools.world.physics.script_actions import behaviour
from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, LIFT_RANGE, LOW
from corpus_tools.world.state.robot_script import LOWER_FORKS, RAISE_FORKS

NOTHING_M = 1e-3
"""Forks that are so near to a height are there."""


@behaviour(RAISE_FORKS)
def raise_forks(sim: Simulation, distance_m: float) -> None:
    """Raise the forks by a distance, or as far as they go."""
    _brought_to(sim, min(sim.forks_m + distance_m, LIFT_RANGE))


@behaviour(LOWER_FORKS)
def lower_forks(sim: Simulation, distance_m: float) -> None:
    """Lower the forks by a distance, or as far as they go; a load stays off the ground."""
    lowest = 0.0 if sim.load is None else ENTRY_HEIGHT - LOW + CARRY_M
    _brought_to(sim, min(max(sim.forks_m - distance_m, lowest), sim.forks_m))


def _brought_to(sim: Simulation, height_m: float) -> None:
    if abs(height_m - sim.forks_m) > NOTHING_M:
        sim.lift(height_m)
