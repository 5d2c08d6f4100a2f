"""Lists of platforms end, and no entry of them is forgotten."""

from __future__ import annotations

from typing import Any

import pytest
from flask import Flask
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.core.config import Config
from annotation_app.crowds.paging import Page, read_pages
from annotation_app.crowds.platform import PlatformError
from tests.annotation_app.crowds.crowd_worker import OPTIONS, Lab, external_url, take_part
from tests.annotation_app.crowds.mturk.turkers import work, worker
from tests.annotation_app.crowds.prolific_stand_in import Freedoms, Prolific
from tests.annotation_app.crowds.stand_ins import MechanicalTurk


def a_study(number: int) -> dict[str, Any]:
    return {"id": f"other{number}", "name": "Other", "internal_name": None, "reward": 100}


@given(
    entries=st.lists(st.integers(0, 9), max_size=12),
    size=st.integers(1, 5),
    back_to=st.none() | st.integers(0, 12),
)
def test_each_entry_comes_once(entries: list[int], size: int, back_to: int | None) -> None:
    """Also of lists whose last page leads back."""
    starts = range(0, max(1, len(entries)), size)
    reads = []

    def read(place: int | None) -> Page:
        reads.append(place)
        start = place or 0
        named = [{"id": str(entry)} for entry in entries[start : start + size]]
        following = start + size
        return Page(named, following if following in starts else back_to)

    found = [entry["id"] for entry in read_pages(read, "id", "list")]
    assert len(reads) <= 2 * len(entries) + 5
    if len(set(entries)) == len(entries):
        assert found == [str(entry) for entry in entries]
    assert len(set(found)) == len(found)


def test_a_list_that_never_ends_is_left() -> None:
    assert read_pages(lambda place: Page((), (place or 0) + 1), "id", "list") == []


def test_an_empty_page_is_not_the_end() -> None:
    pages = [Page([{"id": "a"}], 1), Page((), 2), Page([{"id": "b"}])]
    assert [e["id"] for e in read_pages(lambda place: pages[place or 0], "id", "list")] == [
        "a",
        "b",
    ]


def test_a_rest_is_named() -> None:
    with pytest.raises(PlatformError, match="has 3 entries, and only 1 of them came"):
        read_pages(lambda _: Page([{"id": "a"}], None, 3), "id", "list")


@pytest.mark.parametrize("others", [99, 100, 199])
@pytest.mark.parametrize("page", [None, 100])
def test_a_hundred_studies_are_read(
    app: Flask, lab: Lab, prolific: Prolific, others: int, page: int | None
) -> None:
    prolific.freedoms = Freedoms(page=page, others=[a_study(n) for n in range(others)])
    assert lab.publish(*OPTIONS).exit_code == 0
    assert "0 assignments added, 4 in all" in lab.publish(*OPTIONS).output
    take_part(app, prolific, "p1")
    assert lab.collect().exit_code == 0
    assert prolific.submissions["sub1"]["status"] == "APPROVED"


@pytest.mark.parametrize("submissions", [100, 101])
@pytest.mark.parametrize(
    "freedoms",
    [
        Freedoms(),
        Freedoms(page=20),
        Freedoms(page=100),
        Freedoms(page=100, is_endless=True),
        Freedoms(page=100, counted=False),
        Freedoms(page=100, miscounted=-50),
        Freedoms(page=20, next_page="?page={number}"),
    ],
)
def test_a_hundred_submissions_are_read(
    app: Flask, lab: Lab, prolific: Prolific, submissions: int, freedoms: Freedoms
) -> None:
    prolific.freedoms = freedoms
    lab.publish(*OPTIONS)
    for number in range(submissions - 1):
        prolific.begin(f"stranger{number}")
    take_part(app, prolific, "last")
    result = lab.collect()
    assert result.exit_code == 0, result.exception
    assert prolific.submissions[f"sub{submissions}"]["status"] == "APPROVED"


@pytest.mark.parametrize(
    "freedoms",
    [
        Freedoms(page=2, miscounted=1),
        Freedoms(page=2, next_page="https://elsewhere.example/api/v1/studies/?page={number}"),
        Freedoms(page=2, next_page="//elsewhere.example/?page={number}"),
        Freedoms(page=2, next_page="/api/v1/users/me/?page={number}"),
    ],
)
def test_what_does_not_come_stops_everything(
    app: Flask, lab: Lab, prolific: Prolific, freedoms: Freedoms
) -> None:
    lab.publish(*OPTIONS)
    take_part(app, prolific, "p1")
    prolific.freedoms = freedoms
    prolific.freedoms.others = [a_study(number) for number in range(3)]
    stopped = str(lab.collect().exception)
    assert "only 4 of them came" in stopped or "said to be elsewhere" in stopped
    assert "approve" not in prolific.calls


@pytest.mark.parametrize("page", [None, 2])
def test_a_projects_pages_have_numbers(
    app: Flask, lab: Lab, prolific: Prolific, page: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROLIFIC_PROJECT", "project1")
    prolific.freedoms.others = [a_study(number) for number in range(250)]
    prolific.project_page = page
    assert lab.publish(*OPTIONS).exit_code == 0
    assert "0 assignments added" in lab.publish(*OPTIONS).output
    assert len(prolific.studies) == 1


@pytest.mark.parametrize("is_endless", [False, True])
@pytest.mark.parametrize("page", [1, 100])
def test_all_hits_and_assignments_are_read(
    app: Flask, config: Config, mturk: MechanicalTurk, page: int, is_endless: bool
) -> None:
    mturk.page, mturk.is_endless = page, is_endless
    mturk.others = [{"HITId": f"OTHER{number}"} for number in range(3 * page)]
    lab = Lab(config, mturk.address)  # type: ignore[attr-defined]
    lab.publish("--task", "describe", "--items", "1", "--people", "3")
    address = external_url(next(iter(mturk.hits.values()))["Question"])
    for number in range(3):
        one = worker(app, address, mturk, f"W{number}")
        work(one, 1)
        one.submit(mturk)
    assert lab.collect().exit_code == 0
    assert {a["AssignmentStatus"] for a in mturk.assignments.values()} == {"Approved"}
    bonus = ("--bonus", next(iter(mturk.assignments)), "0.50", "For care")
    for _ in range(2):
        assert lab.collect(*bonus).exit_code == 0
    assert len(mturk.bonuses) == 1
