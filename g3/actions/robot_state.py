"""States: where everything is before an action, and what is on the forks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from g3.actions.logged_actions import at_rest, loaded
from g3.errors import ModelError
from g3.geometry.footprints import extent
from g3.geometry.plane import hull_centre, moved_corners
from g3.groundings import Context, FloatArray, PhysicalObject, Prism, Trajectory
from g3.scene_drawing import scene_svg
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class State:
    """The world between two actions.

    Parameters
    ----------
    context
        The things at their present poses; trajectories are single poses.
    held
        Id of the object on the forks; None if they are empty.
    forks_m
        Height of the forks above their lowest, in metres.
    site
        Surroundings, such as ``hall``; only pictures show them.
    frame
        Origin of the frame in which people see coordinates: x, y and yaw in the context's map. A
        scenario's is its layout's.
    """

    context: Context
    held: str | None
    forks_m: float = 0.0
    site: str = field(default="yard", repr=False, compare=False)
    frame: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), repr=False, compare=False)

    @property
    def pose(self) -> FloatArray:
        """The robot's x, y, yaw."""
        track = self.context.agent.trajectory
        return np.array([*track.xyz[0, :2], track.yaw[0]])

    def _repr_html_(self) -> str:
        """Draw the scene from above."""
        return scene_svg(self.context)

    def thing(self, object_id: str) -> PhysicalObject:
        """Return an object by its id."""
        return next(o for o in self.context.objects if o.id == object_id)


def centres(prisms: Sequence[Prism]) -> FloatArray:
    """Return the middles of footprints, shape (n, 2)."""
    return np.array([hull_centre(p.xy) for p in prisms]).reshape(-1, 2)


def start_state(context: Context) -> State:
    """Return the state in which a context's log starts.

    No log records the height of empty forks: they are down.
    """
    objects = tuple(
        replace(o, trajectory=at_rest(o.trajectory)) if len(o.trajectory) > 1 else o
        for o in context.objects
    )
    held = loaded(context)
    floor = float(context.agent.trajectory.xyz[0, 2])
    bottom = next((o.prism.z_min for o in objects if o.id == held), floor)
    return State(replace(context, objects=objects), held, max(bottom - floor, 0.0))


def moved_to(thing: PhysicalObject, pose: FloatArray, bottom: float) -> PhysicalObject:
    """Carry an object rigidly to a pose x, y, yaw with its bottom at a height."""
    before = np.array([*thing.trajectory.xyz[0, :2], thing.trajectory.yaw[0]])
    corners = moved_corners(thing.prism.xy[None], before[None], pose[None])[0]
    height = thing.prism.z_max - thing.prism.z_min
    lift = bottom - thing.prism.z_min
    xyz = np.array([[*pose[:2], thing.trajectory.xyz[0, 2] + lift]])
    return replace(
        thing,
        prism=Prism(corners, bottom, bottom + height),
        trajectory=Trajectory(np.zeros(1), xyz, pose[2:3]),
    )


def with_moved(
    state: State, moved: dict[str, PhysicalObject], held: str | None, forks_m: float = 0.0
) -> State:
    """Return the state with some objects, by id, at other poses, and the forks' height."""
    objects = tuple(moved.get(o.id, o) for o in state.context.objects)
    context = replace(state.context, objects=objects)
    return replace(state, context=context, held=held, forks_m=forks_m)


SMALLEST_M2, LARGEST_M2 = 0.5, 4.0
"""Footprints of loads are between these: a drum or a cone is smaller, a trailer is larger."""
TALLEST_M = 2.4
"""Height of the tallest load; taller things, such as shelves, stay in place."""
MOSTLY = 0.7
"""A label names a person if this share of its senses does, by how often each is meant."""


def loads_of_context(context: Context) -> tuple[PhysicalObject, ...]:
    """Return the things of a world that the forks can lift, in the world's order."""
    return tuple(o for o in context.objects if o.id != context.agent_id and can_be_lifted(o))


def is_load(state: State, object_id: str) -> bool:
    """Check that an object is a load: the forks can lift it, and it isn't the robot."""
    return object_id != state.context.agent_id and can_be_lifted(state.thing(object_id))


def can_be_lifted(thing: PhysicalObject) -> bool:
    """Check that the forks can lift a thing: as its scenario says, else by its size and labels."""
    if thing.liftable is not None:
        return thing.liftable
    length, width, height = extent(thing.prism, float(thing.trajectory.yaw[0])).tolist()
    fits = height <= TALLEST_M and SMALLEST_M2 <= length * width < LARGEST_M2
    return fits and not names_person(thing.labels)


@lru_cache(maxsize=4096)
def names_person(labels: tuple[str, ...]) -> bool:
    """Check that labels are those of a person: by a list, and by WordNet's senses of the last one.

    >>> names_person(("operator",)), names_person(("tire", "pallet"))
    (True, False)
    """
    # Only planning asks: states, logs and pictures need no words.
    from g3.language.lexicon.tables import WORDS  # noqa: PLC0415
    from g3.language.similarity.resources import wordnet  # noqa: PLC0415
    from g3.language.similarity.wordnet import share_of_senses  # noqa: PLC0415

    words = [word for label in labels for word in label.lower().split()]
    if not words or WORDS["persons"].intersection(words):
        return bool(words)
    try:
        net = wordnet()
    except ModelError:
        return False
    return share_of_senses(net, words[-1], ("person",)) >= MOSTLY
