"""What a plan's picture marks in the scene: what clauses mean, and the ways that are driven."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from g3.actions.action_kinds import Action, move, result
from g3.actions.robot_state import State
from g3.groundings import Grounding, Place, Trajectory, object_ids
from g3.scene_drawing import Marks


def plan_marks(
    start: State, actions: Sequence[Action], groundings: Iterable[Sequence[Grounding]]
) -> Marks:
    """Mark groundings, where loads are put down, and the robot's way in each action."""
    groups = list(groundings)
    places = [g for group in groups for g in group if isinstance(g, Place)]
    places += [a.place for a in actions if a.place is not None and a.place not in places]
    things = {name for group in groups for name in object_ids(group)}
    return Marks(things, places, _ways(start, actions))


def _ways(state: State, actions: Sequence[Action]) -> list[Trajectory]:
    ways = []
    for action in actions:
        motion = move(state, [action])
        ways.append(Trajectory(motion.t[0], motion.xyz[0], motion.yaw[0]))
        state = result(state, action, motion, 0)
    return ways
