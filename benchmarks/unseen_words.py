"""How well OBJECTs are recognised by a noun that no training example has.

``python -m benchmarks.unseen_words CORPUS [random|hard] [--ablate SET]... [--with SET]...``
leaves out, for each of the nouns below in turn and each third of the scenarios, these scenarios
and every clause with the noun, and tests the OBJECTs of these scenarios that are named by it.
"""

from __future__ import annotations

import sys

import numpy as np

from eval.statistics.estimates import figures
from eval.table_1.correspondence import predicted_true
from eval.table_1.divided_examples import Choices, set_up
from eval.table_1.held_out_predictions import predictions
from g3.features.feature_registry import select
from g3.language.lexicon.field_words import normalise
from g3.learning.factor_matrix import matrix_of_examples
from g3.learning.grounding_model import GroundingModel

NOUNS = (
    "pallet skid crate palette tire tyre box truck trailer platform wheel load bricks lorry "
    "forklift dock cart trolley flatbed cargo"
)
PARTS = 3
FEWEST = 4


def main(arguments: list[str]) -> None:
    corpus, negatives, *rest = arguments
    options = list(zip(rest[::2], rest[1::2], strict=True))
    sets = select(
        without=[name for option, name in options if option == "--ablate"],
        plus=[name for option, name in options if option == "--with"],
    )
    choices = Choices(corpus=corpus, division="cv", negatives=negatives)  # type: ignore[arg-type]
    items = [e for e in set_up(choices).items if e.sdc.type == "OBJECT"]
    factors = matrix_of_examples(items, sets)
    part = np.searchsorted(np.unique(factors.scenario), factors.scenario) % PARTS
    rows, probability = [], []
    for noun in map(normalise, NOUNS.split()):
        named = np.array([noun in e.words["figure"] for e in items])
        free = np.array([all(noun not in words for words in e.words.values()) for e in items])
        for held_out in range(PARTS if named.sum() >= FEWEST else 0):
            test = np.flatnonzero(named & (part == held_out))
            train = np.flatnonzero(free & (part != held_out))
            rows.append(test)
            model = GroundingModel(l2=choices.strength).fit(factors[train])
            probability.append(model.predict_proba(factors[test])[:, 1])
    told = predictions([items[i] for i in np.concatenate(rows)], np.concatenate(probability))
    said, label = predicted_true(told, choices.threshold), told.label
    counts = np.array([label & said, ~label & said, label & ~said, ~label & ~said])
    precision, recall, f, accuracy = figures(counts.sum(axis=1))
    likelihood = np.log(np.where(label, told.probability, 1 - told.probability)).mean()
    print(
        f"{len(label)} examples: precision {precision:.3f}, recall {recall:.3f}, F {f:.3f}, "
        f"accuracy {accuracy:.3f}, log likelihood {likelihood:.4f}"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
