"""Plans and worlds as other programs write and read them, by things' ids; and plans in words."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.answer_records import PlaceInScene, PlanStep, SceneShown, ThingInScene
from g3.actions import grounding_candidates as candidates
from g3.actions.action_kinds import KINDS, Action, ActionKind, move, result
from g3.actions.forklift_actions import BACK_UP, DRIVE_BETWEEN, LOWER_FORKS
from g3.actions.robot_state import State, loads_of_context
from g3.errors import FormatError
from g3.geometry.footprints import centre, covers, extent
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, PhysicalObject, Place, object_ids
from g3.inference.grounder import Plan, Result
from g3.inference.reasons.aspects import aspects
from g3.sdc.sdc_notation import to_json
from g3.short_repr import short_repr

DIGITS = 2
"""Coordinates are shown to centimetres."""
BACKWARDS = frozenset({BACK_UP, LOWER_FORKS})
"""Their amounts are below zero, but "back up 3 m" is 3 m."""


@short_repr
@dataclass(frozen=True, slots=True)
class ReadPlan:
    """Steps as actions."""

    actions: tuple[Action, ...] = ()
    """One after the other; none if not all can be carried out."""
    why_not: str = ""
    """Reason why an action is impossible; empty if all are possible."""


def read_steps(steps: Sequence[PlanStep], start: State) -> ReadPlan:
    """Make actions of steps.

    FormatError if a step names what there isn't, or lacks what its action needs.
    """
    state, actions = start, list[Action]()
    for number, step in enumerate(steps, start=1):
        where = f"action {number}"
        kind = _kind(step, where)
        _check_fields(step, kind, where)
        if not kind.fits(state):
            held = f"{state.held} is on the forks" if state.held else "nothing is on the forks"
            return ReadPlan(why_not=f"{where}: {step.action}: {held}")
        load = _load(step, kind, state, where) if kind.handles else None
        place = _place(step, state, load, where) if load and kind.leaves else None
        if load and kind.leaves and place is None:
            return ReadPlan(why_not=f"{where}: there is no free place for {load.id}")
        target = _target(step, state, where) if kind.aims else ()
        action = Action(kind, load.id if load else "", target, place, _amount(step, kind))
        actions.append(action)
        state = result(state, action, move(state, [action]), 0)
    return ReadPlan(tuple(actions))


def carried_out(start: State, actions: Sequence[Action]) -> State:
    """Return the state that actions lead to."""
    state = start
    for action in actions:
        state = result(state, action, move(state, [action]), 0)
    return state


def why_impossible(start: State, actions: Sequence[Action]) -> str:
    """Return the reason why actions can't follow one another; empty if they can."""
    state = start
    for number, action in enumerate(actions, start=1):
        if not action.kind.fits(state):
            held = f"{state.held} is on the forks" if state.held else "nothing is on the forks"
            return f"action {number}: {action.kind}: {held}"
        state = result(state, action, move(state, [action]), 0)
    return ""


def scene_shown(start: State) -> SceneShown:
    """Return the world as it is shown to somebody who plans in it."""
    context, pose = start.context, start.pose
    liftable = {o.id for o in loads_of_context(context)}
    things = tuple(
        _shown(o, start, liftable=o.id in liftable)
        for o in context.objects
        if o.id != context.agent_id
    )
    places = tuple(
        PlaceInScene(place.name, _point(middle), _seen(pose, middle))
        for place in context.places
        if place.name
        for middle in (centre(place.prism),)
    )
    return SceneShown(
        robot=context.agent_id,
        position=_point(pose[:2]),
        heading=_degrees(pose[2]),
        things=things,
        places=places,
        holds=start.held or "",
    )


def _shown(thing: PhysicalObject, state: State, *, liftable: bool) -> ThingInScene:
    middle, yaw = centre(thing.prism), float(thing.trajectory.yaw[0])
    size = extent(thing.prism, yaw)
    under = candidates.carrier(state, thing.id)
    return ThingInScene(
        id=thing.id,
        labels=thing.labels,
        middle=_point(middle),
        size=(_rounded(size[0]), _rounded(size[1]), _rounded(size[2])),
        bottom=_rounded(thing.prism.z_min),
        heading=_degrees(yaw),
        seen=_seen(state.pose, middle),
        liftable=liftable,
        on=under.id if under and thing.id != state.held else "",
        colours=thing.colours,
    )


def _rounded(value: float) -> float:
    return round(float(value), DIGITS) + 0.0  # -0.0 is 0.0


def _point(xy: FloatArray) -> tuple[float, float]:
    return _rounded(xy[0]), _rounded(xy[1])


def _degrees(radians: float) -> float:
    return round(float(np.rad2deg(radians))) % 360 + 0.0


def _seen(pose: FloatArray, point: FloatArray) -> tuple[float, float]:
    return _point(rotate((point - pose[:2])[None], -pose[2:3])[0])


def _kind(step: PlanStep, where: str) -> ActionKind:
    if step.action not in KINDS:
        raise FormatError.unknown("action", step.action, KINDS, where=where)
    return KINDS[step.action]


def _check_fields(step: PlanStep, kind: ActionKind, where: str) -> None:
    """Refuse a step with a missing or an unused field for its action."""
    spots = [name for name in ("on", "near", "at") if getattr(step, name)]
    aims = [name for name in ("target", "to") if getattr(step, name)]
    amount = step.amount is not None
    wants = f"a {kind} action"
    problem = ""
    if kind.takes and not step.object:
        problem = f"{wants} needs an object"
    elif step.object and not kind.handles and not kind.moves_forks:
        problem = f"{wants} takes no object"
    elif len(spots) != int(kind.leaves):
        problem = f"{wants} {'needs one of' if kind.leaves else 'takes none of'} on, near and at"
    elif len(aims) != int(kind.aims):
        problem = f"{wants} {'needs one of' if kind.aims else 'takes none of'} target and to"
    elif kind is DRIVE_BETWEEN and len(step.target) != 2:
        problem = f"{wants} needs two targets"
    elif amount and not kind.unit:
        problem = f"{wants} takes no amount"
    elif kind.unit in ("m", "rad") and not amount:
        problem = f"{wants} needs an amount"
    if problem:
        raise FormatError(problem, where=where, fix="docs/how-to/own-grounder.md lists the actions")


def _thing(name: str, state: State, where: str) -> PhysicalObject:
    thing = next((o for o in state.context.objects if o.id == name), None)
    if thing is None:
        ids = [o.id for o in state.context.objects]
        raise FormatError.unknown("thing", name, ids, where=where)
    return thing


def _load(step: PlanStep, kind: ActionKind, state: State, where: str) -> PhysicalObject:
    load = _thing(step.object or state.held or "", state, where)
    if load.id == state.context.agent_id:
        raise FormatError("the robot can't lift itself", where=where, fix="give another object")
    if not kind.takes and load.id != state.held:
        raise FormatError(
            f"{load.id} isn't on the forks", where=where, fix=f"put down {state.held}, or carry it"
        )
    return load


def _place(step: PlanStep, state: State, load: PhysicalObject, where: str) -> Place | None:
    """Return the place where a load is put down; None if nothing is free."""
    if step.at:
        return _spot_at(np.array(step.at[:2]), step.at[2:], state, load)
    named = _named(step.on or step.near, state, where)
    if isinstance(named, PhysicalObject) and named.id == load.id:
        raise FormatError(
            f"{load.id} can't be put on or near itself", where=where, fix="name another thing"
        )
    spots = candidates.spots_about((named,), state)
    if isinstance(named, PhysicalObject):
        spots = [
            spot
            for spot in spots
            for under in (candidates.beneath(spot, state, load.id),)
            if (under is not None and under.id == named.id) == bool(step.on)
        ]
    free = candidates.are_free(spots, state, load.id) if spots else ()
    return next((spot for spot, is_free in zip(spots, free, strict=True) if is_free), None)


def _spot_at(
    middle: FloatArray, height: Sequence[float], state: State, load: PhysicalObject
) -> Place:
    """Return a spot at a point, on the top of the things there if no height is given."""
    tops = [
        o.prism.z_max
        for o in state.context.objects
        if o.id not in (load.id, state.context.agent_id)
        and candidates.is_surface(o)
        and covers(o.prism, middle)
    ]
    bottom = height[0] if height else max([candidates.ground(state), *tops])
    return candidates.square(middle, float(state.pose[2]), bottom)


def _target(step: PlanStep, state: State, where: str) -> tuple[PhysicalObject | Place, ...]:
    if step.to is not None:
        return (
            candidates.square(np.array(step.to), float(state.pose[2]), candidates.ground(state)),
        )
    targets = tuple(_named(name, state, where) for name in step.target)
    robot_ids = {state.context.agent_id, state.held}
    if any(isinstance(g, PhysicalObject) and g.id in robot_ids for g in targets):
        raise FormatError(
            "the robot and what is on its forks are no targets", where=where, fix="name others"
        )
    return targets


def _named(name: str, state: State, where: str) -> PhysicalObject | Place:
    """Return a thing by its id, or a place by its name."""
    places = (place for place in state.context.places if place.name and place.name == name)
    return next(places, None) or _thing(name, state, where)


def _amount(step: PlanStep, kind: ActionKind) -> float:
    if step.amount is None:
        return 0.0
    if kind.unit == "rad":
        return float(np.deg2rad(step.amount))
    return -abs(step.amount) if kind in BACKWARDS else step.amount


def explained(plan: Plan) -> list[str]:
    """Describe the grounding of each clause of a command, with its reason, in lines for people."""
    words, lines = plan.words, []
    actions = defaultdict[int, list[str]](list)
    for clause, action in zip(plan.clauses, plan.actions, strict=True):
        actions[clause].append(words.action(action))
    for grounding in plan.groundings:
        what = "; ".join(actions[grounding.node]) or words.group(grounding.group)
        rival, other = "", grounding.rival
        if other is not None:
            called = words.action(other) if isinstance(other, Action) else words.group(other)
            rival = f", rather than {called}"
        lines.append(f"{grounding.text!r}: {what} (fits {grounding.probability:.2f}){rival}")
        why = [aspect.text for aspect in aspects(grounding.reasons, grounding.sdc)]
        if rival and not why:
            why = ["nothing in these words tells them apart"]
        lines += [f"    {reason}" for reason in why]
    return lines


def sentence(plan: Plan) -> str:
    """Describe the actions of a plan one after the other."""
    return "; ".join(map(plan.words.action, plan.actions))


def as_record(result: Result, asked: str = "") -> dict[str, object]:
    """Return the plans of a command and its status, for programs.

    `asked` is a question to be answered before an execution; empty if there is none.
    """
    return {
        "sdcs": to_json(result.sdcs),
        "status": _status(result, asked),
        "note": result.note,
        "missing": list(result.missing),
        "question": asked or (result.question.text if result.question else ""),
        "plans": [
            {
                "probability": round(plan.probability, 4),
                "actions": list(map(plan.words.action, plan.actions)),
                "why_not": plan.why_not,
                "groundings": [
                    {
                        "node": g.node,
                        "text": g.text,
                        "type": g.sdc.type,
                        "objects": list(object_ids(g.group)),
                        "probability": round(g.probability, 4),
                        "reasons": [aspect.text for aspect in aspects(g.reasons, g.sdc)],
                    }
                    for g in plan.groundings
                ],
            }
            for plan in result.plans
        ],
    }


def _status(result: Result, question: str) -> str:
    """Return the result of a command: absent, refused, impossible, unsure or found."""
    if result.plan is None:
        return "absent" if result.missing else "refused"
    if result.plan.why_not:
        return "impossible"
    return "unsure" if question else "found"
