"""Plans in words and for programs: what is done, what clauses are grounded in, and why."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action
from g3.groundings import Grounding, Path, Place
from g3.inference.grounder import Plan, Result, object_ids
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.reasons.aspects import aspects
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import to_json


def described(action: Action) -> str:
    """What an action does, and to what."""
    target = " and ".join(object_ids(action.target)) or ("a place" if action.target else "")
    words = [action.kind.name, action.object_id, target]
    if action.place is not None:
        words.append(f"at {_spot(action.place)}, {action.place.prism.z_min:.1f} m up")
    if action.kind.unit == "rad":
        words.append(f"{np.rad2deg(action.amount):.0f} degrees")
    return " ".join(word for word in words if word)


def explained(plan: Plan, sdcs: Sequence[SDC]) -> list[str]:
    """What each clause of a command is grounded in, and why, in lines for people."""
    tree = Tree(tuple(sdcs))
    doing = (n for n in asked(tree) if tree.nodes[n].type in ("EVENT", "PATH"))
    actions = dict(zip(doing, plan.actions, strict=True))
    lines = []
    for found in plan.groundings:
        action = actions.get(found.node)
        what = described(action) if action else _grounded(found.group)
        other = found.rival
        rival = f", rather than {_called(other)}" if other is not None else ""
        lines.append(f"{found.text!r}: {what} (fits {found.probability:.2f}){rival}")
        why = [aspect.text for aspect in aspects(found.reasons, found.sdc)]
        if rival and not why:
            why = ["nothing in these words tells them apart"]
        lines += [f"    {reason}" for reason in why]
    return lines


def _called(rival: Action | Sequence[Grounding]) -> str:
    return described(rival) if isinstance(rival, Action) else _grounded(rival)


def _grounded(group: Sequence[Grounding]) -> str:
    """What a clause is grounded in."""
    if any(isinstance(g, Path) for g in group):
        return "the way there"
    places = [f"the place at {_spot(g)}" for g in group if isinstance(g, Place)]
    return " and ".join((*object_ids(group), *places))


def _spot(place: Place) -> str:
    x, y = place.prism.xy.mean(axis=0)
    return place.name or f"({x:.1f}, {y:.1f})"


def sentence(plan: Plan) -> str:
    """What a plan does, one action after the other."""
    return "; ".join(described(action) for action in plan.actions)


def as_record(result: Result, asked: str = "") -> dict[str, object]:
    """What came of a command, for programs.

    Parameters
    ----------
    result
        What was found.
    asked
        The question that has to be answered before anything is done; empty if there is none.
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
                "actions": [described(action) for action in plan.actions],
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


def _status(result: Result, asked: str) -> str:
    """What came of a command, in a word: absent, refused, unsure or found."""
    if result.plan is None:
        return "absent" if result.missing else "refused"
    return "unsure" if asked else "found"
