"""A corpus whose commands are typed in another way (:mod:`g3.language.parsing.perturbation`)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

from corpus_tools.corpus.corpus_model import Corpus
from g3.language.parsing.perturbation import perturb
from g3.sdc.clauses import SDC


def with_perturbed_commands(corpus: Corpus, kind: str, *, seed: int = 0) -> Corpus:
    """Type all commands of a corpus in another way; annotations keep their groundings.

    `kind` is a name of :data:`g3.language.parsing.perturbation.PERTURBATIONS`. The corpus gets a
    hash of its own.
    """
    trees: dict[str, list[SDC]] = defaultdict(list)
    for annotation in corpus.annotations:
        trees[annotation.command.id] += annotation.sdcs
    typed = {
        command.id: perturb(command.text, kind, seed=seed, sdcs=trees[command.id])
        for command in corpus.commands.values()
    }
    commands = {
        command.id: replace(command, text=typed[command.id].text)
        for command in corpus.commands.values()
    }
    annotations = tuple(
        replace(
            a,
            command=commands[a.command.id],
            sdcs=typed[a.command.id].carry(a.sdcs),
            taken_back=(),  # typed another way, its words may be others
        )
        for a in corpus.annotations
    )
    return replace(corpus, commands=commands, annotations=annotations)
