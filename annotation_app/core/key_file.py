"""The key file of an instance: what signs cookies and links, and the salt that hides people's ids.

Two lines in hexadecimal digits, the key and the salt.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
from dataclasses import dataclass
from pathlib import Path

from g3.errors import FormatError
from g3.storage import regular_file
from g3.storage.atomic_file import flush_folder, write_bytes

KEY_FILE = "secret-key"
KEY_BYTES = 32
SALT_BYTES = 32


@dataclass(frozen=True, slots=True)
class Keys:
    """Contents of a key file. The printed form leaves them out."""

    secret: bytes
    """Key that signs cookies and links."""
    salt: bytes
    """Salt of the hashes of people's ids."""

    def __repr__(self) -> str:
        return "Keys(...)"


def new_keys() -> Keys:
    """Return new random keys."""
    return Keys(secrets.token_hex(KEY_BYTES).encode(), secrets.token_bytes(SALT_BYTES))


def read_keys(file: Path) -> Keys:
    """Return the contents of a key file; a FormatError if it isn't one, or a part of one."""
    try:
        return keys_from(regular_file.read_bytes(file))
    except (OSError, ValueError) as error:
        raise FormatError(
            f"the key file can't be used: {getattr(error, 'strerror', None) or error}",
            where=str(file),
            fix="put it back from a copy of your own or from a backup",
        ) from error


def keys_from(content: bytes) -> Keys:
    """Parse keys in the form of :func:`written`; a ValueError if there are none."""
    lines = content.split()
    if len(lines) != 2:
        raise ValueError("it doesn't have a key and a salt")
    keys = Keys(lines[0], bytes.fromhex(lines[1].decode("ascii", "replace")))
    if len(keys.secret) < KEY_BYTES or len(keys.salt) < SALT_BYTES:
        raise ValueError("the key or the salt is too short")
    return keys


def written(keys: Keys) -> bytes:
    """Return the text of a key file."""
    return keys.secret + b"\n" + keys.salt.hex().encode() + b"\n"


def write_keys(file: Path, keys: Keys) -> None:
    """Replace the key file: all of it or nothing."""
    write_bytes(file, written(keys), private=True)


def make_keys(file: Path) -> None:
    """Write a key file with new keys, unless there is one.

    If several processes do so at once, one wins, and none ever sees a part of the file.
    """
    if file.exists():
        return
    mine = file.with_name(f".{file.name}.new-{secrets.token_hex(4)}")
    write_keys(mine, new_keys())
    try:
        os.link(mine, file)  # unlike renaming, this fails if there is one
        flush_folder(file.parent)
    except FileExistsError:
        pass
    except OSError:  # not all file systems have links
        mine.replace(file)
    finally:
        mine.unlink(missing_ok=True)


def check_value(salt: bytes) -> bytes:
    """Return the database's check value of its key file, which doesn't reveal the salt."""
    return hmac.new(salt, b"salt check", hashlib.sha256).digest()
