"""Programs that collect at the same time, and programs that are killed."""

from __future__ import annotations

import signal
import time
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from threading import Event, Lock
from typing import Any, Literal

import pytest
from flask import Flask

from annotation_app.core.config import Config
from annotation_app.crowds import crowd_session, ledger, prolific_client
from annotation_app.crowds.crowd_registry import find_provider
from annotation_app.crowds.crowd_session import open_session
from annotation_app.crowds.platform import Bonus
from annotation_app.crowds.settlement import Deed, Wishes
from corpus_tools.cli import console
from g3.errors import CorpusError
from tests.annotation_app.crowds.crowd_worker import BONUS, OPTIONS, PAID, Lab, take_part
from tests.annotation_app.crowds.prolific_stand_in import Prolific
from tests.annotation_app.crowds.stand_ins import Reply, serving
from tests.processes import forked

WISHES = Wishes(bonuses=[("sub1", Bonus("key", Decimal("0.50"), "For care"))])


class Killing(Prolific):
    """Prolific, which kills the program that asks it."""

    def __init__(self) -> None:
        super().__init__()
        self.victim: BaseProcess | None = None
        self.starting = Lock()
        self.at: tuple[str, Literal["before", "after"]] | None = None
        self.may_pay = Event()
        self.may_pay.set()

    def _reply(self, request: dict[str, Any], route: list[str]) -> Reply:
        operation = self.calls[-1]
        if self._kills(operation, "before"):
            return None
        if operation == "pay":
            self.may_pay.wait(60)
        reply = super()._reply(request, route)
        return None if self._kills(operation, "after") else reply

    def _kills(self, operation: str, moment: Literal["before", "after"]) -> bool:
        with self.starting:
            victim = self.victim
        if victim is None or self.at != (operation, moment):
            return False
        self.victim = None
        victim.kill()
        wait([victim.sentinel])
        return True


@pytest.fixture
def prolific() -> Any:
    platform = Killing()
    with serving(platform) as platform.address:  # type: ignore[attr-defined]
        yield platform


@pytest.fixture
def lab(app: Flask, lab: Lab, prolific: Killing) -> Lab:
    """Somebody has done an assignment and sent it in."""
    assert lab.publish(*OPTIONS).exit_code == 0
    take_part(app, prolific, "p1")
    return lab


def collect(config: Config, prolific: Killing) -> list[Deed]:
    provider = find_provider("prolific")
    assert provider is not None
    with open_session(
        provider,
        "tests",
        instance=config.instance,
        database=str(config.database),
        sandbox=False,
        endpoint=prolific.address,  # type: ignore[attr-defined]
    ) as session:
        return session.settle(WISHES)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_two_at_once_pay_once(lab: Lab, config: Config, prolific: Killing) -> None:
    prolific.may_pay.clear()
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(collect, config, prolific)
        wait_for(prolific, "pay")
        try:
            with pytest.raises(CorpusError, match="is at work on this study"):
                collect(config, prolific)
        finally:
            prolific.may_pay.set()
        assert [deed.problem for deed in first.result()] == ["", ""]
    assert collect(config, prolific) == []
    assert prolific.orders == PAID


def test_without_a_lock_too(
    lab: Lab, config: Config, prolific: Killing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ledger, "fcntl", None)
    prolific.may_pay.clear()
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(collect, config, prolific)
        wait_for(prolific, "pay")
        try:
            assert collect(config, prolific) == []
        finally:
            prolific.may_pay.set()
        assert [deed.problem for deed in first.result()] == ["", ""]
    assert lab.collect().exit_code == 0
    assert prolific.orders == PAID


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_killed_program_pays_once(lab: Lab, config: Config, prolific: Killing) -> None:
    collecting = ("crowd", "collect", "prolific", "tests", *BONUS)
    preload = (crowd_session.__name__, prolific_client.__name__)

    def is_killed(operation: str, moment: Literal["before", "after"], *options: str) -> bool:
        prolific.at = operation, moment
        with prolific.starting:
            command = [*collecting, *options, *lab.rest]
            program = forked(console.run, command, preload=preload)
            prolific.victim = program
        program.join(60)
        return program.exitcode == -signal.SIGKILL

    assert is_killed("approve", "before")
    assert is_killed("approve", "after")
    assert is_killed("set up", "after")
    assert prolific.submissions["sub1"]["status"] == "APPROVED"
    assert is_killed("pay", "before")
    # Nothing was ordered, and nobody can tell that from here.
    result = lab.collect(*BONUS)
    assert "1 call is in doubt" in str(result.exception)
    assert prolific.orders == []
    number = result.output.partition("in doubt: ")[2].partition(":")[0]
    assert is_killed("pay", "after", "--pay-again", number)
    assert "1 call is in doubt" in str(lab.collect(*BONUS).exception)
    assert prolific.orders == PAID
    prolific.let_minutes_pass()
    assert lab.collect(*BONUS).exit_code == 0
    assert prolific.orders == PAID
    assert prolific.submissions["sub1"]["status"] == "APPROVED"


def wait_for(prolific: Prolific, operation: str) -> None:
    for _ in range(1500):
        if operation in prolific.calls:
            return
        time.sleep(0.02)
    raise AssertionError(operation)
