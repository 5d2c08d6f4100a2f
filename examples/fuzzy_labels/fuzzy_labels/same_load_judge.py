"""A judge who looks at nothing but which loads are picked up."""

from eval.judging.judge import Verdict, picked_in_log, picked_up
from eval.judging.judge_registry import JudgedPlan, plan_judge


@plan_judge("same-load")
def same_load(plan: JudgedPlan) -> Verdict:
    """Accept a plan that picks up what was picked up for the command, and nothing else."""
    wanted = plan.done.picked if plan.done else picked_in_log(plan.context)
    found = picked_up(plan.execution.start, plan.actions, plan.execution.end)
    return Verdict(found == wanted, "" if found == wanted else "these are other loads")
