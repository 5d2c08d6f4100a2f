"""Plans for tests of rating sets, without making any."""

from corpus_tools.following.plan_execution import PlanScript
from corpus_tools.world.state.robot_script import WAIT, ScriptStep
from eval.plan_study.rating_sample import distinct_plans
from eval.plan_study.study_plans import PlanRecord


def waiting(seconds):
    return PlanScript((ScriptStep(WAIT.name, seconds),))


def record(configuration, command, scenario, script, *, right, **also):
    said = {"log": right, **also}
    return PlanRecord(
        configuration, command, scenario, "Go.", 0.5, right, "", script=script, verdicts=said
    )


def plans_of(kinds, *, configurations=("gold",), scenarios=4):
    """Plans that are right or wrong, each of a command of its own, in turn by scenario."""
    return distinct_plans(
        record(which, f"{which}{i:03}", f"s{i % scenarios}", waiting(1.0), right=kind == "right")
        for which in configurations
        for i, kind in enumerate(kinds)
    )
