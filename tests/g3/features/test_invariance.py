"""What no default feature may depend on: where the world lies, how it was logged, the batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from g3.features.feature_registry import catalogue, select, values
from g3.features.matrix import discretise, fit_space, transform
from g3.groundings import FloatArray, Trajectory
from g3.learning.examples import Example, to_batch
from tests.g3.features.scenes import change, denser, random_rows, rigid, table, yard

seeds = st.integers(0, 100_000)

ROUNDING = 1e-4
"""What noise can make of directions, which are rounded."""


def everything(rows: Sequence[Example]) -> dict[str, FloatArray]:
    """Values of all default feature sets, by set and column."""
    batch = to_batch(rows)
    return {
        f"{feature.name}/{column}": column_values
        for feature in select()
        for column, column_values in table(feature.name, batch).items()
    }


def assert_same_values(
    one: Sequence[Example], other: Sequence[Example], atol: float = ROUNDING
) -> None:
    first, second = everything(one), everything(other)
    assert first.keys() == second.keys()
    for name, expected in first.items():
        assert_allclose(second[name], expected, atol=atol, err_msg=name)


def assert_same_bins(one: Sequence[Example], other: Sequence[Example]) -> None:
    batches = to_batch(one), to_batch(other)
    for feature in select():
        columns = feature.columns_for(batches[0])
        first, second = (discretise(values(feature, b), columns) for b in batches)
        differ = {columns[c].name for c in np.flatnonzero((first != second).any(axis=0))}
        assert not differ, feature.name
    space, fitted = fit_space(batches[0], select())
    assert_array_equal(transform(batches[1], select(), space).toarray(), fitted.toarray())


@settings(max_examples=10)
@given(seeds, st.floats(-4, 4), st.tuples(st.floats(-1000, 1000), st.floats(-1000, 1000)))
def test_values_stay_when_the_whole_world_is_moved(
    seed: int, angle: float, shift: tuple[float, float]
) -> None:
    rows = random_rows(seed)
    assert_same_values(rows, rigid(rows, angle, shift))


@pytest.mark.parametrize("angle", [0, 0.3, np.pi / 4, np.pi / 2, 2.2, -np.pi])
@pytest.mark.parametrize("shift", [(0, 0), (0.1, -300.7)])
def test_binary_features_of_a_scene_full_of_ties_stay_when_it_is_moved(
    angle: float, shift: tuple[float, float]
) -> None:
    rows = yard()
    assert_same_bins(rows, rigid(rows, angle, shift))


@pytest.mark.parametrize("seed", range(4))
def test_float_noise_changes_no_binary_feature(seed: int) -> None:
    rng = np.random.default_rng(seed)

    def shake(log: Trajectory) -> Trajectory:
        noise = rng.uniform(-1e-9, 1e-9, (len(log), 4))
        return Trajectory(log.t, log.xyz + noise[:, :3], log.yaw + noise[:, 3])

    rows = yard()
    noisy = change(rows, shake, lambda xy: xy + rng.uniform(-1e-9, 1e-9, xy.shape))
    assert_same_bins(rows, noisy)


@settings(max_examples=8)
@given(seeds, st.integers(2, 5))
def test_the_number_of_path_points_does_not_matter(seed: int, factor: int) -> None:
    rows = [e for e in random_rows(seed) if not e.theme]
    assert_same_values(rows, denser(rows, factor))


def test_how_densely_a_carried_thing_is_logged_hardly_matters() -> None:
    rows = yard()
    coarse, fine = everything(rows), everything(denser(rows, 4))
    for name, expected in coarse.items():
        assert_allclose(fine[name], expected, atol=0.15, err_msg=name)


@settings(max_examples=3)
@given(seeds)
def test_features_of_a_batch_are_those_of_its_rows(seed: int) -> None:
    rows = random_rows(seed)
    batch, single = to_batch(rows), [to_batch([example]) for example in rows]
    for feature in catalogue():
        together = table(feature.name, batch)
        for i, row in enumerate(single):
            alone = table(feature.name, row)
            for column, column_values in together.items():
                # A label that the batch of one hasn't heard of is one that the row hasn't got.
                own = alone[column][0] if column in alone else np.float64(0)
                if column in alone or not np.isnan(column_values[i]):
                    assert_allclose(
                        column_values[i], own, atol=ROUNDING, err_msg=f"{feature.name}/{column}"
                    )


@settings(max_examples=5)
@given(seeds)
def test_the_order_of_rows_does_not_matter(seed: int) -> None:
    rows = random_rows(seed)
    order = np.random.default_rng(seed).permutation(len(rows))
    first, second = everything(rows), everything([rows[i] for i in order])
    for name, expected in first.items():
        assert_allclose(second[name], expected[order], atol=ROUNDING, err_msg=name)


def test_taking_rows_takes_their_values() -> None:
    batch = to_batch(yard())
    some = np.array([7, 3, 3, 30])
    for feature in catalogue():
        assert_array_equal(values(feature, batch.take(some)), values(feature, batch)[some])
