"""A corpus's trees without worlds: a treebank, and Universal Dependencies.

:mod:`corpus_tools.importers.treebank` reads treebanks.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import msgspec
import yaml

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.treebank import PEOPLE, TREES, DatasetFile, PersonRow, TreeRow, trees_of
from corpus_tools.runtime.shipped import DATASET
from g3.annotation import Annotation
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import format_brackets
from g3.storage.text_lines import split_lines


def treebank_files(corpus: Corpus) -> dict[str, bytes]:
    """Return the trees of the annotated commands, and their people.

    A domain is a command's context. People whose commands are all of one scenario have it as their
    group.
    """
    rows = [_row(annotation) for annotation in annotated_commands(corpus.annotations).values()]
    by_person: dict[str, list[TreeRow]] = defaultdict(list)
    for row in rows:
        by_person[row.person].append(row)
    people = [
        PersonRow(
            person,
            domain=_only(row.domain for row in own),
            split_group=_only(corpus.commands[row.id].scenario for row in own),
        )
        for person, own in by_person.items()
        if person
    ]
    about = DatasetFile(corpus.name, corpus.source, corpus.licence)
    encode = msgspec.json.Encoder().encode_lines
    dataset = yaml.safe_dump(msgspec.structs.asdict(about), sort_keys=False, allow_unicode=True)
    files = {DATASET: dataset.encode(), TREES: encode(rows)}
    return {**files, PEOPLE: encode(people)} if people else files


def _only(names: Iterable[str]) -> str:
    """Return the name if it is always the same, else none."""
    first, *others = dict.fromkeys(names)
    return "" if others else first


def _row(annotation: Annotation) -> TreeRow:
    """Return the trees in brackets; with positions where words would be found elsewhere."""
    command, text = annotation.command, annotation.command.text
    plain = TreeRow(
        id=command.id,
        text=text,
        trees=tuple(split_lines(format_brackets(annotation.sdcs))) if annotation.sdcs else (),
        person=command.subject,
        domain=annotation.context.id,
        taken_back=" ".join(word.text for word in annotation.taken_back),
    )
    if trees_of(plain.trees, plain.taken_back, text) == (annotation.sdcs, annotation.taken_back):
        return plain
    placed = split_lines(format_brackets(annotation.sdcs, positions=True))
    return msgspec.structs.replace(plain, trees=tuple(placed))


NAME = "corpus.conllu"


def conllu_files(corpus: Corpus) -> dict[str, bytes]:
    """Return a sentence for each command; annotated ones have their clauses in MISC.

    The syntax is spaCy's, converted (:mod:`g3.language.parsing.universal_dependencies`). Commands
    without a word are left out. Raises ModelError if the parser of English isn't installed.
    """
    from g3.language.parsing.conllu import to_conllu  # noqa: PLC0415 - slow to import
    from g3.language.parsing.spacy_pipeline import analyse  # noqa: PLC0415 - as above

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
