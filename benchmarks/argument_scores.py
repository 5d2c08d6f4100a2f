"""Table 1's F-scores for clauses with and without a grounded argument.

``python -m benchmarks.argument_scores CORPUS`` holds out each scenario in turn, with random
negatives, and prints the rows of docs/table-1.md.
"""

from __future__ import annotations

import sys

import numpy as np

from eval.statistics.estimates import figures
from eval.table_1.correspondence import TYPES, predicted_true
from eval.table_1.divided_examples import Choices
from eval.table_1.held_out_predictions import run


def main(corpus: str) -> None:
    choices = Choices(corpus=corpus, division="cv")
    result = run(choices)
    items, told = result.items, result.predictions
    said = predicted_true(told, choices.threshold)
    argument = np.array([bool(e.landmark or e.theme or e.goal) for e in items])
    for kind in TYPES:
        of_type = told.type == kind
        for name, chosen in (("with", argument), ("without", ~argument)):
            group = of_type & chosen
            label, called = told.label[group], said[group]
            counts = np.array([label & called, ~label & called, label & ~called, ~label & ~called])
            _, _, f, accuracy = figures(counts.sum(axis=1))
            print(f"| {kind}, {name} an argument | {group.sum()} | {f:.2f} | {accuracy:.2f} |")
        idle = (of_type & ~argument & ~told.label).sum()
        right = 2 * told.label[of_type].sum()
        if kind != "OBJECT":  # an OBJECT leaf never has one, and can be recognised by its words
            print(
                f"| {kind}, these called true, all else right | | {right / (right + idle):.2f} | |"
            )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "warehouse")
