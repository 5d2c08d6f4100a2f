"""Which of many slots somebody is given: the first of all, or any of them alike."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from scipy.stats import chisquare
from sqlalchemy import Engine, select, update
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.items.assignment import Lease, take
from annotation_app.items.new_items import new_slots
from annotation_app.store.database import transaction
from annotation_app.store.models import Item, Person, Slot, Study

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])

ITEMS, ANSWERS, TRIALS, NOW = 5, 2, 400, 1000.0


def fill(session: Session) -> Study:
    study = Study(id=new_id(), name="s", config={}, created_at=NOW)
    session.add(study)
    session.flush()
    for number in range(ITEMS):
        item = Item(
            id=f"item {number}", study_id=study.id, task="rate", subject=str(number),
            payload={}, rank=1 - number / ITEMS, attention=False,
        )  # fmt: skip
        item.slots = new_slots(item, ANSWERS)
        session.add(item)
    session.flush()
    return study


def somebody(session: Session) -> Person:
    person = Person(
        id=new_id(), role="worker", provider="open", external_hash=new_id(), profile={},
        created_at=NOW,
    )  # fmt: skip
    session.add(person)
    session.flush()
    return person


def given(session: Session, study: Study, person: Person, *, at_random: bool) -> str:
    lease = take(session, study.id, "rate", person, now=NOW, lease_s=60, in_random_order=at_random)
    assert isinstance(lease, Lease)
    return lease.item_id


def test_the_lowest_rank_comes_first(empty: Engine) -> None:
    with transaction(empty) as session:
        study = fill(session)
        people = [somebody(session) for _ in range(ITEMS * ANSWERS)]
        found = [given(session, study, person, at_random=False) for person in people]
    assert found == [f"item {number}" for number in reversed(range(ITEMS)) for _ in range(ANSWERS)]


def test_at_random_all_items_and_pairs_of_items_are_alike(
    empty: Engine, request: pytest.FixtureRequest
) -> None:
    """Two people in a row get any two slots of the ten alike: 4 in 45 pairs are of one item."""
    state = random.getstate()
    random.seed(20)
    request.addfinalizer(lambda: random.setstate(state))
    pairs: Counter[tuple[str, str]] = Counter()
    with transaction(empty) as session:
        study = fill(session)
        people = [somebody(session) for _ in range(2)]
        slots = session.scalars(select(Slot.id)).all()
        for _ in range(TRIALS):
            session.execute(update(Slot).values(person_id=None, expires_at=None))
            lots = [{"id": slot, "lot": random.random()} for slot in slots]
            session.execute(update(Slot), lots)
            session.expire_all()
            one, other = (given(session, study, who, at_random=True) for who in people)
            pairs[one, other] += 1
    names = [f"item {number}" for number in range(ITEMS)]
    each = 1 / (ITEMS * ANSWERS) / (ITEMS * ANSWERS - 1)
    expected = {(a, b): ANSWERS * (ANSWERS - (a == b)) * each for a in names for b in names}
    counts = [pairs[pair] for pair in expected]
    assert sum(counts) == TRIALS
    assert chisquare(counts, [TRIALS * share for share in expected.values()]).pvalue > 0.001
