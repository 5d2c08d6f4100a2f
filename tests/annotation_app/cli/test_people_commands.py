"""``ct annotate people``, ``check`` and ``audit`` as somebody on the machine uses them."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from flask import Flask

from annotation_app.store.database import reading, transaction
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.readiness import NOBODY, obstacles, study_obstacles
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.tasks.task_registry import task_names
from corpus_tools.cli.console import run
from tests.annotation_app.browser import Browser, engine_of, installation_of
from tests.annotation_app.pages.films import film
from tests.annotation_app.signing_in import PASSWORD, Member, link_in, signed_in


@pytest.fixture
def people(app: Flask, capsys: pytest.CaptureFixture[str]) -> People:
    return People(str(installation_of(app).config.instance), capsys)


class People:
    """The command of an instance."""

    def __init__(self, instance: str, capsys: pytest.CaptureFixture[str]) -> None:
        self.instance, self.capsys = instance, capsys

    def __call__(self, *arguments: str, group: str = "people") -> tuple[int, str]:
        """The exit status, and all that was told."""
        self.capsys.readouterr()
        options = [*arguments, "--instance", self.instance]
        status = run(["annotate", *((group,) if group else ()), *options])
        told = self.capsys.readouterr()
        return status, told.out + told.err


def test_three_people_get_logins(app: Flask, people: People) -> None:
    """What docs/annotation.md says, done."""
    lab = "https://lab.example.org"
    for login, role in (("ann", "annotator"), ("bea", "adjudicator"), ("cy", "admin")):
        status, told = people("invite", "--role", role, "--url", f"{lab}/")
        assert status == 0
        assert f"{lab}/setup/" in told
        member = Member(app, login)
        path = link_in(told)
        assert member.post(path, login=login, password=PASSWORD, again=PASSWORD).status_code == 303
        assert member.role == role
    status, told = people("list", "--json")
    assert [(p["login"], p["role"], p["state"]) for p in json.loads(told)["people"]] == [
        ("ann", "annotator", "active"),
        ("bea", "adjudicator", "active"),
        ("cy", "admin", "active"),
    ]
    assert people("list")[1].startswith("ann: annotator, active, last signed in 2")


def test_a_lost_password_of_the_only_admin(app: Flask, people: People) -> None:
    lost = signed_in(app, "ann", "admin")
    statuses = [lost.sign_in("what was it").status_code for _ in range(15)]
    assert statuses[-1] == 429
    status, told = people("reset", "Ann")
    assert status == 0
    assert lost.role is None
    assert lost.post(link_in(told), password=PASSWORD, again=PASSWORD).status_code == 303
    assert lost.role == "admin"
    assert lost.sign_in().status_code == 303


def test_changes_on_the_machine_hold_at_once(app: Flask, people: People) -> None:
    signed_in(app, "boss", "admin")
    member = signed_in(app, "ann", "annotator")
    assert people("role", "ann", "adjudicator") == (0, "ann: now adjudicator\n")
    assert member.role is None
    member.sign_in()
    assert member.role == "adjudicator"
    assert people("block", "ann") == (0, "ann: blocked\n")
    assert member.role is None
    blocked = member.sign_in()
    assert blocked.status_code == 403
    assert "has been blocked" in blocked.text
    assert json.loads(people("unblock", "ann", "--json")[1]) == {
        "login": "ann",
        "done": "unblocked",
    }
    assert member.sign_in().status_code == 303
    assert people("remove", "ann", "--yes") == (0, "ann: removed\n")
    assert member.role is None
    assert member.sign_in().status_code == 422


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("block", "boss"), "boss: this is the last admin (make another admin first"),
        (("role", "boss", "annotator"), "this is the last admin"),
        (("remove", "boss", "--yes"), "this is the last admin"),
        (("block", "nobody"), "nobody: nobody has this login (list all with"),
        (("reset", "nobody"), "nobody has this login"),
        (("add", "boss", "--role", "admin"), "this login is taken"),
        (("add", "boss", "--role", "worker"), "Invalid value for '--role'"),
    ],
)
def test_mistakes_are_named(
    app: Flask, people: People, arguments: tuple[str, ...], told: str
) -> None:
    boss = signed_in(app, "boss", "admin")
    status, found = people(*arguments)
    assert status == 2
    assert told in found
    assert boss.role == "admin"


def test_no_password_is_an_argument(
    app: Flask, people: People, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "password"
    file.write_text(f"{PASSWORD}\n")
    assert people("add", "ann", "--role", "admin", "--password-file", str(file))[0] == 0
    assert Member(app, "ann").sign_in().status_code == 303
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"too short\n")))
    status, told = people("add", "bob", "--role", "annotator", "--password-file", "-")
    assert status == 2
    assert "bob: a password has 10 to 200 characters" in told
    status, told = people("add", "bob", "--role", "annotator")
    bob = Member(app, "bob")
    assert bob.sign_in("").status_code == 422
    assert bob.post(link_in(told), password=PASSWORD, again=PASSWORD).status_code == 303
    assert bob.role == "annotator"


def test_a_new_installation_can_be_given_its_admin_before_it_is_served(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    people = People(str(tmp_path / "new"), capsys)
    assert people("list")[0] == 2
    assert not (tmp_path / "new").exists()
    assert people("invite", "--role", "admin")[0] == 0
    assert "an invitation: admin, by command line" in people("list")[1]


def test_the_audit_trail(app: Flask, people: People, tmp_path: Path) -> None:
    signed_in(app, "boss", "admin")
    people("invite", "--role", "annotator", "--days", "2")
    assert people("export", str(tmp_path / "a.csv"), "--format", "csv", group="")[0] == 0
    status, told = people("audit", group="")
    assert status == 0
    lines = [line.partition(" UTC ")[2] for line in told.splitlines()]
    assert lines == [
        "command line exported tests (format: csv)",
        "command line invited (role: annotator)",
        "boss signed in",
        "tests added boss (role: admin)",
    ]
    _, told = people("audit", "--person", "boss", "--action", "signed in", "--json", group="")
    (entry,) = json.loads(told)["entries"]
    assert (entry["actor"], entry["action"]) == ("boss", "signed in")
    assert people("audit", "--person", "eve", group="") == (0, "nothing like this was noted\n")


def test_everything_in_a_new_study_can_be_done_by_somebody(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    videos = film(tmp_path / "films")
    study, instance = tmp_path / "my-study.yaml", tmp_path / "instance"
    assert run(["annotate", "init", str(study)]) == 0
    check = People(str(instance), capsys)
    options = [str(study), "--videos", str(videos)]
    assert check("check", *options, group="") == (0, f"{study}: nothing would stop people\n")
    assert not instance.exists()
    study.write_text(study.read_text().replace("lease_minutes: 60}", "role: annotator}"))
    status, told = check("check", *options, group="")
    assert status == 2
    assert told.count("\n") == 3
    assert "study my-study: nobody may do the task segment, which asks for the role ann" in told
    assert "ct annotate people invite --role annotator" in told
    status, told = check("check", str(study), group="")
    assert status == 2
    assert "there are no videos (make them with" in told
    assert check("check", group="")[0] == 2


def test_what_the_installation_lacks(app: Flask, people: People, tmp_path: Path) -> None:
    config = StudyConfig(
        name="strict",
        title="Strict",
        tasks={
            "describe": TaskConfig(role="annotator", practice=False),
            "segment": TaskConfig(role="annotator", answers=2, practice=False),
            "check": TaskConfig(practice=False),
        },
    )
    with transaction(engine_of(app)) as session:
        put_study(session, config, rendered_videos(film(tmp_path / "films")))

    def told() -> str:
        status, found = people("check", group="")
        assert status == 2
        return found

    assert "there is no admin" in told()
    assert "study strict: nobody may do the task describe" in told()
    assert "study strict: nothing ever comes to the task check" in told()
    assert "nobody may decide where answers to segment differ" in told()
    boss = signed_in(app, "boss", "admin")  # who may do what annotators may
    assert "study strict: the task segment asks for 2 answers to each item" in told()
    signed_in(app, "ann", "annotator")
    assert [line for line in told().splitlines() if line.startswith("study strict")] == [
        "study strict: nothing ever comes to the task check (add the task ground, whose answers "
        "it is about)"
    ]
    boss.client.get("/")
    people("block", "ann")
    assert "asks for 2 answers" in told()


@pytest.mark.parametrize(
    ("adoption", "found"), [("all", 1), ("adjudicator", 1), ("majority", 0), (0.75, 0)]
)
def test_an_adjudicator_is_needed_where_no_rule_decides(adoption: Any, found: int) -> None:
    task = TaskConfig(answers=3, adoption=adoption, practice=False)
    config = StudyConfig(name="a", title="A", tasks={"segment": task})
    told = [obstacle.what for obstacle in study_obstacles(config, NOBODY, {"segment": 3})]
    assert len(told) == found
    assert all("nobody may decide" in what for what in told)


def test_what_is_imported_or_named_needs_no_task_before(app: Flask) -> None:
    config = StudyConfig(name="a", title="A", tasks={"segment": TaskConfig(practice=False)})
    assert list(study_obstacles(config, NOBODY, {"segment": 3})) == []
    assert len(list(study_obstacles(config, NOBODY, {}))) == 1
    everything = msgspec.structs.replace(
        config, tasks={task: TaskConfig(practice=False) for task in task_names()}
    )
    assert list(study_obstacles(everything, NOBODY, {})) == []
    Browser(app)
    with reading(engine_of(app)) as session:
        assert obstacles(session, of_installation=False) == []


def test_the_environments_admin_needs_a_password_that_can_be_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ANNOTATE_ADMIN_PASSWORD", "short")
    people = People(str(tmp_path / "new"), capsys)
    status, told = people("serve", group="")
    assert status == 2
    assert "ANNOTATE_ADMIN_PASSWORD and ANNOTATE_ADMIN_LOGIN: a password has 10 to 200" in told


def test_a_group_gets_items(app: Flask, people: People) -> None:
    for name in ("ann", "bob"):
        Member(app, name, "annotator")
    assert people("group", "lab", "ann", "nobody")[0] == 2
    assert people("group", "lab", "ann", "bob") == (0, "group lab: ann, bob\n")
    assert json.loads(people("list", "--json")[1])["groups"] == {"lab": ["ann", "bob"]}
    status, told = people("assign", "tests", "describe", "--group", "lab")
    assert (status, told.endswith("of describe assigned\n")) == (0, True)
    status, told = people("assign", "tests", "describe", "--group", "library")
    assert (status, "no group library" in told) == (2, True)
    assert people("assign", "tests", "describe", "--way", "anybody")[0] == 0
    assert people("group", "lab") == (0, "group lab: removed\n")
    assert json.loads(people("list", "--json")[1])["groups"] == {}
