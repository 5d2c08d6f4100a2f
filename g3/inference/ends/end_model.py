"""Probability of where each load ends, from all words of a command: evidence without a tree.

A small transformer over the things of a world (Vaswani et al., 2017), which attend to the words of
the command and to each other, says for each load whether it stays, is held, or is put on the
ground, on a thing or beside one, and on which side; and where the robot ends if no load is moved.
It is asked again with the ends of some loads given, so that "two of them" are two. It is learned,
with the last layers of the words' encoder, from commands with their right ends
(``python -m benchmarks.end_model``). It is evidence for the plans that trees lead to
(:mod:`g3.inference.calibration`), and proposes another one (:mod:`g3.inference.ends.proposal`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from g3.geometry.plane import convex_hull, point_gap, wrap
from g3.geometry.relations import NEAR_M, in_frame, looking_at
from g3.groundings import FloatArray
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
STANDS, ELSEWHERE, AHEAD, BACK, LEFT, RIGHT, AROUND, NEAR = range(8)
"""Ends of the robot where it moves no load: as it stands, further on or back, turned to a side or
around; those of being near each of t things follow from the last on, and of facing each."""
BESIDE_M = 7.0
"""A load is beside a thing whose middle is so near."""
LEAST, LEAST_ROBOT = -6.0, -3.0
"""Least evidence, and least of the robot: what is quite improbable is no worse than this."""
UNTOLD = -1.5
"""Evidence where there is no text: about its mean for the plans that are chosen."""
STEP_M, TURN_RAD = 1.5, np.deg2rad(20)
"""Shorter ways, and smaller turns, are none."""
ROBOT = -1
"""Row of the robot among the things."""
SIDES = ("next to", "to the left of", "to the right of", "in front of", "behind", "between")
"""Where a load is put beside a thing."""
END_TYPES = 5
"""Staying, held, on the ground, on a thing, beside a thing."""
NEARLY_SURE = float(np.log(0.9))
"""Logarithm of the probability from which an end is given together with others."""
HEADS = 6
NO_CARRIER = 6.0
"""Nats against being put on what carries no loads."""
_MATRICES = (
    "words",
    "labels",
    "features",
    "hidden",
    "end",
    "ask",
    "told",
    "kind",
    "decided",
    "side",
    "robot_end",
    "robot_ask",
    "robot_told",
)
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
    """Logarithms of the probabilities of the ends of t things and the robot.

    Parameters
    ----------
    loads
        Of each thing as a load: `STAYS`, `HELD`, `GROUND`, `ON` each thing, beside each thing;
        shape (t, 3 + 2 t).
    robot
        Of the robot, if no load is moved: `STANDS` to `AROUND`, near each thing, facing each;
        shape (7 + 2 t,).
    sides
        Of each of `SIDES` for each thing as a load that is put beside another, shape (t, 6).
    """

    loads: Float32Array
    robot: Float32Array
    sides: Float32Array


class JointEnds:
    """Probability of the ends of all loads together, by the chain rule.

    Parameters
    ----------
    rows
        Rows of the things that can be lifted.
    given
        Function that returns the ends where those of some loads, by row, are known.
    has_robot
        False if nothing is known of the robot's end.
    """

    def __init__(
        self,
        rows: Sequence[int],
        given: Callable[[Mapping[int, int]], Ends],
        *,
        has_robot: bool = True,
    ) -> None:
        self.rows = rows
        self.has_robot = has_robot
        self._given = given
        self._known: dict[frozenset[tuple[int, int]], Ends] = {}

    def given(self, told: Mapping[int, int]) -> Ends:
        """Return the ends where those of some loads, by row, are known."""
        key = frozenset(told.items())
        if key not in self._known:
            self._known[key] = self._given(told)
        return self._known[key]

    def of_loads(self) -> JointEnds:
        """Return the ends of loads alone."""
        return JointEnds(self.rows, self.given, has_robot=False)

    def log_probability(self, ends: Mapping[int, Sequence[int]]) -> float:
        """Return the logarithm of the probability that all loads end so.

        Parameters
        ----------
        ends
            The ends of each load that count as one, of which the most probable one is given for the
            others; by row. Also those of the robot.
        """
        told: dict[int, int] = {}
        robot = [*ends[ROBOT]] if self.has_robot and ROBOT in ends else []
        total = max(float(logsumexp(self.given({}).robot[robot])), LEAST_ROBOT) if robot else 0.0
        left = set(self.rows)
        while left:
            loads = self.given(told).loads
            chance = {row: float(logsumexp(loads[row][[*ends[row]]])) for row in left}
            sure = [row for row in left if chance[row] > NEARLY_SURE]
            for row in sure or [max(left, key=lambda row: (chance[row], -row))]:
                told = {**told, row: max(ends[row], key=lambda end: loads[row][end])}
                total += chance[row]
                left.remove(row)
        return total


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

    def ends(self, seen: Described, known: Mapping[int, int] | None = None) -> Ends:
        """Return the probabilities of all ends.

        Parameters
        ----------
        seen
            The command and the world.
        known
            The ends of some loads, by row.
        """
        decided, links = known_ends(known or {}, len(seen.labels))
        w, norms = self.weights, self.weights["norms"]
        words = normalised(self._linear(seen.words, "words"), *norms[0])
        x = self._linear(gelu(self._linear(seen.features, "features")), "hidden")
        x = x + self._linear(seen.labels, "labels") + self._linear(decided, "decided")
        x = np.vstack((w["robot"], x))
        named = np.vstack((np.zeros_like(seen.naming[:1]), seen.naming))
        pairs = np.pad(np.dstack((seen.pairs, links)), ((1, 0), (1, 0), (0, 0)))
        for number in range(len(w["inner"])):
            x = self._layer(number, x, words, named, pairs)
        x = normalised(x, *norms[1])
        robot, things = x[:1], x[1:]
        count, d = things.shape
        ask = self._linear(things, "ask").reshape(count, 2, d).transpose(1, 0, 2)
        asked = self._linear(things, "told").reshape(count, 2, d).transpose(1, 2, 0)
        at = ask @ asked / np.float32(np.sqrt(d)) + self._linear(things, "kind").T[..., None]
        at[0] -= NO_CARRIER * ~seen.carriers
        at[:, range(count), range(count)] = -np.inf
        asked = self._linear(things, "robot_told").reshape(count, 2, d).transpose(1, 0, 2)
        met = asked @ self._linear(robot, "robot_ask").reshape(2, d, 1) / np.float32(np.sqrt(d))
        return Ends(
            log_softmax(np.hstack((self._linear(things, "end"), *at)), axis=1),
            log_softmax(np.hstack((self._linear(robot, "robot_end")[0], *met[..., 0]))),
            log_softmax(self._linear(things, "side"), axis=1),
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


def known_ends(known: Mapping[int, int], count: int) -> tuple[Float32Array, Float32Array]:
    """Return known ends of loads as arrays.

    Parameters
    ----------
    known
        The ends, by row.
    count
        Number t of things.

    Returns
    -------
    tuple of ndarray
        Type of each thing's end, shape (t, END_TYPES); and whether a thing ends at another, and the
        other way round, shape (t, t, 2).
    """
    decided = np.zeros((count, END_TYPES), dtype=np.float32)
    links = np.zeros((count, count, 2), dtype=np.float32)
    for row, end in known.items():
        decided[row, min(end, ON) + (end >= ON + count)] = 1
        if end >= ON:
            mark = (end - ON) % count
            links[row, mark, 0] = links[mark, row, 1] = 1
    return decided, links


def ends_of(text: str, state: State, model: EndModel | None = None) -> JointEnds | None:
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
    own = model or default_end_model()
    with one_thread():
        seen = describe(words, state, own.encoder)

    def given(told: Mapping[int, int]) -> Ends:
        with one_thread():
            return own.ends(seen, told)

    return JointEnds(np.flatnonzero(seen.loads).tolist(), given)


def end_evidence(ends: JointEnds, actions: Sequence[Action], end: State, start: State) -> float:
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
    return max(ends.log_probability(plan_ends(ends.rows, actions, end, start)), LEAST)


def plan_ends(
    rows: Sequence[int], actions: Sequence[Action], end: State, start: State
) -> dict[int, list[int]]:
    """Return the ends of each load that are those of a plan, by its row among the things.

    Where no load is moved, those of the robot are there, too.

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
    own = {
        row: load_ends(row, end, start) if things[row].id in handled else [STAYS] for row in rows
    }
    return own if handled else own | {ROBOT: robot_ends(end.pose, start)}


def robot_ends(pose: FloatArray, start: State) -> list[int]:
    """Return the ends of a robot that a pose x, y, yaw has, if no load was moved.

    Parameters
    ----------
    pose
        The pose in metres and radians, shape (3,).
    start
        The state before.
    """
    ahead, aside = in_frame(pose[None, :2], start.pose)[0]
    turned = wrap(pose[2:] - start.pose[2])[0]
    things = things_of(start)
    if np.hypot(ahead, aside) < STEP_M:
        turns = {STANDS: 0.0, LEFT: np.pi / 2, RIGHT: -np.pi / 2, AROUND: np.pi}
        middles = (centre(thing.prism)[None] for thing in things)
        turns |= {
            NEAR + len(things) + i: looking_at(pose, middle)[2] - start.pose[2]
            for i, middle in enumerate(middles)
        }
        met = [end for end, turn in turns.items() if abs(wrap(np.array(turned - turn))) < TURN_RAD]
        return met or [ELSEWHERE]
    hulls = (convex_hull(thing.prism.xy)[None] for thing in things)
    away = [float(point_gap(pose[None, None, :2], hull)[0, 0]) for hull in hulls]
    straight = abs(turned) < TURN_RAD and abs(aside) < abs(ahead) * np.tan(TURN_RAD)
    met = [AHEAD if ahead > 0 else BACK] if straight else []
    return [*met, *(NEAR + i for i, metres in enumerate(away) if metres < NEAR_M)] or [ELSEWHERE]


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
