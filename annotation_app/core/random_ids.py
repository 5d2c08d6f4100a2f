"""Ids of people and items."""

from __future__ import annotations

import re
import secrets


def new_id() -> str:
    """Return an id that can't be guessed."""
    return secrets.token_hex(12)


ALPHABET = "23456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Characters of codes: no 0 or O, no 1, I or L, and no U, so that no code is a rude word."""
GROUPS, LENGTH = 3, 4
_CODE = re.compile(rf"[{ALPHABET}]{{{GROUPS * LENGTH}}}")


def new_code() -> str:
    """Return a code that can't be guessed, such as ``7KQM-2XWD-HN5R``: one of 5 × 10¹⁷."""
    letters = "".join(secrets.choice(ALPHABET) for _ in range(GROUPS * LENGTH))
    return _grouped(letters)


def read_code(given: str) -> str | None:
    """Return a typed code as it is kept; None if it can't be one."""
    letters = re.sub(r"[\s-]", "", given).upper()
    return _grouped(letters) if _CODE.fullmatch(letters) else None


def _grouped(letters: str) -> str:
    return "-".join(letters[i : i + LENGTH] for i in range(0, len(letters), LENGTH))
