"""Plans as scripts that are kept in a file, to be carried out later."""

from __future__ import annotations

import hashlib
import json

import msgspec
import numpy as np

from corpus_tools.following.bundled_grounder import to_script
from corpus_tools.world.state.robot_script import Script
from g3.actions.action_kinds import Action
from g3.actions.robot_state import State
from g3.groundings import Place, Prism

DIGITS = 3
"""Plans whose numbers agree to so many digits, in metres and degrees, are the same."""


class KeptPlace(msgspec.Struct, frozen=True):
    """A place that a script names: corners in metres, heights of bottom and top."""

    xy: tuple[tuple[float, float], ...]
    z_min: float
    z_max: float
    name: str = ""


class PlanScript(msgspec.Struct, frozen=True):
    """What a plan has the robot do.

    Parameters
    ----------
    kept_places
        By the names that the steps use.
    """

    steps: Script
    kept_places: dict[str, KeptPlace] = {}

    @property
    def places(self) -> dict[str, Place]:
        """The places by their names, as :func:`~corpus_tools.world.physics.execute` takes them."""
        return {
            key: Place(Prism(np.array(p.xy), p.z_min, p.z_max), p.name)
            for key, p in self.kept_places.items()
        }

    @property
    def digest(self) -> str:
        """The same for plans that do the same."""
        text = json.dumps(_rounded(msgspec.to_builtins(self)), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:10]


def script_of(start: State, actions: tuple[Action, ...]) -> PlanScript:
    """Write a plan as a script."""
    told = to_script(start, actions)
    places = {
        key: KeptPlace(
            tuple((float(x), float(y)) for x, y in place.prism.xy),
            float(place.prism.z_min),
            float(place.prism.z_max),
            place.name,
        )
        for key, place in told.places.items()
    }
    return PlanScript(told.script, places)


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return round(value, DIGITS) + 0.0  # -0.0 is 0.0
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    return value
