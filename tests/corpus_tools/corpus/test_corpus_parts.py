"""Parts of corpora: filter, select and split."""

from __future__ import annotations

import tempfile
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from corpus_tools.corpus import corpus_reading, corpus_writing, encoding
from corpus_tools.corpus.corpus_model import Corpus, draw_parts
from g3.errors import CorpusError
from tests.strategies import corpora

few = settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
names = st.sampled_from(["a", "b", "c", "d", "e"])


@few
@given(corpora(), st.data())
def test_a_selection_has_what_belongs_to_its_commands(corpus: Corpus, data):
    ids = data.draw(
        st.lists(st.sampled_from(sorted(corpus.commands)), unique=True) if corpus else st.just([])
    )
    part = corpus.select(ids)
    assert list(part.commands) == ids
    for entry in part:
        assert entry.annotations == corpus[entry.id].annotations
        assert entry.outcomes == corpus[entry.id].outcomes
        assert all(a.context is part.contexts[a.context.id] for a in entry.annotations)
    with tempfile.TemporaryDirectory() as folder:
        part.save(Path(folder) / "part")
        again = Corpus.load(Path(folder) / "part")
    assert again == part
    assert again.hash == part.hash


@few
@given(corpora(), st.sampled_from(["scenario", "world"]), st.integers(0, 9))
def test_a_split_divides_the_commands(corpus: Corpus, by, seed):
    train, test = corpus.split(by, seed=seed)
    assert sorted([*train.commands, *test.commands]) == sorted(corpus.commands)
    assert not set(train.parts(by).values()) & set(test.parts(by).values())
    assert (train, test) == corpus.split(by, seed=seed)
    assert len(train.annotations) + len(test.annotations) == len(corpus.annotations)


def test_a_filter_sees_entries(small_corpus: Corpus):
    part = small_corpus.filter(lambda entry: bool(entry.annotations))
    assert {a.command.id for a in small_corpus.annotations} == set(part.commands)
    assert part.annotations == small_corpus.annotations
    assert small_corpus.filter(lambda _: False).contexts == {}


def test_judgments_go_with_their_commands(small_corpus: Corpus):
    command = next(iter(small_corpus.commands.values()))
    kept = small_corpus.select([command.id]).judgments
    about = [
        j
        for j in small_corpus.judgments
        if (j.command, j.command_video) == (command.text, command.video)
    ]
    assert list(kept) == about


def test_named_parts_are_held_out(small_corpus: Corpus):
    scenario = next(iter(small_corpus.commands.values())).scenario
    train, test = small_corpus.split(held_out=[scenario])
    assert {c.scenario for c in test.commands.values()} == {scenario}
    assert scenario not in {c.scenario for c in train.commands.values()}


def test_unknown_names_are_refused(small_corpus: Corpus):
    with pytest.raises(CorpusError, match="'x'"):
        small_corpus.select(["x"])
    with pytest.raises(CorpusError, match="'x'"):
        small_corpus.split(held_out=["x"])
    with pytest.raises(CorpusError, match="'video'"):
        small_corpus.split("video")  # type: ignore[arg-type]


def test_a_corpus_does_not_change(small_corpus: Corpus):
    with pytest.raises(FrozenInstanceError):
        small_corpus.name = "other"  # type: ignore[misc]


@given(st.sets(names, min_size=2), st.integers(0, 100))
def test_a_draw_has_two_sides_and_is_repeatable(known, seed):
    drawn = draw_parts(known, seed=seed)
    assert 0 < len(drawn) < len(known)
    assert set(drawn) < known
    assert drawn == draw_parts(sorted(known, reverse=True), seed=seed)


def test_a_third_is_drawn():
    known = [f"s{i}" for i in range(15)]
    assert len(draw_parts(known, seed=0)) == 5
    assert len({draw_parts(known, seed=seed) for seed in range(9)}) > 1


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        (corpus_reading, "load_corpus", "Corpus.load"),
        (corpus_writing, "write_corpus", "Corpus.save"),
        (encoding, "make_corpus", "Corpus.build"),
        (encoding, "merged", "Corpus.merge"),
    ],
)
def test_old_names_warn(module, old, new, small_corpus: Corpus, tmp_path):
    with pytest.warns(DeprecationWarning, match=f"use {new}"):
        assert callable(getattr(module, old))
    with pytest.raises(AttributeError, match="no attribute"):
        _ = module.never_there
