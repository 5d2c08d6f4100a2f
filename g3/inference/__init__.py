"""Inference: from a command and a state to groundings and a plan (section 3.4).

Read `grounder` first: it finds the groundings of OBJECTs and PLACEs (`things`), then action
sequences for EVENTs and PATHs (`search`). `state` is what an action starts from, `actions` what
the robot can do, `motions` how that looks as trajectories, `scene` packs candidates for features,
`scoring` scores them. Importing the package registers the kinds of actions, and what
other distributions name in the entry point group ``g3.actions``.
"""

from g3.extensions import load_extensions
from g3.inference import proposals

__all__ = ["proposals"]

load_extensions("g3.actions")
