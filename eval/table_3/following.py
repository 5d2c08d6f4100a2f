"""A command followed by a model or another grounder, and the plan judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from corpus_tools.following.plan_steps import carried_out, why_impossible
from eval.judging.execution import planned
from eval.judging.judge import Verdict, picked_up
from eval.judging.judge_registry import AUTOMATIC, JudgedPlan, PlanJudge, judge_named
from eval.judging.words_judge import judge_by_words, why_not_judged
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, Proposal
from eval.table_3.judged_commands import JudgedCommand
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_rows import ALONE, MODELS, PAPERS_OWN
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.groundings import PhysicalObject, object_ids
from g3.inference.grounder import Grounder, Result
from g3.inference.potentials.potential_registry import potentials
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost
from g3.language.discourse.groups import noun_leaf
from g3.language.parsing.trees import Parse
from g3.sdc.clauses import SDC, all_words

CONFIGURATIONS = (*ALONE, PAPERS_OWN, *MODELS)
NO_PLAN = "no plan was made"


@dataclass(frozen=True, slots=True)
class FollowedPlan:
    """A plan for a command, as a model or a grounder made it.

    Parameters
    ----------
    final
        State after the plan; None where there is no plan.
    evidence
        Evidence from which its probability was calibrated.
    objects
        Number of annotated OBJECTs, and of those grounded as annotated.
    """

    proposal: Proposal
    final: State | None = None
    evidence: tuple[float, ...] = ()
    objects: tuple[int, int] = (0, 0)


def follow_command(
    which: str,
    tested: JudgedCommand,
    extracted: Sequence[SDC] | Parse,
    grounder: Grounder,
) -> Outcome:
    """Follow a command by a model in its own world and judge the plan, however improbable it is.

    The parameters are those of :func:`plan_by_model`.
    """
    return judged(tested, plan_by_model(which, tested, extracted, grounder))


def plan_by_model(
    which: str,
    tested: JudgedCommand,
    extracted: Sequence[SDC] | Parse,
    grounder: Grounder,
) -> FollowedPlan:
    """Make a plan by a model.

    Parameters
    ----------
    which
        ``gold``, or ``random`` and ``paper`` where the command is annotated, take its annotated
        clauses. All others take those that were extracted, ``paper`` the best tree alone.
    extracted
        The command's clauses as they are extracted from its text, maybe several trees.
    grounder
        With the costs of the configuration.
    """
    annotation = tested.annotation if which in ("gold", "random", PAPERS_OWN) else None
    sdcs = annotation.sdcs if annotation else extracted
    if which == PAPERS_OWN and isinstance(sdcs, Parse):
        sdcs = replace(sdcs, trees=sdcs.trees[:1])
    result = grounder.follow(sdcs, tested.context, least=0.0, insist=True)
    followed = plan_of(result)
    grounded = annotation if result.plan else None
    return replace(followed, objects=_objects(grounded, result)) if grounded else followed


def papers_own(cost: Cost) -> Grounder:
    """Return the paper's own model: correspondence factors and the beam, without rules of ours."""
    return Grounder(cost, without=[p.name for p in potentials()], rewriting=False)


def plan_of(result: Result) -> FollowedPlan:
    """Return a model's best plan, or the reason for its absence."""
    plan = result.plan
    if plan is None:
        return FollowedPlan(Proposal(note=result.note))
    return FollowedPlan(Proposal(plan.actions, plan.probability), plan.state, plan.evidence)


def task_of(tested: JudgedCommand, heading: str = "") -> PlanTask:
    """Return a grounder's task: the command and its world, without the execution."""
    own = tested.command
    start = start_state(tested.context)
    return PlanTask(own.text, start, tested.loads, own.id, own.scenario, heading)


def plan_by_grounder(grounder: PlanGrounder, task: PlanTask, learned: Any = None) -> FollowedPlan:
    """Have a grounder propose a plan, and carry it out if that is possible."""
    start, proposal = task.start, grounder.propose(task, learned)
    why_not = "" if proposal.actions else proposal.note or NO_PLAN
    why_not = why_not or why_impossible(start, proposal.actions)
    if why_not:
        return FollowedPlan(Proposal(note=why_not))
    return FollowedPlan(proposal, carried_out(start, proposal.actions))


def judged(
    tested: JudgedCommand, own: FollowedPlan, heading: str = "", judge: PlanJudge | None = None
) -> Outcome:
    """Return the outcome of a plan; a missing plan is wrong, with its note as the reason.

    The first verdict is the judge's, or the automatic one's if none is given.
    """
    command, theme = tested.command, None if tested.picked is None else False
    verdict = Verdict(False, own.proposal.note)
    by_words = verdict if tested.annotation else None
    if own.final is not None:
        start, actions = start_state(tested.context), tuple(own.proposal.actions)
        picked = picked_up(start, actions, own.final)
        theme = None if tested.picked is None else picked == tested.picked
        execution = planned(tested.context, actions)
        case = JudgedPlan(
            command.text,
            replace(execution, end=own.final),
            actions,
            tested.context,
            tested.annotation,
            tested.done,
        )
        verdict = (judge or judge_named(AUTOMATIC)).verdict(case)
        by_words = judge_by_words(tested.annotation, execution)
    total, right = own.objects
    return Outcome(
        command.id,
        command.scenario,
        command.text,
        own.proposal.probability,
        verdict.correct,
        verdict.reason,
        total,
        right,
        own.evidence,
        by_words=by_words.correct if by_words else None,
        words_reason=by_words.reason if by_words else why_not_judged(tested.annotation),
        theme=theme,
        refused=own.final is None,
        heading=heading,
    )


def _objects(annotation: Annotation, result: Result) -> tuple[int, int]:
    """Count annotated OBJECTs, and those of them that are grounded as annotated.

    The plan may be of other clauses than the annotated ones, so they are compared by their words.
    """
    grounded = {g.node: object_ids(g.group) for g in result.plans[0].groundings}
    nodes = Tree(result.sdcs).nodes
    given = {all_words(s): grounded.get(n, ()) for n, s in enumerate(nodes) if s.type == "OBJECT"}
    right = total = 0
    for node, sdc in enumerate(Tree(annotation.sdcs).nodes):
        groundings = annotation.groundings[node]
        if sdc.type != "OBJECT" or not all(isinstance(g, PhysicalObject) for g in groundings):
            continue
        if groundings and annotation.correct[node]:
            total += 1
            same = given.get(all_words(sdc), given.get(noun_leaf(sdc).words, ()))
            right += set(same) == set(object_ids(groundings))
    return total, right
