from __future__ import annotations

import math
from itertools import chain, combinations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from g3.errors import ModelError
from g3.language.similarity.cooccurrence import (
    MAX_TAGS_PER_IMAGE,
    count_list,
    count_together,
    frequent_tags,
    read_tags,
    table_from_bytes,
    table_to_bytes,
)
from g3.language.similarity.resources import tag_table

LINES = ["truck tire", "truck,trailer", "truck\ttires", "# truck trailer", "", "dog"]
TABLE = count_list(LINES)

images = st.lists(st.frozensets(st.sampled_from("abcdefgh")), max_size=30)


@pytest.mark.parametrize(
    ("line", "tags"),
    [
        ("truck tires\n", {"truck", "tire"}),
        ("Red Truck, tires", {"red truck", "tire"}),
        ("fork+lift,caf%C3%A9", {"fork lift", "café"}),
        ("a\tb c\t\tb c", {"a", "b c"}),
        (" ,, ", set()),
    ],
)
def test_tags_of_a_line(line: str, tags: set[str]) -> None:
    assert read_tags(line) == tags


def test_a_line_of_spam_is_cut() -> None:
    assert len(read_tags(" ".join(f"t{i}x" for i in range(1000)))) == MAX_TAGS_PER_IMAGE


def test_a_list_is_counted_by_hand() -> None:
    assert (TABLE.images, TABLE.tags) == (4, ("dog", "tire", "trailer", "truck"))
    expected = [[1, 0, 0, 0], [0, 2, 0, 2], [0, 0, 1, 1], [0, 2, 1, 3]]
    assert_array_equal(TABLE.together.toarray(), expected)


def test_conditional_probability_and_mutual_information_by_hand() -> None:
    assert TABLE.conditional(["tires"], ["truck"])[0, 0] == pytest.approx(2 / 3)
    assert TABLE.conditional(["truck"], ["tires"])[0, 0] == 1
    # P(tire, truck) = 1/2, P(tire) P(truck) = 1/2 * 3/4: ln (4/3) / -ln (1/2).
    assert TABLE.npmi(["tire"], ["truck"])[0, 0] == pytest.approx(math.log(4 / 3) / math.log(2))
    assert TABLE.npmi(["dog", "cat", "tire"], ["truck", "tire"])[:2].tolist() == [[0, 0], [0, 0]]
    assert TABLE.npmi(["dog"], ["dog"])[0, 0] == pytest.approx(1)
    assert count_list(["a b", "a b"]).npmi(["a"], ["b"])[0, 0] == 1


@given(images)
def test_streaming_counts_as_in_memory(drawn: list[frozenset[str]]) -> None:
    tags = frequent_tags(iter(drawn), 100)
    assert tags == tuple(sorted(set().union(*drawn)))
    table = count_together(iter(drawn), tags)
    for a, b in combinations(tags, 2):
        i, j = tags.index(a), tags.index(b)
        assert table.together[i, j] == table.together[j, i] == sum({a, b} <= x for x in drawn)
    for i, tag in enumerate(tags):
        assert table.together[i, i] == sum(tag in image for image in drawn)
    assert table.images == len(drawn)


@given(images, st.integers(1, 4), st.integers(2, 12))
def test_no_frequent_tag_is_forgotten(drawn: list[frozenset[str]], limit: int, bucket: int) -> None:
    kept = frequent_tags(drawn, limit, bucket=bucket)
    assert len(kept) <= limit
    occurrences = list(chain.from_iterable(drawn))
    bound = len(occurrences) / bucket
    frequent = {tag for tag in occurrences if occurrences.count(tag) > bound}
    assert frequent <= set(frequent_tags(drawn, 100, bucket=bucket))


@given(images)
def test_similarities_are_degrees(drawn: list[frozenset[str]]) -> None:
    table = count_together(drawn, frequent_tags(drawn, 100))
    words = [*table.tags, "unknown"]
    for values in (table.npmi(words, words), table.conditional(words, words)):
        assert values.shape == (len(words), len(words))
        assert ((values >= 0) & (values <= 1)).all()
    assert_array_equal(table.npmi(words, words), table.npmi(words, words).T)


@given(images)
@example([frozenset({"a\u2028b", "c\x85d"})])
def test_a_table_survives_a_file(drawn: list[frozenset[str]]) -> None:
    table = count_together(drawn, frequent_tags(drawn, 100))
    content = table_to_bytes(table)
    again = table_from_bytes(content)
    assert (again.tags, again.images) == (table.tags, table.images)
    assert_array_equal(again.together.toarray(), table.together.toarray())
    assert table_to_bytes(again) == content


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"tags", table_to_bytes(TABLE)[:-40]])
def test_something_else_is_no_table(content: bytes) -> None:
    with pytest.raises(ModelError):
        table_from_bytes(content)


def test_the_table_made_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CT_TAGS", raising=False)
    near, far = tag_table().npmi(["skid"], ["pallet", "truck"])[0]
    assert near > 0.4 > far
    assert np.argmax(tag_table().conditional(["pallet", "tire", "box"], ["wheels"])) == 1
