"""Actions of plans in words."""

from __future__ import annotations

import numpy as np

from g3.inference.actions import Action
from g3.inference.grounder import object_ids


def described(action: Action) -> str:
    """What an action does, and to what."""
    target = " and ".join(object_ids(action.target)) or ("a place" if action.target else "")
    words = [action.kind, action.object_id, target]
    if action.place is not None:
        x, y = action.place.prism.xy.mean(axis=0)
        name = action.place.name or f"({x:.1f}, {y:.1f})"
        words.append(f"at {name}, {action.place.prism.z_min:.1f} m up")
    if action.kind == "turn":
        words.append(f"{np.rad2deg(action.amount):.0f} degrees")
    return " ".join(word for word in words if word)
