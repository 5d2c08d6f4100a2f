"""Table 1's F-scores where neither the scenario nor, in some rows, the corpus was learned from.

``python -m benchmarks.unseen_worlds choices REAL BUNDLED [OTHER]... [--ablate SET]...`` (or
``--with SET``) shows how well clauses are told with each scenario held out, and with whole corpora
held out: what helps in all of these rows may help in worlds that nobody looked at.

``python -m benchmarks.unseen_worlds curve REAL BUNDLED`` learns from the bundled corpus and from
more and more scenarios of the real one, and tests on the real scenarios that are left.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.labelled_corpus import labelled_examples
from corpus_tools.importers.authored.bundled import open_corpus
from eval.statistics.estimates import BoolArray
from eval.table_1.correspondence import TYPES
from g3.features.feature_registry import select
from g3.learning.factor_matrix import FactorMatrix, matrix_of_examples
from g3.learning.grounding_model import GroundingModel

SIZES = (0, 3, 6, 9, 12, 14)
DRAWS = 3
PARTS = 7
"""Of the bundled corpus, each held out in turn."""

Names: TypeAlias = npt.NDArray[Any]
Side: TypeAlias = tuple[BoolArray, BoolArray]


def main(arguments: list[str]) -> None:
    mode, *rest = arguments
    names = [name for name in rest if not name.startswith("--")]
    options = [i for i, name in enumerate(rest) if name.startswith("--")]
    named = {rest[i + 1]: rest[i] for i in options}
    names = [name for name in names if name not in named]
    sets = select(
        without=[name for name, option in named.items() if option == "--ablate"],
        plus=[name for name, option in named.items() if option == "--with"],
    )
    items = [(name, e) for name in names for e in labelled_examples(open_corpus(name))]
    factors = matrix_of_examples([e for _, e in items], sets)
    corpus = np.array([name for name, _ in items])
    scenario = np.char.add(np.char.add(corpus, "/"), factors.scenario.astype(np.str_))
    types = np.array([e.sdc.type for _, e in items])
    if mode == "curve":
        _curve(factors, types, corpus, scenario, names)
    else:
        _choices(factors, types, corpus, scenario, names)


def _choices(
    factors: FactorMatrix,
    types: Names,
    corpus: Names,
    scenario: Names,
    names: Sequence[str],
) -> None:
    real, bundled, *others = names
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


def _curve(
    factors: FactorMatrix,
    types: Names,
    corpus: Names,
    scenario: Names,
    names: Sequence[str],
) -> None:
    real, bundled = names
    scenes = np.unique(scenario[corpus == real])
    print(f"| real scenarios | {' | '.join(TYPES)} | overall |")
    for size in (s for s in SIZES if s < len(scenes)):
        sides = []
        for learned in _drawn(scenes, size):
            test = (corpus == real) & ~np.isin(scenario, learned)
            sides.append(((corpus == bundled) | np.isin(scenario, learned), test))
        label, said, kind = _told(factors, types, sides)
        print(f"| {size} | {_row(label, said, kind)} |", flush=True)


def _drawn(scenes: Names, size: int) -> Iterator[Names]:
    """Scenarios to learn from; all ways of leaving one out, a few draws of fewer."""
    if size == len(scenes) - 1:
        yield from (scenes[scenes != left_out] for left_out in scenes)
        return
    rng = np.random.default_rng(size)
    for _ in range(DRAWS if size else 1):
        yield rng.choice(scenes, size=size, replace=False)


def _without(known: BoolArray, scenario: Names, held_out: Sequence[str] | Names) -> Side:
    test = np.isin(scenario, held_out)
    return known & ~test, test


def _told(
    factors: FactorMatrix, types: Names, sides: Sequence[Side]
) -> tuple[BoolArray, BoolArray, Names]:
    """Labels, predictions and types of all that is tested, one side after the other."""
    said = [GroundingModel().fit(factors[train]).predict(factors[test]) for train, test in sides]
    label = np.concatenate([factors.correct[test] for _, test in sides])
    return label, np.concatenate(said), np.concatenate([types[test] for _, test in sides])


def _row(label: BoolArray, said: BoolArray, kind: Names) -> str:
    of_kind = [*(kind == t for t in TYPES), np.ones(len(label), dtype=bool)]
    return " | ".join(f"{_f(label[own], said[own]):.3f}" for own in of_kind)


def _f(label: BoolArray, said: BoolArray) -> float:
    return float(2 * (label & said).sum() / max(label.sum() + said.sum(), 1))


if __name__ == "__main__":
    main(sys.argv[1:] or ["choices", "aaai11", "warehouse"])
