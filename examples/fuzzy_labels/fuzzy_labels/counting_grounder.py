"""A grounder that learns what things are called, by counting."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TypeAlias

from corpus_tools.corpus.answer_records import PlanStep
from corpus_tools.following.plan_steps import read_steps
from eval.table_3.grounder_registry import PlanTask, Proposal, grounder
from g3.annotation import Annotation
from g3.groundings import PhysicalObject
from g3.sdc.clauses import all_words, breadth_first

Said: TypeAlias = dict[str, Counter[str]]


def learn(annotations: Sequence[Annotation]) -> Said:
    """Count the words of commands by the labels of the things that they name."""
    said: Said = {}
    for annotation in annotations:
        if annotation.source != "positive":
            continue
        clauses = breadth_first(annotation.sdcs)
        for clause, group in zip(clauses, annotation.groundings, strict=True):
            words = [word.text.lower() for word in all_words(clause)]
            for label in {name for thing in group for name in getattr(thing, "labels", ())}:
                said.setdefault(label, Counter()).update(words)
    return said


@grounder("counts", fit=learn)
def counts(task: PlanTask, said: Said) -> Proposal:
    """Pick up the load that was most often called so."""

    def score(thing: PhysicalObject) -> int:
        return sum(said.get(label, Counter())[w] for label in thing.labels for w in task.words)

    if not task.loads or task.start.held:
        return Proposal(note="there is no load to pick up")
    load = max(task.loads, key=score)
    plan = read_steps([PlanStep(action="pick up", object=load.id)], task.start)
    return Proposal(plan.actions, 0.5, plan.why_not)
