"""Execution of scripts in physics, with a report of the results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from corpus_tools.world.physics import (
    controller,
    forklift_behaviours,  # noqa: F401 - they register
)
from corpus_tools.world.physics.behaviours import (
    ActionError,
    Goal,
    argument_text,
    behave,
    script_arguments,
    step_text,
)
from corpus_tools.world.state.recording import Recording, Step, heading
from corpus_tools.world.state.robot_script import ACTIONS, Script, ScriptStep
from g3.actions.logged_actions import loaded
from g3.geometry.plane import wrap
from g3.groundings import Context, Place
from g3.short_repr import short_repr

NEAR_M = 0.15
NEAR_DEG = 5.0
"""Largest distance of a load or the robot from its goal, in metres and in degrees."""
DISPLACED_M = 0.1
"""Largest displacement of things that no step was to move, in metres."""
PAUSE_S = 1.0
"""The world stands still so long before the first and after the last step."""


@short_repr
@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a step."""

    step: ScriptStep
    goal: Goal | None
    """Goal of the step; None if it had none."""
    error_m: float = 0.0
    error_deg: float = 0.0
    """Distance from the goal at the step's end, in metres, and from its heading, in degrees."""
    lean_deg: float = 0.0
    """Lean of the moved thing, in degrees."""


@short_repr
@dataclass(frozen=True, slots=True)
class Execution:
    """Result of a script."""

    recording: Recording
    """Recording of the execution, to the end or to its failure."""
    outcomes: tuple[Outcome, ...]
    """Outcomes of the executed steps."""
    failure: ActionError | None
    """Reason why the step after those could not be executed; None if all were."""
    handled: frozenset[str] = frozenset()
    """Ids of objects that were on the forks."""
    held: str | None = None
    """Id of the object on the forks at the end."""

    @property
    def problems(self) -> tuple[str, ...]:
        """All that keeps the execution from being as the script wants it."""
        problems = [str(self.failure)] if self.failure else []
        for outcome in self.outcomes:
            if outcome.error_m > NEAR_M or outcome.error_deg > NEAR_DEG:
                problems.append(
                    f"{step_text(outcome.step)}: ended {outcome.error_m:.2f} m and "
                    f"{outcome.error_deg:.1f} degrees from its goal"
                )
            if outcome.lean_deg > np.rad2deg(controller.TILT):
                problems.append(
                    f"{step_text(outcome.step)}: leans by {outcome.lean_deg:.0f} degrees"
                )
        return (*problems, *self._displaced())

    def _displaced(self) -> list[str]:
        start, position = self.recording.start, self.recording.position
        brought = (outcome.goal.thing for outcome in self.outcomes if outcome.goal)
        meant = {start.agent_id, loaded(start), *brought}
        if self.failure is not None:
            return []
        moved = np.linalg.norm(position[-1] - position[0], axis=1)
        return [
            f"{item.id} was displaced by {far:.2f} m"
            for item, far in zip(start.objects, moved, strict=True)
            if far > DISPLACED_M and item.id not in meant
        ]


def execute(
    context: Context,
    script: Script,
    *,
    places: Mapping[str, Place] | None = None,
    rate_hz: float = 50.0,
    forks_m: float = 0.0,
    held: str | None = None,
) -> Execution:
    """Carry out a script in a simulated world.

    The same arguments give the same recording, bit for bit. A step that can't be carried out ends
    it, and is named in the result.

    Parameters
    ----------
    context
        The world at the start; trajectories are followed only to their first pose.
    places
        By the names that the script uses; the context's places by their names if None.
    rate_hz
        Number of states a second in the recording.
    forks_m
        Height of empty forks at the start, in metres.
    held
        Id of the object on the forks at the start; if None, as the context shows.

    Raises
    ------
    CorpusError
        If the script names an action, an object or a place that there isn't, or gives an action
        the wrong kind of argument.
    """
    arguments = script_arguments(context, script, places)
    sim = controller.simulation(context, rate_hz, forks_m, held)
    sim.wait(PAUSE_S)
    steps: list[Step] = []
    outcomes: list[Outcome] = []
    failure = None
    for step, argument in zip(script, arguments, strict=True):
        began = sim.time_s
        try:
            outcomes.append(_outcome(sim, step, behave(sim, step, argument)))
        except ActionError as error:
            failure = error
        said = ((ACTIONS[step.action].argument, argument_text(step)),)
        steps.append(Step(step.action, said, began, sim.time_s))
        if failure is not None:
            break
    if failure is None:
        sim.wait(PAUSE_S)
    recording = replace(sim.recording(), steps=tuple(steps))
    held = sim.load.id if sim.load else None
    return Execution(recording, tuple(outcomes), failure, frozenset(sim.handled), held)


def reached(execution: Execution) -> bool:
    """Check that every step reached its goal and nothing else was moved."""
    return not execution.problems


def _outcome(sim: controller.Simulation, step: ScriptStep, goal: Goal | None) -> Outcome:
    if goal is None:
        return Outcome(step, None)
    xyz, orientation = sim.body_pose(goal.thing)
    return Outcome(
        step,
        goal,
        float(np.linalg.norm(xyz - goal.xyz)),
        float(np.rad2deg(np.abs(wrap(heading(orientation) - goal.yaw)))),
        float(np.rad2deg(sim.lean(goal.thing))),
    )
