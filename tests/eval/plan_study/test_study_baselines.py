"""Baselines stand beside a study's plans, and nobody is asked about them."""

from eval.plan_study.study_plans import Settings
from eval.plan_study.whole_study import baseline_records, by_judge, compare_judge
from eval.table_3.baselines import BASELINES, missing


def test_each_command_of_a_study_has_a_verdict_on_each_baseline():
    records = baseline_records(Settings("warehouse", "warehouse", 1, 1.0, 0))
    there = [name for name in BASELINES if name not in missing()]
    scenarios = {r.scenario for r in records}
    assert len(records) == len(there) * len(scenarios)
    assert {r.configuration for r in records} == set(there)
    assert any(r.correct for r in records)
    assert not any(r.run for r in records)
    rows = {row["configuration"]: row for row in by_judge(records, seed=0, draws=20)}
    # A baseline that can't be run has a row without figures.
    assert set(BASELINES) <= set(rows)
    assert rows["keywords"]["n"] == len(scenarios)
    own = [r.correct for r in records if r.configuration == "keywords"]
    assert rows["keywords"]["precision"] == sum(own) / len(own)
    # Baselines aren't compared with each other.
    assert compare_judge(records, seed=0, draws=20) == []
