"""Corpora that were damaged, changed by hand, or written by an older program, in commands."""

from __future__ import annotations

import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_records import MANIFEST
from g3.errors import FormatError
from tests.damage import damaged
from tests.tiny_corpus import rated_corpus


@pytest.fixture(scope="module")
def corpus():
    return rated_corpus()


def test_the_command_line_tells_each_in_one_line(corpus, tmp_path, capsys):
    corpus.save(tmp_path / "c")
    path = tmp_path / "c" / "trajectories.npz"
    for _, content in damaged(path.read_bytes(), 60, seed=7):
        path.write_bytes(content)
        status = run(["corpus", "stats", str(tmp_path / "c")])
        told = capsys.readouterr().err
        assert (status, told.count("\n")) in ((2, 1), (0, 0)), told
        assert status == 0 or "trajectories.npz" in told
        assert "unexpected" not in told


def test_changes_by_hand_are_accepted_by_a_command(corpus, tmp_path, capsys):
    folder = tmp_path / "c"
    corpus.save(folder)
    path = folder / "commands.jsonl"
    before = path.read_text()
    path.write_text(before.replace('"subject":"0', '"subject":"1', 1))
    assert path.read_text() != before
    assert run(["corpus", "validate", str(folder)]) == 2
    assert f"{path}: the content is not what was written" in capsys.readouterr().out
    assert run(["corpus", "seal", str(folder)]) == 0
    assert "its hash is the same" in capsys.readouterr().out
    assert run(["corpus", "validate", str(folder)]) == 0
    path.write_text(path.read_text()[:-5])
    manifest = (folder / MANIFEST).read_bytes()
    assert run(["corpus", "seal", str(folder)]) == 2
    assert (folder / MANIFEST).read_bytes() == manifest


def test_a_corpus_of_the_first_version_is_read_and_can_be_sealed(corpus, tmp_path):
    folder = tmp_path / "c"
    corpus.save(folder)
    text = (folder / MANIFEST).read_text()
    old = text[: text.index(',\n  "digests"')] + "\n}\n"
    (folder / MANIFEST).write_text(old.replace('"schema_version": 2', '"schema_version": 1'))
    assert Corpus.load(folder).files() == corpus.files()
    assert run(["corpus", "seal", str(folder)]) == 0
    assert (folder / MANIFEST).read_text() == text
    (folder / MANIFEST).write_text(text.replace('"schema_version": 2', '"schema_version": 1'))
    with pytest.raises(FormatError, match="digest differs"):
        Corpus.load(folder)
