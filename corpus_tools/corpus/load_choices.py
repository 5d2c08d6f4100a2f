"""The commands of a corpus with the loads that they were about, as models learn from them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.task_outcomes import contexts_of_commands, outcomes_of
from g3.actions.robot_state import start_state
from g3.annotation import Annotation, Command
from g3.groundings import Context, PhysicalObject
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked, frame
from g3.inference.problem.loads_of_state import loads_of
from g3.language.lexicon.field_words import text_words
from g3.learning.load_choice import LoadChoice


def load_choices(corpus: Corpus) -> list[LoadChoice]:
    """Find which load each command was about: by outcomes, else by annotations.

    Commands without a known load, and those that began with a load on the forks, are left out.
    """
    contexts = contexts_of_commands(corpus)
    choices = []
    annotated = annotated_commands(corpus.annotations)
    for command in corpus.commands.values():
        outcomes = outcomes_of(corpus, command)
        picked = {thing for o in outcomes for thing in o.picked}
        if any({"picked", "rest"} & set(o.unknown) for o in outcomes):
            continue
        if command.id in annotated and not outcomes:
            context = annotated[command.id].context
            picked = set(_handled(annotated[command.id]))
        elif command.id in contexts:
            context = corpus.contexts[contexts[command.id]]
        else:
            continue
        choice = _choice(command, context, picked, corpus)
        if any(choice.right):
            choices.append(choice)
    return choices


def load_choices_of(corpora: Sequence[Corpus]) -> list[LoadChoice]:
    """Return the load choices of several corpora; none where no corpus has outcomes.

    Annotated commands train the factors of clauses, which determine the load more precisely.
    """
    if not any(outcome.picked for corpus in corpora for outcome in corpus.outcomes):
        return []
    return [choice for corpus in corpora for choice in load_choices(corpus)]


def _choice(command: Command, context: Context, right_ids: set[str], corpus: Corpus) -> LoadChoice:
    state = start_state(context)
    loads = loads_of(state) if state.held is None else {}
    right = tuple(load in right_ids for load in loads)
    return LoadChoice(
        text_words(command.text),
        tuple(loads.values()),
        right,
        corpus.name,
        command.scenario,
        command.subject,
    )


def _handled(annotation: Annotation) -> Iterator[str]:
    """Yield the id of the thing that the first handling clause is about, if it is only one."""
    tree = Tree(annotation.sdcs)
    for clause in (frame(tree, node) for node in asked(tree)):
        if not clause.handles:
            continue
        for node in clause.objects[:1]:
            things = [g for g in annotation.groundings[node] if isinstance(g, PhysicalObject)]
            if len(things) == 1 and annotation.correct[node] is not False:
                yield things[0].id
        return
