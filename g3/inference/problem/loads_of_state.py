"""The loads of a state as :mod:`g3.learning.load_choice` sees them, and the words of a command."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from g3.actions.robot_state import State, loads_of_context
from g3.geometry.footprints import centre
from g3.inference.problem.command_tree import Tree
from g3.language.lexicon.field_words import bare
from g3.learning.load_choice import Load
from g3.sdc.clauses import Span, all_words


def loads_of(state: State) -> dict[str, Load]:
    """Return the loads of a state by id."""
    x, y, yaw = state.pose
    found = {}
    for thing in loads_of_context(state.context):
        away = centre(thing.prism) - (x, y)
        bearing = np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - yaw)))
        distance = float(np.linalg.norm(away))
        found[thing.id] = Load(tuple(thing.labels), distance, float(bearing))
    return found


def words_of(tree: Tree, but: Collection[Span] = ()) -> tuple[str, ...]:
    """The words of all clauses but some, in their order in the command."""
    said = {span for sdc in tree.sdcs for span in all_words(sdc)} - set(but)
    spans = {(span.start, span.text) for span in said}
    return tuple(word for _, text in sorted(spans) if (word := bare(text)))
