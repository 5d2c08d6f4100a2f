"""Actions and groundings in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action
from g3.groundings import Grounding, Path, Place, object_ids


def described(action: Action) -> str:
    """Describe an action and its object."""
    target = " and ".join(object_ids(action.target)) or ("a place" if action.target else "")
    words = [action.kind.name, action.object_id, target]
    if action.place is not None:
        words.append(f"at {_spot(action.place)}, {action.place.prism.z_min:.1f} m up")
    if action.kind.unit == "rad":
        words.append(f"{np.rad2deg(action.amount):.0f} degrees")
    elif action.amount:  # also of a kind that mostly has none: "drive away", by so many metres
        words.append(f"{abs(action.amount):.3g} {action.kind.unit or 'm'}")
    return " ".join(word for word in words if word)


def grounded(group: Sequence[Grounding]) -> str:
    """Describe a clause's groundings."""
    if any(isinstance(g, Path) for g in group):
        return "the way there"
    places = [f"the place at {_spot(g)}" for g in group if isinstance(g, Place)]
    return " and ".join((*object_ids(group), *places))


def _spot(place: Place) -> str:
    x, y = place.prism.xy.mean(axis=0)
    return place.name or f"({x:.1f}, {y:.1f})"
