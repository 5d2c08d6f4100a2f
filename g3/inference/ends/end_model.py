"""Probability of where each load ends, from all words of a command: evidence without a tree.

A small transformer over the things of a world (Vaswani et al., 2017), which attend to the words of
the command and to each other, says for each load whether it stays, is held, or is put on the
ground, on a thing or beside one. It is learned, with the last layers of the words' encoder, from
commands with their right ends (``python -m benchmarks.end_model``). It is evidence for the plans
that trees lead to (:mod:`g3.inference.calibration`), and proposes another one
(:mod:`g3.inference.ends.proposal`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import NamedTuple

import numpy as np
from scipy.special import log_softmax, logsumexp

from g3.actions.action_kinds import Action
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State
from g3.errors import ModelError
from g3.geometry.footprints import centre
from g3.inference.ends.described import Described, describe, things_of
from g3.language.parsing.encoder import (
    LAYER_FIELDS,
    Encoder,
    Float32Array,
    attend,
    gelu,
    layer_arrays,
    linear,
    normalised,
    with_last_layers,
)
from g3.language.parsing.one_thread import one_thread
from g3.language.parsing.sdc_parser import default_parser
from g3.language.parsing.words import cut
from g3.short_repr import short_repr
from g3.storage.array_file import Array, Field, read_arrays, write_arrays

FILE = "end_model.npz"
STAYS, HELD, GROUND, ON = 0, 1, 2, 3
"""Ends of a load; those of being on each of t things follow, and of being beside each."""
BESIDE_M = 7.0
"""A load is beside a thing whose middle is so near."""
LEAST = -8.0
"""Least evidence: what is quite improbable is no worse than this."""
UNTOLD = -1.5
"""Evidence where there is no text: about its mean for the plans that are chosen."""
HEADS = 6
NO_CARRIER = 6.0
"""Nats against being put on what carries no loads."""
_MATRICES = ("words", "labels", "features", "hidden", "end", "ask", "told", "kind")
_LAYERED = ("square", "inner", "outer", "pairs")
_FIELDS = {
    "robot": Field("<f2", finite=True),
    "norms": Field("<f2", dimensions=3, finite=True),
    "layer_norms": Field("<f2", dimensions=4, finite=True),
    "naming": Field("<f2", dimensions=2, finite=True),
    "square": Field("<f2", dimensions=4, finite=True),
    "square_bias": Field("<f2", dimensions=3, finite=True),
    **{name: Field("<f2", dimensions=3, finite=True) for name in _LAYERED[1:]},
    **{f"{name}_bias": Field("<f2", dimensions=2, finite=True) for name in _LAYERED[1:]},
    **{name: Field("<f2", dimensions=2, finite=True) for name in _MATRICES},
    **{f"{name}_bias": Field("<f2", finite=True) for name in _MATRICES},
}
_ENCODER = "encoder_"
"""Beginning of the names of the encoder's layers in a file."""


class Ends(NamedTuple):
    """Logarithms of the probabilities of the ends of t things, where a command leads.

    Parameters
    ----------
    loads
        Of each thing as a load: `STAYS`, `HELD`, `GROUND`, `ON` each thing, beside each thing;
        shape (t, 3 + 2 t).
    rows
        Rows of the things that can be lifted.
    """

    loads: Float32Array
    rows: Sequence[int]


@short_repr
@dataclass(frozen=True, eq=False)
class EndModel:
    """The transformer's weights, by name; d is its width.

    Parameters
    ----------
    weights
        Matrices (out, in) with their biases, those of layers stacked.
    encoder
        What gives words their vectors.
    """

    weights: Mapping[str, Float32Array]
    encoder: Encoder

    def ends(self, seen: Described) -> Ends:
        """Return the probabilities of all ends.

        Parameters
        ----------
        seen
            The command and the world.
        """
        w, norms = self.weights, self.weights["norms"]
        words = normalised(self._linear(seen.words, "words"), *norms[0])
        x = self._linear(gelu(self._linear(seen.features, "features")), "hidden")
        x = np.vstack((w["robot"], x + self._linear(seen.labels, "labels")))
        named = np.vstack((np.zeros_like(seen.naming[:1]), seen.naming))
        pairs = np.pad(seen.pairs, ((1, 0), (1, 0), (0, 0)))
        for number in range(len(w["inner"])):
            x = self._layer(number, x, words, named, pairs)
        things = normalised(x, *norms[1])[1:]
        count, d = things.shape
        ask = self._linear(things, "ask").reshape(count, 2, d).transpose(1, 0, 2)
        told = self._linear(things, "told").reshape(count, 2, d).transpose(1, 2, 0)
        at = ask @ told / np.float32(np.sqrt(d)) + self._linear(things, "kind").T[..., None]
        at[0] -= NO_CARRIER * ~seen.carriers
        at[:, range(count), range(count)] = -np.inf
        return Ends(
            log_softmax(np.hstack((self._linear(things, "end"), *at)), axis=1),
            np.flatnonzero(seen.loads).tolist(),
        )

    def _linear(self, x: Float32Array, name: str) -> Float32Array:
        return linear(x, (self.weights[name], self.weights[f"{name}_bias"]))

    def _layer(
        self,
        number: int,
        x: Float32Array,
        words: Float32Array,
        named: Float32Array,
        pairs: Float32Array,
    ) -> Float32Array:
        w = self.weights
        own = {name: (w[name][number], w[f"{name}_bias"][number]) for name in _LAYERED}
        norms = w["layer_norms"][number]
        square = list(zip(*own["square"], strict=True))
        y = normalised(x, *norms[0])
        keys, values = linear(words, square[1]), linear(words, square[2])
        bias = w["naming"][number][:, None, None] * named
        mixed = attend(linear(y, square[0]), keys, values, HEADS, bias)
        x = x + linear(mixed, square[3])
        y = normalised(x, *norms[1])
        keys, values = linear(y, square[5]), linear(y, square[6])
        bias = np.ascontiguousarray(linear(pairs, own["pairs"]).transpose(2, 0, 1))
        mixed = attend(linear(y, square[4]), keys, values, HEADS, bias)
        x = x + linear(mixed, square[7])
        return x + linear(gelu(linear(normalised(x, *norms[2]), own["inner"])), own["outer"])

    def to_bytes(self) -> bytes:
        """Write the weights in half precision, and the encoder's own layers, as NumPy arrays."""
        arrays: dict[str, Array] = {n: v.astype(np.float16) for n, v in self.weights.items()}
        changed = self.encoder.changed
        layers = layer_arrays(self.encoder.layers[-changed:], self.encoder.norms[-4 * changed :])
        arrays |= {_ENCODER + name: array for name, array in layers.items()}
        return write_arrays(arrays, sealed=True)

    @classmethod
    def from_bytes(cls, content: bytes, *, where: str = FILE) -> EndModel:
        """Read what :meth:`to_bytes` wrote.

        Raises
        ------
        ModelError
            If it is damaged.
        """
        fix = "install the program again"
        fields = _FIELDS | {_ENCODER + name: own for name, own in LAYER_FIELDS.items()}
        arrays = read_arrays(content, fields, where=where, fix=fix, error=ModelError)
        layers = {name: arrays[_ENCODER + name] for name in LAYER_FIELDS}
        try:
            encoder = with_last_layers(default_parser().encoder_, layers)
        except (ValueError, IndexError) as error:
            raise ModelError(f"its encoder can't be read: {error}", where=where, fix=fix) from error
        return cls({name: arrays[name].astype(np.float32) for name in _FIELDS}, encoder)


@lru_cache(maxsize=1)
def default_end_model() -> EndModel:
    """Return the bundled model, read once."""
    content = (resources.files("g3.inference.ends") / FILE).read_bytes()
    return EndModel.from_bytes(content)


def ends_of(text: str, state: State, model: EndModel | None = None) -> Ends | None:
    """Return where a text says that things end; None without words or things.

    Parameters
    ----------
    text
        A command.
    state
        The state in which it is given.
    model
        The model; None for the bundled one.
    """
    words = cut(text)
    if not words.forms or not things_of(state):
        return None
    model = model or default_end_model()
    with one_thread():
        return model.ends(describe(words, state, model.encoder))


def end_evidence(ends: Ends, actions: Sequence[Action], end: State, start: State) -> float:
    """Return the logarithm of the probability of where a plan leads, from `LEAST` to 0.

    Parameters
    ----------
    ends
        Probabilities of all ends.
    actions
        Actions of the plan.
    end, start
        The states after and before it.
    """
    told = plan_ends(ends.rows, actions, end, start)
    total = sum(float(logsumexp(ends.loads[row, own])) for row, own in told.items())
    return max(total, LEAST)


def plan_ends(
    rows: Sequence[int], actions: Sequence[Action], end: State, start: State
) -> dict[int, list[int]]:
    """Return the ends of each load that are those of a plan, by its row among the things.

    Parameters
    ----------
    rows
        Rows of the loads.
    actions
        Actions of the plan.
    end, start
        The states after and before it.
    """
    handled = {action.object_id for action in actions} - {""}
    things = things_of(start)
    return {
        row: load_ends(row, end, start) if things[row].id in handled else [STAYS] for row in rows
    }


def load_ends(row: int, end: State, start: State) -> list[int]:
    """Return the ends of a handled load that are those of a plan, by its row among the things."""
    things = things_of(start)
    load = things[row].id
    if end.held == load:
        return [STAYS if start.held == load else HELD]
    ids = [thing.id for thing in things]
    below = carrier(end, load)
    if below is not None:
        return [ON + ids.index(below.id)]
    middle = centre(end.thing(load).prism)
    apart = [float(np.linalg.norm(centre(end.thing(name).prism) - middle)) for name in ids]
    beside = [i for i, away in enumerate(apart) if i != row and away < BESIDE_M]
    return [GROUND, *(ON + len(ids) + i for i in beside)]
