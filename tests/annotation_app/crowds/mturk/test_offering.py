from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import Config
from annotation_app.crowds.mturk import NOT_AVAILABLE
from annotation_app.store.models import Person
from tests.annotation_app.browser import rows_in
from tests.annotation_app.crowds.crowd_worker import LAB, CrowdWorker, Lab
from tests.annotation_app.crowds.mturk.turkers import participations, worker
from tests.annotation_app.crowds.stand_ins import MechanicalTurk


def test_what_is_offered(lab: Lab, address: str, mturk: MechanicalTurk) -> None:
    (hit,) = mturk.hits.values()
    assert hit["MaxAssignments"] == 5
    assert hit["Reward"] == "0.20"
    assert address.startswith(f"{LAB}/crowd/mturk/")


def test_publishing_again_offers_only_what_is_missing(
    lab: Lab, address: str, mturk: MechanicalTurk
) -> None:
    options = ("--task", "describe", "--items", "2", "--sandbox")
    assert "0 assignments added, 5 in all" in lab.publish(*options, "--people", "5").output
    assert "15 assignments added, 20 in all" in lab.publish(*options, "--people", "20").output
    assert [hit["MaxAssignments"] for hit in mturk.hits.values()] == [5, 9, 6]
    assert "0 assignments added" in lab.publish(*options, "--people", "20").output
    # Other items are another offer.
    assert "3 assignments added" in lab.publish("--items", "20", "--people", "3").output


def test_what_ran_out_is_opened_again(lab: Lab, address: str, mturk: MechanicalTurk) -> None:
    options = ("--task", "describe", "--items", "2", "--people", "5", "--sandbox")
    (hit,) = mturk.hits.values()
    hit["Expiration"] = 0
    with pytest.raises(StopIteration):
        mturk.accept("W1")
    assert "0 assignments added, 5 in all" in lab.publish(*options).output
    mturk.accept("W1")
    lab.publish(*options)
    assert mturk.calls.count("UpdateExpirationForHIT") == 1


def test_who_may_accept(app: Flask, lab: Lab, mturk: MechanicalTurk) -> None:
    options = ("--min-approval", "95", "--min-approved", "100")
    assert lab.publish(*options).exit_code == 0
    (hit,) = mturk.hits.values()
    assert {
        rule["QualificationTypeId"]: (rule["Comparator"], rule["IntegerValues"])
        for rule in hit["QualificationRequirements"]
    } == {
        "000000000000000000L0": ("GreaterThanOrEqualTo", [95]),
        "00000000000000000040": ("GreaterThanOrEqualTo", [100]),
    }


def test_a_reply_that_is_lost_makes_no_second_hit(
    app: Flask, lab: Lab, mturk: MechanicalTurk
) -> None:
    mturk.losses = {"CreateHIT": "unavailable"}
    result = lab.publish("--people", "3", "--sandbox")
    assert "in doubt" in str(result.exception)
    assert mturk.calls.count("CreateHIT") == 1
    assert "0 assignments added, 3 in all" in lab.publish("--people", "3", "--sandbox").output
    assert len(mturk.hits) == 1


def test_a_preview_shows_and_accepts_nothing(app: Flask, address: str) -> None:
    client = app.test_client()
    path = urlsplit(address).path
    for arguments in ({"assignmentId": NOT_AVAILABLE, "workerId": "W1"}, {}):
        page = client.get(path, query_string=arguments)
        assert page.status_code == 200
        assert "This is a preview" in page.text
        assert "0.20" in page.text
        assert "<form" not in page.text
        assert "Set-Cookie" not in page.headers
    assert client.get("/crowd/finish").status_code == 404
    assert participations(app) == []


def test_ids_are_kept_as_hashes(app: Flask, address: str, mturk: MechanicalTurk) -> None:
    worker(app, address, mturk, "WVERYPRIVATE")
    (person,) = rows_in(app, select(Person).where(Person.provider == "mturk"))
    assert "PRIVATE" not in f"{person.external_hash}{person.profile}{person.login}"
    assert "PRIVATE" not in "".join(f"{p.assignment}{p.outcome}" for p in participations(app))


@pytest.mark.parametrize(
    "arguments",
    [
        {"assignmentId": "A1"},
        {"assignmentId": "A1", "workerId": "W" * 200},
        {"assignmentId": "A\0", "workerId": "W1"},
        {"assignmentId": "A1", "workerId": "W1", "turkSubmitTo": "https://evil.example"},
        {"assignmentId": "A1", "workerId": "W1", "turkSubmitTo": "https://www.mturk.com.evil.net"},
    ],
)
def test_forged_arrivals_are_refused(app: Flask, address: str, arguments: dict[str, str]) -> None:
    response = app.test_client().get(urlsplit(address).path, query_string=arguments)
    assert response.status_code == 400
    assert participations(app) == []


def test_nobody_takes_over_an_assignment(app: Flask, address: str, mturk: MechanicalTurk) -> None:
    arguments = mturk.accept("W1")
    CrowdWorker(app, address, arguments)
    path = urlsplit(address).path
    other = app.test_client().get(path, query_string={**arguments, "workerId": "W2"})
    assert other.status_code == 403


def test_nobody_changes_what_is_asked_for(app: Flask, address: str) -> None:
    path = urlsplit(address).path
    for changed in (path[:-1], path + "A", path.replace("mturk", "nowhere")):
        assert app.test_client().get(changed).status_code == 404


def test_without_a_network_there_is_one_line(
    app: Flask, config: Config, mturk: MechanicalTurk
) -> None:
    result = Lab(config, "http://127.0.0.1:9").collect()
    assert result.exit_code != 0
    assert "Mechanical Turk: " in str(result.exception)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_coming_in_several_times_at_once_is_one_assignment(
    app: Flask, address: str, mturk: MechanicalTurk
) -> None:
    arguments = mturk.accept("W1")

    def come_in(_: int) -> int:
        return app.test_client().get(urlsplit(address).path, query_string=arguments).status_code

    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(come_in, range(8))) == {302}
    (mine,) = participations(app)
    assert mine.assignment == arguments["assignmentId"]
