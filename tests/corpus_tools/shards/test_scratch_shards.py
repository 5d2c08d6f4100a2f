"""Shards for the time of one training are read as they were written."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
import pytest

from corpus_tools.corpus.labelled_corpus import Options, labelled_examples
from corpus_tools.shards.shard_files import read_shard
from corpus_tools.shards.shard_making import to_shard, write_scratch_shards
from g3.learning import factor_matrix
from tests.tiny_corpus import tiny_corpus


@pytest.fixture(scope="module")
def items():
    return labelled_examples(tiny_corpus())


def test_what_is_read_is_what_was_written(items, tmp_path):
    manifest = write_scratch_shards(tiny_corpus(), items, tmp_path, Options(), size=30)
    first = read_shard(tmp_path / manifest.shards[0].file)
    for found, made in zip(astuple(first), astuple(to_shard(items[:30], Options())), strict=True):
        np.testing.assert_array_equal(found, made)
    rows = [read_shard(tmp_path / shard.file) for shard in manifest.shards]
    assert sum(s.right.sum() + s.wrong.sum() for s in rows) == len(items) == manifest.examples
    assert [shard.rows for shard in manifest.shards] == [len(s.right) for s in rows]


def test_blocks_of_examples_make_the_same_rows(items, monkeypatch):
    whole = to_shard(items, Options())
    monkeypatch.setattr(factor_matrix, "BLOCK", 7)
    blocks = to_shard(items, Options())
    assert _rows(blocks) == _rows(whole)


def _rows(shard):
    """What is active in each row by name, with how many examples are right and wrong."""
    names = np.array([shard.space.name(i) for i in range(len(shard.keys))])
    active = np.split(names[shard.features], shard.offsets[1:-1])
    return [
        (frozenset(row), right, wrong)
        for row, right, wrong in zip(active, shard.right, shard.wrong, strict=True)
    ]
