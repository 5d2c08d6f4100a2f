"""The salt is in the key file, not in the database."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core.config import open_instance
from annotation_app.core.key_file import KEY_FILE
from annotation_app.serving import server as serving
from corpus_tools.cli.console import run
from g3.errors import FormatError
from tests.annotation_app.browser import installation_of


def holding(folder: Path, secret: bytes) -> list[str]:
    """Names of the files in a folder that hold a secret in some form."""
    forms = re.compile(b"|".join(map(re.escape, (secret, secret.hex().encode()))))
    files = [file for file in folder.rglob("*") if file.is_file()]
    return sorted(file.name for file in files if forms.search(file.read_bytes()))


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_another_machine_needs_the_key_file(app: Flask, tmp_path: Path) -> None:
    config = installation_of(app).config
    serving.prepare(config)
    other = open_instance(tmp_path / "other", str(config.database))
    with pytest.raises(
        FormatError, match=r"isn't the one.*copy the file secret-key of the machine"
    ):
        serving.prepare(other)
    command = ["annotate", "export", str(tmp_path / "out"), "--database", str(config.database)]
    assert run([*command, "--instance", str(other.instance)]) == 0  # needs no salt
    shutil.copy(config.instance / KEY_FILE, other.instance / KEY_FILE)
    serving.prepare(open_instance(other.instance, str(config.database)))


def test_a_new_installation_never_has_it_in_the_database(tmp_path: Path) -> None:
    config = open_instance(tmp_path / "new")
    assert config.salt is not None
    assert config.salt.hex() not in repr(config)
    serving.prepare(config)
    assert holding(config.instance, config.salt) == [KEY_FILE]
    key, salt = (config.instance / KEY_FILE).read_text().split()
    assert (key.encode(), bytes.fromhex(salt)) == (config.secret_key, config.salt)


@pytest.mark.parametrize(
    "content", ["", "short", "a" * 64, f"{'a' * 64}\nnot hex", f"{'a' * 64}\nab"]
)
def test_a_damaged_key_file_is_named(tmp_path: Path, content: str) -> None:
    (tmp_path / KEY_FILE).write_text(content)
    with pytest.raises(FormatError, match=f"{KEY_FILE}: the key file can't be used"):
        open_instance(tmp_path)
