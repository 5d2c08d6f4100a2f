"""From base features and words to the sparse binary matrix that the model is trained on."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch, FieldWords
from g3.features.feature_registry import Columns, FeatureSet, scale_of, values
from g3.groundings import FloatArray
from g3.sdc.clauses import SDC_TYPES, SDCType
from g3.short_repr import short_repr

EDGE_TOLERANCE = 1e-6
"""A value this close below the edge of a bin, in bins, is on it: the last digits of a sum
depend on the order of its terms, and no feature should."""

BIASED: tuple[SDCType, ...] = ("OBJECT", "PLACE")
"""Types whose words say by themselves how often a phrase is right: many things are "the pallet".
In a corpus each EVENT and PATH comes with a right and with a wrong trajectory."""

ALONE = ""
"""Stands for no word: the base feature by itself."""


@short_repr
@dataclass(frozen=True, slots=True)
class FeatureSpace:
    """The binary features of a model.

    Parameters
    ----------
    sets
        Names of the feature sets that the features come from.
    bases
        Names of the discretised base features, ``TYPE/set/column/bin``.
    words
        Names of the words, ``field:word``, the empty name standing for none.
    keys
        The features, sorted: base index times the number of words plus word index,
        shape (k,).
    """

    sets: tuple[str, ...]
    bases: tuple[str, ...]
    words: tuple[str, ...]
    keys: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.keys)

    def name(self, feature: int) -> str:
        """Name a feature for people: base feature and word."""
        base, word = divmod(int(self.keys[feature]), len(self.words))
        return f"{self.bases[base]} & {self.words[word]}" if word else self.bases[base]


def fit_space(
    batch: FactorBatch,
    sets: Sequence[FeatureSet],
    *,
    biased: Collection[SDCType] = BIASED,
) -> tuple[FeatureSpace, sparse.csr_array]:
    """Collect the features that occur in a batch.

    Parameters
    ----------
    biased
        Types of which each word counts by itself, with any measurement.

    Returns
    -------
    tuple
        The space, and the batch's matrix (n, k) in it.
    """
    bases: dict[str, int] = {}
    words: dict[str, int] = {ALONE: 0}
    rows, keys = _cells(batch, sets, bases, words, grow=True, biased=biased)
    names = tuple(s.name for s in sets)
    space = FeatureSpace(names, tuple(bases), tuple(words), np.unique(keys))
    return space, _matrix(space, keys, rows, len(batch))


def joint_space(
    fitted: Sequence[tuple[FeatureSpace, sparse.csr_array]], sets: Sequence[FeatureSet]
) -> tuple[FeatureSpace, sparse.csr_array]:
    """Join the spaces of several batches that were fitted one by one.

    Parameters
    ----------
    fitted
        Result of :func:`fit_space` for each.

    Returns
    -------
    tuple
        The space, and the batches' matrix (n, k) in it, whose rows follow each other.
    """
    spaces = [space for space, _ in fitted]
    bases = _numbered(name for space in spaces for name in space.bases)
    words = _numbered((ALONE, *(name for space in spaces for name in space.words)))
    own = [renumbered(space, bases, words) for space in spaces]
    keys = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *own]))
    ends = np.cumsum(np.concatenate([[0], *(np.diff(matrix.indptr) for _, matrix in fitted)]))
    narrow = max(ends[-1], len(keys)) <= np.iinfo(np.int32).max
    width = np.dtype(np.int32 if narrow else np.int64)
    columns = [
        np.searchsorted(keys, is_fitted).astype(width)[matrix.indices]
        for is_fitted, (_, matrix) in zip(own, fitted, strict=True)
    ]
    indices = np.concatenate([np.empty(0, dtype=width), *columns])
    entries = (np.ones(len(indices)), indices, ends.astype(width))
    joint = sparse.csr_array(entries, shape=(len(ends) - 1, len(keys)))
    joint.sort_indices()
    return FeatureSpace(tuple(s.name for s in sets), tuple(bases), tuple(words), keys), joint


def _numbered(names: Iterable[str]) -> dict[str, int]:
    return {name: i for i, name in enumerate(dict.fromkeys(names))}


def renumbered(
    space: FeatureSpace, bases: Iterable[str], words: Iterable[str]
) -> npt.NDArray[np.int64]:
    """Return a space's keys among other names, shape (k,); -1 for a missing name."""
    base_of, word_of = _numbered(bases), _numbered(words)
    base, word = np.divmod(space.keys, len(space.words))
    base = np.array([base_of.get(name, -1) for name in space.bases], dtype=np.int64)[base]
    word = np.array([word_of.get(name, -1) for name in space.words], dtype=np.int64)[word]
    return np.where((base < 0) | (word < 0), -1, base * len(word_of) + word)


def columns_in(space: FeatureSpace, other: FeatureSpace) -> IntArray:
    """Return the column of each feature of a space in another, shape (k,); -1 for none."""
    keys = renumbered(space, other.bases, other.words)
    return np.where(np.isin(keys, other.keys), np.searchsorted(other.keys, keys), -1)


def prior_scale(space: FeatureSpace) -> FloatArray:
    """Return the prior scale of each feature's weight, from its feature set; shape (k,)."""
    of_base = np.array([scale_of(name.split("/")[1]) for name in space.bases])
    return of_base[space.keys // len(space.words)]


def transform(
    batch: FactorBatch, sets: Sequence[FeatureSet], space: FeatureSpace
) -> sparse.csr_array:
    """Return the matrix (n, k) of a batch in a space; unknown features are left out."""
    rows, keys = _cells(batch, sets, _numbered(space.bases), _numbered(space.words), grow=False)
    return _matrix(space, keys, rows, len(batch))


def _matrix(
    space: FeatureSpace, keys: npt.NDArray[np.int64], rows: IntArray, n: int
) -> sparse.csr_array:
    column = np.searchsorted(space.keys, keys)
    column[column == len(space.keys)] = 0
    in_space = space.keys[column] == keys if len(space.keys) else np.zeros(len(keys), dtype=bool)
    ones = np.ones(int(in_space.sum()))
    matrix = sparse.csr_array(
        (ones, (rows[in_space], column[in_space])), shape=(n, len(space.keys))
    )
    matrix.sum_duplicates()
    matrix.data[:] = 1.0
    return matrix


def _cells(
    batch: FactorBatch,
    sets: Sequence[FeatureSet],
    bases: dict[str, int],
    words: dict[str, int],
    *,
    grow: bool,
    biased: Collection[SDCType] = BIASED,
) -> tuple[IntArray, npt.NDArray[np.int64]]:
    """Row and key of each active product, both shape (cells,)."""
    parts = [_type_cells(batch, bases, words, grow=grow, biased=biased)]
    tables: dict[tuple[tuple[str, ...], bool], tuple[IntArray, IntArray]] = {}
    for feature in sets:
        key = (feature.words, feature.alone)
        if key not in tables:
            tables[key] = _word_table(batch.words, *key, words, grow=grow)
        row, base = _active(batch, feature, bases, grow=grow)
        parts.append(_multiply(row, base, batch.factor, *tables[key]))
    row, base, word = (np.concatenate(cells) for cells in zip(*parts, strict=True))
    return row, base.astype(np.int64) * len(words) + word


def _type_cells(
    batch: FactorBatch,
    bases: dict[str, int],
    words: dict[str, int],
    *,
    grow: bool,
    biased: Collection[SDCType],
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the bias of a type, alone and with each word: how often a phrase is right at all."""
    ids = np.array([_lookup(f"{t}/bias", bases, grow=grow and t in biased) for t in SDC_TYPES])
    base = ids[batch.type]
    rows = np.flatnonzero(base >= 0)
    table = _word_table(batch.words, ("figure", "relation", "goal"), True, words, grow=grow)
    return _multiply(rows, base[rows], batch.factor, *table)


def _active(
    batch: FactorBatch, feature: FeatureSet, bases: dict[str, int], *, grow: bool
) -> tuple[IntArray, IntArray]:
    """Rows and base features that are active, after discretisation into uniform bins.

    A value activates the thresholds of its bin and of all bins below, so that neighbouring
    bins share what is learned.
    """
    columns = feature.columns_for(batch)
    number = discretise(values(feature, batch), columns)
    width = max((max(c.bins, 1) for c in columns), default=1)
    levels = np.arange(width)
    binary = np.array([c.bins == 0 for c in columns], dtype=bool)
    reached = (number[:, :, None] >= levels) & ((levels > 0) | binary[:, None])
    row, column, level = np.nonzero(reached)
    key = (batch.type[row].astype(np.intp) * len(columns) + column) * width + level
    unique, inverse = np.unique(key, return_inverse=True)
    ids = np.empty(len(unique), dtype=np.intp)
    for i, code in enumerate(unique):
        rest, of_level = divmod(int(code), width)
        kind, place = divmod(rest, len(columns))
        name = f"{SDC_TYPES[kind]}/{feature.name}/{columns[place].name}"
        if columns[place].bins:
            name += f">={of_level}"
        ids[i] = _lookup(name, bases, grow=grow)
    base = ids[inverse.reshape(-1)]
    in_space = base >= 0
    return row[in_space], base[in_space]


def discretise(table: FloatArray, columns: Columns) -> npt.NDArray[np.int64]:
    """Uniform bins of base features (section 3.3).

    Parameters
    ----------
    table
        Values (n, len(columns)).

    Returns
    -------
    ndarray
        Bin numbers (n, len(columns)); -1 where nothing is active: a value that is NaN,
        or a binary feature that is false.
    """
    bins = np.array([c.bins for c in columns])
    low = np.array([c.low for c in columns])
    width = np.array([c.high - c.low for c in columns]) / np.maximum(bins, 1)
    number = np.floor((table - low) / width + EDGE_TOLERANCE)
    number = np.clip(number, 0, np.maximum(bins - 1, 0))
    number = np.where(bins == 0, np.where(table > 0.5, 0, -1), number)
    return np.where(np.isnan(table), -1, number).astype(np.int64)


def _word_table(
    factors: Sequence[FieldWords],
    fields: tuple[str, ...],
    alone: bool,
    words: dict[str, int],
    *,
    grow: bool,
) -> tuple[IntArray, IntArray]:
    """Word ids of every factor, as a flat array and offsets into it."""
    flat: list[int] = []
    offsets = [0]
    for factor in factors:
        if alone:
            flat.append(words[ALONE])
        ids = dict.fromkeys(_lookup(name, words, grow=grow) for name in word_names(factor, fields))
        flat.extend(i for i in ids if i >= 0)
        offsets.append(len(flat))
    return np.array(flat, dtype=np.intp), np.array(offsets, dtype=np.intp)


def word_names(factor: FieldWords, fields: tuple[str, ...]) -> tuple[str, ...]:
    """Return the words of some of a factor's fields, and the whole phrase of those with several."""
    return tuple(
        f"{field}:{form}"
        for field in fields
        for words in (factor.get(field, ()),)  # type: ignore[call-overload]
        for form in ((*words, "_".join(words)) if len(words) > 1 else words)
    )


def _multiply(
    row: IntArray, base: IntArray, factor: IntArray, flat: IntArray, offsets: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Each row's active base features with each of its factor's words: row, base and word."""
    begin, end = offsets[factor[row]], offsets[factor[row] + 1]
    repeat = end - begin
    total = int(repeat.sum())
    first = np.cumsum(repeat) - repeat
    word = flat[np.arange(total) - np.repeat(first - begin, repeat)]
    return np.repeat(row, repeat), np.repeat(base, repeat), word


def _lookup(name: str, table: dict[str, int], *, grow: bool) -> int:
    if grow:
        return table.setdefault(name, len(table))
    return table.get(name, -1)
