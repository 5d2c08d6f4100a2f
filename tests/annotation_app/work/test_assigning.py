"""Items that are assigned: only those people get them."""

from __future__ import annotations

from typing import Any

import pytest
from flask import Flask
from sqlalchemy import func, select

from annotation_app.privacy.erasure import erase
from annotation_app.store.database import transaction
from annotation_app.store.models import Assignment, Item, Person
from tests.annotation_app.browser import Browser, described, engine_of, row_in, rows_in
from tests.annotation_app.signing_in import Member, signed_in

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])

PAGE = "/dashboard/tests/assign"


def assign(judge: Member, way: str, *people: Browser, **form: str) -> Any:
    sent = {"csrf_token": judge.csrf, "task": "describe", "way": way, **form}
    return judge.client.post(
        PAGE, data={**sent, "people": [one.person.id for one in people]}, follow_redirects=True
    )


def taken(person: Browser) -> set[str]:
    """All items that somebody gets."""
    found = set()
    while (leased := person.lease("describe")).status_code == 200:
        found.add(leased.json["item"])
        assert person.answer(leased.json["item"], described()).status_code == 200
    return found


def test_only_the_chosen_get_shared_items(app: Flask) -> None:
    judge = signed_in(app, "judy", "adjudicator")
    people = [Member(app, name, "annotator") for name in ("ann", "bob", "cy")]
    for person in people:
        person.sign_in()
        person.agree()
    stranger = Browser(app)
    items = set(rows_in(app, select(Item.id).where(Item.task == "describe")))
    assert "Choose 2 people or more" in assign(judge, "share", people[0]).text
    told = assign(judge, "share", *people).text
    assert f"{len(items)} open items of describe assigned." in told
    assert taken(stranger) == set()
    shares = [taken(person) for person in people]
    assert set.union(*shares) == items
    assert sum(map(len, shares)) == 2 * len(items)  # each wants two answers
    assert max(map(len, shares)) - min(map(len, shares)) <= 1


def test_items_are_for_one_video_or_for_anybody_again(app: Flask) -> None:
    judge = signed_in(app, "judy", "adjudicator")
    people = [Member(app, name, "annotator") for name in ("ann", "bob")]
    videos = rows_in(app, select(Item.video).where(Item.task == "describe").distinct())
    assert "1 open item of describe" in assign(judge, "each", *people, video=videos[0]).text
    assert row_in(app, select(func.count()).select_from(Assignment)) == 2
    assert len(taken(Browser(app))) == len(videos) - 1
    with transaction(engine_of(app)) as session:
        erase(session, session.get_one(Person, people[0].person.id), now=1.0)
    assert row_in(app, select(func.count()).select_from(Assignment)) == 1
    assign(judge, "anybody")
    assert rows_in(app, select(Assignment.item_id)) == []
    assert assign(judge, "nonsense").status_code == 422
    assert judge.client.get(PAGE).status_code == 200
    assert Browser(app, "annotator").client.get(PAGE).status_code == 403


def test_items_are_shared_out_in_a_group(app: Flask) -> None:
    judge = signed_in(app, "judy", "adjudicator")
    people = [Member(app, name, "annotator") for name in ("ann", "bob", "cy")]
    for person in people:
        person.sign_in()
        person.agree()
    items = set(rows_in(app, select(Item.id).where(Item.task == "describe")))

    def group(name: str, *members: Browser, **form: str) -> str:
        sent = {"csrf_token": judge.csrf, "group": name, **form}
        ids = [one.person.id for one in members]
        page = judge.client.post(
            f"{PAGE}/groups", data={**sent, "people": ids}, follow_redirects=True
        )
        return str(page.text)

    assert "Choose the people" in group("night shift")
    assert "Give the group a name" in group(" ", *people)
    assert "The group night shift is saved." in group("night shift", *people)
    assert "The group night shift is saved." in group("night shift", *people[:2])
    assert "There is no group day shift" in assign(judge, "share", groups="day shift").text
    assert f"{len(items)} open items" in assign(judge, "share", groups="night shift").text
    assert taken(people[2]) == set()
    assert taken(people[0]) == taken(people[1]) == items
    page = group("", remove="night shift")
    assert "The group night shift is removed." in page
    assert 'name="groups"' not in page
