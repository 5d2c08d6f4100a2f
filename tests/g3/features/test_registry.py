from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from g3.errors import ModelError
from g3.features.factor_batch import Role, WordField
from g3.features.feature_registry import (
    Column,
    FeatureSet,
    catalogue,
    feature_set,
    scale_of,
    select,
    values,
)
from g3.learning.examples import to_batch
from g3.sdc.clauses import SDC_TYPES
from tests.g3.features.scenes import yard

every_set = pytest.mark.parametrize("feature", catalogue(), ids=lambda s: s.name)


@every_set
def test_a_set_says_what_it_is(feature: FeatureSet) -> None:
    assert feature.description
    assert feature.description.endswith((".", ":")) or "," in feature.description
    assert feature.types
    assert set(feature.types) <= set(SDC_TYPES)
    assert feature.roles
    assert set(feature.roles) <= set(get_args(Role))
    assert set(feature.words) <= set(get_args(WordField))
    assert feature.scale > 0
    # A set that counts neither alone nor with a word would have no features.
    assert feature.alone or feature.words


@every_set
def test_columns_are_named_once_and_have_ranges(feature: FeatureSet) -> None:
    columns = feature.columns_for(to_batch(yard()))
    assert columns
    names = [column.name for column in columns]
    assert len(set(names)) == len(names)
    for column in columns:
        assert column.unit in ("m", "rad", "1", "bool")
        assert column.low < column.high
        assert (column.bins == 0) == (column.unit == "bool")
        # Slashes and the sign of a level separate the parts of a feature's name.
        assert not set("/&>") & set(column.name)


@every_set
def test_values_have_a_column_each_and_apply_where_they_say(feature: FeatureSet) -> None:
    batch = to_batch(yard())
    table = values(feature, batch)
    assert table.shape == (len(batch), len(feature.columns_for(batch)))
    applies = np.isin(batch.type, [SDC_TYPES.index(t) for t in feature.types])
    for role in feature.roles:
        applies &= batch.role(role) >= 0
    assert applies.any()
    assert np.isnan(table[~applies]).all()
    assert not np.isinf(table).any()
    for column, value in zip(feature.columns_for(batch), table.T, strict=True):
        if column.unit == "bool":
            # An average over a trajectory counts as true where it is most of the time.
            assert column.name.startswith("mean.") or set(value[~np.isnan(value)]) <= {0, 1}
            assert np.nanmin(value) >= 0
            assert np.nanmax(value) <= 1


def test_the_catalogue_is_sorted_and_names_are_unique() -> None:
    names = [feature.name for feature in catalogue()]
    assert names == sorted(set(names))


def test_select_leaves_out_and_adds() -> None:
    default = [s.name for s in select()]
    assert default == [s.name for s in catalogue() if s.default]
    assert [s.name for s in select(without=["labels"])] == [n for n in default if n != "labels"]
    assert [s.name for s in select(plus=["start-pose"])] == sorted([*default, "start-pose"])
    assert select(plus=["labels"]) == select()  # it has no optional types
    assert "shape" not in [s.name for s in select(without=["shape"], plus=["shape"])]


def test_a_set_is_used_for_its_optional_types_only_if_it_is_added() -> None:
    def types_of(name: str, plus: tuple[str, ...] = ()) -> tuple[str, ...]:
        return next(s.types for s in select(plus=plus) if s.name == name)

    whole = next(s for s in catalogue() if s.name == "bearing")
    assert whole.types == ("OBJECT", "PLACE")
    assert types_of("bearing") == ("OBJECT",)
    assert types_of("bearing", plus=("bearing",)) == ("OBJECT", "PLACE")
    assert types_of("bearing", plus=("start-pose",)) == ("OBJECT",)
    assert whole.for_types({"PLACE", "PATH"}).types == ("PLACE",)


@pytest.mark.parametrize("argument", ["without", "plus"])
def test_select_names_what_it_does_not_know(argument: str) -> None:
    with pytest.raises(ModelError, match="no feature set 'lables'") as caught:
        select(**{argument: ["labels", "lables"]})
    assert "'labels'" in caught.value.fix
    assert "ct features list" in caught.value.fix


def test_a_name_is_registered_once() -> None:
    before = catalogue()
    register = feature_set(
        "labels", types=("OBJECT",), roles=("figure",), words=(), columns=(Column("a", "bool"),)
    )
    with pytest.raises(ValueError, match="'labels' is registered already"):
        register(lambda batch: np.zeros((len(batch), 1)))
    assert catalogue() == before


def test_scales() -> None:
    for feature in catalogue():
        assert scale_of(feature.name) == feature.scale
    assert scale_of("bias") == 1


def test_values_of_rows_that_do_not_apply_are_not_computed() -> None:
    events = [example for example in yard() if example.sdc.type == "EVENT"]
    batch = to_batch(events)

    def fail(_: object) -> np.ndarray:
        raise AssertionError("was asked for rows that it doesn't apply to")

    feature = FeatureSet("x", "", ("OBJECT",), ("figure",), (), (Column("a", "1"),), fail)
    assert_array_equal(values(feature, batch), np.full((len(events), 1), np.nan))


@every_set
def test_equal_rows_are_computed_once_and_have_the_same_values(feature: FeatureSet) -> None:
    items = yard()
    alone, twice = to_batch(items), to_batch([*items, *items[::-1]])
    expected = values(feature, alone)
    assert_array_equal(values(feature, twice), np.concatenate((expected, expected[::-1])))


@every_set
def test_wordless_sets_do_not_depend_on_words(feature: FeatureSet) -> None:
    items = yard()
    batch = to_batch(items)
    strange = ({"figure": ("left",), "relation": ("near", "between"), "name": ("truck",)},)
    others = replace(batch, words=strange, factor=np.zeros(len(batch), dtype=np.intp))
    same = np.array_equal(values(feature, batch), values(feature, others), equal_nan=True)
    assert same or not feature.wordless
