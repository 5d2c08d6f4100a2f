"""What is written is read back, and the same corpus gives the same bytes."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_records import ObjectReference
from corpus_tools.corpus.corpus_tables import content_hash, encode
from corpus_tools.corpus.corpus_validation import validate
from g3.annotation import Command, Judgment, TaskOutcome
from g3.groundings import PhysicalObject
from tests.strategies import corpora

few = settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))


def write_and_load(corpus: Corpus) -> Corpus:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "corpus"
        corpus.save(path)
        assert validate(path) == []
        return Corpus.load(path)


@few
@given(corpora())
def test_what_is_written_is_read_back(corpus: Corpus):
    loaded = write_and_load(corpus)
    assert loaded == corpus
    assert loaded.files() == corpus.files()
    assert_instances_are_shared(loaded)


def assert_instances_are_shared(loaded: Corpus):
    objects = {id(o): o for c in loaded.contexts.values() for o in c.objects}
    for annotation in loaded.annotations:
        assert annotation.command is loaded.commands[annotation.command.id]
        assert annotation.context is loaded.contexts[annotation.context.id]
        for groundings in annotation.groundings:
            for grounding in groundings:
                if isinstance(grounding, PhysicalObject) and grounding in objects.values():
                    assert id(grounding) in objects


@few
@given(corpora())
def test_the_hash_sees_everything_but_subjects_and_the_name(corpus: Corpus):
    renamed = replace(
        corpus,
        name="another name",
        commands={k: replace(c, subject="somebody else") for k, c in corpus.commands.items()},
        judgments=tuple(replace(j, subject="nobody") for j in corpus.judgments),
    )
    assert renamed.hash == corpus.hash

    extra_command = Command("extra", "Go", "s1")
    extra_judgment = Judgment("extra", "Go", "v", "v", "SA", "", "study")
    context = next(iter(corpus.contexts.values()))
    changed = [
        replace(corpus, commands={**corpus.commands, "extra": extra_command}),
        replace(corpus, judgments=(*corpus.judgments, extra_judgment)),
        replace(corpus, contexts={**corpus.contexts, "extra": replace(context, id="extra")}),
        replace(corpus, outcomes=(*corpus.outcomes, TaskOutcome("extra", "s1", context.id))),
    ]
    if corpus.annotations:
        first, *rest = corpus.annotations
        turned = tuple(None if label else True for label in first.correct)
        changed += [
            replace(corpus, annotations=tuple(rest)),
            replace(corpus, annotations=(replace(first, correct=turned), *rest)),
        ]
    hashes = {content_hash(encode(other.content)) for other in changed}
    assert corpus.hash not in hashes
    assert len(hashes) == len(changed)


def test_equal_trajectories_are_stored_once(small_corpus: Corpus):
    tables = encode(small_corpus.content)
    lengths = np.diff(tables.trajectories["offsets"])
    assert len(lengths) == 2  # the agent's, and one of the two pallets that stand still
    assert tables.trajectories["t"].shape == (lengths.sum(),)


def test_objects_of_contexts_are_referred_to_by_id(small_corpus: Corpus):
    (annotation,) = encode(small_corpus.content).annotations
    references = [g for gs in annotation.groundings for g in gs if isinstance(g, ObjectReference)]
    assert references == [ObjectReference("robot"), ObjectReference("p1"), ObjectReference("p2")]
