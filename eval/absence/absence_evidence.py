"""Commands in worlds from which what they mean was removed, and nouns of anything at all.

Each command is given in its own world, where an alarm is false. It is also given in that world
without all things that share a label with something it means: there an alarm is right. What a model
would have learned of words and labels is learned from other scenarios alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.task_outcomes import contexts_of_commands, outcomes_of
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.annotation import Annotation, Command
from g3.errors import CorpusError
from g3.groundings import Context, PhysicalObject
from g3.inference.absence import how_present
from g3.inference.problem.command_tree import Tree
from g3.language.parsing.parser import parse
from g3.language.similarity.learned_lexicon import Lexicon
from g3.language.similarity.presence import best_naming, may_be_absent
from g3.language.similarity.resources import wordnet
from g3.learning.load_choice import lexicon_of

ANY_NOUNS = 20
"""How many nouns of WordNet are asked for in each world."""
SEEN = 5
"""Such a noun occurs at least so often in WordNet's tagged texts."""
PRESENT = 2.0
"""More than the evidence for anything: no noun of the command can be absent."""


@dataclass(frozen=True, slots=True)
class AbsenceEvidence:
    """How present the least present noun is, from 0 to 1; `PRESENT` where none can be absent.

    Parameters
    ----------
    own
        Of each command in its own world.
    removed
        Of each command in worlds without something that it means.
    any_noun
        Of nouns of WordNet in the corpus's worlds.
    alarms
        The nouns that are least present in commands' own worlds, with that.
    """

    corpus: str
    own: tuple[float, ...]
    removed: tuple[float, ...]
    any_noun: tuple[float, ...]
    alarms: tuple[tuple[str, float], ...]


def absence_evidence(
    corpora: Sequence[Corpus], seed: int, on_progress: OnProgress = no_progress
) -> list[AbsenceEvidence]:
    """Hold all commands of some corpora against their worlds, and against poorer ones."""
    choices = load_choices_of(corpora)
    rng = np.random.default_rng(seed)
    nouns = any_nouns()
    found = []
    for corpus in corpora:
        known = list(_known(corpus))
        if not known:
            raise CorpusError(
                "the world of none of its commands is known",
                where=f"corpus {corpus.name}",
                fix="take a corpus with annotations or outcomes",
            )
        own, removed, other = [], [], []
        alarms: list[tuple[str, float]] = []
        lexica: dict[str, Lexicon | None] = {}
        for done, (command, context, meant) in enumerate(known):
            on_progress(corpus.name, done, len(known))
            scenario = command.scenario
            if scenario not in lexica:
                rest = [c for c in choices if c.scenario != scenario]
                lexica[scenario] = lexicon_of(rest) if rest else None
                drawn = rng.choice(nouns, ANY_NOUNS, replace=False)
                labels = [o.labels for o in context.objects if o.id != context.agent_id]
                other += [best_naming(str(n), labels, lexica[scenario]) for n in drawn]
            trees = parse(command.text).trees
            if not trees:
                continue
            tree, lexicon = Tree(trees[0].sdcs), lexica[scenario]
            present = how_present(tree, context, lexicon)
            own.append(min(present.values(), default=PRESENT))
            alarms += present.items()
            for labels_of in dict.fromkeys(meant):
                poorer = how_present(tree, without(context, labels_of), lexicon)
                removed.append(min(poorer.values(), default=PRESENT))
        worst = tuple(sorted(alarms, key=lambda alarm: alarm[1]))
        found.append(
            AbsenceEvidence(corpus.name, tuple(own), tuple(removed), tuple(other), worst[:50])
        )
    return found


def without(context: Context, labels: Sequence[str]) -> Context:
    """A world without all things, but the robot, that have one of some labels."""
    gone = frozenset(labels)
    left = (o for o in context.objects if o.id == context.agent_id or not gone & set(o.labels))
    return replace(context, objects=tuple(left))


def any_nouns() -> list[str]:
    """Common nouns of WordNet that name things or stuff."""
    net = wordnet()
    return sorted(
        word
        for word, senses in net.senses.items()
        if word.isalpha()
        and sum(net.frequency.get(s, 0) for s in senses) >= SEEN
        and may_be_absent(word)
    )


def _known(corpus: Corpus) -> Iterator[tuple[Command, Context, list[tuple[str, ...]]]]:
    """Commands with their worlds, and the labels of each thing that they mean."""
    annotated, contexts = annotated_commands(corpus.annotations), contexts_of_commands(corpus)
    for command in corpus.commands.values():
        if not command.text.strip():
            continue
        if command.id in annotated:
            annotation = annotated[command.id]
            yield command, annotation.context, _meant(annotation)
        elif command.id in contexts:
            context = corpus.contexts[contexts[command.id]]
            picked = {thing for o in outcomes_of(corpus, command) for thing in o.picked}
            yield command, context, [o.labels for o in context.objects if o.id in picked]


def _meant(annotation: Annotation) -> list[tuple[str, ...]]:
    """The labels of the things that the OBJECTs with nouns of their own are grounded in."""
    tree = Tree(annotation.sdcs)
    starts = {noun[-1].start for noun in tree.nouns}
    return [
        g.labels
        for sdc, groundings in zip(tree.nodes, annotation.groundings, strict=True)
        if sdc.type == "OBJECT" and sdc.words and sdc.words[-1].start in starts
        for g in groundings
        if isinstance(g, PhysicalObject) and g.id != annotation.context.agent_id
    ]
