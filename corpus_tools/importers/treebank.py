"""Treebanks: commands with SDC trees in bracket notation, without worlds and groundings.

A treebank is a folder with ``trees.jsonl`` and, where somebody has more to say of it,
``people.jsonl`` and ``dataset.yaml``; ``datasets/treebank`` is one. Its corpus has a context for
each domain, in which there is nothing but a robot.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar, get_args

import msgspec
import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.report import ImportReport, Journal, SourceFile
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.runtime.shipped import DATASET
from corpus_tools.tables.json_text import json_lines
from corpus_tools.world.scenarios.documents import read_document
from g3.annotation import Annotation, Command
from g3.errors import CorpusError, FormatError
from g3.groundings import Aspect, Context, PhysicalObject, Prism, Trajectory
from g3.sdc.clauses import SDC, SDC_TYPES, Span, breadth_first
from g3.sdc.sdc_notation import parse_brackets
from g3.sdc.word_alignment import FieldWord, align_words
from g3.short_repr import short_repr
from g3.storage import regular_file

IMPORTER = "treebank"
TREES, PEOPLE, SECOND = "trees.jsonl", "people.jsonl", "second.jsonl"
FIX = "docs/treebanks.md describes the file"
DOMAIN = "commands"
"""Domain of commands that name none."""

T = TypeVar("T", bound=msgspec.Struct)


class TreeRow(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True
):
    """A line of trees.jsonl: a command with its top-level clauses, one notation each."""

    id: str
    person: str = ""
    domain: str = DOMAIN
    text: str
    trees: tuple[str, ...]
    taken_back: str = ""


class SecondRow(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line of second.jsonl: the trees of a command by a second annotator."""

    id: str
    trees: tuple[str, ...]
    taken_back: str = ""


class PersonRow(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A line of people.jsonl: a person, and the group of people that are held out together."""

    person: str
    domain: str = ""
    description: str = ""
    split_group: int | str = ""


class DatasetFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The file dataset.yaml: the treebank's name, source and licence."""

    name: str
    source: str = ""
    licence: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class TreebankCommand:
    """A command of a treebank.

    Parameters
    ----------
    split_group
        People of one group are held out together: they have something in common, such as the
        writer who imitated them. Without groups it is the person.
    trees
        Top-level clauses; none if the command asks for nothing.
    taken_back
        Words that the person takes back, which are in no clause.
    """

    id: str
    person: str
    domain: str
    split_group: str
    text: str
    trees: tuple[SDC, ...]
    taken_back: tuple[Span, ...] = ()


def read_treebank(folder: Path | str) -> list[TreebankCommand]:
    """Read the commands of a treebank, in the order of their file."""
    return _read(Path(folder), Journal(keep_going=False))


def read_second_trees(folder: Path | str) -> dict[str, tuple[SDC, ...]]:
    """Read the trees of the second annotator by the commands' ids."""
    texts = {command.id: command.text for command in read_treebank(folder)}
    path, found = Path(folder) / SECOND, {}
    for number, row in json_lines(path, SecondRow, fix=FIX):
        if row.id not in texts:
            raise FormatError.unknown("command", row.id, texts, where=f"{path}:{number}")
        found[row.id], _ = trees_of(row.trees, row.taken_back, texts[row.id])
    return found


def import_treebank(
    path: Path,
    *,
    salt: str = "",
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read a treebank as a corpus: see `corpus_tools.importers.importer_registry.ImportFunction`.

    A command's subject is its person, its scenario the group of people that are held out together,
    and its context the domain. A command that asks for nothing has an annotation without clauses.
    """
    on_progress("reading", 0, 1)
    journal = Journal(keep_going)
    dataset = _dataset(path)
    found = _read(path, journal)
    journal.check()
    domains = dict.fromkeys(one.domain for one in found)
    contexts = {domain: robot_alone(domain) for domain in domains}
    commands = {
        one.id: Command(one.id, one.text, one.split_group, subject=one.person) for one in found
    }
    corpus = Corpus.build(
        dataset.name,
        contexts=contexts.values(),
        commands=commands.values(),
        annotations=[_annotation(one, commands[one.id], contexts[one.domain]) for one in found],
        source=dataset.source,
        licence=dataset.licence,
    )
    not_imported = {SECOND: 1} if (path / SECOND).is_file() else {}
    return corpus, journal.report(IMPORTER, _counts(found), not_imported)


def is_treebank(folder: Path) -> bool:
    """Check that a folder has the trees of a treebank."""
    return (folder / TREES).is_file()


def _read(folder: Path, journal: Journal) -> list[TreebankCommand]:
    if folder.exists() and not is_treebank(folder):
        raise FormatError(f"this is no treebank: it has no {TREES}", where=str(folder), fix=FIX)
    groups: dict[str, str] = {}
    if (folder / PEOPLE).is_file():
        for number, person in _rows(folder / PEOPLE, PersonRow, journal):
            if person.person in groups:
                twice = FormatError("the person is there twice", where="person", fix=FIX)
                journal.skip(f"{PEOPLE}:{number}", person.person, twice)
            group = person.split_group
            groups[person.person] = f"writer-{group}" if isinstance(group, int) else group
    else:
        journal.missing.append(PEOPLE)
    found: dict[str, TreebankCommand] = {}
    for number, row in _rows(folder / TREES, TreeRow, journal):
        try:
            if row.id in found:
                raise FormatError("another command has the id", where="id", fix=FIX)
            if groups and row.person and row.person not in groups:
                raise FormatError.unknown("person", row.person, groups, where="person")
            trees, taken_back = trees_of(row.trees, row.taken_back, row.text)
        except CorpusError as error:
            problem = FormatError(error.what, where=error.where, fix=error.fix)
            journal.skip(f"{TREES}:{number}", row.id, problem)
            continue
        group = groups.get(row.person) or row.person or DOMAIN
        found[row.id] = TreebankCommand(
            row.id, row.person, row.domain, group, row.text, trees, taken_back
        )
    journal.check()
    return list(found.values())


def _rows(path: Path, kind: type[T], journal: Journal) -> Iterator[tuple[int, T]]:
    rows = list(json_lines(path, kind, fix=FIX))
    content = regular_file.read_bytes(path)
    journal.files.append(SourceFile(path.name, hashlib.sha256(content).hexdigest(), len(rows)))
    yield from rows


def trees_of(
    trees: Sequence[str], taken_back: str, text: str
) -> tuple[tuple[SDC, ...], tuple[Span, ...]]:
    """Return a command's top-level clauses, and the words that are taken back.

    A word that is taken back is in no clause: of a repeated word, clauses have another copy.
    """
    words = [FieldWord(word, where="taken_back") for word in taken_back.split()]
    (spans,) = align_words([words], text)
    rest = list(text)
    for span in spans:
        rest[span.start : span.end] = " " * len(span.text)
    if not trees:
        return (), spans
    return parse_brackets("\n".join(trees), command="".join(rest)), spans


def _dataset(folder: Path) -> DatasetFile:
    path = folder / DATASET
    if not path.is_file():
        return DatasetFile(folder.resolve().name)
    content = read_document(path, DATASET).value
    try:
        return msgspec.convert(content, DatasetFile)
    except msgspec.ValidationError as error:
        raise FormatError(
            str(error), where=str(path), fix="docs/treebanks.md describes it"
        ) from error


def robot_alone(domain: str) -> Context:
    """Return the context of a domain: a robot alone, of which all is assumed."""
    square = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    still = Trajectory(np.zeros(1), np.zeros((1, 3)), np.zeros(1))
    robot = PhysicalObject("robot", ("robot",), Prism(square, 0.0, 1.0), still)
    assumed = tuple((robot.id, aspect) for aspect in get_args(Aspect))
    return Context(domain, (robot,), (), robot.id, assumed)


def _annotation(one: TreebankCommand, command: Command, context: Context) -> Annotation:
    clauses = sum(1 for _ in breadth_first(one.trees))
    return Annotation(
        id=f"{one.id}/positive",
        command=command,
        context=context,
        sdcs=one.trees,
        groundings=((),) * clauses,
        correct=(None,) * clauses,
        source="positive",
        taken_back=one.taken_back,
    )


def _counts(found: list[TreebankCommand]) -> dict[str, int]:
    types = Counter(sdc.type for one in found for sdc in breadth_first(one.trees))
    return {
        "commands": len(found),
        "commands that ask for nothing": sum(not one.trees for one in found),
        "commands with words taken back": sum(bool(one.taken_back) for one in found),
        "people": len({one.person for one in found}),
        "groups of people": len({one.split_group for one in found}),
        "domains": len({one.domain for one in found}),
        **{f"{name} clauses": types[name] for name in SDC_TYPES},
    }
