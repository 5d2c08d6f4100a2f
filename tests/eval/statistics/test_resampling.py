from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.runtime.parallel import Executor, Workers
from eval.statistics.estimates import BLOCK, resampled_sums


def sums(clusters, draws, jobs=1, seed=0):
    with Executor(Workers(jobs)) as executor:
        return resampled_sums(
            clusters, rng=np.random.default_rng(seed), draws=draws, executor=executor
        )


def test_as_many_clusters_are_drawn_as_there_are():
    clusters = np.array([[1, 0, 5], [1, 1, 0], [1, 0, 7]])
    drawn = sums(clusters, 1000)
    assert drawn.shape == (1000, 3)
    assert (drawn[:, 0] == 3).all()
    # One of three, drawn three times: binomial, and never the same in all draws.
    share = [np.mean(drawn[:, 1] == k) for k in range(4)]
    np.testing.assert_allclose(share, np.array([8, 12, 6, 1]) / 27, atol=0.05)
    assert drawn.mean(axis=0) == pytest.approx([3, 1, 12], rel=0.05)


def test_the_shape_of_what_is_added_up_is_kept():
    assert sums(np.ones((4, 2, 3)), 7).shape == (7, 2, 3)


@pytest.mark.parametrize("draws", [1, BLOCK, 2 * BLOCK + 1])
def test_two_processes_draw_the_same(draws):
    clusters = np.random.default_rng(5).normal(size=(20, 2))
    np.testing.assert_array_equal(sums(clusters, draws), sums(clusters, draws, jobs=2))


def test_blocks_differ():
    first, second = np.split(sums(np.arange(50.0), 2 * BLOCK), 2)
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, sums(np.arange(50.0), BLOCK, seed=1))


@pytest.mark.parametrize(
    ("clusters", "draws", "message"), [([], 10, "no cluster"), ([1, 2], 0, "draws is 0")]
)
def test_what_cannot_be_drawn(clusters, draws, message):
    with pytest.raises(ValueError, match=message):
        sums(clusters, draws)


def test_what_has_no_resamples_refuses_jobs(capsys):
    command = ["eval", "--errors", "--corpus", "warehouse", "--cv", "scenario", "--jobs", "2"]
    assert run(command) == 2
    assert "--jobs doesn't go with" in capsys.readouterr().err
