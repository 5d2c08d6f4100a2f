from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, FeatureSet, catalogue, scale_of, select
from g3.features.matrix import (
    FeatureSpace,
    discretise,
    fit_space,
    joint_space,
    prior_scale,
    transform,
)
from g3.groundings import FloatArray
from g3.learning.examples import Example, to_batch
from tests.g3.features.scenes import random_rows, row, yard
from tests.worlds import scene, thing

BINS = (Column("a", "m", 0, 10, 5),)


def discretised(column: Column, *values: float) -> list[int]:
    return discretise(np.array(values)[:, None], (column,))[:, 0].tolist()


def test_bins_are_uniform_and_values_outside_are_taken_as_the_ends() -> None:
    values = (-5, 0, 1.9, 2, 3, 7.9, 8, 10, 99, np.inf, -np.inf)
    assert discretised(BINS[0], *values) == [0, 0, 0, 1, 1, 3, 4, 4, 4, 4, 0]


def test_bins_start_at_the_low_end() -> None:
    assert discretised(Column("a", "1", -2, 2, 8), -2, -1.6, -1.5, 0, 1.99) == [0, 0, 1, 4, 7]


def test_a_value_that_does_not_apply_has_no_bin() -> None:
    assert discretised(BINS[0], np.nan) == [-1]
    assert discretised(Column("a", "bool"), np.nan) == [-1]


def test_a_binary_value_is_there_or_not() -> None:
    assert discretised(Column("a", "bool"), 0, 1) == [-1, 0]


@given(st.integers(0, 4), st.floats(-1e-8, 1e-8))
def test_noise_does_not_move_a_value_off_an_edge(edge: int, noise: float) -> None:
    assert discretised(BINS[0], 2 * edge + noise) == [edge]


@given(st.lists(st.floats(-20, 20), min_size=2, max_size=10))
def test_larger_values_have_no_smaller_bins(values: list[float]) -> None:
    numbers = discretised(BINS[0], *sorted(values))
    assert numbers == sorted(numbers)


THING = thing("a", "pallet", 5, 0)
WORLD = scene(THING)


def made_up(
    *values: float, words: tuple[str, ...] = ("relation",), alone: bool = True
) -> FeatureSet:
    """A set of one column with given values."""
    table = np.array(values)[:, None]
    compute = lambda batch: table[batch.factor]  # noqa: E731
    return FeatureSet("made-up", "", ("OBJECT",), ("figure",), words, BINS, compute, True, alone)


def names(space: FeatureSpace, matrix: FloatArray) -> list[set[str]]:
    return [{space.name(i) for i in np.flatnonzero(line)} for line in matrix]


def objects(*relations: str) -> FactorBatch:
    """Rows with words of their own, even where these are the same."""
    batch = to_batch([row(WORLD, "OBJECT", THING, relation=r) for r in relations])
    own = np.arange(len(relations))
    return replace(batch, factor=own, words=[batch.words[i] for i in batch.factor])


BIAS = "OBJECT/bias"


def test_features_are_levels_reached_and_their_products_with_words() -> None:
    space, matrix = fit_space(objects("near", ""), [made_up(5, 2)])
    levels = [f"OBJECT/made-up/a>={n}" for n in (1, 2)]
    assert names(space, matrix.toarray()) == [
        {BIAS, f"{BIAS} & relation:near", *levels, *(f"{n} & relation:near" for n in levels)},
        {BIAS, levels[0]},
    ]
    assert space.sets == ("made-up",)
    assert set(matrix.data) == {1.0}


def test_several_words_are_features_and_so_is_their_phrase() -> None:
    space, matrix = fit_space(objects("next to"), [made_up(2)])
    (found,) = names(space, matrix.toarray())
    level = "OBJECT/made-up/a>=1"
    assert {n for n in found if n.startswith(level)} == {
        level, *(f"{level} & relation:{w}" for w in ("next", "to", "next_to"))
    }  # fmt: skip


def test_a_set_without_words_counts_alone() -> None:
    space, matrix = fit_space(objects("near"), [made_up(2, words=())])
    (found,) = names(space, matrix.toarray())
    assert {n for n in found if "made-up" in n} == {"OBJECT/made-up/a>=1"}


def test_a_set_that_says_nothing_alone_counts_with_words_only() -> None:
    space, matrix = fit_space(objects("near", ""), [made_up(2, 2, alone=False)])
    found = names(space, matrix.toarray())
    assert {n for n in found[0] if "made-up" in n} == {"OBJECT/made-up/a>=1 & relation:near"}
    assert found[1] == {BIAS}


def test_a_word_twice_counts_once() -> None:
    _, once = fit_space(objects("near"), [made_up(2)])
    _, matrix = fit_space(objects("near near"), [made_up(2)])
    assert set(matrix.data) == {1.0}
    # The phrase "near near" is one more word.
    assert matrix.shape[1] == once.shape[1] + 2


def test_values_in_the_lowest_bin_and_those_that_do_not_apply_are_no_features() -> None:
    space, matrix = fit_space(objects("", ""), [made_up(1, np.nan)])
    assert names(space, matrix.toarray()) == [{BIAS}, {BIAS}]


def test_words_alone_say_how_often_a_thing_or_place_is_right_and_nothing_of_actions() -> None:
    types = ("OBJECT", "EVENT", "PLACE", "PATH")
    rows = [row(WORLD, t, THING, relation="near") for t in types]  # type: ignore[arg-type]
    space, matrix = fit_space(to_batch(rows), [])
    place = {"PLACE/bias", "PLACE/bias & relation:near"}
    thing = {BIAS, f"{BIAS} & relation:near"}
    assert names(space, matrix.toarray()) == [thing, set(), place, set()]


@pytest.mark.parametrize("sets", [select(), catalogue()], ids=["default", "all"])
def test_a_transformed_training_batch_is_its_fitted_matrix(sets: tuple[FeatureSet, ...]) -> None:
    batch = to_batch([*yard(), *random_rows(0)])
    space, matrix = fit_space(batch, sets)
    again = transform(batch, sets, space)
    assert matrix.shape == again.shape == (len(batch), len(space))
    assert_array_equal(again.toarray(), matrix.toarray())
    assert (matrix.sum(axis=0) >= 1).all()
    assert (np.diff(space.keys) > 0).all()
    assert len({space.name(i) for i in range(len(space))}) == len(space)


@given(at=st.integers(0, 30), between=st.integers(0, 30))
def test_batches_fitted_one_by_one_have_the_features_of_the_whole(at: int, between: int) -> None:
    rows, sets = yard()[:31], select()
    parts = [rows[:at], rows[at : at + between], rows[at + between :]]
    fitted = [fit_space(to_batch(part), sets) for part in parts if part]
    joint, matrix = joint_space(fitted, sets)
    whole, all_rows = fit_space(to_batch(rows), sets)
    assert joint.sets == whole.sets
    assert names(joint, matrix.toarray()) == names(whole, all_rows.toarray())
    assert (np.diff(joint.keys) > 0).all()
    assert matrix.has_canonical_format


def test_no_batches_have_no_features() -> None:
    joint, matrix = joint_space([], select())
    assert (len(joint), matrix.shape) == (0, (0, 0))


def test_transforming_rows_gives_their_lines_of_the_matrix() -> None:
    rows = yard()
    space, matrix = fit_space(to_batch(rows), select())
    some = [rows[i] for i in (4, 20, 30)]
    assert_array_equal(
        transform(to_batch(some), select(), space).toarray(), matrix.toarray()[[4, 20, 30]]
    )


def test_words_and_labels_that_the_space_does_not_know_are_dropped() -> None:
    known = [row(WORLD, "OBJECT", THING, words="pallet")]
    space, matrix = fit_space(to_batch(known), select())
    novel = thing("a", "pallet zeppelin", 5, 0)
    unknown = [row(scene(novel), "OBJECT", novel, words="pallet airship")]
    lines = transform(to_batch(unknown), select(), space)
    assert lines.shape == (1, len(space))
    both = names(space, matrix.toarray())[0] & names(space, lines.toarray())[0]
    assert "OBJECT/labels/pallet & figure:pallet" in both
    other_type = transform(to_batch([row(WORLD, "EVENT", THING)]), select(), space)
    assert other_type.nnz == 0


def test_a_space_without_features() -> None:
    sets = [made_up(9)]
    space, matrix = fit_space(to_batch([row(WORLD, "EVENT", THING)]), sets)
    assert len(space) == 0
    assert matrix.shape == transform(objects("far"), sets, space).shape == (1, 0)


def test_prior_scales_are_those_of_the_sets() -> None:
    space, _ = fit_space(to_batch(yard()), select())
    scales = prior_scale(space)
    assert scales.shape == (len(space),)
    for i in range(0, len(space), 97):
        assert scales[i] == scale_of(space.name(i).split("/")[1].split(" ")[0])


def summary(rows: list[Example]) -> str:
    space, matrix = fit_space(to_batch(rows), catalogue())
    listed = [space.name(i) for i in range(len(space))]
    return f"{listed} {matrix.indices.tolist()} {matrix.indptr.tolist()}"


def test_features_and_their_order_do_not_depend_on_hashes() -> None:
    code = (
        "from hashlib import sha256\n"
        "from tests.g3.features.scenes import yard\n"
        "from tests.g3.features.test_matrix import summary\n"
        "print(sha256(summary(yard()).encode()).hexdigest())"
    )
    root = Path(__file__).parents[3]
    other = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONHASHSEED": "1", "PYTHONPATH": str(root)},
        cwd=root,
        check=True,
        capture_output=True,
        text=True,
    )
    # This process has hashes of its own.
    assert other.stdout.strip() == sha256(summary(yard()).encode()).hexdigest()
