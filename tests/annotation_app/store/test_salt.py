"""The salt is in the key file, not in the database, also of installations that had it there."""

from __future__ import annotations

import re
import shutil
import stat
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import Config, open_instance
from annotation_app.core.key_file import KEY_FILE, read_keys
from annotation_app.people.participants import find_or_add
from annotation_app.serving import server as serving
from annotation_app.serving.factory import create_app
from annotation_app.store import migrating
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Draft, Person, Secret
from corpus_tools.cli.console import run
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described, installation_of
from tests.annotation_app.old_installations import KEY, SALT, old_installation

BOTH = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


@pytest.fixture
def old(app: Flask, tmp_path: Path, other_database: str | None) -> Config:
    """An installation of the first program in which somebody has answered."""
    Browser(app).do("describe", described("Go there 😀"))
    return old_installation(installation_of(app).config, tmp_path / "old", other_database)


def kept(config: Config) -> dict[str, bytes]:
    with opened(config.database) as engine, reading(engine) as session:
        return {secret.name: secret.value for secret in session.scalars(select(Secret))}


def holding(folder: Path, secret: bytes) -> list[str]:
    """Names of the files in a folder that hold a secret in some form."""
    forms = re.compile(b"|".join(map(re.escape, (secret, secret.hex().encode()))))
    files = [file for file in folder.rglob("*") if file.is_file()]
    return sorted(file.name for file in files if forms.search(file.read_bytes()))


@BOTH
def test_an_old_installation_moves_it(old: Config, kind: str) -> None:
    assert (old.salt, kept(old)["salt"]) == (None, SALT)
    if kind == "sqlite":
        assert holding(old.instance, SALT) == ["annotation.sqlite"]
    serving.prepare(old)
    now = open_instance(old.instance, None if kind == "sqlite" else str(old.database))
    assert (now.secret_key, now.salt) == (KEY.encode(), SALT)
    assert set(kept(now)) == {"salt check"}
    assert holding(old.instance, SALT) == [KEY_FILE]
    assert stat.S_IMODE((old.instance / KEY_FILE).stat().st_mode) == 0o600
    with opened(now.database) as engine:
        app = create_app(now, engine)
        assert installation_of(app).salt == SALT
        with app.app_context(), transaction(engine) as session:
            known = find_or_add(session, "prolific", "5f1c0a")
            assert find_or_add(session, "prolific", "5f1c0a").id == known.id
            codes = [person.code for person in session.scalars(select(Person))]
            assert all(codes)
            assert len(set(codes)) == len(codes)
            assert session.scalars(select(Draft)).all() == []
    serving.prepare(now)
    assert open_instance(old.instance).salt == SALT


STEPS = ("before writing", "after writing", "before compacting", "after compacting")
KILLED = """
import os, sys
from pathlib import Path
from annotation_app.serving import server as serving
from annotation_app.store import compaction, salt
from annotation_app.core.config import open_instance

def killed(*_):
    os.kill(os.getpid(), 9)

def then_killed(function):
    return lambda *a, **k: (function(*a, **k), killed())

step = sys.argv[2]
if step == "before writing":
    salt.write_keys = killed
elif step == "after writing":
    salt.write_keys = then_killed(salt.write_keys)
elif step == "before compacting":
    salt.compact_if_asked = killed
else:
    compaction.compact = then_killed(compaction.compact)
serving.prepare(open_instance(Path(sys.argv[1])))
"""


@pytest.mark.parametrize("kind", ["sqlite"])
@pytest.mark.parametrize("step", STEPS)
def test_being_killed_on_the_way_loses_nothing(old: Config, step: str) -> None:
    command = [sys.executable, "-c", KILLED, str(old.instance), step]
    assert subprocess.run(command, check=False).returncode == -9
    halfway = {read_keys(old.instance / KEY_FILE).salt, kept(old).get("salt")}
    assert SALT in halfway
    assert halfway <= {SALT, None}
    serving.prepare(open_instance(old.instance))
    assert open_instance(old.instance).salt == SALT
    assert set(kept(old)) == {"salt check"}
    assert holding(old.instance, SALT) == [KEY_FILE]


@pytest.mark.slow
@BOTH
def test_several_processes_move_it_once(old: Config) -> None:
    context = get_context("forkserver")
    context.set_forkserver_preload([serving.__name__, migrating.__name__])
    with ProcessPoolExecutor(4, mp_context=context) as pool:
        for started in [pool.submit(serving.prepare, old) for _ in range(4)]:
            started.result()
    assert read_keys(old.instance / KEY_FILE).salt == SALT
    assert set(kept(old)) == {"salt check"}


@pytest.mark.parametrize("kind", ["postgresql"])
def test_another_machine_needs_the_key_file(
    old: Config, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its old one has the same key and no salt; a new one has another salt."""
    second = tmp_path / "second"
    shutil.copytree(old.instance, second)
    serving.prepare(old)
    fix = "copy the file secret-key of the machine"
    with pytest.raises(FormatError, match=f"the key file has no salt.*{fix}"):
        serving.prepare(replace(old, instance=second))
    command = ["annotate", "export", str(tmp_path / "out"), "--database", str(old.database)]
    third = open_instance(tmp_path / "third", str(old.database))
    with pytest.raises(FormatError, match=f"isn't the one.*{fix}"):
        serving.prepare(third)
    assert run([*command, "--instance", str(third.instance)]) == 0  # needs no salt
    shutil.copy(old.instance / KEY_FILE, second / KEY_FILE)
    serving.prepare(open_instance(second, str(old.database)))


@pytest.mark.parametrize("kind", ["sqlite"])
def test_an_old_database_with_another_installations_keys(old: Config, tmp_path: Path) -> None:
    other = open_instance(tmp_path / "other")
    with pytest.raises(FormatError, match="another salt than the database"):
        serving.prepare(replace(other, database=old.database))
    assert read_keys(other.instance / KEY_FILE).salt == other.salt
    assert kept(old)["salt"] == SALT


def test_a_new_installation_never_has_it_in_the_database(tmp_path: Path) -> None:
    config = open_instance(tmp_path / "new")
    assert config.salt is not None
    assert config.salt.hex() not in repr(config)
    serving.prepare(config)
    assert holding(config.instance, config.salt) == [KEY_FILE]
    key, salt = (config.instance / KEY_FILE).read_text().split()
    assert (key.encode(), bytes.fromhex(salt)) == (config.secret_key, config.salt)


@pytest.mark.parametrize("content", ["", "short", "a" * 64 + "\nnot hex", "a" * 64 + "\n" + "ab"])
def test_a_damaged_key_file_is_named(tmp_path: Path, content: str) -> None:
    (tmp_path / KEY_FILE).write_text(content)
    with pytest.raises(FormatError, match=f"{KEY_FILE}: the key file can't be used"):
        open_instance(tmp_path)
