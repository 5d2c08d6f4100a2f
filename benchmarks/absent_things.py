"""Alarms about absent things: ``python -m benchmarks.absent_things warehouse aaai11 automatic``.

Each command is given in its own world, where an alarm is false. It is also given in that world
without all things that share a label with something it means, where an alarm is right. Nouns of
WordNet are requested in each world. Words are learned from other scenarios alone.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.task_outcomes import contexts_of_commands, outcomes_of
from corpus_tools.importers.authored.bundled import open_corpus
from g3.annotation import Annotation
from g3.groundings import Context, PhysicalObject
from g3.inference.absence import how_present
from g3.inference.problem.command_tree import Tree
from g3.language.parsing.parser import parse
from g3.language.similarity.presence import best_naming, least_alike, may_be_absent
from g3.language.similarity.resources import wordnet
from g3.learning.load_choice import LoadChoice, lexicon_of

NOUNS_PER_WORLD = 20
LEAST_FREQUENCY = 5
"""In WordNet's tagged texts."""


def world_without(context: Context, labels: Sequence[str]) -> Context:
    """Return a world without the things, except the robot, that have one of some labels."""
    left = (o for o in context.objects if o.id == context.agent_id or not {*labels} & {*o.labels})
    return replace(context, objects=tuple(left))


def common_nouns() -> list[str]:
    """Return common nouns of WordNet that name things or stuff."""
    net = wordnet()
    return sorted(
        word
        for word, senses in net.senses.items()
        if word.isalpha()
        and sum(net.frequency.get(s, 0) for s in senses) >= LEAST_FREQUENCY
        and may_be_absent(word)
    )


def commands_in_worlds(
    corpus: Corpus,
) -> Iterator[tuple[str, str, Context, list[tuple[str, ...]]]]:
    """Yield scenario, text and world of each command, with the labels of each thing it means."""
    annotated, contexts = annotated_commands(corpus.annotations), contexts_of_commands(corpus)
    for command in corpus.commands.values():
        if not command.text.strip():
            continue
        if command.id in annotated:
            annotation = annotated[command.id]
            yield command.scenario, command.text, annotation.context, _meant(annotation)
        elif command.id in contexts:
            context = corpus.contexts[contexts[command.id]]
            picked = {thing for o in outcomes_of(corpus, command) for thing in o.picked}
            labels = [o.labels for o in context.objects if o.id in picked]
            yield command.scenario, command.text, context, labels


def _meant(annotation: Annotation) -> list[tuple[str, ...]]:
    """Return the labels of the things that OBJECTs with their own nouns are grounded in."""
    tree = Tree(annotation.sdcs)
    starts = {noun[-1].start for noun in tree.nouns}
    return [
        g.labels
        for sdc, groundings in zip(tree.nodes, annotation.groundings, strict=True)
        if sdc.type == "OBJECT" and sdc.words and sdc.words[-1].start in starts
        for g in groundings
        if isinstance(g, PhysicalObject) and g.id != annotation.context.agent_id
    ]


def shares(
    corpus: Corpus, choices: Sequence[LoadChoice], rng: np.random.Generator
) -> Iterator[tuple[str, int, float]]:
    """Yield each kind, its number of cases, and the share of these with an alarm."""
    nouns, lexica = common_nouns(), {}
    alarms, total = Counter[str](), Counter[str]()

    def count(kind: str, presence: float) -> None:
        total[kind] += 1
        alarms[kind] += presence < least_alike()

    for scenario, text, context, meant in commands_in_worlds(corpus):
        if scenario not in lexica:
            rest = [choice for choice in choices if choice.scenario != scenario]
            lexica[scenario] = lexicon_of(rest) if rest else None
            labels = [o.labels for o in context.objects if o.id != context.agent_id]
            for noun in rng.choice(nouns, NOUNS_PER_WORLD, replace=False):
                count("any noun", best_naming(str(noun), labels, lexica[scenario]))
        if trees := parse(text).trees:
            tree = Tree(trees[0].sdcs)
            worlds = [context, *(world_without(context, labels) for labels in dict.fromkeys(meant))]
            for number, world in enumerate(worlds):
                present = how_present(tree, world, lexica[scenario])
                count("removed" if number else "false", min(present.values(), default=np.inf))
    yield from ((kind, total[kind], alarms[kind] / total[kind]) for kind in total)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.absent_things", description=__doc__)
    parser.add_argument("corpora", nargs="+", help="the corpora whose commands are given")
    corpora = [open_corpus(name) for name in parser.parse_args().corpora]
    rng, choices = np.random.default_rng(0), load_choices_of(corpora)
    for corpus in corpora:
        for kind, number, share in shares(corpus, choices, rng):
            print(f"{corpus.name:12} {kind:10} {number:5}  alarms {share:.3f}", flush=True)


if __name__ == "__main__":
    main()
