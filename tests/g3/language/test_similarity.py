from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from g3.language.lexicon.field_words import normalise
from g3.language.similarity.word_similarity import (
    MEASURES,
    best_match,
    domain,
    exact,
    lemma,
    mean_match,
    spelling,
)
from tests.g3.language.installed import needs_wordnet

every_measure = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=needs_wordnet) if name in ("path", "wup", "lin") else name
        for name in MEASURES
    ],
)


@pytest.fixture(autouse=True, scope="module")
def vectors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A file of vectors, which don't come along."""
    file = tmp_path_factory.mktemp("vectors") / "vectors.txt"
    file.write_text("tire 1 0\npallet 0 2\ntrailer 1 1\nforklift -1 1\nP 3 4\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CT_VECTORS", str(file))
        yield


def test_the_measures_there_are() -> None:
    named = ["exact", "lemma", "spelling", "domain", "path", "wup", "lin", "tag-npmi", "tag-given"]
    assert list(MEASURES) == [*named, "vector"]


def test_exact_does_not_see_capitals() -> None:
    assert_array_equal(exact(["Tire", "tires"], ["tire", "Pallet"]), [[1, 0], [0, 0]])


def test_lemma_sees_the_stem() -> None:
    assert_array_equal(lemma(["tires", "pallet", "truck"], ["tire", "pallets"]),
                       [[1, 0], [0, 1], [0, 0]])  # fmt: skip


def test_spelling_is_jaro_winkler_of_the_stems() -> None:
    # martha, marhta: 6 of 6 match, one transposition: Jaro (1 + 1 + 5 / 6) / 3 = 0.944,
    # and 3 equal letters in front: 0.944 + 3 * 0.1 * 0.056 = 0.961.
    assert_allclose(spelling(["martha"], ["marhta"]), [[0.9611]], atol=1e-4)
    close, far = spelling(["palett"], ["pallet", "trailer"])[0]
    assert close > 0.9 > 0.7 > far
    assert spelling(["pallets"], ["pallet"])[0, 0] == 1


@pytest.mark.parametrize(
    ("word", "label"),
    [
        ("skid", "pallet"), ("lorry", "truck"), ("tyre", "tire"), ("crates", "box"),
        ("flatbed", "trailer"), ("truck", "trailer"), ("boxes", "generator"),
        ("tires", "assembly"), ("robot", "forklift"), ("man", "person"), ("drum", "barrel"),
        ("boxes", "accessories"), ("parts", "accessories"),
    ],
)  # fmt: skip
def test_domain_knows_synonyms(word: str, label: str) -> None:
    assert domain([word], [label])[0, 0] == 1


@pytest.mark.parametrize(
    ("word", "label"),
    [("tire", "pallet"), ("pallet", "truck"), ("skid", "zeppelin"), ("parts", "generator")],
)
def test_domain_tells_kinds_apart(word: str, label: str) -> None:
    assert domain([word], [label])[0, 0] == 0


@every_measure
@given(
    words=st.lists(st.text("abPl-t", max_size=5), min_size=1, max_size=4),
    labels=st.lists(st.sampled_from(["tire", "pallet", "Flatbed", "lap"]), max_size=3),
)
def test_measures_give_a_table_of_degrees(name: str, words: list[str], labels: list[str]) -> None:
    table = MEASURES[name](words, labels)
    assert table.shape == (len(words), len(labels))
    assert ((table >= 0) & (table <= 1)).all()
    for i, word in enumerate(words):
        assert_array_equal(table[i : i + 1], MEASURES[name]([word], labels))


@every_measure
def test_a_label_is_like_itself(name: str) -> None:
    labels = ["tire", "pallet", "trailer", "forklift"]
    assert_array_equal(np.diag(MEASURES[name](labels, labels)), np.ones(4))


@given(st.sampled_from(["tires", "Pallets", "boxes"]))
def test_equal_stems_are_spelled_alike(word: str) -> None:
    assert lemma([word], [normalise(word)]) == spelling([word], [normalise(word)]) == 1


@st.composite
def matches(draw: st.DrawFn) -> tuple[np.ndarray, list[list[int]], np.ndarray, np.ndarray]:
    w, label_count = draw(st.integers(1, 4)), draw(st.integers(0, 3))
    f, n = draw(st.integers(1, 4)), draw(st.integers(0, 6))
    cells = st.lists(st.floats(0, 1), min_size=w * label_count, max_size=w * label_count)
    similarity = np.array(draw(cells)).reshape(w, label_count)
    word_lists = draw(st.lists(st.lists(st.integers(0, w - 1), max_size=3), min_size=f, max_size=f))
    factor = draw(st.lists(st.integers(0, f - 1), min_size=n, max_size=n))
    has = st.lists(st.booleans(), min_size=n * label_count, max_size=n * label_count)
    labels = np.array(draw(has), dtype=bool).reshape(n, label_count)
    return similarity, word_lists, np.array(factor, dtype=np.intp), labels


@given(matches())
def test_best_match_is_the_closest_pair(
    drawn: tuple[np.ndarray, list[list[int]], np.ndarray, np.ndarray],
) -> None:
    similarity, words, factor, labels = drawn
    expected = [
        max((similarity[w, i] for w in words[f] for i in np.flatnonzero(row)), default=0.0)
        for f, row in zip(factor, labels, strict=True)
    ]
    assert_array_equal(best_match(similarity, words, factor, labels), expected)


def test_best_match_of_an_example() -> None:
    similarity = np.array([[0.2, 0.9], [0.5, 0.1], [1.0, 1.0]])
    labels = np.array([[True, False], [False, True], [True, True], [False, False]])
    # Rows 0 and 1 have the words 0 and 1; row 2 has none; row 3 has words, but no label.
    found = best_match(similarity, [[0, 1], [], [2]], np.array([0, 0, 1, 2]), labels)
    assert_array_equal(found, [0.5, 0.9, 0, 0])


def initials(words: Sequence[str], labels: Sequence[str]) -> np.ndarray:
    """Words are like labels that share their first letter; of pairs only "red rose" is known."""
    like = {("red rose", "tree")}
    return np.array(
        [[float((w, x) in like or (" " not in w and w[0] == x[0])) for x in labels] for w in words]
    ).reshape(len(words), len(labels))


def test_mean_match_of_an_example() -> None:
    labels, patterns = ["tree", "pond"], np.array([[True, False], [True, True], [False, False]])
    names = [("the", "pine"), ("one",), ("red", "rose", "path"), ("rose",), ()]
    # "the" is like "tree", "pine" like "pond"; "one" and "rose" are like nothing.
    found = mean_match(initials, names, labels, patterns)
    nothing = [np.nan] * 3
    assert_array_equal(found, [[0.5, 1, 0], nothing, [0.5, 1, 0], nothing, nothing])


@needs_wordnet
def test_wordnet_knows_what_no_lexicon_lists() -> None:
    # A carton is a box, a van is nearer to a truck than to a tire, and a tyre is a tire.
    assert MEASURES["path"](["carton"], ["box"])[0, 0] == 0.5
    van = MEASURES["wup"](["van"], ["truck", "tire", "pallet"])[0]
    assert van.argmax() == 0
    assert MEASURES["lin"](["tyres"], ["tire"])[0, 0] == 1


@needs_wordnet
@pytest.mark.parametrize("word", ["the", "a", "in", "left", "wheeled", "zxq", ""])
def test_function_words_are_like_nothing_in_wordnet(word: str) -> None:
    assert not MEASURES["wup"]([word], ["pallet", "trailer"]).any()
