"""Baselines stand beside a study's plans, and nobody is asked about them."""

from eval.plan_study.study_plans import Settings
from eval.plan_study.whole_study import baseline_outcomes, by_judge, compare_judge
from eval.table_3.baselines import BASELINES, missing


def test_each_command_of_a_study_has_a_verdict_on_each_baseline():
    outcomes = baseline_outcomes(Settings("warehouse", "warehouse", 1, 1.0, 0))
    assert set(outcomes) == {name for name in BASELINES if name not in missing()}
    scenarios = {o.scenario for o in outcomes["keywords"]}
    assert all(len(several) == len(scenarios) for several in outcomes.values())
    assert any(o.correct for o in outcomes["keywords"])
    rows = {row["configuration"]: row for row in by_judge(outcomes, seed=0, draws=20)}
    # A baseline that can't be run has a row without figures.
    assert set(BASELINES) <= set(rows)
    correct = [o.correct for o in outcomes["keywords"]]
    assert rows["keywords"]["precision"] == sum(correct) / len(correct)
    # The words are judged, too: not all plans of a baseline are wrong by them.
    assert rows["keywords"]["by_words"] > 0
    # Baselines aren't compared with each other.
    assert compare_judge(outcomes, seed=0, draws=20) == ()
