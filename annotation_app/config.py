"""What an installation of the app needs to know, and its folder with the secret key."""

from __future__ import annotations

import os
import secrets
from dataclasses import dataclass
from pathlib import Path

from g3.errors import FormatError

KEY_FILE = "secret-key"
DATABASE_FILE = "annotation.sqlite"
KEY_BYTES = 32
MEGABYTE = 2**20


@dataclass(frozen=True, slots=True)
class Config:
    """How the app is set up.

    Parameters
    ----------
    instance
        Folder with the secret key, the database if it is SQLite's, and what is rendered.
    secret_key
        What cookies and invitations are signed with. Not shown when this is printed.
    database
        A SQLite file or a URL.
    https
        Whether people reach the app by HTTPS only, so that cookies can be kept to it.
    proxies
        How many reverse proxies stand before it, whose headers are believed.
    frame_ancestors
        Sites that may show the app in a frame, such as a crowd platform.
    form_targets
        Other sites that its forms may be sent to.
    rate_limits
        Whether requests are limited.
    limits_storage
        Where limits are counted: a URL as the package ``limits`` takes it. By default each process
        counts its own.
    media_url
        Where copies of videos and pictures are, as ``ct annotate copy-media`` names them; empty if
        the app gives them out itself.
    open_trying
        Whether anybody may try commands, not only people with a login.
    model
        File of the model that follows commands which are tried; by default the one that
        comes along.
    idle_hours
        How long somebody with a login may do nothing before they must sign in again.
    max_body_bytes
        Largest request that is read.
    """

    instance: Path
    secret_key: bytes
    database: str | Path
    https: bool = False
    proxies: int = 0
    frame_ancestors: tuple[str, ...] = ()
    form_targets: tuple[str, ...] = ()
    rate_limits: bool = True
    limits_storage: str = "process://"
    media_url: str = ""
    open_trying: bool = False
    model: Path | None = None
    idle_hours: float = 12.0
    max_body_bytes: int = MEGABYTE

    def __repr__(self) -> str:
        return f"Config(instance={str(self.instance)!r})"


def open_instance(folder: Path, database: str | None = None) -> Config:
    """Read an installation's folder; it is made, with a new key, if there is none.

    Parameters
    ----------
    database
        URL of the database; by default it is a file in the folder.

    Raises
    ------
    FormatError
        If the key can't be one.
    """
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    key_file = folder / KEY_FILE
    try:
        descriptor = os.open(key_file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        pass
    else:
        with os.fdopen(descriptor, "wb") as file:
            file.write(secrets.token_hex(KEY_BYTES).encode())
            file.flush()
            os.fsync(file.fileno())
    key = key_file.read_bytes().strip()
    if len(key) < KEY_BYTES:
        raise FormatError(
            "the secret key is too short",
            where=str(key_file),
            fix="restore it from a backup; a new one signs everybody out",
        )
    return Config(folder.resolve(), key, database or folder.resolve() / DATABASE_FILE)
