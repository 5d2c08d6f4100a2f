from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.statistics.estimates import FIGURES
from eval.table_1.correspondence import (
    PAPER_TABLE_1,
    ROW_TYPES,
    TYPES,
    Predictions,
    predicted_true,
    table_rows,
)

example = st.tuples(
    st.sampled_from(TYPES),
    st.booleans(),
    st.floats(0, 1),
    st.sampled_from(["c1", "c2", "c3", "c4"]),
    st.sampled_from(["s1", "s2"]),
)


def of(examples):
    columns = list(zip(*examples, strict=True)) or [()] * 5
    return Predictions(*(np.array(column) for column in columns))


HAND = of(
    [
        ("OBJECT", True, 0.9, "c1", "s1"),
        ("OBJECT", True, 0.5, "c1", "s1"),  # on the threshold: predicted true
        ("OBJECT", False, 0.7, "c2", "s1"),
        ("OBJECT", True, 0.2, "c2", "s1"),
        ("OBJECT", False, 0.1, "c3", "s2"),
        ("PLACE", False, 0.3, "c1", "s1"),
        ("PLACE", False, 0.8, "c3", "s2"),
        ("EVENT", True, 0.8, "c3", "s2"),
    ]
)


def values(row):
    return [getattr(row, name).value for name in FIGURES]


def test_rows_worked_by_hand():
    rows = {row.type: row for row in table_rows(HAND)}
    assert tuple(rows) == ROW_TYPES
    # OBJECT: tp 2, fp 1, fn 1, tn 1.
    np.testing.assert_allclose(values(rows["OBJECT"]), [2 / 3, 2 / 3, 4 / 6, 3 / 5])
    # PLACE: fp 1, tn 1; nothing is true, so recall is undefined.
    np.testing.assert_allclose(values(rows["PLACE"]), [0, np.nan, 0, 1 / 2])
    # Overall, micro: tp 3, fp 2, fn 1, tn 2.
    np.testing.assert_allclose(values(rows["overall"]), [3 / 5, 3 / 4, 6 / 9, 5 / 8])
    counts = {kind: (r.n, r.positives, r.commands, r.scenarios) for kind, r in rows.items()}
    assert counts == {
        "OBJECT": (5, 3, 3, 2),
        "PLACE": (2, 0, 2, 2),
        "PATH": (0, 0, 0, 0),
        "EVENT": (1, 1, 1, 1),
        "overall": (8, 4, 3, 2),
    }


def test_a_type_without_examples_has_no_figures():
    path = table_rows(HAND)[ROW_TYPES.index("PATH")]
    assert {getattr(path, name).reason for name in FIGURES} == {"empty class"}
    assert not any(getattr(path, name).is_known for name in FIGURES)


def test_a_type_in_one_command_has_figures_without_intervals():
    event = table_rows(HAND)[ROW_TYPES.index("EVENT")]
    assert event.accuracy.value == 1
    assert math.isnan(event.accuracy.low)
    assert math.isnan(event.accuracy.high)


def test_no_examples_at_all():
    rows = table_rows(of([]))
    assert [row.n for row in rows] == [0] * 5
    assert all(math.isnan(row.f.value) for row in rows)


def test_the_threshold_moves_predictions():
    assert predicted_true(HAND, 0.75).sum() == 3
    strict = {row.type: row for row in table_rows(HAND, threshold=0.75)}
    # OBJECT: tp 1, fn 2, tn 2.
    np.testing.assert_allclose(values(strict["OBJECT"]), [1, 1 / 3, 2 / 4, 3 / 5])


def test_rows_depend_on_the_seed_only_in_their_bounds():
    one, again, other = (table_rows(HAND, seed=seed, draws=30) for seed in (1, 1, 2))
    assert repr(one) == repr(again)  # NaN is not equal to itself
    np.testing.assert_array_equal([values(r) for r in one], [values(r) for r in other])


@given(st.lists(example, max_size=25), st.randoms(use_true_random=False))
def test_the_order_of_examples_does_not_matter(examples, random):
    shuffled = list(examples)
    random.shuffle(shuffled)
    assert repr(table_rows(of(examples), draws=20)) == repr(table_rows(of(shuffled), draws=20))


@given(st.lists(example, max_size=25))
def test_counts_add_up_to_overall(examples):
    *by_type, overall = table_rows(of(examples), draws=5)
    assert sum(row.n for row in by_type) == overall.n == len(examples)
    assert sum(row.positives for row in by_type) == overall.positives
    right = sum(row.accuracy.value * row.n for row in by_type if row.n)
    if examples:
        assert overall.accuracy.value * overall.n == pytest.approx(right)


def test_intervals_over_scenarios_are_wider_when_scenarios_differ():
    rng = np.random.default_rng(5)
    hard = rng.beta(2, 1, 20)
    scenario = np.repeat(np.arange(20), 30)
    right = rng.random(600) < hard[scenario]
    predictions = Predictions(
        type=np.full(600, "PATH"),
        label=np.ones(600, dtype=bool),
        probability=np.where(right, 0.9, 0.1),
        command=np.array([f"c{i // 3}" for i in range(600)]),
        scenario=np.array([f"s{i}" for i in scenario]),
    )
    width = {
        unit: table_rows(predictions, cluster=unit)[-1].accuracy for unit in ("command", "scenario")
    }
    assert width["scenario"].high - width["scenario"].low > 1.5 * (
        width["command"].high - width["command"].low
    )


def test_paper_figures():
    assert tuple(PAPER_TABLE_1) == ROW_TYPES
    assert PAPER_TABLE_1["OBJECT"] == (0.93, 0.94, 0.94, 0.91)
    assert PAPER_TABLE_1["overall"] == (0.90, 0.88, 0.89, 0.86)
    for row in PAPER_TABLE_1.values():
        # The figures are consistent up to rounding.
        f = 2 * row.precision * row.recall / (row.precision + row.recall)
        assert row.f == pytest.approx(f, abs=0.011)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"type": ["OBJECT", "THING"]}, "'THING' is no SDC type"),
        ({"label": [True, None]}, "label has type object"),
        ({"label": [1, 0]}, "label has type int64"),
        ({"probability": [0.5, 1.5]}, "outside 0 to 1"),
        ({"probability": [0.5, np.nan]}, "outside 0 to 1"),
        ({"command": ["c1"]}, r"command has shape \(1,\), expected \(2,\)"),
    ],
)
def test_malformed_predictions_are_refused(change, message):
    good = {
        "type": ["OBJECT", "PATH"],
        "label": [True, False],
        "probability": [0.5, 0.5],
        "command": ["c1", "c2"],
        "scenario": ["s", "s"],
    }
    Predictions(**good)
    with pytest.raises(ValueError, match=message):
        Predictions(**good | change)


def test_predictions_are_copies_that_cannot_change():
    probability = np.array([0.1])
    predictions = Predictions(["PATH"], [True], probability, ["c"], ["s"])
    probability[0] = 0.9
    assert predictions.probability[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        predictions.label[0] = False
