"""Words of a command and things about the robot, as arrays for :mod:`g3.inference.ends.end_model`.

A thing is described by its labels, by what it is and carries, and by where it is, also among those
alike: nearest, leftmost, one of three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import State, is_load
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray, rotate
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.plan_things import naming
from g3.language.parsing.encoder import Encoder, Float32Array
from g3.language.parsing.words import Words
from g3.short_repr import short_repr

RANGE_M, CLOSE_M = 20.0, 5.0
"""Scales of distances from the robot, and between things."""
FEATURES = 32
"""Number of features of a thing."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """The n words of a command and the t things of a world, all but the robot.

    Parameters
    ----------
    words
        Vectors of the words with and without their context, shape (n, 2 d).
    labels
        Vectors of the things' labels, shape (t, d).
    naming
        How well each word names each thing, from 0 to 1, shape (t, n).
    features
        Features of each thing, shape (t, FEATURES).
    pairs
        Whether a thing stands on another, carries it, and has the same labels; and how near they
        are; shape (t, t, 4).
    loads, carriers
        Whether each can be lifted, and whether it carries loads without being one, shape (t,).
    """

    words: Float32Array
    labels: Float32Array
    naming: Float32Array
    features: Float32Array
    pairs: Float32Array
    loads: BoolArray
    carriers: BoolArray


def things_of(state: State) -> list[PhysicalObject]:
    """Return all things but the robot."""
    return [o for o in state.context.objects if o.id != state.context.agent_id]


def describe(words: Words, state: State, encoder: Encoder) -> Described:
    """Describe a command's words, at least one, and the things of its world, at least one.

    Parameters
    ----------
    words
        The command.
    state
        The state in which it is given.
    encoder
        What gives words their vectors.
    """
    things = things_of(state)
    labels = [tuple(thing.labels) for thing in things]
    in_context = next(encoder.encode_all([words]))
    alone = np.stack([encoder.meaning((form,)) for form in words.forms])
    names = [[naming(form, own) for form in words.forms] for own in labels]
    xy = np.array([centre(thing.prism) for thing in things]) - state.pose[:2]
    under = [carrier(state, thing.id) for thing in things]
    below = [None if thing is None else thing.id for thing in under]
    on = np.array([[own == thing.id for thing in things] for own in below])
    same = np.array([[own == other for other in labels] for own in labels])
    apart = np.linalg.norm(xy[:, None] - xy, axis=2)
    loads = np.array([is_load(state, thing.id) for thing in things])
    carriers = np.array([is_surface(thing) for thing in things]) & ~loads
    held = np.array([thing.id == state.held for thing in things])
    alike = (loads[:, None] == loads) & (carriers[:, None] == carriers)
    count, aboard = same.sum(axis=1), on.sum(axis=0)
    features = [
        *_where(rotate(xy, np.full(len(xy), -state.pose[2])), (same, alike)),
        *(loads, carriers, held, on.any(axis=1), aboard > 0, aboard / 3),
        *(count == 1, count == 2, count >= 3),
    ]
    return Described(
        np.hstack((in_context, alone)),
        np.stack([encoder.meaning(own) for own in labels]),
        np.array(names, dtype=np.float32),
        np.stack(features, axis=1).astype(np.float32),
        np.stack((on, on.T, same, np.exp(-apart / CLOSE_M)), axis=2).astype(np.float32),
        loads,
        carriers,
    )


def _where(xy: FloatArray, groups: Sequence[BoolArray]) -> list[FloatArray | BoolArray]:
    """Return features of where things are about the robot, and among those of their groups."""
    distance = np.linalg.norm(xy, axis=1)
    unit = xy / np.maximum(distance, 1)[:, None]
    found = [*(xy.T / RANGE_M), distance / RANGE_M, *unit.T[::-1]]
    for group in groups:
        for key in (distance, *xy.T):
            found += _ranks(key, group)
    return found


def _ranks(key: FloatArray, group: BoolArray) -> Sequence[FloatArray | BoolArray]:
    """Return each thing's rank in its group, from 0 to 1, and whether it is first or last."""
    before = (group & (key[:, None] > key + 1e-6)).sum(axis=1)
    others = group.sum(axis=1) - 1
    rank = np.where(others > 0, before / np.maximum(others, 1), 0.5)
    return rank, before == 0, before == others
