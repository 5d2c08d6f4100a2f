"""Vectors of words: the bundled ones, and those of a file that people have."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from g3.errors import ModelError
from g3.language.similarity.resources import word_vectors, word_vectors_identity
from g3.language.similarity.vectors import read_vectors
from g3.language.similarity.word_similarity import MEASURES

LINES = ["skid 3 4", "pallet 4 3", "truck -4 3", "loading dock 0 1", "skid 9 9"]


def test_cosines_worked_by_hand() -> None:
    # (3 * 4 + 4 * 3) / 25 = 0.96; skid and truck are at right angles; pallet and truck -7 / 25.
    vectors = read_vectors(LINES)
    found = vectors.cosine(["skid", "Pallet", "ufo"], ["pallet", "truck", "skid"])
    assert_allclose(found, [[0.96, 0, 1], [1, 0, 0.96], [0, 0, 0]], atol=1e-6)
    assert_allclose(vectors.cosine(["loading dock"], ["skid"]), [[0.8]], atol=1e-6)


def test_a_first_line_of_counts_is_skipped_and_only_so_many_words_are_read() -> None:
    assert set(read_vectors(["5 2", *LINES]).rows) == {"skid", "pallet", "truck", "loading dock"}
    assert list(read_vectors(LINES, most=1).rows) == ["skid"]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "no vectors"),
        (["4 2"], "no vectors"),
        (["skid 1 2", "pallet 1"], "line 2"),
        (["skid 1 2", "pallet 1 x"], "line 2"),
        (["skid 1 nan"], "line 1"),
    ],
)
def test_other_files_are_refused(lines: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_vectors(lines)


@pytest.mark.parametrize("name", ["vectors.txt", "vectors.vec.gz"])
def test_the_measure_reads_the_named_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = "\n".join(LINES).encode()
    file = tmp_path / name
    file.write_bytes(gzip.compress(content, mtime=0) if name.endswith("gz") else content)
    monkeypatch.setenv("CT_VECTORS", str(file))
    assert word_vectors_identity().startswith("sha256:")
    assert math.isclose(MEASURES["vector"](["skid"], ["pallet"])[0, 0], 0.96, abs_tol=1e-6)


LABELS = ["truck", "refrigerator", "accessories", "shelf", "person", "brick"]


@pytest.mark.parametrize(
    ("word", "label"),
    [
        *(("lorry", "truck"), ("Fridge", "refrigerator"), ("parts", "accessories")),
        *(("rack", "shelf"), ("guy", "person"), ("bricks", "brick")),
    ],
)
def test_without_a_file_words_are_like_what_they_mean(
    word: str, label: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CT_VECTORS", raising=False)
    assert word_vectors_identity().startswith("sha256:")
    (likeness,) = MEASURES["vector"]([word], LABELS)
    assert LABELS[int(likeness.argmax())] == label


@given(words=st.lists(st.text(max_size=12), max_size=4))
def test_any_texts_have_a_likeness(words: list[str]) -> None:
    likeness = MEASURES["vector"](words, words)
    assert likeness.shape == (len(words), len(words))
    assert ((likeness >= 0) & (likeness <= 1)).all()
    assert_allclose(likeness, likeness.T)


def test_a_file_that_cannot_be_read_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for broken, content in (("none.txt", None), ("bad.txt", b"one\n"), ("cut.gz", b"\x1f\x8b\x08")):
        file = tmp_path / broken
        if content is not None:
            file.write_bytes(content)
        monkeypatch.setenv("CT_VECTORS", str(file))
        with pytest.raises(ModelError, match="can't be read"):
            word_vectors()
