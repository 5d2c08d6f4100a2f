"""What baselines without a model would do with a study's commands; nobody is shown it."""

from __future__ import annotations

from corpus_tools.importers.authored.bundled import open_corpus
from eval.plan_study.study_plans import PlanRecord, chosen_commands
from eval.plan_study.study_settings import Settings
from eval.table_3.baselines import BASELINES, missing
from eval.table_3.following import judged, plan_by_grounder, task_of
from eval.table_3.grounder_registry import grounder_named
from eval.table_3.judged_commands import judged_commands


def baseline_records(settings: Settings) -> list[PlanRecord]:
    """The automatic judge's verdicts on baselines' plans for the commands of a study."""
    chosen = {annotation.command.id for annotation in chosen_commands(settings)}
    commands = [c for c in judged_commands(open_corpus(settings.test)) if c.command.id in chosen]
    names = [name for name in BASELINES if name not in missing()]
    outcomes = [
        (name, judged(command, plan_by_grounder(grounder_named(name), task_of(command))))
        for name in names
        for command in commands
    ]
    return [
        PlanRecord(name, o.command, o.scenario, o.text, o.probability, o.correct, o.reason)
        for name, o in outcomes
    ]
