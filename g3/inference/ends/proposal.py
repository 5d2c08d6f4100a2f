"""Clauses that ask for the most probable ends of all loads, for a plan that no tree leads to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import State
from g3.inference.ends.described import things_of
from g3.inference.ends.end_model import (
    AHEAD,
    AROUND,
    BACK,
    ELSEWHERE,
    GROUND,
    HELD,
    LEFT,
    NEAR,
    NEARLY_SURE,
    ON,
    RIGHT,
    ROBOT,
    SIDES,
    STANDS,
    STAYS,
    JointEnds,
)
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.sdc.sdc_notation import format_word, parse_brackets

BETWEEN = SIDES.index("between")
BEAM = 4
"""Number of partial outcomes that are pursued."""
ROBOT_MOVES = {
    STANDS: "Wait",
    AHEAD: "Go forward",
    BACK: "Back up",
    LEFT: "Turn left",
    RIGHT: "Turn right",
    AROUND: "Turn around",
}
"""Clauses that ask for ends of the robot that no thing defines."""


class Proposal(NamedTuple):
    """Clauses, and which things their OBJECTs mean.

    Parameters
    ----------
    sdcs
        The clauses: "Put the crates on the truck".
    answers
        Ids of the things that each OBJECT means, by its node.
    """

    sdcs: tuple[SDC, ...]
    answers: Mapping[int, tuple[str, ...]]


def likely_ends(ends: JointEnds, state: State) -> dict[int, int]:
    """Return the most probable end of each load, by row; at most one is lifted.

    Where all stay, that of the robot is there, too, unless it isn't known.

    Parameters
    ----------
    ends
        Probabilities of all ends.
    state
        The state before.
    """
    things = things_of(state)
    flat = [i for i, thing in enumerate(things) if not is_surface(thing)]
    known: list[tuple[float, dict[int, int]]] = [(0.0, {})]
    while len(known[0][1]) < len(ends.rows):
        known = sorted(
            (own for one in known for own in _further(ends, *one, flat)), key=lambda own: -own[0]
        )[:BEAM]
    likely = known[0][1]
    robot = int(ends.given({}).robot.argmax())
    moves = any(_is_moved(things[row].id, end, state) for row, end in likely.items())
    is_told = ends.has_robot and robot != ELSEWHERE
    return likely | {ROBOT: robot} if is_told and not moves else likely


def _further(
    ends: JointEnds, total: float, told: dict[int, int], flat: Sequence[int]
) -> list[tuple[float, dict[int, int]]]:
    """Give the loads whose ends are nearly sure, or the surest one its two likeliest ends."""
    left = [row for row in ends.rows if row not in told]
    if not left:
        return [(total, told)]
    loads = ends.given(told).loads.copy()
    loads[:, [ON + i for i in flat]] = -np.inf
    if HELD in told.values():
        loads[:, HELD] = -np.inf
    best = loads.max(axis=1)
    sure = [row for row in left if best[row] > NEARLY_SURE and loads[row].argmax() != HELD]
    if sure:
        now = {row: int(loads[row].argmax()) for row in sure}
        return [(total + float(best[sure].sum()), told | now)]
    row = max(left, key=lambda row: best[row])
    two = np.argsort(-loads[row])[:2].tolist()
    return [(total + float(loads[row][end]), told | {row: end}) for end in two]


def sides_of(ends: JointEnds, likely: Mapping[int, int]) -> dict[int, tuple[int, int]]:
    """Return on which of `SIDES` each load is put beside a thing, and which is the other thing.

    Parameters
    ----------
    ends
        Probabilities of all ends.
    likely
        The end of each load, by its row.
    """
    found = {}
    for row in ends.rows:
        others = ends.given({key: end for key, end in likely.items() if key not in (row, ROBOT)})
        beside = ON + len(others.loads)
        if likely[row] >= beside:
            marks = others.loads[row, beside:].copy()
            marks[likely[row] - beside] = -np.inf
            found[row] = int(others.sides[row].argmax()), int(marks.argmax())
    return found


def proposal_of(
    likely: Mapping[int, int],
    state: State,
    metres: float | None = None,
    sides: Mapping[int, tuple[int, int]] | None = None,
) -> Proposal | None:
    """Return clauses that ask for ends of loads, or of the robot; None if there are none.

    Parameters
    ----------
    likely
        The end of each load, by its row, and of the robot.
    state
        The state before.
    metres
        How far the robot goes; None for as far as is usual.
    sides
        Where loads are put beside things (:func:`sides_of`); None for anywhere.
    """
    ids = [thing.id for thing in things_of(state)]
    if ROBOT in likely:
        return _of_robot(likely[ROBOT], ids, state, metres)
    moved: dict[tuple[int, int, int, bool], list[str]] = {}  # what is held comes by itself
    for row, end in likely.items():
        if _is_moved(ids[row], end, state):
            side, other = (sides or {}).get(row, (0, 0))
            key = end, side, other if side == BETWEEN else 0, ids[row] == state.held
            moved.setdefault(key, []).append(ids[row])
    told = sorted(moved.items(), key=lambda own: _turn(own[0][0], own[1], state))
    said, marks = [], list[Sequence[str]]()
    for (end, side, other, _), loads in told:
        own = _name(loads, state)
        if end == HELD:
            said.append(f"EVENT(r = Pick up, l = OBJ(f = {own}))")
            continue
        named: list[tuple[str, ...]] = [()] if end == GROUND else [(ids[(end - ON) % len(ids)],)]
        if side == BETWEEN:
            named.append((ids[other],))
        things = [f"OBJ(f = {_name(mark, state) if mark else 'the ground'})" for mark in named]
        landmarks = ", l2 = ".join(things)
        relation = SIDES[side] if end >= ON + len(ids) else "on"
        place = f"PLACE(r = {relation}, l = {landmarks})"
        said.append(f"EVENT(r = Put, l = OBJ(f = {own}), l2 = {place})")
        marks += named
    return _proposal(said, [*(loads for _, loads in told), *marks]) if said else None


def _of_robot(end: int, ids: Sequence[str], state: State, metres: float | None) -> Proposal:
    if end in (AHEAD, BACK) and metres is not None:
        far = f"OBJ(f = {metres:g} meters)"
        return _proposal([f"EVENT(r = {ROBOT_MOVES[end]}, l = {far})"], [()])
    if end < NEAR:
        return _proposal([f"EVENT(r = {ROBOT_MOVES[end]})"], [])
    mark = (ids[(end - NEAR) % len(ids)],)
    obj = f"OBJ(f = {_name(mark, state)})"
    facing = end >= NEAR + len(ids)
    said = (
        f"EVENT(r = Face, l = {obj})" if facing else f"EVENT(r = Go, l = PATH(r = to, l = {obj}))"
    )
    return _proposal([said], [mark])


def _proposal(said: Sequence[str], meant: Sequence[Sequence[str]]) -> Proposal:
    """Return clauses in brackets, with the ids of the things that their OBJECTs mean, in order."""
    sdcs = parse_brackets("\n".join(said))
    nodes = enumerate(breadth_first(sdcs))
    objects = [n for n, sdc in nodes if sdc.type == "OBJECT" and not sdc.is_implicit]
    answers = {node: tuple(ids) for node, ids in zip(objects, meant, strict=True) if ids}
    return Proposal(sdcs, answers)


def _is_moved(load: str, end: int, state: State) -> bool:
    return end != STAYS and not (end == HELD and load == state.held)


def _turn(end: int, loads: Sequence[str], state: State) -> tuple[bool, bool, bool]:
    """Return the key by which clauses are sorted: what is held first, what is lifted last."""
    aboard = any(carrier(state, load) is not None for load in loads)
    return end == HELD, state.held not in loads, not aboard


def _name(ids: Sequence[str], state: State) -> str:
    labels = list(dict.fromkeys(" ".join(state.thing(name).labels) for name in ids))
    noun = labels[0] + "s" * (len(ids) > 1) if len(labels) == 1 else "loads"
    return " ".join(format_word(Span(0, word)) for word in ("the", *noun.split()))
