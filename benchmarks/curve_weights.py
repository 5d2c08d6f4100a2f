"""Calibration of the probabilities of plans on a corpus that their curve hasn't seen.

``python -m benchmarks.curve_weights CORPUS CORPUS...`` follows the commands of each corpus as
typed, each scenario held out of what is learned. Each plan counts by its known outcome, and a
second time by the verdict on the annotated words where there is one, as these may allow other ends
than the known one. It then fits the curve to the plans for all corpora but
one, each counted as much as the others, and prints its errors on the one. The last line has the
weights for `g3.inference.calibration`, fitted to all. What comes after ``--tested`` is neither
learned from nor fitted to. "written" are the commands that imitate people
(:mod:`benchmarks.written_commands`), the first eight sets; a set's name is that set. Nothing
is learned from them. With ``--apart`` no scenario of the tested corpus is learned from.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from benchmarks.written_commands import SETS, by_model, followed, learned_cost, records_of
from corpus_tools.runtime.parallel import Workers
from eval.statistics.estimates import BoolArray
from eval.table_3.end_to_end import run
from eval.table_3.outcomes import Outcome, reliability, risk_coverage
from g3.groundings import FloatArray
from g3.inference.calibration import fit_curve
from g3.inference.grounder import Grounder

PLANS = 200
"""Weight of each corpus as a number of plans, compared with the prior of the slope."""
DRAWS = 300
"""Number of draws of verdicts from the stated probabilities, for the error by chance."""
WRITTEN: Mapping[str, Sequence[str]] = {"written": SETS[:8], **{name: (name,) for name in SETS}}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.curve_weights",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", nargs="*", default=["aaai11", "automatic", "warehouse", "written"])
    parser.add_argument("--tested", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--jobs", type=int, default=1, help="how many processes work")
    parser.add_argument("--apart", action="store_true", help="learn from the other corpora alone")
    options = parser.parse_args()
    workers, plans = Workers(options.jobs), dict[str, list[Outcome]]()
    for name in (*options.names, *options.tested):
        left_out = {*WRITTEN, name} if options.apart else {*WRITTEN}
        learned = ",".join(other for other in options.names if other not in left_out)
        plans[name] = _written(name, learned) if name in WRITTEN else _plans(name, learned, workers)
    print(
        "| left out | plans | right | stated | ECE | by chance | p | Brier | under risk-coverage |"
    )
    for name, own in plans.items():
        others = [plans[other] for other in options.names if not _alike(other, name)]
        chance = expit(_seen(own) @ fitted(others))
        told = [replace(o, probability=float(p)) for o, p in zip(own, chance, strict=True)]
        right = _right(own)
        brier = float(np.square(chance - right).mean())
        error, by_chance = reliability(told)[0].value, _by_chance(told)
        p = float(np.mean(by_chance >= error))
        found = (error, by_chance.mean(), p, brier, risk_coverage(told).value)
        figures = (right.mean(), chance.mean(), *found)
        print(f"| {name} | {len(own) // 2} | {' | '.join(f'{f:.3f}' for f in figures)} |")
    print(f"weights: {np.round(fitted([plans[name] for name in options.names]), 2).tolist()}")


def _alike(one: str, other: str) -> bool:
    """Check that plans are of one kind of world, so that they are left out together."""
    return one == other or (one in WRITTEN and other in WRITTEN)


def fitted(parts: Sequence[Sequence[Outcome]]) -> FloatArray:
    """Fit a curve to the plans of several corpora, each with the same weight."""
    counts = np.concatenate([np.full(len(own), PLANS / len(own)) for own in parts])
    together = [o for own in parts for o in own]
    return fit_curve(_seen(together), _right(together), counts)


def _plans(test: str, train: str, workers: Workers) -> list[Outcome]:
    found = run(train, test, configurations=("auto",), workers=workers).outcomes["auto"]
    own = [o for o in found if o.evidence]
    by_words = [o if o.by_words is None else replace(o, correct=o.by_words) for o in own]
    return [*own, *by_words]


def _written(name: str, train: str) -> list[Outcome]:
    plan = by_model(Grounder(learned_cost(train.split(","))))
    records = [record for own in WRITTEN[name] for record in records_of(own)]
    own = [o for o in (followed(record, plan) for record in records) if o.evidence]
    return [*own, *own]


def _seen(plans: list[Outcome]) -> FloatArray:
    return np.array([o.evidence for o in plans])


def _right(plans: list[Outcome]) -> BoolArray:
    return np.array([o.correct for o in plans], dtype=bool)


def _by_chance(plans: list[Outcome]) -> FloatArray:
    """Return expected calibration errors of outcomes drawn as if the probabilities were right."""
    rng, once = np.random.default_rng(0), plans[: len(plans) // 2]
    drawn = [
        reliability([replace(o, correct=bool(rng.random() < o.probability)) for o in once])[0].value
        for _ in range(DRAWS)
    ]
    return np.array(drawn)


if __name__ == "__main__":
    main()
