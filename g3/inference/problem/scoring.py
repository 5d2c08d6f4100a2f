"""Scores of factors: log p(φ | words, groundings) for many candidates at once.

A factor's score is linear in its binary features, and these are thresholds of base features
times words. With the words given, all weights of a column's bins add up to one table entry for
each bin: scoring a batch is computing the base features and looking their bins up. No matrix of
features is ever made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import log_expit

from g3.features.factor_batch import ROLES, FactorBatch, FieldWords
from g3.features.feature_registry import Columns, FeatureSet, values
from g3.features.matrix import ALONE, discretise, word_names
from g3.groundings import FloatArray
from g3.learning.grounding_model import GroundingModel
from g3.sdc.clauses import SDC_TYPES, SDCType

IntArray = npt.NDArray[np.intp]

MOST_TABLES = 1024
"""Of so many phrases tables are kept, in some 20 MB."""


@dataclass(frozen=True, slots=True)
class Reason:
    """Contribution of a base feature, with one of the words, to a score.

    Parameters
    ----------
    feature
        ``set/column`` and the value's bin, if it has bins.
    word
        ``field:word``; empty for the feature by itself.
    weight
        What it adds to the log-odds.
    """

    feature: str
    word: str
    weight: float


class Scorer:
    """A model made ready for scoring; it keeps the tables that it has made.

    Parameters
    ----------
    model
        The trained model.
    """

    def __init__(self, model: GroundingModel) -> None:
        self.model = model
        self._sets = model.sets
        self._bases = {name: i for i, name in enumerate(model.space_.bases)}
        self._words = {name: i for i, name in enumerate(model.space_.words)}
        self._levels: dict[tuple[str, SDCType, tuple[str, ...]], IntArray] = {}
        self._tables: dict[tuple[object, ...], tuple[float, FloatArray]] = {}

    def log_probability(self, batch: FactorBatch, *, true: bool = True) -> FloatArray:
        """Log p(φ = true) of each row, shape (n,); of p(φ = false) if so asked."""
        odds = self.log_odds(batch)
        result: FloatArray = log_expit(odds if true else -odds)
        return result

    def log_odds(self, batch: FactorBatch) -> FloatArray:
        """Log-odds of φ of each row, shape (n,)."""
        total = np.zeros(len(batch))
        for kind in np.unique(batch.type):
            rows = np.flatnonzero(batch.type == kind)
            part = batch.take(rows) if len(rows) < len(batch) else batch
            total[rows] = self._of_type(part, SDC_TYPES[int(kind)])
        return total

    def _of_type(self, batch: FactorBatch, kind: SDCType) -> FloatArray:
        used, factor = np.unique(batch.factor, return_inverse=True)
        parts = [(feature, feature.columns_for(batch)) for feature in self._told(batch, kind)]
        known = [self._table(kind, parts, batch.words[i]) for i in used]
        total: FloatArray = np.array([bias for bias, _ in known])[factor]
        if parts:
            columns = tuple(column for _, own in parts for column in own)
            table = np.concatenate([values(feature, batch) for feature, _ in parts], axis=1)
            number = discretise(table, columns) + 1
            added = np.stack([table for _, table in known])
            total += added[factor[:, None], np.arange(len(columns)), number].sum(axis=1)
        return total

    def _told(self, batch: FactorBatch, kind: SDCType) -> list[FeatureSet]:
        """The feature sets that say something of some row of a batch."""
        there = {role for role in ROLES if (batch.role(role) >= 0).any()}
        return [f for f in self._sets if kind in f.types and there.issuperset(f.roles)]

    def _bias(self, words: FieldWords, kind: SDCType) -> float:
        base = np.array([self._bases.get(f"{kind}/bias", -1)])
        ids = self._word_ids(words, ("figure", "relation", "goal"), alone=True)
        return float(self._weights(base, ids).sum())

    def _table(
        self, kind: SDCType, parts: Sequence[tuple[FeatureSet, Columns]], words: FieldWords
    ) -> tuple[float, FloatArray]:
        """The bias, and what each bin of each column adds: (columns, bins + 1), none at 0."""
        named = tuple(c.name for feature, own in parts if callable(feature.columns) for c in own)
        key = (kind, tuple(feature.name for feature, _ in parts), named, *sorted(words.items()))
        found = self._tables.get(key)
        if found is None:
            if len(self._tables) >= MOST_TABLES:
                self._tables.clear()
            found = self._tables[key] = self._bias(words, kind), self._added(kind, parts, words)
        return found

    def _added(
        self, kind: SDCType, parts: Sequence[tuple[FeatureSet, Columns]], words: FieldWords
    ) -> FloatArray:
        steps = []
        for feature, columns in parts:
            levels = self._level_bases(feature, kind, columns)
            ids = self._word_ids(words, feature.words, alone=feature.alone)
            weight = self._weights(levels.reshape(-1), ids).sum(axis=1)
            steps.append(np.cumsum(weight.reshape(levels.shape), axis=1))
        width = 1 + max((step.shape[1] for step in steps), default=0)
        table = np.zeros((sum(len(step) for step in steps), width))
        row = 0
        for step in steps:
            table[row : row + len(step), 1 : 1 + step.shape[1]] = step
            row += len(step)
        return table

    def _level_bases(self, feature: FeatureSet, kind: SDCType, columns: Columns) -> IntArray:
        """The base feature of each bin's threshold, -1 where none is, (columns, bins)."""
        names = tuple(c.name for c in columns)
        key = (feature.name, kind, names)
        if key not in self._levels:
            width = max((max(c.bins, 1) for c in columns), default=1)
            levels = np.full((len(columns), width), -1, dtype=np.intp)
            for row, column in zip(levels, columns, strict=True):
                name = f"{kind}/{feature.name}/{column.name}"
                if not column.bins:
                    row[0] = self._bases.get(name, -1)
                for level in range(1, column.bins):
                    row[level] = self._bases.get(f"{name}>={level}", -1)
            self._levels[key] = levels
        return self._levels[key]

    def _word_ids(self, words: FieldWords, fields: tuple[str, ...], *, alone: bool) -> IntArray:
        names = ((ALONE,) if alone else ()) + word_names(words, fields)
        known = dict.fromkeys(self._words.get(name, -1) for name in names)
        return np.array([i for i in known if i >= 0], dtype=np.intp)

    def _weights(self, bases: IntArray, words: IntArray) -> FloatArray:
        """Weights of all pairs, 0 for those that the model doesn't know; (bases, words)."""
        space = self.model.space_
        if not len(space) or not len(words):
            return np.zeros((len(bases), len(words)))
        keys = bases[:, None] * len(space.words) + words
        place = np.minimum(np.searchsorted(space.keys, keys), len(space) - 1)
        found = (space.keys[place] == keys) & (bases >= 0)[:, None]
        return np.where(found, self.model.weights_[place], 0.0)

    def reasons(self, batch: FactorBatch) -> list[Reason]:
        """Return the reasons for and against the only row of a batch, the weightiest first."""
        kind = SDC_TYPES[int(batch.type[0])]
        words = batch.words[int(batch.factor[0])]
        found: list[Reason] = []
        for feature in self._sets:
            if kind not in feature.types:
                continue
            columns = feature.columns_for(batch)
            number = discretise(values(feature, batch), columns)[0]
            levels = self._level_bases(feature, kind, columns)
            ids = self._word_ids(words, feature.words, alone=feature.alone)
            for i in np.flatnonzero(number >= 0):
                active = levels[i, : number[i] + 1]
                weight = self._weights(active, ids).sum(axis=0)
                name = f"{feature.name}/{columns[i].name}"
                if columns[i].bins:
                    name += f" (bin {number[i] + 1} of {columns[i].bins})"
                found += [
                    Reason(name, self.model.space_.words[word], float(w))
                    for word, w in zip(ids, weight, strict=True)
                    if w != 0
                ]
        return sorted(found, key=lambda reason: (-abs(reason.weight), reason.feature, reason.word))
