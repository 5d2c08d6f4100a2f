"""Clauses that ask for the most probable ends of all loads, for a plan that no tree leads to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import State
from g3.inference.ends.described import things_of
from g3.inference.ends.end_model import GROUND, HELD, ON, STAYS, Ends
from g3.sdc.clauses import SDC, Span, breadth_first
from g3.sdc.sdc_notation import format_word, parse_brackets


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


def likely_ends(ends: Ends, state: State) -> dict[int, int]:
    """Return the most probable end of each load, by row; at most one is lifted.

    Parameters
    ----------
    ends
        Probabilities of all ends.
    state
        The state before.
    """
    if not ends.rows:
        return {}
    things = things_of(state)
    told = ends.loads[ends.rows].copy()
    flat = [i for i, thing in enumerate(things) if not is_surface(thing)]
    told[:, [ON + i for i in flat]] = -np.inf
    lifted = np.where(told.argmax(1) == HELD, told[:, HELD], -np.inf)
    told[np.arange(len(told)) != lifted.argmax(), HELD] = -np.inf
    return dict(zip(ends.rows, told.argmax(1).tolist(), strict=True))


def proposal_of(likely: Mapping[int, int], state: State) -> Proposal | None:
    """Return clauses that ask for ends of loads; None if all stay.

    Parameters
    ----------
    likely
        The end of each load, by its row.
    state
        The state before.
    """
    things = things_of(state)
    ids = [thing.id for thing in things]
    moved: dict[int, list[str]] = {}
    for row, end in likely.items():
        if end != STAYS and not (end == HELD and ids[row] == state.held):
            moved.setdefault(end, []).append(ids[row])
    told = sorted(moved.items(), key=lambda own: _turn(own[0], own[1], state))
    said, marks = [], list[tuple[str, ...]]()
    for end, loads in told:
        own = _name(loads, state)
        if end == HELD:
            said.append(f"EVENT(r = Pick up, l = OBJ(f = {own}))")
            continue
        mark = () if end == GROUND else (ids[(end - ON) % len(ids)],)
        relation = "next to" if end >= ON + len(ids) else "on"
        name = _name(mark, state) if mark else "the ground"
        place = f"PLACE(r = {relation}, l = OBJ(f = {name}))"
        said.append(f"EVENT(r = Put, l = OBJ(f = {own}), l2 = {place})")
        marks.append(mark)
    sdcs = parse_brackets("\n".join(said))
    nodes = enumerate(breadth_first(sdcs))
    objects = [n for n, sdc in nodes if sdc.type == "OBJECT" and not sdc.is_implicit]
    meant = [*(tuple(loads) for _, loads in told), *marks]
    answers = {node: ids for node, ids in zip(objects, meant, strict=True) if ids}
    return Proposal(sdcs, answers) if said else None


def _turn(end: int, loads: Sequence[str], state: State) -> tuple[bool, bool, bool]:
    """Return the key by which clauses are sorted: what is held first, what is lifted last."""
    aboard = any(carrier(state, load) is not None for load in loads)
    return end == HELD, state.held not in loads, not aboard


def _name(ids: Sequence[str], state: State) -> str:
    labels = list(dict.fromkeys(" ".join(state.thing(name).labels) for name in ids))
    noun = labels[0] + "s" * (len(ids) > 1) if len(labels) == 1 else "loads"
    return " ".join(format_word(Span(0, word)) for word in ("the", *noun.split()))
