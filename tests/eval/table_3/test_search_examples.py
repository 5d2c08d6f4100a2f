"""What costs are learned from: made by any executor, handed over by a file."""

import os
import time

import numpy as np
import pytest

from corpus_tools.runtime.parallel import Executor, Workers
from eval.table_3.held_out import costs_without, data_of, read, written
from g3.errors import CorpusError
from g3.storage.cache_folder import cache_folder
from tests.eval.yard import few_annotated

SCENARIOS = ("court_put_crate_on_trailer", "hall_pick_up_boxes")


@pytest.fixture(scope="module")
def few():
    return few_annotated({f"{name}-0{number}" for name in SCENARIOS for number in (1, 2)})


@pytest.fixture(scope="module")
def data(few):
    return data_of([few])


def assert_same(one, other):
    assert (one.space.sets, one.space.bases, one.space.words) == (
        other.space.sets, other.space.bases, other.space.words,
    )  # fmt: skip
    np.testing.assert_array_equal(one.space.keys, other.space.keys)
    for name in ("indptr", "indices", "data"):
        np.testing.assert_array_equal(getattr(one.matrix, name), getattr(other.matrix, name))
    np.testing.assert_array_equal(one.correct, other.correct)
    np.testing.assert_array_equal(one.scenario, other.scenario)


def test_a_team_makes_the_same_examples_and_tells_how_far_it_is(few, data):
    told = []
    with Executor(Workers(2)) as executor:
        made = data_of(
            [few], executor=executor, on_progress=lambda *progress: told.append(progress)
        )
    assert_same(made, data)
    assert told == [("trying actions", done, 3) for done in (1, 2, 3)]


def test_what_is_written_is_read_and_gone_afterwards(data):
    with written(data) as file:
        again = read(file)
    assert_same(again, data)
    assert not file.parent.exists()
    left_out = SCENARIOS[0]
    one, other = (costs_without(known)(left_out).model.weights_ for known in (data, again))
    np.testing.assert_array_equal(one, other)


def test_files_of_processes_that_were_killed_are_removed_after_a_month(data, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    old, new = (cache_folder() / f".examples-{name}" for name in ("old", "new"))
    for folder in (old, new):
        folder.mkdir(parents=True)
    long_ago = time.time() - 40 * 24 * 3600
    os.utime(old, (long_ago, long_ago))
    with written(data):
        assert not old.exists()
        assert new.exists()


def test_a_cache_that_cannot_be_written_is_told(data, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with (
        pytest.raises(CorpusError, match=r"can't be written in the cache.*XDG_CACHE_HOME"),
        written(data),
    ):
        pass
