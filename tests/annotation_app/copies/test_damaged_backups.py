"""Backups that are damaged, or restored by a process that is killed."""

from __future__ import annotations

import gzip
import hashlib
import json
import random
import re
import signal
import stat
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from flask import Flask
from sqlalchemy import inspect

from annotation_app.copies import backups
from annotation_app.copies.backups import back_up, encoded_end
from annotation_app.copies.restoring import restore, verify
from annotation_app.core.config import Config, open_instance
from annotation_app.core.key_file import KEY_FILE, new_keys, write_keys
from annotation_app.store.database import opened
from corpus_tools.cli.console import run
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, described, installation_of
from tests.annotation_app.copies.killed_restore import restore_until
from tests.annotation_app.copies.test_backups import rows
from tests.full_disks import full_disk, left_in
from tests.processes import forked

PASSPHRASE = "correct horse battery"
FLIPS, CUTS = 120, 40


@pytest.fixture
def filled(app: Flask) -> Config:
    """An installation with answers and a draft."""
    person = Browser(app)
    person.do("describe", described("Go there 😀"))
    person.draft(person.take("describe")["item"], 1, {"text": "Go"})
    return installation_of(app).config


@pytest.fixture
def archive(filled: Config, tmp_path: Path) -> Path:
    made = tmp_path / "backup.jsonl.gz"
    back_up(filled, made, None)
    return made


def content_or_none(data: bytes) -> bytes | None:
    try:
        return gzip.decompress(data)
    except Exception:
        return None


def damaged(whole: bytes) -> Iterator[tuple[str, bytes]]:
    """Files as disks, networks and people damage them; none has the same content."""
    draws = random.Random(7)
    content = gzip.decompress(whole)
    yield "empty", b""
    yield "no gzip", content
    yield "zeros", bytes(len(whole))
    yield "twice", whole + whole
    for n in sorted(draws.sample(range(1, len(whole)), CUTS)):
        yield f"cut at {n}", whole[:n]
    for n in [*range(10), *(draws.randrange(len(whole)) for _ in range(FLIPS))]:
        bit = draws.randrange(8)
        flipped = bytearray(whole)
        flipped[n] ^= 1 << bit
        # The bits that fill the last byte of a compressed block say nothing.
        if content_or_none(bytes(flipped)) != content or n < 10:
            yield f"bit {bit} of byte {n} flipped", bytes(flipped)
    lines = content.splitlines(keepends=True)
    middle = len(lines) // 2
    edits: dict[str, list[bytes]] = {
        "without its end": lines[:-1],
        "half": lines[:middle],
        "half with the end": [*lines[:middle], lines[-1]],
        "without a row": [*lines[:middle], *lines[middle + 1 :]],
        "a row twice": [*lines[: middle + 1], *lines[middle:]],
        "rows in another order": [lines[0], *lines[-2:0:-1], lines[-1]],
        "two rows swapped": [*lines[:2], lines[3], lines[2], *lines[4:]],
        "without its head": lines[1:],
        "a row after the end": [*lines, lines[middle]],
        "two ends": [*lines, lines[-1]],
        "only a head": lines[:1],
        "blank lines": [line + b"\n" for line in lines],
        "an unknown table": [*lines[:2], b'["nothing",{}]\n', *lines[2:]],
        "no row": [*lines[:2], b"[1]\n", *lines[2:]],
        "deep": [*lines[:2], b"[" * 100_000 + b"\n", *lines[2:]],
        "no UTF-8": [*lines[:2], b'["person",{"\xff":1}]\n', *lines[2:]],
    }
    text = content.decode()
    swaps = {
        "wrong counts": ('"answer":1', '"answer":2'),
        "another digest": ('"sha256":"', '"sha256":"0'),
        "another word": ("Go there", "Go where"),
        "a newer form": ('"version":2', '"version":3'),
        "an older form": ('"version":2', '"version":1'),
        "a newer program": ('"schema":"', '"schema":"9'),
        "another program": ('{"version"', '{"a":1,"version"'),
        "another table": ('["person"', '["persons"'),
        "no number": ('"session_number":1', '"session_number":"1"'),
        "a column less": ('"session_number":1,', ""),
    }
    for name, (before, after) in swaps.items():
        assert before in text, name
        edits[name] = [text.replace(before, after).encode()]
    for name, edited in edits.items():
        yield name, gzip.compress(b"".join(edited), mtime=0)


def test_no_damaged_backup_is_accepted(
    archive: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """By verify or by restore: both say what is wrong with which file, in one line."""
    keys = str(open_instance(tmp_path / "instance").instance / KEY_FILE)
    tried = 0
    where = tmp_path / "restored"
    for name, data in damaged(archive.read_bytes()):
        bad = tmp_path / "bad.gz"
        bad.write_bytes(data)
        for command in (
            ["verify", str(bad)],
            ["restore", str(bad), "--instance", str(where), "--keys", keys],
        ):
            capfd.readouterr()
            assert run(["annotate", *command]) == 2, (name, capfd.readouterr())
            said = capfd.readouterr()
            assert said.out == ""
            assert re.fullmatch(rf"ct: error: {bad}(, line \d+)?: .+\n", said.err), (name, said.err)
            assert not where.exists(), name
        tried += 1
    assert tried >= 180
    assert run(["annotate", "verify", str(archive)]) == 0
    assert run(["annotate", "restore", str(archive), "--instance", str(where), "--keys", keys]) == 0


def test_who_compresses_it_anew_changes_nothing(archive: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.gz"
    content = gzip.decompress(archive.read_bytes())
    done = subprocess.run(["gzip", "-9", "-c"], input=content, capture_output=True, check=True)
    again.write_bytes(done.stdout)
    assert verify(again) == verify(archive)


def test_a_backup_is_its_owners_from_its_first_byte_on(
    filled: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modes: list[int] = []
    real = backups.encoded_row

    def looked_at(*row: Any) -> bytes:
        modes.extend(stat.S_IMODE(file.stat().st_mode) for file in tmp_path.glob(".backup.gz.*"))
        return real(*row)

    monkeypatch.setattr(backups, "encoded_row", looked_at)
    back_up(filled, tmp_path / "backup.gz", None)
    assert set(modes) == {0o600}

    def full(*_: Any) -> bytes:
        raise OSError(28, "No space left on device")

    before = (tmp_path / "backup.gz").read_bytes()
    monkeypatch.setattr(backups, "encoded_end", full)
    with pytest.raises(OSError, match="No space left"):
        back_up(filled, tmp_path / "backup.gz", None)
    assert (tmp_path / "backup.gz").read_bytes() == before
    assert not list(tmp_path.glob(".backup.gz.*"))


def test_keys_are_in_a_backup_encrypted_or_not_at_all(filled: Config, tmp_path: Path) -> None:
    salt = filled.salt
    assert salt is not None
    without, sealed = tmp_path / "without.gz", tmp_path / "sealed.gz"
    back_up(filled, without, None)
    back_up(filled, sealed, PASSPHRASE)
    for archive in (without, sealed):
        content = gzip.decompress(archive.read_bytes())
        for secret in (filled.secret_key, salt, salt.hex().encode()):
            assert secret not in content
        assert PASSPHRASE.encode() not in content
    own, other = filled.instance / KEY_FILE, tmp_path / "other"
    write_keys(other, new_keys())
    refused: list[tuple[Path, dict[str, Any], str]] = [
        (without, {}, "without its keys.*--keys"),
        (without, {"passphrase": PASSPHRASE}, "without its keys.*--keys"),
        (without, {"keys": other}, "aren't the keys"),
        (sealed, {}, "encrypted.*--passphrase-file.*--keys"),
        (sealed, {"passphrase": "wrong horse battery"}, "can't be decrypted"),
        (sealed, {"keys": other}, "aren't the keys"),
    ]
    for archive, given, match in refused:
        with pytest.raises(FormatError, match=match):
            restore(archive, tmp_path / "no", **given)
        assert not (tmp_path / "no").exists()
    with pytest.raises(FormatError, match="shorter than 12"):
        back_up(filled, tmp_path / "short.gz", "too short")
    assert not (tmp_path / "short.gz").exists()
    accepted: list[tuple[Path, dict[str, Any]]] = [
        (without, {"keys": own}),
        (sealed, {"keys": own}),
        (sealed, {"passphrase": PASSPHRASE}),
    ]
    for number, (archive, given) in enumerate(accepted):
        restore(archive, tmp_path / f"yes{number}", **given)
        made = open_instance(tmp_path / f"yes{number}")
        assert (made.secret_key, made.salt) == (filled.secret_key, salt)
        assert rows(made) == rows(filled)


def test_a_backup_wants_a_choice_about_the_keys(
    filled: Config, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    archive, words = str(tmp_path / "backup.gz"), tmp_path / "words"
    words.write_text(f"{PASSPHRASE}\n")
    command = ["annotate", "backup", archive, "--instance", str(filled.instance)]
    assert run(command) == 2
    said = capsys.readouterr().err
    assert "--passphrase-file" in said
    assert "--without-keys" in said
    assert run([*command, "--without-keys", "--passphrase-file", str(words)]) == 2
    assert not Path(archive).exists()
    assert run([*command, "--passphrase-file", str(words)]) == 0
    where = ["--instance", str(tmp_path / "restored")]
    assert run(["annotate", "restore", archive, *where]) == 2
    assert "--passphrase-file" in capsys.readouterr().err
    assert run(["annotate", "restore", archive, *where, "--passphrase-file", str(words)]) == 0
    words.write_text("\n")
    assert run([*command, "--passphrase-file", str(words)]) == 2


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_rows_that_the_database_refuses_leave_nothing_behind(
    filled: Config, tmp_path: Path, other_database: str | None
) -> None:
    """A backup that somebody has made by hand lacks rows that others refer to."""
    archive = tmp_path / "by-hand.gz"
    back_up(filled, archive, None)
    *lines, end = gzip.decompress(archive.read_bytes()).splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(b'["event"')]
    counts = {**json.loads(end)["counts"], "event": 0}
    digest = hashlib.sha256(b"".join(kept)).hexdigest()
    content = b"".join((*kept, encoded_end(counts, digest)))
    archive.write_bytes(gzip.compress(content, mtime=0))
    keys = filled.instance / KEY_FILE
    with pytest.raises(FormatError):
        restore(archive, tmp_path / "new", other_database, keys=keys)
    assert not (tmp_path / "new").exists()
    if other_database:
        with opened(other_database) as engine:
            assert inspect(engine).get_table_names() == []
    back_up(filled, archive, None)
    restore(archive, tmp_path / "new", other_database, keys=keys)


@pytest.mark.parametrize(
    ("kind", "step", "is_there"),
    [
        ("sqlite", "keys", False),
        ("sqlite", "rows", False),
        ("sqlite", "migrated", False),
        ("sqlite", "end", True),
        ("postgresql", "rows", True),
    ],
)
def test_a_killed_restore_does_not_block_the_next(
    archive: Path,
    filled: Config,
    tmp_path: Path,
    other_database: str | None,
    step: str,
    is_there: bool,
) -> None:
    instance, keys = tmp_path / "new", filled.instance / KEY_FILE
    if is_there:  # with something of somebody's
        instance.mkdir()
        (instance / "mine").write_text("mine")
    restoring = forked(restore_until, step, archive, instance, keys, other_database)
    restoring.join(120)
    assert restoring.exitcode == -signal.SIGKILL
    with pytest.raises(FormatError, match="not to its end"):
        open_instance(instance)
    restore(archive, instance, other_database, keys=keys)
    assert rows(open_instance(instance, other_database)) == rows(filled)
    expected = {"mine"} if is_there else set()
    assert {file.name for file in instance.iterdir()} - expected <= {
        KEY_FILE,
        "annotation.sqlite",
        "annotation.sqlite-wal",
        "annotation.sqlite-shm",
    }


def test_a_folder_that_cannot_be_made_is_named(archive: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="instance"):
        restore(archive, tmp_path / "file" / "new", keys=tmp_path / "instance" / KEY_FILE)


def test_a_restore_on_a_full_disk_leaves_nothing(filled: Config, tmp_path: Path) -> None:
    archive = tmp_path / "backup.jsonl.gz"
    back_up(filled, archive, PASSPHRASE)
    with full_disk(tmp_path / "disk", free_bytes=16384) as disk:
        with pytest.raises((FormatError, OSError)) as found:
            restore(archive, disk / "new", passphrase=PASSPHRASE)
        assert str(disk / "new") in str(found.value)
        assert "take another backup" not in str(found.value)
        assert [name for name in left_in(disk) if "sqlite" in name or "key" in name] == []
