"""The commands of a corpus that have annotated SDC trees."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation, Command
from g3.errors import CorpusError
from g3.sdc.clauses import SDC


class Annotated(NamedTuple):
    """A command and its annotated top-level clauses."""

    command: Command
    sdcs: tuple[SDC, ...]


def annotated_trees(corpus: Corpus) -> list[Annotated]:
    """List each annotated command of a corpus once, with its first annotation's trees.

    A command that asks for nothing has none.

    Raises
    ------
    CorpusError
        If there are no trees.
    """
    found: dict[str, Annotated] = {}
    for annotation in corpus.annotations:
        command = annotation.command
        found.setdefault(command.id, Annotated(command, annotation.sdcs))
    if not any(annotated.sdcs for annotated in found.values()):
        raise CorpusError(
            "no command has SDC trees",
            where=f"corpus {corpus.name}",
            fix="take a corpus with annotations ('ct corpus stats' counts them)",
        )
    return list(found.values())


def annotated_commands(annotations: Iterable[Annotation]) -> dict[str, Annotation]:
    """Return the first positive annotation of each command, by the command's id."""
    found: dict[str, Annotation] = {}
    for annotation in annotations:
        if annotation.source == "positive":
            found.setdefault(annotation.command.id, annotation)
    return found
