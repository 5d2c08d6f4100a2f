"""Plans in words and for programs: their actions, their clauses' groundings, and the reasons."""

from __future__ import annotations

from collections.abc import Sequence

from g3.actions.action_kinds import Action
from g3.actions.action_words import described, grounded
from g3.groundings import object_ids
from g3.inference.grounder import Plan, Result
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.reasons.aspects import aspects
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import to_json


def explained(plan: Plan, sdcs: Sequence[SDC]) -> list[str]:
    """Describe the grounding of each clause of a command, with its reason, in lines for people."""
    tree = Tree(tuple(sdcs))
    doing = (n for n in asked(tree) if tree.nodes[n].type in ("EVENT", "PATH"))
    actions = dict(zip(doing, plan.actions, strict=True))
    lines = []
    for grounding in plan.groundings:
        action = actions.get(grounding.node)
        frame = plan.state.frame
        what = described(action, frame) if action else grounded(grounding.group, frame)
        rival, other = "", grounding.rival
        if other is not None:
            called = (
                described(other, frame) if isinstance(other, Action) else grounded(other, frame)
            )
            rival = f", rather than {called}"
        lines.append(f"{grounding.text!r}: {what} (fits {grounding.probability:.2f}){rival}")
        why = [aspect.text for aspect in aspects(grounding.reasons, grounding.sdc)]
        if rival and not why:
            why = ["nothing in these words tells them apart"]
        lines += [f"    {reason}" for reason in why]
    return lines


def sentence(plan: Plan) -> str:
    """Describe the actions of a plan one after the other."""
    return "; ".join(described(action, plan.state.frame) for action in plan.actions)


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
                "actions": [described(action, plan.state.frame) for action in plan.actions],
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
