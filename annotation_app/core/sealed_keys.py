"""An installation's keys in a backup, readable only with a passphrase.

The passphrase becomes a key by scrypt (128 MB and some tenths of a second for each guess), which
encrypts with AES-256-GCM. So a wrong passphrase and a changed content are both noticed.
"""

from __future__ import annotations

import base64
import secrets
from typing import TypeAlias

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.kdf.scrypt import Scrypt

from annotation_app.core.key_file import Keys, keys_from, written
from g3.errors import FormatError

Sealed: TypeAlias = dict[str, str]
"""Form of the keys in a backup; all of it is text."""

METHOD = "scrypt:131072:8:1 aes-256-gcm"
"""The only one that there is so far."""
SHORTEST_PASSPHRASE = 12
_PURPOSE = b"ct annotate backup: keys"


def seal(keys: Keys, passphrase: str) -> Sealed:
    """Encrypt keys; a FormatError if the passphrase is too short."""
    if len(passphrase) < SHORTEST_PASSPHRASE:
        raise FormatError(
            f"the passphrase is shorter than {SHORTEST_PASSPHRASE} characters",
            fix="use four random words or more",
        )
    salt, nonce = secrets.token_bytes(16), secrets.token_bytes(12)
    box = AESGCM(_key(passphrase, salt)).encrypt(nonce, written(keys), _PURPOSE)
    parts = {"salt": salt, "nonce": nonce, "box": box}
    return {
        "method": METHOD,
        **{name: base64.b64encode(part).decode() for name, part in parts.items()},
    }


def unseal(sealed: Sealed, passphrase: str, where: str) -> Keys:
    """Decrypt keys; a FormatError if the passphrase or the program that sealed them is another."""
    try:
        if sealed["method"] != METHOD:
            raise ValueError("method")
        salt, nonce, box = (base64.b64decode(sealed[name]) for name in ("salt", "nonce", "box"))
        return keys_from(AESGCM(_key(passphrase, salt)).decrypt(nonce, box, _PURPOSE))
    except InvalidTag:
        raise FormatError(
            "the keys can't be decrypted", where=where, fix="give the passphrase of this backup"
        ) from None
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(
            "the keys aren't encrypted as this program does",
            where=where,
            fix="use a newer version of the program, or give the key file with --keys",
        ) from error


def _key(passphrase: str, salt: bytes) -> bytes:
    return Scrypt(salt=salt, length=32, n=131_072, r=8, p=1).derive(passphrase.encode())
