"""Configurations compared on the commands that they share, corrected for comparing many."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt
from scipy import special

from corpus_tools.corpus.estimate import Estimate
from eval.statistics.estimates import (
    ALIKE,
    FEWEST_CLUSTERS,
    FloatArray,
    IntArray,
    percentiles,
    resampled_sums,
)
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class Comparison:
    """Two configurations on the same commands."""

    one: str
    other: str
    n: int
    """Number of commands that both have."""
    difference: Estimate
    """Difference of the shares, first less second, with a bootstrap's bounds."""
    p: float
    """Two-sided p value of no difference."""
    adjusted_p: float
    """The p value after Holm's correction for all comparisons."""
    effect: float
    """Cohen's h."""


def compare_all(
    shares: Mapping[str, FloatArray],
    cluster: IntArray,
    *,
    rng: np.random.Generator,
    draws: int = 10_000,
    including: Collection[str] = (),
) -> list[Comparison]:
    """Compare each two configurations on the commands that both have.

    `shares` are by configuration, the part of each command's judgments that agree, shape
    (commands,); NaN where it has none. `cluster` is each command's cluster, such as its video,
    shape (commands,). Pairs that have none of those to be `including` are left out, and those
    without a command in common.
    """
    result = []
    for one, other in combinations(shares, 2):
        if including and not {one, other} & set(including):
            continue
        both = ~np.isnan(shares[one]) & ~np.isnan(shares[other])
        if both.any():
            mine, theirs = shares[one][both], shares[other][both]
            _, index = np.unique(cluster[both], return_inverse=True)
            estimate = _difference(mine - theirs, index, rng, draws)
            effect = cohens_h(float(mine.mean()), float(theirs.mean()))
            p = clustered_mcnemar(mine - theirs, index)
            result.append(Comparison(one, other, int(both.sum()), estimate, p, p, effect))
    adjusted = holm([c.p for c in result])
    return [
        replace(c, adjusted_p=float(corrected))
        for c, corrected in zip(result, adjusted, strict=True)
    ]


def _difference(
    differences: FloatArray, cluster: IntArray, rng: np.random.Generator, draws: int
) -> Estimate:
    """Return the mean difference, with whole clusters resampled."""
    counted = np.stack([np.bincount(cluster, weights=differences), np.bincount(cluster)], axis=1)
    sums, sizes = resampled_sums(counted, rng=rng, draws=draws).T
    return percentiles(float(differences.mean()), sums / sizes, len(counted))


def clustered_mcnemar(differences: FloatArray, cluster: IntArray) -> float:
    """Return the two-sided p of no difference, for matched pairs in clusters.

    N. A. Obuchowski, Statistics in Medicine 17 (1998): the square of the sum over that of the
    clusters' squared sums, which is McNemar's test where each pair is a cluster. Its distribution
    is approximate. Where fewer than :data:`~eval.statistics.estimates.FEWEST_CLUSTERS` clusters
    differ, the sum is compared with those that all changes of the clusters' signs give instead,
    which is exact. Where none differs, p is 1.

    `differences` are those of each matched pair, shape (n,): −1, 0 or 1 for yes and no, or
    differences of shares.
    """
    sums = np.bincount(cluster, weights=differences)
    sums = sums[np.abs(sums) > ALIKE]
    if len(sums) == 0:
        return 1.0
    if len(sums) < FEWEST_CLUSTERS:
        from scipy.stats import permutation_test  # noqa: PLC0415 - heavy

        # SciPy wants two observations; one of zero changes nothing.
        exact = permutation_test(
            (np.append(sums, 0.0),),
            np.sum,
            permutation_type="samples",
            n_resamples=2**FEWEST_CLUSTERS,
        )
        return float(exact.pvalue)
    squares = float((sums**2).sum())
    return float(special.chdtrc(1, float(sums.sum()) ** 2 / squares))


def holm(p: npt.ArrayLike) -> FloatArray:
    """Adjust p values by S. Holm's step-down procedure (Scand. J. Stat. 6, 1979)."""
    values = np.asarray(p, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    steps = values[order] * np.arange(len(values), 0, -1)
    adjusted = np.empty_like(values)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return adjusted


def cohens_h(one: float, other: float) -> float:
    """Return the difference of two shares on the arcsine scale (J. Cohen, 1988, chapter 6)."""
    first, second = np.arcsin(np.sqrt(np.clip([one, other], 0, 1)))
    return float(2 * first - 2 * second)
