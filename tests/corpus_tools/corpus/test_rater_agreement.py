from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.corpus.rater_agreement import fleiss_kappa, krippendorff_alpha

# Krippendorff (2011), section C: four observers, twelve units, with missing values.
OBSERVERS = (
    "1 2 3 3 2 1 4 1 2 . . .",
    "1 2 3 3 2 2 4 1 2 5 . 3",
    ". 3 3 3 2 3 4 2 2 5 1 .",
    "1 2 3 3 2 4 4 1 2 5 1 .",
)
UNITS = [
    [int(rating) for rating in unit if rating != "."]
    for unit in zip(*(line.split() for line in OBSERVERS), strict=True)
]

# Fleiss (1971), table 1: how many of six psychiatrists gave each of thirty patients each of five
# diagnoses.
DIAGNOSES = (
    "00060", "03003", "01401", "00006", "03030", "20400", "00402", "20310", "20040", "00006",
    "10050", "11040", "03300", "10050", "02031", "00501", "30012", "51000", "02040", "10203",
    "00006", "01050", "02013", "20040", "10041", "05010", "40002", "02040", "10500", "00006",
)  # fmt: skip

# The worked example of Wikipedia's article on Fleiss' kappa: ten subjects, fourteen raters.
COUNTS = (
    (0, 0, 0, 0, 14), (0, 2, 6, 4, 2), (0, 0, 3, 5, 6), (0, 3, 9, 2, 0), (2, 2, 8, 1, 1),
    (7, 7, 0, 0, 0), (3, 2, 6, 3, 0), (2, 5, 3, 2, 2), (6, 5, 2, 1, 0), (0, 2, 2, 3, 7),
)  # fmt: skip
RATED = [[value for value, n in enumerate(row) for _ in range(n)] for row in COUNTS]

complete = st.integers(2, 4).flatmap(
    lambda raters: st.lists(
        st.lists(st.integers(1, 5), min_size=raters, max_size=raters), min_size=1, max_size=12
    )
)


@pytest.mark.parametrize(
    ("level", "published"), [("nominal", 0.743), ("ordinal", 0.815), ("interval", 0.849)]
)
def test_alpha_of_krippendorffs_example(level: str, published: float) -> None:
    assert krippendorff_alpha(UNITS, level).value == pytest.approx(published, abs=5e-4)  # type: ignore[arg-type]


def test_alpha_of_two_observers() -> None:
    """Krippendorff (2011), section A: 1 − 19 · 4 / (14 · 6), for four disagreements in ten."""
    pairs = list(zip("0100000010", "1110010000", strict=True))
    assert krippendorff_alpha(pairs).value == pytest.approx(0.095, abs=5e-4)


def test_kappa_of_fleiss_example() -> None:
    units = [
        [diagnosis for diagnosis, n in enumerate(row) for _ in range(int(n))] for row in DIAGNOSES
    ]
    assert fleiss_kappa(units).value == pytest.approx(0.430, abs=5e-4)


def test_kappa_of_the_worked_example() -> None:
    assert fleiss_kappa(RATED).value == pytest.approx(0.210, abs=5e-4)


@given(complete)
def test_alpha_is_kappa_corrected_for_small_samples(units: list[list[int]]) -> None:
    """With equally many ratings, 1 − α = (1 − κ)(n − 1)/n for n ratings in all."""
    alpha, kappa = krippendorff_alpha(units), fleiss_kappa(units)
    assert alpha.reason == kappa.reason
    if alpha.is_known:
        n = sum(map(len, units))
        assert 1 - alpha.value == pytest.approx((1 - kappa.value) * (n - 1) / n)


@given(complete, st.sampled_from(["nominal", "ordinal", "interval"]))
def test_alpha_does_not_depend_on_who_rated(units: list[list[int]], level: str) -> None:
    alpha = krippendorff_alpha(units, level)  # type: ignore[arg-type]
    turned = krippendorff_alpha([unit[::-1] for unit in units[::-1]], level)  # type: ignore[arg-type]
    assert alpha.reason == turned.reason
    assert not alpha.is_known or alpha.value == pytest.approx(turned.value)
    assert not alpha.is_known or alpha.value <= 1 + 1e-9


def test_perfect_and_undefined() -> None:
    assert krippendorff_alpha([[1, 1], [2, 2, 2]]).value == 1.0
    assert krippendorff_alpha([[1, 1], [1, 1]]).reason == "all alike"
    assert krippendorff_alpha([[1], [2]]).reason == "no overlap"
    assert krippendorff_alpha([]).reason == "no overlap"
    assert fleiss_kappa([[1, 1], [1, 1]]).reason == "all alike"
    assert fleiss_kappa([[1, 1], [2, 2, 2]]).reason == "unequal numbers"
    assert fleiss_kappa([[1], [2]]).reason == fleiss_kappa([]).reason == "no overlap"
