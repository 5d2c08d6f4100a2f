"""The salt of people's ids: in the key file only, never beside the hashes that it makes."""

from __future__ import annotations

import hmac

from sqlalchemy import Engine
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.key_file import KEY_FILE, check_value
from annotation_app.store.database import lock_set_up, reading, transaction
from annotation_app.store.models import Secret
from annotation_app.store.schema import check_current
from g3.errors import FormatError

CHECK = "salt check"
"""Shows whether a key file has the salt that people's ids here were hashed with."""


def installation_salt(engine: Engine, config: Config) -> bytes:
    """Return the salt of hashes of people's ids, and note by what it is known, the first time.

    A FormatError says that the database hasn't been set up, or that the key file is another's.
    """
    check_current(engine)
    if config.salt is None:
        raise _unfit(config, "the instance has no key file")
    with reading(engine) as session:
        known = session.get(Secret, CHECK)
    if known is None:
        with transaction(engine) as session:
            lock_set_up(session.connection())
            known = session.get(Secret, CHECK) or keep_check(session, config.salt)
    if not hmac.compare_digest(check_value(config.salt), known.value):
        raise _unfit(config, "the key file isn't the one that this database was made with")
    return config.salt


def keep_check(session: Session, salt: bytes) -> Secret:
    """Keep by what a salt is known, in place of any other."""
    return session.merge(Secret(name=CHECK, value=check_value(salt)))


def _unfit(config: Config, what: str) -> FormatError:
    file = config.instance / KEY_FILE
    fix = f"copy the file {KEY_FILE} of the machine that has served it, or of its backup"
    return FormatError(what, where=str(file), fix=fix)
