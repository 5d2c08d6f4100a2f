"""Waits after wrong passwords."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from flask import Flask
from sqlalchemy import delete, select

from annotation_app.people import accounts, failed_sign_ins
from annotation_app.serving.factory import create_app
from annotation_app.store.database import transaction
from annotation_app.store.models import FailedSignIn
from tests.annotation_app.browser import Browser, engine_of, installation_of, rows_in
from tests.annotation_app.signing_in import PASSWORD, Member

MINUTE_S = 60.0
HOUR_S = 3600.0


def begin(app: Flask, login: str, address: str, now: float) -> float:
    with app.app_context(), transaction(engine_of(app)) as session:
        return failed_sign_ins.begin(session, login, address, now=now)


def guessed(app: Flask, seconds: float, attempts: list[tuple[str, str]], *, at: float) -> int:
    """How many attempts of somebody who tries without pause are looked at."""
    step = seconds / len(attempts)
    waits = [begin(app, *attempt, at + i * step) for i, attempt in enumerate(attempts)]
    return waits.count(0.0)


def test_many_new_cookies_give_no_more_guesses(app: Flask, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was tried: within a minute, from one address with 25 workers' cookies, 249 wrong
    passwords, and then the right one."""
    Member(app, "ann", "admin")
    workers = [Browser(app) for _ in range(25)]
    wrong, statuses, started = 249, [], time.time()
    for number in range(wrong + 1):
        at = started + number * MINUTE_S / wrong
        monkeypatch.setattr(time, "time", lambda at=at: at)
        worker = workers[number % len(workers)]
        password = PASSWORD if number == wrong else f"wrong password {number}"
        form = {"csrf_token": worker.csrf, "login": "ann", "password": password}
        statuses.append(worker.client.post("/login", data=form).status_code)
    assert statuses[-1] == 429  # the right one too: nobody guesses it now
    answered = sum(status != 429 for status in statuses)
    assert answered < 15


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_guesses_at_once_are_counted_one_after_the_other(app: Flask) -> None:
    with ThreadPoolExecutor(8) as pool:
        waits = list(pool.map(lambda _: begin(app, "ann", "192.0.2.1", 1000.0), range(24)))
    assert waits.count(0.0) == failed_sign_ins.FREE_BY_LOGIN


def test_waits_grow_to_a_quarter_of_an_hour_and_no_further(app: Flask) -> None:
    free = failed_sign_ins.FREE_BY_LOGIN
    assert [begin(app, "ann", "192.0.2.1", 1000.0) for _ in range(free)] == [0.0] * free
    now, waits = 1000.0, []
    for _ in range(12):
        wait_s = begin(app, "ann", "192.0.2.1", now)
        assert begin(app, "ann", "192.0.2.1", now + wait_s / 2) == wait_s / 2  # no longer for it
        now += wait_s
        assert begin(app, "ann", "192.0.2.1", now) == 0.0
        waits.append(wait_s)
    assert waits == [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 900.0, 900.0]


def test_one_address_cannot_try_many_logins_nor_one_login_from_many_addresses(app: Flask) -> None:
    many_logins = [(f"login-{i}", "192.0.2.1") for i in range(250)]
    assert guessed(app, MINUTE_S, many_logins, at=1000.0) <= failed_sign_ins.FREE_BY_ADDRESS + 7
    many_addresses = [("ann", f"198.51.100.{i}") for i in range(250)]
    assert guessed(app, MINUTE_S, many_addresses, at=1000.0) <= failed_sign_ins.FREE_BY_LOGIN + 7
    network = [(f"name-{i}", f"2001:db8:1:2::{i:x}") for i in range(250)]
    assert guessed(app, MINUTE_S, network, at=1000.0) <= failed_sign_ins.FREE_BY_ADDRESS + 7


def test_who_others_keep_waiting_waits_a_quarter_of_an_hour_at_most(app: Flask) -> None:
    guessed(app, 24 * HOUR_S, [("ann", f"198.51.100.{i % 250}") for i in range(2000)], at=1000.0)
    wait_s = begin(app, "ann", "203.0.113.9", 1000.0 + 24 * HOUR_S)
    assert wait_s <= failed_sign_ins.LONGEST_WAIT_S
    with app.app_context(), transaction(engine_of(app)) as session:
        failed_sign_ins.forget(session, "ANN ")
    assert begin(app, "ann", "203.0.113.9", 1000.0 + 24 * HOUR_S) == 0.0


def test_success_clears_the_login_and_not_the_address(app: Flask) -> None:
    address = "192.0.2.1"
    for i in range(failed_sign_ins.FREE_BY_ADDRESS - 1):
        assert begin(app, f"login-{i}", address, 1000.0) == 0.0
    for _ in range(30):  # a class signs in
        assert begin(app, "ann", address, 1000.0) == 0.0
        with app.app_context(), transaction(engine_of(app)) as session:
            failed_sign_ins.succeeded(session, "ann", address)
    assert begin(app, "bob", address, 1000.0) == 0.0
    assert begin(app, "bob", address, 1000.0) > 0.0


def test_a_clock_that_is_set_back_makes_nobody_wait_longer(app: Flask) -> None:
    for _ in range(failed_sign_ins.FREE_BY_LOGIN):
        begin(app, "ann", "192.0.2.1", 90 * HOUR_S)
    assert begin(app, "ann", "192.0.2.1", 90 * HOUR_S) > 0.0
    assert begin(app, "ann", "192.0.2.1", 66 * HOUR_S) == 0.0


def test_nothing_readable_is_kept_and_nothing_for_long(app: Flask) -> None:
    begin(app, "ann", "192.0.2.1", 1000.0)
    begin(app, "bob", "192.0.2.2", 1000.0)
    rows = rows_in(app, select(FailedSignIn.whose))
    assert len(rows) == 4
    assert not any("ann" in row or "192.0.2" in row for row in rows)
    begin(app, "cy", "192.0.2.3", 1000.0 + 25 * HOUR_S)
    assert len(rows_in(app, select(FailedSignIn.whose))) == 2


def test_people_are_told_when_to_try_again_and_processes_count_together(
    app: Flask, monkeypatch: pytest.MonkeyPatch
) -> None:
    started = time.time()
    monkeypatch.setattr(time, "time", lambda: started)  # however slow the machine is
    Member(app, "ann", "annotator")
    other = create_app(installation_of(app).config, engine_of(app))
    for number in range(failed_sign_ins.FREE_BY_LOGIN):
        process = (app, other)[number % 2]
        for login in ("ann", "nobody-at-all"):
            assert Member(process, login).sign_in("wrong password").status_code == 422
    for login in ("ann", "nobody-at-all"):  # a wait doesn't tell which logins there are
        waiting = Member(other, login).sign_in()
        assert waiting.status_code == 429
        assert 1 <= int(waiting.headers["Retry-After"]) <= 2
        assert "too many wrong passwords. Try again in" in waiting.text
    for number in range(failed_sign_ins.FREE_BY_ADDRESS):
        Member(app, f"made-up-{number}").sign_in("wrong password")
    before = rows_in(app, select(FailedSignIn.whose))
    assert Member(app, "one-more").sign_in("wrong password").status_code == 429
    assert rows_in(app, select(FailedSignIn.whose)) == before
    with app.app_context(), transaction(engine_of(app)) as session:
        session.execute(delete(FailedSignIn).where(FailedSignIn.count >= 10))  # the address's
        accounts.unblock(session, accounts.required_login(session, "ann"), actor="tests")
    assert Member(app, "ann").sign_in().status_code == 303
