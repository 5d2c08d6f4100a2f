from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.core.problems import Refusal
from annotation_app.crowds.participation import (
    Offer,
    completion_code,
    credited,
    read_offer,
    sign_offer,
)
from annotation_app.store.models import Participation

KEY = b"k" * 32
OFFER = Offer("study", "rate", 5)
times = st.integers(0, 50).map(float)


def assignment(number: int, begun_at: float, items: int) -> Participation:
    return Participation(id=number, begun_at=begun_at, items=items, received_at=None)


@given(st.lists(st.tuples(times, st.integers(1, 4)), max_size=5), st.lists(times, max_size=30))
def test_each_answer_counts_once(begun: list[tuple[float, int]], answered: list[float]) -> None:
    mine = [assignment(i, at, items) for i, (at, items) in enumerate(begun)]
    counts = credited(mine, answered)
    assert sum(counts.values()) <= len(answered)
    for one in mine:
        assert counts[one.id] <= one.items
        later = sum(at >= one.begun_at for at in answered)
        assert counts[one.id] <= later
    if len(mine) == 1:
        assert counts[0] == min(mine[0].items, later)


def test_nothing_goes_to_what_was_given_up() -> None:
    given_up, current = assignment(1, 0.0, 3), assignment(2, 10.0, 3)
    assert credited([given_up, current], [1.0, 11.0, 12.0, 13.0]) == {1: 1, 2: 3}


def test_offers_are_signed() -> None:
    token = sign_offer(KEY, OFFER)
    assert read_offer(KEY, token) == OFFER
    with pytest.raises(Refusal):
        read_offer(b"x" * 32, token)


def test_codes_differ_by_offer_and_installation() -> None:
    codes = {
        completion_code(KEY, OFFER),
        completion_code(KEY, Offer("study", "rate", 6)),
        completion_code(b"x" * 32, OFFER),
    }
    assert len(codes) == 3
    assert completion_code(KEY, OFFER) == completion_code(KEY, Offer("study", "rate", 5))
