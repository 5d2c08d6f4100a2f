"""Each row of the language's tables has its effect in its example, and a module that reads it."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from g3.language.discourse.exclusions import exclusions
from g3.language.discourse.negation import is_negation
from g3.language.lexicon import tables
from g3.language.lexicon.attribute_words import colours_named, sizes_named
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, normalise
from g3.language.lexicon.tables import WORDS, Row, Source, rows
from g3.language.lexicon.verb_classes import word_class
from g3.language.parsing.words import cut
from g3.language.similarity.word_similarity import domain

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = ("g3", "eval", "corpus_tools")
SOURCES = [p.read_text() for name in PACKAGES for p in (ROOT / name).rglob("*.py")]
READ = {
    name
    for text in SOURCES
    for name in re.findall(r'(?:WORDS|COUNTS|VALUES|FORMS|rows\(\))\["([^"]+)"\]', text)
}
KINDS = {kind for text in SOURCES for kind in re.findall(r'members\("(\w+)"\)', text)}


def words_of(text: str) -> list[str]:
    spans = [span.text.lower() for span in cut(text).spans]
    return [*text.lower().split(), *spans, *re.split(r"\W+", text.lower())]


def effect(row: Row) -> bool:
    """Check that a row is seen in its example by what looks it up."""
    kind, _, name = row.name.partition("/")
    words = words_of(row.example)
    plain = [bare(word) for word in words]
    if kind == "cue":
        return any(exclusions(cut(row.example).spans))
    if kind == "negation":
        return any(map(is_negation, words))
    if kind == "colour":
        return colours_named(plain) == {name}
    if kind == "size":
        sense = (name.removeprefix("-"), -1 if name.startswith("-") else 1)
        return any(sense in senses for senses in sizes_named(plain))
    if kind == "concept":
        return name in concepts(map(normalise, words))
    if kind == "class" and row.name not in READ:
        return any(name in word_class(word).split("+") for word in plain)
    if kind == "kind":
        return bool(domain(plain, [name]).any())
    if row.values or row.forms:
        phrases = [" ".join(pair) for pair in pairwise(map(normalise, row.example.split()))]
        return not {*row.values, *row.forms}.isdisjoint([*words, *phrases])
    forms = map(normalise, words) if row.stems else {*words, *plain}
    return not WORDS[row.name].isdisjoint(forms)


@pytest.mark.parametrize("row", rows().values(), ids=lambda row: row.name)
def test_each_row_has_its_effect_in_its_example(row: Row) -> None:
    assert effect(row)


def test_each_row_is_read_and_each_row_that_is_read_is_there() -> None:
    included = {name for row in rows().values() for name in row.include}
    of_kinds = {name for name in rows() if name.partition("/")[0] in KINDS}
    assert {*rows()} - READ - included - of_kinds == set()
    assert {*READ, *included} - {*rows()} == set()


def test_each_name_is_in_one_row_only_and_each_table_has_a_source() -> None:
    names: list[str] = []
    for path in sorted(tables.FOLDER.glob("*.jsonl")):
        source, *lines = path.read_bytes().splitlines()
        assert msgspec.json.decode(source, type=Source).source
        names += [msgspec.json.decode(line, type=Row).name for line in lines]
    assert len(names) == len(set(names))


def test_words_of_a_row_are_written_once() -> None:
    for row in rows().values():
        words = row.words.split()
        assert len(words) == len(set(words)), row.name
