"""A corpus's commands as Universal Dependencies, with the clauses of its annotations."""

from __future__ import annotations

from corpus_tools.corpus.corpus_model import Corpus
from g3.language.parsing.conllu import to_conllu
from g3.language.parsing.spacy_pipeline import analyse
from g3.sdc.clauses import SDC

NAME = "corpus.conllu"


def conllu_files(corpus: Corpus) -> dict[str, bytes]:
    """Return a sentence for each command; annotated ones have their clauses in MISC.

    The syntax is spaCy's, converted (:mod:`g3.language.parsing.universal_dependencies`). Commands
    without a word are left out. Raises ModelError if the parser of English isn't installed.
    """
    clauses: dict[str, tuple[SDC, ...]] = {}
    for annotation in corpus.annotations:
        clauses.setdefault(annotation.command.id, annotation.sdcs)
    commands = list(corpus.commands.values())
    sentences = (
        to_conllu(
            analysis,
            clauses.get(command.id, ()),
            sent_id=f"{number}-{command.id}".replace(" ", "_"),
            comments={"command_id": command.id, "scenario": command.scenario},
        )
        for number, (command, analysis) in enumerate(
            zip(commands, analyse([c.text for c in commands]), strict=True), start=1
        )
    )
    return {NAME: "".join(f"{text}\n" for text in sentences if text).encode()}
