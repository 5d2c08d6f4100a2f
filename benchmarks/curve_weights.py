"""How right the probabilities of plans are on a corpus that their curve hasn't seen.

``python -m benchmarks.curve_weights CORPUS CORPUS...`` follows the commands of each corpus, each
scenario held out of what is learned. It then fits the curve to the plans for all corpora but one,
each counted as much as the others, and prints its errors on the one. The last line has the weights
for `g3.inference.calibration`, fitted to all. Corpora after ``--tested`` are not learned from.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from scipy.special import expit

from eval.statistics.estimates import BoolArray
from eval.table_3.end_to_end import run
from eval.table_3.outcomes import Outcome, reliability, risk_coverage
from g3.groundings import FloatArray
from g3.inference.calibration import fit_curve

PLANS = 200
"""How many each corpus counts for, beside the prior of the slope."""
DRAWS = 300
"""Of verdicts that the stated probabilities make, which say how large the error is by chance."""


def main(names: list[str]) -> None:
    at = names.index("--tested") if "--tested" in names else len(names)
    learned, tested = names[:at], names[at + 1 :]
    plans = {name: _plans(name, ",".join(learned)) for name in (*learned, *tested)}
    print("| left out | plans | right | ECE | by chance | Brier | under risk-coverage |")
    for name, own in plans.items():
        weights = fitted(plan for other, plan in plans.items() if other != name)
        chance = expit(_seen(own) @ weights)
        told = [replace(o, probability=float(p)) for o, p in zip(own, chance, strict=True)]
        right = _right(own)
        brier = float(np.square(chance - right).mean())
        figures = (right.mean(), reliability(told)[0], _by_chance(told), brier, risk_coverage(told))
        print(f"| {name} | {len(own)} | {' | '.join(f'{f:.3f}' for f in figures)} |")
    print(f"weights: {np.round(fitted(plans.values()), 2).tolist()}")


def fitted(plans: Iterable[list[Outcome]]) -> FloatArray:
    """A curve for plans of several corpora, each as weighty as the others."""
    parts = list(plans)
    counts = np.concatenate([np.full(len(own), PLANS / len(own)) for own in parts])
    together = [o for own in parts for o in own]
    return fit_curve(_seen(together), _right(together), counts)


def _plans(test: str, train: str) -> list[Outcome]:
    found: Mapping[str, Iterable[Outcome]] = run(
        train, test, configurations=("gold", "auto")
    ).outcomes
    return [o for o in found.get("gold", found["auto"]) if o.evidence]


def _seen(plans: list[Outcome]) -> FloatArray:
    return np.array([o.evidence for o in plans])


def _right(plans: list[Outcome]) -> BoolArray:
    return np.array([o.correct for o in plans], dtype=bool)


def _by_chance(plans: list[Outcome]) -> float:
    """The mean expected calibration error if the probabilities were right."""
    rng = np.random.default_rng(0)
    drawn = (
        reliability([replace(o, correct=bool(rng.random() < o.probability)) for o in plans])[0]
        for _ in range(DRAWS)
    )
    return float(np.mean(list(drawn)))


if __name__ == "__main__":
    main(sys.argv[1:] or ["aaai11", "automatic", "warehouse"])
