"""Actions of the robot: kinds, candidate end points, effects, trajectories.

Read :mod:`~g3.actions.action_kinds` first. Importing the package registers the kinds of actions,
and what other distributions name in the entry point group ``g3.actions``.
"""

from g3.actions import forklift_actions
from g3.actions.action_kinds import KINDS

__all__ = ["forklift_actions"]

KINDS.load_others()
