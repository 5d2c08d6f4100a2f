"""Training of the choice of nouns (:mod:`g3.language.parsing.attachment`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import sparse

from g3.groundings import FloatArray
from g3.language.parsing.attachment import AttachmentModel, choice_features, leaf
from g3.language.parsing.spacy_pipeline import Analysis
from g3.language.parsing.tree_assembly import Clause, assemble
from g3.language.parsing.word_roles import Reading
from g3.lbfgs import lbfgs


def annotated_choice(
    reading: Reading, record: Callable[[int, Sequence[Clause], int], None] | None = None
) -> Callable[[int, Sequence[Clause]], int]:
    """The choices of annotated trees, for :func:`g3.language.parsing.tree_assembly.assemble`."""

    def choose(modifier: int, nouns: Sequence[Clause]) -> int:
        target = reading.modified.get(modifier)
        for number, noun in enumerate(nouns):
            if leaf(noun).begin == target:
                if record is not None:
                    record(modifier, nouns, number)
                return number
        return 0

    return choose


def train_attachments(
    commands: Sequence[Analysis], readings: Sequence[Reading], *, l2: float
) -> AttachmentModel:
    """Fit the choice by maximum likelihood with L-BFGS.

    Parameters
    ----------
    commands
        Analysed commands.
    readings
        What their annotated trees say (:func:`g3.language.parsing.word_roles.read_roles`).
    l2
        Strength of the regularisation.
    """
    groups: list[tuple[list[tuple[int, ...]], int]] = []
    for command, reading in zip(commands, readings, strict=True):

        def record(
            modifier: int, nouns: Sequence[Clause], chosen: int, command: Analysis = command
        ) -> None:
            groups.append((choice_features(command, modifier, nouns), chosen))

        choose = annotated_choice(reading, record)
        assemble(reading.roles, command.spans, command.lower, choose)
    keys = sorted({key for options, _ in groups for option in options for key in option})
    if not keys:
        return AttachmentModel()
    columns = {key: i for i, key in enumerate(keys)}
    rows = [[columns[key] for key in option] for options, _ in groups for option in options]
    group = np.array([g for g, (options, _) in enumerate(groups) for _ in options])
    gold = np.array([k == chosen for options, chosen in groups for k in range(len(options))])
    ends = np.cumsum([0, *map(len, rows)])
    flat = [column for row in rows for column in row]
    matrix = sparse.csr_array((np.ones(len(flat)), flat, ends), shape=(len(rows), len(keys)))
    transposed = sparse.csr_array(matrix.T)

    def objective(weights: FloatArray) -> tuple[float, FloatArray]:
        scores = matrix @ weights
        top = np.full(len(groups), -np.inf)
        np.maximum.at(top, group, scores)
        odds = np.exp(scores - top[group])
        total = np.bincount(group, odds)
        chance = odds / total[group]
        value = float((np.log(total) + top).sum() - scores[gold].sum())
        gradient = transposed @ (chance - gold) + l2 * weights
        return value + 0.5 * l2 * float(weights @ weights), gradient

    found = lbfgs(objective, np.zeros(len(keys)))
    return AttachmentModel(
        {key: float(w) for key, w in zip(keys, found, strict=True) if abs(w) > 1e-4}
    )
