"""The prompts: a command, its world, and the robot's actions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec

from corpus_tools.corpus.answer_records import PlanStep, Probability, SceneShown
from corpus_tools.following.plan_steps import scene_shown
from eval.judging.judge_registry import JudgedPlan
from eval.language_model.chat_endpoint import Message
from eval.table_3.grounder_registry import PlanTask
from g3.actions.action_kinds import KINDS, ActionKind
from g3.actions.action_words import described
from g3.actions.forklift_actions import DRIVE_BETWEEN
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State
from g3.geometry.footprints import centre

SCENE = """\
The world is JSON. Coordinates are in metres, headings in degrees counter-clockwise from +x. "seen"
is where the robot sees something at the start: metres ahead, and metres to its left (negative: to
its right). "on" is what a thing stands on; without it, it stands on the ground. The robot can lift
what is "liftable". "colours" are there where they are known."""
PLANNING = """\
You plan for a robotic forklift. You get a command that a person typed, and the world in which it
was given. Say what the robot is to do so that the person is content: all that the command asks for,
and nothing else.

{scene}

The actions, and what each takes:
{actions}

"target" is a list of ids of things or names of places. Instead of a target, "to" is a point [x, y].
Where a load is put down, give one of "on" (id of what it is put on), "near" (id of what it is put
beside, on the ground) and "at" (a point [x, y]). One load is on the forks at most. "carry" picks a
load up, takes it there and puts it down, so it needs no "pick up" before.

Reply with JSON: "actions", a list in their order, each with "action" and what it takes;
"probability", from 0 to 1, how sure you are that this is what was meant; "reason", in a
few words. If the command can't be followed, "actions" is empty."""
JUDGING = """\
You judge a robotic forklift. You get a command that a person typed, the world before the robot did
anything, and what it did. Say whether the robot did what the command asks for: all of it, and
nothing to other things. Any thing, side or place that the words allow is right.

{scene}

Reply with JSON: "correct", true or false; "reason", in a few words what is wrong, or empty."""


class PlanReply(msgspec.Struct, frozen=True):
    """A plan, as a language model is to give it."""

    actions: tuple[PlanStep, ...]
    probability: Probability = 0.0
    reason: str = ""


class VerdictReply(msgspec.Struct, frozen=True):
    """A verdict, as a language model is to give it."""

    correct: bool
    reason: str = ""


def plan_prompt() -> str:
    """Return the text before any command."""
    actions = "\n".join(f'- "{kind}": {_takes(kind)} {kind.description}' for kind in KINDS.values())
    return PLANNING.format(scene=SCENE, actions=actions)


def judge_prompt() -> str:
    """Return the text before any plan."""
    return JUDGING.format(scene=SCENE)


def plan_messages(task: PlanTask) -> list[Message]:
    """Return the messages that request a plan."""
    return _messages(
        plan_prompt(), f"World: {_compact(scene_shown(task.start))}\nCommand: {task.text}"
    )


def judge_messages(plan: JudgedPlan) -> list[Message]:
    """Return the messages that request a verdict."""
    start = plan.deeds.start
    world = _compact(scene_shown(start))
    done = "\n".join(f"- {line}" for line in _done(plan, start))
    asked = f"World: {world}\nCommand: {plan.text}\nWhat the robot did:\n{done}"
    return _messages(judge_prompt(), asked)


def _messages(system: str, user: str) -> list[Message]:
    return [{"role": "system", "content": system}, {"role": "user", "content": user}]


def _compact(scene: SceneShown) -> str:
    return msgspec.json.encode(scene).decode()


def _takes(kind: ActionKind) -> str:
    """Return the fields of an action, in brackets."""
    units = {"m": "metres", "rad": "degrees, to the left if positive", "s": "seconds"}
    fields = ["object"] if kind.handles else []
    fields += ["on, near or at"] if kind.leaves else []
    aim = "target, two of them" if kind is DRIVE_BETWEEN else "target or to"
    fields += [aim] if kind.aims else []
    fields += [f"amount in {units[kind.unit]}"] if kind.unit else []
    return f"({'; '.join(fields)})"


def _done(plan: JudgedPlan, start: State) -> Sequence[str]:
    """Describe an execution by its traces, for a log has no actions."""
    execution = plan.deeds
    lines = [f"action: {described(action)}" for action in plan.actions]
    for load in execution.carried:
        after = execution.end.thing(load.id)
        if load.lowered is None:
            where = "is on the forks at the end"
        else:
            under = carrier(execution.end, load.id)
            x, y = centre(after.prism)
            where = f"ends at [{x:.1f}, {y:.1f}] on {under.id if under else 'the ground'}"
        taken = "was on the forks at the start" if load.id == start.held else "was picked up"
        lines.append(f"{load.id} {taken} and {where}")
    if not execution.carried:
        lines.append("no load was moved")
    way = execution.way[:: max(1, len(execution.way) // 12)]
    points = ", ".join(f"[{x:.1f}, {y:.1f}]" for x, y, _ in (*way, execution.way[-1]))
    x, y, yaw = execution.way[-1]
    lines.append(f"the robot drove by {points}")
    lines.append(f"it ends at [{x:.1f}, {y:.1f}], heading {_degrees(yaw):.0f} degrees")
    return lines


def _degrees(radians: float) -> float:
    return round(math.degrees(radians)) % 360 + 0.0
