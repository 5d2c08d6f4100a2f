"""A command followed by a model or a baseline, and the plan judged."""

from __future__ import annotations

from collections.abc import Sequence

from eval.judging.deeds import planned
from eval.judging.judge import Verdict, judge
from eval.judging.outcome_judge import judge_outcome
from eval.judging.picked_up import picked_up
from eval.judging.words_judge import judge_by_words
from eval.table_3.baselines import BASELINES, carried_out, scene_of
from eval.table_3.judged_commands import JudgedCommand
from eval.table_3.outcomes import Outcome
from g3.actions.action_kinds import Action
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.groundings import PhysicalObject, object_ids
from g3.inference.grounder import Grounder, Result
from g3.inference.problem.command_tree import Tree
from g3.language.parsing.extractor import Parse
from g3.sdc.clauses import SDC

CONFIGURATIONS = ("random", *BASELINES, "gold", "auto")
NOTHING_TO_LIFT = "there is no load to pick up"


def follow_command(
    which: str,
    tested: JudgedCommand,
    extracted: Sequence[SDC] | Parse = (),
    grounder: Grounder | None = None,
    heading: str = "",
) -> Outcome:
    """Follow a command in its own world and judge the plan, however improbable it is.

    Parameters
    ----------
    which
        One of `CONFIGURATIONS`.
    extracted
        The command's clauses as they are extracted from its text, maybe several trees; ``auto``
        takes these, and ``random`` where nobody has annotated the command.
    grounder
        With the costs of the configuration; baselines need none.
    heading
        What to note as the heading.
    """
    if which in BASELINES:
        return _by_baseline(which, tested, heading)
    if grounder is None:
        raise ValueError(f"{which} needs a grounder")
    annotation = None if which == "auto" else tested.annotation
    sdcs = annotation.sdcs if annotation else extracted
    result = grounder.follow(sdcs, tested.context, least=0.0, insist=True)
    plan = result.plan
    if plan is None:
        return _judged(tested, heading, why=result.note)
    right, total = _objects(annotation, result) if annotation else (0, 0)
    return _judged(
        tested,
        heading,
        plan.actions,
        plan.state,
        probability=plan.probability,
        evidence=plan.evidence,
        objects=(total, right),
    )


def _by_baseline(which: str, tested: JudgedCommand, heading: str) -> Outcome:
    start = start_state(tested.context)
    actions = BASELINES[which](scene_of(tested.command.text, start, tested.loads))
    if not actions:
        return _judged(tested, heading, why=NOTHING_TO_LIFT)
    return _judged(tested, heading, actions, carried_out(start, actions))


def _judged(
    tested: JudgedCommand,
    heading: str,
    actions: Sequence[Action] = (),
    final: State | None = None,
    *,
    probability: float = 0.0,
    evidence: tuple[float, ...] = (),
    objects: tuple[int, int] = (0, 0),
    why: str = "",
) -> Outcome:
    """The outcome of a plan; of a refusal, for a reason, without a state that it leads to."""
    own, theme = tested.command, None if tested.picked is None else False
    verdict = Verdict(False, why)
    by_words = verdict if tested.annotation else None
    if final is not None:
        start = start_state(tested.context)
        picked = picked_up(start, actions, final)
        theme = None if tested.picked is None else picked == tested.picked
        verdict = (
            judge(tested.context, final)
            if tested.done is None
            else judge_outcome(tested.done, picked, start, final)
        )
        if tested.annotation:
            by_words = judge_by_words(tested.annotation, planned(tested.context, actions))
    return Outcome(
        own.id,
        own.scenario,
        own.text,
        probability,
        verdict.correct,
        verdict.reason,
        *objects,
        evidence,
        by_words=by_words.correct if by_words else None,
        words_reason=by_words.reason if by_words else "",
        theme=theme,
        refused=final is None,
        heading=heading,
    )


def _objects(annotation: Annotation, result: Result) -> tuple[int, int]:
    """How many annotated OBJECTs are grounded as annotated, and how many there are."""
    given = {g.node: object_ids(g.group) for g in result.plans[0].groundings}
    right = total = 0
    for node, sdc in enumerate(Tree(annotation.sdcs).nodes):
        groundings = annotation.groundings[node]
        if sdc.type != "OBJECT" or not all(isinstance(g, PhysicalObject) for g in groundings):
            continue
        if groundings and annotation.correct[node]:
            total += 1
            right += set(given.get(node, ())) == set(object_ids(groundings))
    return right, total
