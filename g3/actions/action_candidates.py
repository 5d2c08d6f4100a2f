"""The actions that are possible in a context: kinds, the objects and places they may be about."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from g3.actions.logged_actions import (
    Outcome,
    back_up,
    carry,
    centre,
    covers,
    drive_past,
    drive_to,
    loaded,
    pick_up,
    put_down,
    recorded,
    turn,
)
from g3.geometry.plane import area, convex_hull
from g3.groundings import Context, FloatArray, PhysicalObject, Prism

Kind = Literal["drive", "pick up", "carry", "put down", "turn", "back up"]
KINDS: tuple[Kind, ...] = get_args(Kind)

MOVED_M = 0.15
"""Moves of the middle shorter than this are noise of the logs."""
SURFACE_M2 = 4.0
"""Things at least this large can have a load put on top."""
FREE_M = 1.2
"""Gap between the middle of a place and whatever stands at its height; loads end with 1.4 m."""
_PLACE_M = 1.0
_TURNS = (np.pi / 2, -np.pi / 2, np.pi)
_BACK_UPS_M = (3.0, 6.0)


@dataclass(frozen=True, slots=True)
class Candidate:
    """An action that could be done, not yet what would come of it.

    Parameters
    ----------
    kind
        What is done.
    object_id
        The object carried, driven to or driven past; empty if none.
    place
        Where an object is put down or the agent drives to.
    amount
        Radians to turn, or metres to back up.
    past
        Whether the object is driven past instead of up to.
    """

    kind: Kind
    object_id: str = ""
    place: Prism | None = None
    amount: float = 0.0
    past: bool = False


def candidates(context: Context, movable: Iterable[str]) -> list[Candidate]:
    """Every candidate action of a context.

    Parameters
    ----------
    movable
        Labels of things that the agent can carry.
    """
    others = recorded(context).objects
    held = loaded(context)
    sites = [p.prism for p in context.places] + [on_top(o) for o in others if _is_surface(o)]
    ground = float(context.agent.trajectory.xyz[0, 2])
    floor = [p for p in sites if p.z_min < ground + 0.5 and is_free(context, p, held)]
    found = [Candidate("turn", amount=angle) for angle in _TURNS]
    found += [Candidate("back up", amount=distance) for distance in _BACK_UPS_M]
    found += [Candidate("drive", place=place) for place in floor]
    found += [
        Candidate("drive", o.id, past=past)
        for o in others
        if o.id != held
        for past in (False, True)
    ]
    if held is not None:
        return found + [Candidate("put down", held, p) for p in sites if is_free(context, p, held)]
    loads = [o for o in others if set(o.labels) & set(movable) and not _is_buried(o, others)]
    found += [Candidate("pick up", o.id) for o in loads]
    found += [
        Candidate("carry", o.id, place)
        for o in loads
        for place in sites
        if is_free(context, place, o.id)
    ]
    return found


def perform(context: Context, candidate: Candidate) -> Outcome:
    """Do a candidate action."""
    kind, place = candidate.kind, candidate.place
    if kind == "turn":
        return turn(context, candidate.amount)
    if kind == "back up":
        return back_up(context, candidate.amount)
    if kind == "pick up":
        return pick_up(context, candidate.object_id)
    if place is not None:
        if kind == "drive":
            return drive_to(context, place, gap_m=None)
        return (carry if kind == "carry" else put_down)(context, candidate.object_id, place)
    thing = next(o for o in context.objects if o.id == candidate.object_id)
    return (drive_past if candidate.past else drive_to)(context, thing.prism)


def kind_of(context: Context) -> Kind:
    """Which kind of action the context's own log shows."""
    log = recorded(context)
    held = loaded(context)
    away = [o for o in log.objects if o.id in moved(log)]
    if not away:
        return "drive"
    load = next((o for o in away if o.id == held), away[0])
    gap = load.trajectory.xyz[-1, :2] - log.agent.trajectory.xyz[-1, :2]
    released = float(np.linalg.norm(gap)) > RELEASED_M
    if load.id == held:
        return "put down" if released else "drive"
    return "carry" if released else "pick up"


RELEASED_M = 2.0
"""A load further than this from the agent is no longer on the forks."""


def moved(outcome: Outcome) -> frozenset[str]:
    """Ids of the objects that end elsewhere than they start."""
    return frozenset(
        o.id
        for o in outcome.objects
        if float(np.linalg.norm(o.trajectory.xyz[-1] - o.trajectory.xyz[0])) > MOVED_M
    )


def end_of(thing: PhysicalObject) -> FloatArray:
    """Where the middle of an object's footprint ends, shape (2,).

    Exact for objects whose position is their middle; the others' turn is ignored.
    """
    shift: FloatArray = thing.trajectory.xyz[-1, :2] - thing.trajectory.xyz[0, :2]
    return centre(thing.prism) + shift


def path_length(outcome: Outcome) -> float:
    """How far the agent drives, in metres."""
    step = np.diff(outcome.agent.trajectory.xyz[:, :2], axis=0)
    return float(np.linalg.norm(step, axis=1).sum())


def on_top(thing: PhysicalObject) -> Prism:
    """A place in the middle of an object's top."""
    return square(centre(thing.prism), thing.prism.z_max)


def square(middle: FloatArray, bottom: float) -> Prism:
    """A place of two metres by two, one metre high."""
    corners = _PLACE_M * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return Prism(middle + corners, bottom, bottom + _PLACE_M)


def is_free(context: Context, place: Prism, load: str | None) -> bool:
    """Whether nothing stands in the middle of a place, apart from a load that is to go there."""
    middle = centre(place)
    return not any(
        covers(o.prism, middle, FREE_M)
        for o in recorded(context).objects
        if o.id != load and o.prism.z_max > place.z_min + 0.3
    )


def _is_surface(thing: PhysicalObject) -> bool:
    return bool(area(convex_hull(thing.prism.xy)[None])[0] >= SURFACE_M2)


def _is_buried(thing: PhysicalObject, others: Iterable[PhysicalObject]) -> bool:
    """Whether something stands on an object."""
    return any(
        o.id != thing.id
        and o.prism.z_min > thing.prism.z_max - 0.2
        and covers(thing.prism, centre(o.prism))
        for o in others
    )
