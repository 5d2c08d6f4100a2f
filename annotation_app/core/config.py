"""Configuration of an installation of the app, and its folder with the secret key."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from annotation_app.core.key_file import KEY_FILE, make_keys, new_keys, read_keys
from g3.errors import FormatError
from g3.storage.system_errors import named_error

DATABASE_FILE = "annotation.sqlite"
UNFINISHED = "unfinished-restore"
"""A file in the folder while a backup is restored into it (`annotation_app.copies.restoring`)."""
MEGABYTE = 2**20


@dataclass(frozen=True, slots=True)
class Config:
    """Settings of the app."""

    instance: Path
    """Folder with the secret key, the database if it is SQLite's, and what is rendered."""
    secret_key: bytes
    """Key that signs cookies and invitations. Left out of the printed form."""
    database: str | Path
    """A SQLite file or a URL."""
    salt: bytes | None = None
    """Salt of the hashes of people's ids, from the key file; None without one. Left out of the
    printed form."""
    https: bool = False
    """True if people reach the app by HTTPS only, so that cookies can be kept to it."""
    proxies: int = 0
    """Number of reverse proxies in front of the app whose headers are trusted."""
    url: str = ""
    """Public address of the app, such as ``https://lab.example.org``, with which links to send to
    others begin. If it is empty, they begin as the request did in which they are made."""
    frame_ancestors: tuple[str, ...] = ()
    """Sites that may show the app in a frame, such as a crowd platform."""
    form_targets: tuple[str, ...] = ()
    """Other sites that its forms may be sent to."""
    rate_limits: bool = True
    """True if requests are limited."""
    limits_storage: str = "process://"
    """Storage of the rate limits: a URL as the package ``limits`` takes it. By default each process
    counts its own."""
    media_url: str = ""
    """Address of the copies of videos and pictures, as ``ct annotate copy-media`` names them; empty
    if the app serves them itself."""
    open_trying: bool = False
    """True if anybody may try commands, not only people with a login."""
    model: Path | None = None
    """File of the model that follows commands which are tried, and suggests groundings. By default
    commands are tried with one trained on the bundled corpus, and nothing is suggested."""
    idle_hours: float = 12.0
    """Longest idle time of somebody with a login before they must sign in again, in hours."""
    max_body_bytes: int = MEGABYTE
    """Largest request that is read."""
    studies: Path | None = None
    """Folder of the study files and videos that admins work with in the browser; by default
    ``studies`` in the instance's folder."""

    def __repr__(self) -> str:
        return f"Config(instance={str(self.instance)!r})"

    @property
    def studies_folder(self) -> Path:
        """The folder of studies that are made in the browser; it may not be there yet."""
        return (self.studies or self.instance / "studies").resolve()


def open_instance(folder: Path, database: str | None = None) -> Config:
    """Read an installation's folder; it is made, with a new key, if there is none.

    Without the URL of a database it is a file in the folder. A FormatError says that the key file
    isn't one, that the folder can't be made, or that a backup was restored into it and not to its
    end.
    """
    key_file = folder / KEY_FILE
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        if (folder / UNFINISHED).exists():
            raise FormatError(
                "a backup was restored here, but not to its end",
                where=str(folder),
                fix="run the same `ct annotate restore` again, or delete the folder",
            )
        make_keys(key_file)
    except OSError as error:
        named = named_error(error)
        raise FormatError(
            f"the instance can't be made: {error.strerror}",
            where=str(folder),
            fix=named.fix if named else "name another folder with --instance",
        ) from error
    return _read(folder, database)


def existing_instance(folder: Path, database: str | None = None) -> Config:
    """Read an installation that is there, for what changes or reads it; nothing is made.

    If only the database is named, and the folder has no key, the key of this configuration is
    a random one.

    Raises
    ------
    FormatError
        If there is no key file and no URL of a database, or no file of an SQLite database.
    """
    if not is_there(folder, database):
        raise no_installation(folder)
    if database is not None and not (folder / KEY_FILE).exists():
        return Config(folder.resolve(), new_keys().secret, database)
    return _read(folder, database)


def is_there(folder: Path, database: str | None = None) -> bool:
    """Check that there is an installation: its database, as far as that is a file."""
    if database is None or "://" not in database:
        return Path(database or folder / DATABASE_FILE).is_file()
    from sqlalchemy.engine import make_url  # noqa: PLC0415 - slow to load
    from sqlalchemy.exc import ArgumentError  # noqa: PLC0415 - as above

    try:
        url = make_url(database)
    except ArgumentError:  # who opens it says what is wrong
        return True
    return url.get_backend_name() != "sqlite" or Path(url.database or "").is_file()


def no_installation(folder: Path) -> FormatError:
    """Return the error where an installation is needed and there is none."""
    fix = "name it with --instance, or start one with `ct annotate`"
    return FormatError("there is no installation here", where=str(folder), fix=fix)


def _read(folder: Path, database: str | None) -> Config:
    keys = read_keys(folder / KEY_FILE)
    where = folder.resolve()
    return Config(where, keys.secret, database or where / DATABASE_FILE, keys.salt)
