"""Resampling of clusters with replacement, for all bootstrap intervals here.

Draws are made in blocks, each with its own random numbers. So they are the same for any number of
processes, and memory doesn't grow with the number of draws.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from corpus_tools.runtime.parallel import Executor, Workers, work_in_order

BLOCK = 250
"""Draws in a block."""


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    clusters: npt.NDArray[np.float64]
    draws: int
    rng: np.random.Generator


def resampled_sums(
    clusters: npt.ArrayLike,
    *,
    rng: np.random.Generator,
    draws: int,
    executor: Executor | None = None,
) -> npt.NDArray[np.float64]:
    """Return sums over clusters drawn with replacement, shape (draws, ...).

    Davison and Hinkley (1997), Bootstrap Methods and their Application, section 3.8: the counts of
    drawn clusters are multinomial, so a block of draws is one product of matrices.

    `clusters` has the summands of each cluster, shape (clusters, ...). The same state of `rng`
    gives the same sums. The executor makes the blocks, or this process. A ValueError means that
    there is no cluster, or no draw.
    """
    values = np.asarray(clusters, dtype=np.float64)
    if not len(values):
        raise ValueError("there is no cluster to draw")
    if draws < 1:
        raise ValueError(f"draws is {draws}, expected at least 1")
    flat = values.reshape(len(values), -1)
    starts = range(0, draws, BLOCK)
    blocks = [
        _Block(flat, min(BLOCK, draws - start), own)
        for start, own in zip(starts, rng.spawn(len(starts)), strict=True)
    ]
    sums = work_in_order(_sums, blocks, executor or Executor(Workers()))
    return np.concatenate(sums).reshape(draws, *values.shape[1:])


def _sums(block: _Block) -> npt.NDArray[np.float64]:
    n = len(block.clusters)
    times = block.rng.multinomial(n, np.full(n, 1 / n), size=block.draws)
    return times.astype(np.float64) @ block.clusters
