"""Inference: from a command and a state to groundings and a plan (section 3.4).

Read `grounder` first: it finds the groundings of OBJECTs and PLACEs (`things`), then action
sequences for EVENTs and PATHs (`search`). `state` is what an action starts from, `actions` what
the robot can do, `motions` how that looks as trajectories, `scene` packs candidates for features,
`scoring` scores them. `potentials` is the catalogue of hand-written rules. Importing the package
registers the kinds of actions and the potentials, and what other distributions name in the entry
point groups ``g3.actions`` and ``g3.potentials``.
"""

from g3.extensions import load_extensions
from g3.inference import (
    changes,
    clauses,
    directions,
    loaded,
    meant,
    places,
    proposals,
    referents,
    rows,
    salience,
    sides,
)

__all__ = [
    "changes",
    "clauses",
    "directions",
    "loaded",
    "meant",
    "places",
    "proposals",
    "referents",
    "rows",
    "salience",
    "sides",
]

load_extensions("g3.actions")
load_extensions("g3.potentials")
