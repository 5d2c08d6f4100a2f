"""A corpus is written as a whole or not at all."""

from __future__ import annotations

import os

import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime import atomic_folder as atomic
from g3.errors import FormatError


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def interrupt(monkeypatch, function, at, error):
    """Make the `at`-th call of a function of os raise."""
    calls = 0
    original = getattr(os, function)

    def wrapped(*args, **kwargs):
        nonlocal calls
        calls += 1
        if calls == at:
            raise error
        return original(*args, **kwargs)

    monkeypatch.setattr(os, function, wrapped)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError("the disk is full")])
@pytest.mark.parametrize("at", range(1, 8))
def test_an_interrupted_write_leaves_nothing(small_corpus, tmp_path, monkeypatch, at, error):
    interrupt(monkeypatch, "fsync", at, error)
    with pytest.raises(type(error)):
        small_corpus.save(tmp_path / "corpus")
    assert names(tmp_path) == []


@pytest.mark.parametrize("at", [1, 7])
def test_an_interrupted_replacement_keeps_the_old(small_corpus, corpus_path, monkeypatch, at):
    (corpus_path / "mark").touch()
    interrupt(monkeypatch, "fsync", at, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        small_corpus.save(corpus_path, force=True)
    assert names(corpus_path.parent) == ["corpus"]
    assert (corpus_path / "mark").exists()


def test_an_interrupt_between_the_two_renames_keeps_the_old(small_corpus, corpus_path, monkeypatch):
    (corpus_path / "mark").touch()
    monkeypatch.setattr(atomic, "exchange", lambda _one, _other: False)
    interrupt(monkeypatch, "rename", 2, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        small_corpus.save(corpus_path, force=True)
    assert names(corpus_path.parent) == ["corpus"]
    assert (corpus_path / "mark").exists()


def test_an_existing_corpus_is_replaced_only_by_force(small_corpus, corpus_path):
    with pytest.raises(FormatError, match="--force"):
        small_corpus.save(corpus_path)
    (corpus_path / "mark").touch()
    small_corpus.save(corpus_path, force=True)
    assert "mark" not in names(corpus_path)
    assert names(corpus_path.parent) == ["corpus"]
    assert Corpus.load(corpus_path) == small_corpus


def test_what_is_no_corpus_is_never_replaced(small_corpus, tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").touch()
    with pytest.raises(FormatError, match="other things"):
        small_corpus.save(tmp_path / "thesis", force=True)
    with pytest.raises(FormatError, match="not a folder"):
        Corpus.check_target(tmp_path / "thesis" / "chapter.tex", force=True)
    with pytest.raises(FormatError, match="no such folder"):
        Corpus.check_target(tmp_path / "nowhere" / "corpus")
    assert names(tmp_path / "thesis") == ["chapter.tex"]


def test_an_empty_folder_is_filled(small_corpus, tmp_path):
    (tmp_path / "corpus").mkdir()
    small_corpus.save(tmp_path / "corpus", attachments={"note.txt": b"hello"})
    assert Corpus.load(tmp_path / "corpus") == small_corpus
    assert (tmp_path / "corpus" / "note.txt").read_bytes() == b"hello"
