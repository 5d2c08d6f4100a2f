"""A corpus written for slu_core's programs is read again as it was."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.exporters.slu_core import MARKER, slu_core_files
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core
from corpus_tools.runtime.atomic_folder import write_folder
from g3.annotation import Annotation, Judgment
from g3.sdc.clauses import SDC, Span
from tests.tiny_corpus import tiny_corpus


def again(corpus: Corpus, folder: Path) -> Corpus:
    write_folder(folder, slu_core_files(corpus), force=False, marker=MARKER)
    return import_slu_core(folder, salt="salt")[0]


def texts(corpus: Corpus) -> list[str]:
    return sorted(command.text for command in corpus.commands.values())


def test_annotations_come_back(tmp_path: Path) -> None:
    corpus = tiny_corpus()
    found = again(corpus, tmp_path / "out")
    assert texts(found) == texts(corpus)
    assert len(found.annotations) == len(corpus.annotations)
    by_text = {(a.command.text, a.command.scenario, a.source): a for a in found.annotations}
    for annotation in corpus.annotations:
        command = annotation.command
        read = by_text[command.text, command.scenario, annotation.source]
        assert read.sdcs == annotation.sdcs
        assert read.groundings == annotation.groundings
        assert read.correct == annotation.correct
        assert read.context.objects == annotation.context.objects


def test_clauses_that_readers_would_give_a_figure(tmp_path: Path) -> None:
    corpus = tiny_corpus()
    first = corpus.annotations[0]
    command = replace(first.command, text="Stop now")
    tree = SDC("EVENT", relation=(Span(0, "Stop"),))
    changed = replace(
        first, command=command, sdcs=(tree,), groundings=first.groundings[:1], correct=(True,)
    )
    small = Corpus.build(
        "small", contexts=[first.context], commands=[command], annotations=[changed], source=""
    )
    (read,) = again(small, tmp_path / "out").annotations
    assert read.sdcs == (replace(tree, figure=(SDC("OBJECT"),)),)
    assert read.groundings == (first.groundings[0], ())
    assert read.correct == (True, None)


def test_what_nobody_has_said_is_left_out(tmp_path: Path) -> None:
    corpus = tiny_corpus()
    right, wrong = corpus.annotations[:2]
    unsaid = replace(wrong, correct=tuple(None for _ in wrong.correct))
    small = Corpus.build(
        "small",
        contexts=[right.context],
        commands=[right.command],
        annotations=[right, unsaid],
        source="",
    )
    read = again(small, tmp_path / "out").annotations[1]
    assert read.source == "random"
    assert set(read.correct) == {None}
    assert not any(read.groundings)


def test_judgments_come_back(tmp_path: Path) -> None:
    corpus = tiny_corpus()
    command = next(iter(corpus.commands.values()))
    judgment = Judgment("j", command.text, command.video, "another video", "SA", "rater", "mine")
    found = again(replace(corpus, judgments=(judgment,)), tmp_path / "out").judgments
    assert [(j.command, j.command_video, j.shown_video, j.rating) for j in found] == [
        (command.text, command.video, "another video", "SA")
    ]


def test_authored_commands_come_back(tmp_path: Path) -> None:
    whole = open_corpus("warehouse")
    world = next(iter(whole.contexts.values()))
    kept = [a for a in whole.annotations if a.context == world and a.source != "hard"]
    commands = {a.command.id: a.command for a in kept}
    part = Corpus.build(
        "part", contexts=whole.contexts.values(), commands=commands.values(), annotations=kept,
        source="",
    )  # fmt: skip
    found = again(part, tmp_path / "out")
    assert texts(found) == texts(part)
    assert len(found.annotations) == len(kept) > 10
    assert Counter(labels(found.annotations)) == Counter(labels(kept))


def labels(annotations: Iterable[Annotation]) -> Iterator[bool]:
    every = (label for annotation in annotations for label in annotation.correct)
    return (label for label in every if label is not None)
