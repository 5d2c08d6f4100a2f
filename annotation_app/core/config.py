"""What an installation of the app needs to know, and its folder with the secret key."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from annotation_app.core.key_file import KEY_FILE, make_keys, read_keys
from g3.errors import FormatError

DATABASE_FILE = "annotation.sqlite"
UNFINISHED = "unfinished-restore"
"""A file in the folder while a backup is restored into it (`annotation_app.copies.restoring`)."""
MEGABYTE = 2**20


@dataclass(frozen=True, slots=True)
class Config:
    """How the app is set up."""

    instance: Path
    """Folder with the secret key, the database if it is SQLite's, and what is rendered."""
    secret_key: bytes
    """What cookies and invitations are signed with. Not shown when this is printed."""
    database: str | Path
    """A SQLite file or a URL."""
    salt: bytes | None = None
    """What people's ids are hashed with, from the key file; None as long as an older program's
    database has it. :func:`annotation_app.store.salt.installation_salt` gives it in any case. Not
    shown either."""
    https: bool = False
    """Whether people reach the app by HTTPS only, so that cookies can be kept to it."""
    proxies: int = 0
    """How many reverse proxies stand before it, whose headers are believed."""
    frame_ancestors: tuple[str, ...] = ()
    """Sites that may show the app in a frame, such as a crowd platform."""
    form_targets: tuple[str, ...] = ()
    """Other sites that its forms may be sent to."""
    rate_limits: bool = True
    """Whether requests are limited."""
    limits_storage: str = "process://"
    """Where limits are counted: a URL as the package ``limits`` takes it. By default each process
    counts its own."""
    media_url: str = ""
    """Where copies of videos and pictures are, as ``ct annotate copy-media`` names them; empty if
    the app gives them out itself."""
    open_trying: bool = False
    """Whether anybody may try commands, not only people with a login."""
    model: Path | None = None
    """File of the model that follows commands which are tried, and suggests groundings. By default
    commands are tried with one trained on the bundled corpus, and nothing is suggested."""
    idle_hours: float = 12.0
    """How long somebody with a login may do nothing before they must sign in again."""
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
        raise FormatError(
            f"the instance can't be made: {error.strerror}",
            where=str(folder),
            fix="name a folder that you may write to with --instance",
        ) from error
    keys = read_keys(key_file)
    where = folder.resolve()
    return Config(where, keys.secret, database or where / DATABASE_FILE, keys.salt)
