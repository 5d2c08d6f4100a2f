"""Ids of people and items."""

from __future__ import annotations

import secrets


def new_id() -> str:
    """Return an id that can't be guessed."""
    return secrets.token_hex(12)
