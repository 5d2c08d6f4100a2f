"""A grounder that compares words with labels letter by letter, so that misspelt ones match."""

from collections.abc import Sequence

from rapidfuzz import fuzz, process

from corpus_tools.corpus.answer_records import PlanStep
from corpus_tools.following.plan_steps import read_steps
from eval.table_3.grounder_registry import PlanTask, Proposal, grounder
from g3.groundings import PhysicalObject


@grounder("fuzzy")
def fuzzy(task: PlanTask) -> Proposal:
    """Take the load whose label is most like a word, and put it on what follows "on"."""
    before, _, after = task.text.lower().partition(" on ")
    load, sure = most_alike(before, task.loads)
    goal, _ = most_alike(after, task.others)
    if load is None or task.start.held:
        return Proposal(note="there is no load to pick up")
    step = PlanStep(action="pick up", object=load.id)
    if after and goal is not None:
        step = PlanStep(action="carry", object=load.id, on=goal.id)
    plan = read_steps([step], task.start)
    return Proposal(plan.actions, sure, plan.why_not)


def most_alike(text: str, things: Sequence[PhysicalObject]) -> tuple[PhysicalObject | None, float]:
    """Return the thing with the label most like a part of a text, and their likeness, up to 1."""
    labels = {(n, label): label for n, thing in enumerate(things) for label in thing.labels}
    found = process.extractOne(text, labels, scorer=fuzz.partial_ratio)
    return (things[found[2][0]], found[1] / 100) if found else (None, 0.0)
