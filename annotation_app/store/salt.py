"""The salt of people's ids: in the key file only, never beside the hashes that it makes.

Older programs kept it in the database. It is moved in steps that may be cut off anywhere. It is
written to the key file first, then deleted from the database. Last, the database is compacted, so
that no free page holds it.
"""

from __future__ import annotations

import hmac
from dataclasses import replace

from sqlalchemy import Engine, delete, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.key_file import KEY_FILE, Keys, check_value, read_keys, write_keys
from annotation_app.store.compaction import ask, compact_if_asked
from annotation_app.store.database import lock_set_up, reading, transaction
from annotation_app.store.models import Secret
from annotation_app.store.schema import check_current
from g3.errors import FormatError

SALT = "salt"
"""Name under which older programs kept the salt in the database."""
CHECK = "salt check"
"""Shows whether a key file has the salt that people's ids here were hashed with."""


def installation_salt(engine: Engine, config: Config) -> bytes:
    """Return the salt of hashes of people's ids, which is moved to the key file if necessary.

    A FormatError says that the database hasn't been set up, or that the key file is another's.
    """
    check_current(engine)
    with reading(engine) as session:
        kept = _kept(session)
    if set(kept) == {CHECK} and config.salt is not None:
        return _checked(config, config.salt, kept[CHECK])
    return _settle(engine, config)


def keep_check(session: Session, salt: bytes) -> None:
    """Keep by what a salt is known, in place of any other."""
    session.merge(Secret(name=CHECK, value=check_value(salt)))


def _settle(engine: Engine, config: Config) -> bytes:
    """Move the salt out of the database, or note by what it is known."""
    with transaction(engine) as session:
        lock_set_up(session.connection())
        kept = _kept(session)
        # Another process may have moved it since the configuration was read.
        keys = read_keys(config.instance / KEY_FILE)
        salt = _move(session, config, keys, kept[SALT]) if SALT in kept else keys.salt
        if salt is None:
            raise _unfit(
                config,
                "the key file has no salt, and the database no longer has it",
                "has brought the database up to date",
            )
        if CHECK in kept:
            _checked(config, salt, kept[CHECK])
        else:
            keep_check(session, salt)
    compact_if_asked(engine)
    return salt


def _move(session: Session, config: Config, keys: Keys, salt: bytes) -> bytes:
    file = config.instance / KEY_FILE
    if keys.salt is None:
        try:
            write_keys(file, replace(keys, salt=salt))
        except OSError as error:
            raise FormatError(
                f"the salt can't be moved from the database to the key file: {error.strerror}",
                where=str(file),
                fix="let this user write to the file and its folder, at this start",
            ) from error
    elif not hmac.compare_digest(keys.salt, salt):
        raise FormatError(
            "the key file has another salt than the database",
            where=str(file),
            fix="name the instance that the database belongs to; if its key file is lost, delete "
            "the second line of this one, for the database still has the salt",
        )
    session.execute(delete(Secret).where(Secret.name == SALT))
    ask(session)
    return salt


def _kept(session: Session) -> dict[str, bytes]:
    wanted = select(Secret).where(Secret.name.in_((SALT, CHECK)))
    return {secret.name: secret.value for secret in session.scalars(wanted)}


def _checked(config: Config, salt: bytes, check: bytes) -> bytes:
    if not hmac.compare_digest(check_value(salt), check):
        what = "the key file isn't the one that this database was made with"
        raise _unfit(config, what, "has served it, or of its backup")
    return salt


def _unfit(config: Config, what: str, machine: str) -> FormatError:
    file = config.instance / KEY_FILE
    fix = f"copy the file {KEY_FILE} of the machine that {machine}"
    return FormatError(what, where=str(file), fix=fix)
