"""Samples that are balanced over cells, with the chance that each item had."""

from __future__ import annotations

import numpy as np

from eval.statistics.estimates import FloatArray, IntArray


def balanced_sample(
    cell: IntArray, size: int, rng: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """Draw as evenly from all cells as their sizes allow.

    Every cell gives the same number, or all that it has. What is left over is less than one item
    for each cell that has more. It is drawn from these cells systematically, which spreads it over
    their order and gives each the same chance (W. G. Cochran, Sampling Techniques, 1977, chapter
    8). Weights of one over the chance make up for the balance (D. G. Horvitz and D. J. Thompson,
    J. Am. Stat. Assoc. 47, 1952), also where a cell gives nothing.

    Parameters
    ----------
    cell
        Number of each item's cell, from 0 without gaps, shape (n,).
    size
        How many items are wanted; there may be fewer.

    Returns
    -------
    drawn : ndarray
        Indices of the items drawn, growing.
    chance : ndarray
        With which each item is drawn, shape (n,).
    """
    if size <= 0 or len(cell) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(len(cell))
    sizes = np.bincount(cell)
    each = max(k for k in range(sizes.max() + 1) if np.minimum(sizes, k).sum() <= size)
    taken = np.minimum(sizes, each)
    larger = np.flatnonzero(sizes > each)
    rest = min(size, len(cell)) - int(taken.sum())
    chance = taken / sizes
    if rest:
        chance[larger] += rest / len(larger) / sizes[larger]
        steps = (rng.random() + np.arange(rest)) * len(larger) / rest
        taken[larger[steps.astype(np.int64)]] += 1
    drawn = [
        rng.choice(np.flatnonzero(cell == number), int(count), replace=False)
        for number, count in enumerate(taken)
    ]
    return np.sort(np.concatenate(drawn)), chance[cell]
