"""Table 1's F-scores where neither the scenario nor, in some rows, the corpus was learned from.

``python -m benchmarks.unseen_worlds REAL BUNDLED [OTHER]... [--ablate SET]...`` (or
``--with SET``) shows how well clauses are classified with each scenario held out, and with whole
corpora held out: a feature that helps in all of these rows may help in worlds not seen before.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from sklearn.metrics import f1_score

from corpus_tools.corpus.labelled_corpus import labelled_examples
from corpus_tools.importers.authored.bundled import open_corpus
from eval.statistics.estimates import BoolArray
from eval.table_1.correspondence import TYPES
from g3.features.feature_registry import select
from g3.learning.factor_matrix import FactorMatrix, matrix_of_examples
from g3.learning.grounding_model import GroundingModel

PARTS = 7
"""Number of parts of the bundled corpus, each held out in turn."""

Names: TypeAlias = npt.NDArray[Any]
Side: TypeAlias = tuple[BoolArray, BoolArray]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.unseen_worlds", description=__doc__)
    parser.add_argument("names", nargs="*", default=["aaai11", "warehouse"])
    parser.add_argument("--ablate", action="append", default=[], metavar="SET")
    parser.add_argument("--with", action="append", default=[], metavar="SET", dest="plus")
    options = parser.parse_args()
    sets = select(without=options.ablate, plus=options.plus)
    items = [(name, e) for name in options.names for e in labelled_examples(open_corpus(name))]
    factors = matrix_of_examples([e for _, e in items], sets)
    corpus = np.array([name for name, _ in items])
    scenario = np.char.add(np.char.add(corpus, "/"), factors.scenario.astype(np.str_))
    types = np.array([e.sdc.type for _, e in items])
    real, bundled, *others = options.names
    known = np.isin(corpus, (real, bundled))
    own = corpus == real
    scenes = np.unique(scenario[corpus == bundled])
    rng = np.random.default_rng(0)
    parts = np.array_split(rng.permutation(scenes), PARTS)
    rows: dict[str, list[Side]] = {
        f"{real}, by scenario": [_without(known, scenario, [s]) for s in np.unique(scenario[own])],
        f"{bundled}, in {PARTS} parts": [_without(known, scenario, part) for part in parts],
        f"{real} only, {bundled} tested": [(own, corpus == bundled)],
        f"{bundled} only, {real} tested": [(corpus == bundled, own)],
        **{f"both, {name} tested": [(known, corpus == name)] for name in others},
    }
    print(f"| | {' | '.join(TYPES)} | overall |")
    for name, sides in rows.items():
        label, said, kind = _told(factors, types, sides)
        print(f"| {name} | {_row(label, said, kind)} |", flush=True)


def _without(known: BoolArray, scenario: Names, held_out: Sequence[str] | Names) -> Side:
    test = np.isin(scenario, held_out)
    return known & ~test, test


def _told(
    factors: FactorMatrix, types: Names, sides: Sequence[Side]
) -> tuple[BoolArray, BoolArray, Names]:
    """Return labels, predictions and types of all tested factors, one side after the other."""
    said = [GroundingModel().fit(factors[train]).predict(factors[test]) for train, test in sides]
    label = np.concatenate([factors.correct[test] for _, test in sides])
    return label, np.concatenate(said), np.concatenate([types[test] for _, test in sides])


def _row(label: BoolArray, said: BoolArray, kind: Names) -> str:
    of_kind = [*(kind == t for t in TYPES), np.ones(len(label), dtype=bool)]
    scores = (f1_score(label[own], said[own], zero_division=0.0) for own in of_kind)
    return " | ".join(f"{score:.3f}" for score in scores)


if __name__ == "__main__":
    main()
