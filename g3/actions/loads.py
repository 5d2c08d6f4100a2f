"""What the forks can lift: the one definition of a load, for search, negatives and judges.

A scenario's file may say it of a thing (``liftable``). Else size and labels decide: people are no
loads, nor is what is too large, or too small for the forks to go under, such as a drum or a post.
"""

from __future__ import annotations

from functools import lru_cache

from g3.actions.robot_state import State
from g3.errors import ModelError
from g3.geometry.footprints import extent
from g3.groundings import Context, PhysicalObject
from g3.language.lexicon.word_sets import PERSONS
from g3.language.similarity.resources import wordnet
from g3.language.similarity.wordnet import share_of_senses

SMALLEST_M2, LARGEST_M2 = 0.5, 4.0
"""Footprints of loads are between these: a drum or a cone is smaller, a trailer is larger."""
TALLEST_M = 2.4
"""What is taller, such as shelves, stays where it is."""
MOSTLY = 0.7
"""A label names a person if this share of its senses does, by how often each is meant."""


def loads_of_context(context: Context) -> tuple[PhysicalObject, ...]:
    """The things of a world that the forks can lift, in the world's order."""
    return tuple(o for o in context.objects if o.id != context.agent_id and can_be_lifted(o))


def is_load(state: State, object_id: str) -> bool:
    """Whether the forks can lift an object, which isn't the robot."""
    return object_id != state.context.agent_id and can_be_lifted(state.thing(object_id))


def can_be_lifted(thing: PhysicalObject) -> bool:
    """Whether the forks can lift a thing: as its scenario says, else by its size and labels."""
    if thing.liftable is not None:
        return thing.liftable
    length, width, height = extent(thing.prism, float(thing.trajectory.yaw[0])).tolist()
    fits = height <= TALLEST_M and SMALLEST_M2 <= length * width < LARGEST_M2
    return fits and not names_person(thing.labels)


@lru_cache(maxsize=4096)
def names_person(labels: tuple[str, ...]) -> bool:
    """Whether labels are those of a person: by a list, and by what WordNet says of the last one.

    >>> names_person(("operator",)), names_person(("tire", "pallet"))
    (True, False)
    """
    words = [word for label in labels for word in label.lower().split()]
    if not words or PERSONS.intersection(words):
        return bool(words)
    try:
        net = wordnet()
    except ModelError:
        return False
    return share_of_senses(net, words[-1], ("person",)) >= MOSTLY
