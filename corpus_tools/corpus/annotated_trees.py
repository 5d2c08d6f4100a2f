"""The commands of a corpus that have annotated SDC trees, as they are or typed in another way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation, Command
from g3.errors import CorpusError
from g3.language.parsing.perturbation import perturb
from g3.sdc.clauses import SDC


class Annotated(NamedTuple):
    """A command and its annotated top-level clauses."""

    command: Command
    sdcs: tuple[SDC, ...]


def annotated_trees(corpus: Corpus) -> list[Annotated]:
    """List each annotated command of a corpus once, with its first annotation's trees.

    A command that asks for nothing has none.
    """
    by_command: dict[str, Annotated] = {}
    for annotation in corpus.annotations:
        command = annotation.command
        by_command.setdefault(command.id, Annotated(command, annotation.sdcs))
    if not any(annotated.sdcs for annotated in by_command.values()):
        raise CorpusError(
            "no command has SDC trees",
            where=f"corpus {corpus.name}",
            fix="take a corpus with annotations ('ct corpus stats' counts them)",
        )
    return list(by_command.values())


def annotated_commands(annotations: Iterable[Annotation]) -> dict[str, Annotation]:
    """Return the first positive annotation of each command, by the command's id."""
    by_command: dict[str, Annotation] = {}
    for annotation in annotations:
        if annotation.source == "positive":
            by_command.setdefault(annotation.command.id, annotation)
    return by_command


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
