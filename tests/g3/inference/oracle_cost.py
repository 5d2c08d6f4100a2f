"""A cost that knows what is right, which shows whether the search can reach it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from g3.features.bodies import Bodies, IntArray
from g3.features.factor_batch import FactorBatch
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray, PhysicalObject
from g3.sdc.clauses import SDC_TYPES

RIGHT, WRONG = np.log(0.95), -10.0


@dataclass(frozen=True)
class OracleCost:
    """Prefers what is right by far, and nothing else.

    Parameters
    ----------
    things
        The things that an OBJECT means, by one of its words.
    places
        Which of points x, y, z (n, 3) are where a PLACE may be; shape (n,).
    load
        Which of the context's objects is to end there; -1 for none.
    """

    things: Mapping[str, Sequence[PhysicalObject]]
    places: Callable[[FloatArray], BoolArray]
    load: int = -1

    def log_probability(self, batch: FactorBatch, *, true: bool = True) -> FloatArray:
        """Near 0 for what is right."""
        kind = SDC_TYPES[int(batch.type[0])]
        bodies, right = batch.bodies, np.ones(len(batch), dtype=bool)
        if kind == "OBJECT":
            words = {word for own in batch.words[0].values() for word in own}
            meant = [things for word, things in self.things.items() if word in words]
            right = _are(bodies, batch.figure, meant[0]) if meant else right
        elif kind == "PLACE":
            figure = batch.figure
            right = self.places(np.column_stack((bodies.centre[figure], bodies.z_min[figure])))
        elif kind == "EVENT" and self.load >= 0:
            right = self.places(bodies.xyz[batch.theme, -1]) & (batch.theme >= 0)
        return np.where(right, RIGHT, WRONG)


def _are(bodies: Bodies, index: IntArray, things: Sequence[PhysicalObject]) -> BoolArray:
    """Which bodies are just these things."""
    middles = np.array([centre(thing.prism) for thing in things])
    members = bodies.members[index]
    apart = np.linalg.norm(members[:, :, None] - middles, axis=-1)
    found = (np.nan_to_num(apart, nan=np.inf) < 1e-3).any(axis=1).all(axis=1)
    return found & (bodies.count[index] == len(things))
