"""Training on a corpus: the same model whether its features are in memory or in files."""

from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.labelled_corpus import Options, labelled_examples
from corpus_tools.corpus.load_choices import load_choices
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.learning import trained
from g3.learning.grounding_model import GroundingModel
from tests.tiny_corpus import tiny_corpus


def test_many_examples_give_the_model_that_few_give(monkeypatch):
    corpus = tiny_corpus()
    items = labelled_examples(corpus)
    few = trained.from_corpus(corpus, 0.5, Options())
    monkeypatch.setattr(trained, "IN_MEMORY", len(items) - 1)
    monkeypatch.setattr(trained, "IN_A_FILE", 20)
    many = trained.from_corpus(corpus, 0.5, Options())
    assert (few.on_disk, many.on_disk) == (False, True)
    assert many.sources == few.sources
    assert many.model.card == few.model.card
    assert set(many.model.space_.bases) == set(few.model.space_.bases)
    expected = few.model.predict_proba(items)
    assert many.model.predict_proba(items) == pytest.approx(expected, abs=1e-4)


def test_loads_are_learned_either_way(monkeypatch):
    corpus = open_corpus("warehouse")  # without outcomes, so that its annotations tell the loads
    monkeypatch.setattr(trained, "load_choices_of", lambda corpora: load_choices(corpora[0]))
    few = trained.from_corpus(corpus, 1.0, Options(ablated=("word-wordnet",)))
    monkeypatch.setattr(trained, "IN_MEMORY", 1000)
    many = trained.from_corpus(corpus, 1.0, Options(ablated=("word-wordnet",)))
    assert many.on_disk
    one, other = (model.load_chooser_ for model in (few.model, many.model))
    assert one is not None
    assert np.array_equal(one.weights, other.weights)


def test_training_says_that_it_keeps_features_in_files(tmp_path, monkeypatch, capsys):
    tiny_corpus().save(tmp_path / "tiny")
    monkeypatch.setattr(trained, "IN_MEMORY", 10)
    out = tmp_path / "m"
    assert run(["train", "g3", "--corpus", str(tmp_path / "tiny"), "--out", str(out)]) == 0
    assert "features were kept in files" in capsys.readouterr().err
    assert GroundingModel.load(out).space_
