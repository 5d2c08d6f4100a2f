"""The catalogue of feature sets: every feature that the model can use is registered here."""

from __future__ import annotations

import logging
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from g3.errors import ModelError
from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch, Role, WordField
from g3.groundings import FloatArray
from g3.registry import Registry
from g3.sdc.clauses import SDC_TYPES, SDCType
from g3.short_repr import short_repr

CATALOGUE_VERSION = 3
"""Raised whenever a change makes older models read features differently."""


@dataclass(frozen=True, slots=True)
class Column:
    """One base feature.

    Parameters
    ----------
    name
        Unique in its set.
    unit
        Unit of the value: "m", "rad", "1" for a ratio, "bool".
    low, high
        Values outside are taken as these.
    bins
        Number of uniform bins between them; 0 for a binary feature.
    """

    name: str
    unit: str
    low: float = 0.0
    high: float = 1.0
    bins: int = 0


Columns = tuple[Column, ...]
Compute = Callable[[FactorBatch], FloatArray]


@short_repr
@dataclass(frozen=True, slots=True)
class FeatureSet:
    """A named family of base features that share their computation.

    Parameters
    ----------
    name
        Unique in the catalogue; what ``--ablate`` takes.
    description
        One line, from the docstring.
    types
        SDC types whose factors have these features.
    roles
        Groundings that must be present.
    words
        Fields whose words multiply the features.
    columns
        The features, or a function that names them for a batch (labels).
    compute
        From a batch of n rows to values (n, len(columns)); NaN where a feature does
        not apply.
    default
        True if models use the set by default.
    alone
        True if the features also count without a word. A property of one grounding alone says
        nothing about its being right.
    scale
        Expected size of the features' weights, relative to other sets' (the standard deviation of
        the Gaussian prior that L2 regularisation is).
    wordless
        True if the values depend on nothing but the scene and the groundings in the set's roles.
        Then rows that are equal in these need them once.
    data
        For a set that reads data which may be absent or differ, what identifies these data; raises
        a ModelError where there are none.
    optional
        Those of its types that models use it for only if it is added by its name: what helps
        one type of clause may hurt another (docs/table-1.md).
    """

    name: str
    description: str
    types: tuple[SDCType, ...]
    roles: tuple[Role, ...]
    words: tuple[WordField, ...]
    columns: Columns | Callable[[FactorBatch], Columns]
    compute: Compute
    default: bool = True
    alone: bool = True
    scale: float = 1.0
    wordless: bool = False
    data: Callable[[], str] | None = None
    optional: tuple[SDCType, ...] = ()

    def for_types(self, wanted: Container[SDCType]) -> FeatureSet:
        """Return the set for some of its types alone."""
        return replace(self, types=tuple(kind for kind in self.types if kind in wanted))

    def columns_for(self, batch: FactorBatch) -> Columns:
        """Return the features' descriptions for this batch."""
        return self.columns(batch) if callable(self.columns) else self.columns


FEATURES: Registry[FeatureSet] = Registry(
    "feature set", "g3.features", error=ModelError, see="'ct features list' shows the catalogue"
)
catalogue = FEATURES.by_name


def feature_set(
    name: str,
    *,
    types: Iterable[SDCType],
    roles: Iterable[Role],
    words: Iterable[WordField],
    columns: Columns | Callable[[FactorBatch], Columns],
    default: bool = True,
    alone: bool = True,
    scale: float = 1.0,
    wordless: bool = False,
    data: Callable[[], str] | None = None,
    optional: Iterable[SDCType] = (),
) -> Callable[[Compute], Compute]:
    """Register a function as a feature set; the parameters are those of `FeatureSet`."""

    def make(description: str, compute: Compute) -> FeatureSet:
        return FeatureSet(
            name,
            description,
            tuple(types),
            tuple(roles),
            tuple(words),
            columns,
            compute,
            default,
            alone,
            scale,
            wordless,
            data,
            tuple(optional),
        )

    return FEATURES.adding(name, make)


def select(*, without: Iterable[str] = (), plus: Iterable[str] = ()) -> tuple[FeatureSet, ...]:
    """Select the default feature sets, without some and with others.

    A default set whose data are absent is left out, with a note in the log. A set that is added is
    used for all of its types, other sets for those alone that aren't optional.

    Raises
    ------
    ModelError
        If a name is not in the catalogue, or the data of an added set are absent.
    """
    without, plus = set(without), set(plus)
    FEATURES.check(without | plus)
    chosen = [s for s in catalogue() if (s.default or s.name in plus) and s.name not in without]
    for feature in chosen:
        if feature.data is not None and feature.name in plus:
            feature.data()
    used = (s for s in chosen if s.data is None or _has_data(s))
    return tuple(s if s.name in plus else _by_default(s) for s in used)


def _by_default(feature: FeatureSet) -> FeatureSet:
    used = set(feature.types) - set(feature.optional)
    return feature.for_types(used) if feature.optional else feature


def _has_data(feature: FeatureSet) -> bool:
    try:
        if feature.data is not None:
            feature.data()
    except ModelError as error:
        _note(f"feature set {feature.name!r} is off: {error}")
        return False
    return True


@cache
def _note(text: str) -> None:
    """Say something once."""
    logging.getLogger(__name__).warning(text)


def scale_of(name: str) -> float:
    """Prior scale of a feature set; 1 for a name that isn't in the catalogue."""
    return FEATURES[name].scale if name in FEATURES else 1.0


def values(feature: FeatureSet, batch: FactorBatch) -> FloatArray:
    """Values of a feature set for every row, NaN where it doesn't apply; shape (n, columns).

    Nobody may change them.
    """
    rows, part = batch.once(
        (feature.types, feature.roles), lambda b: _applicable(b, feature.types, feature.roles)
    )
    if not len(rows):
        return np.full((len(batch), len(feature.columns_for(batch))), np.nan)
    shared, compute = feature.wordless, feature.compute
    table = part.shared(compute, *feature.roles) if shared else compute(part)
    table = np.asarray(table, dtype=float)
    if part is batch:
        return table
    result = np.full((len(batch), table.shape[1]), np.nan)
    result[rows] = table
    return result


def _applicable(
    batch: FactorBatch, types: tuple[SDCType, ...], roles: tuple[Role, ...]
) -> tuple[IntArray, FactorBatch]:
    """Rows of some types that have groundings in some roles, and the batch of them."""
    applies = np.array([t in types for t in SDC_TYPES])[batch.type]
    for role in roles:
        applies &= batch.role(role) >= 0
    rows = np.flatnonzero(applies)
    return rows, batch.take(rows) if 0 < len(rows) < len(batch) else batch
