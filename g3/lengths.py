"""Limits on the length of texts, checked before work that grows faster than a text."""

from __future__ import annotations

from g3.errors import CorpusError, FormatError

MAX_CHARACTERS = 4_000
"""Characters of a command; 400 words, which are what is parsed of it, have some 2500."""
MAX_NOTATION = 100_000
"""Characters of clauses in brackets."""


def too_long(text: str, limit: int = MAX_CHARACTERS) -> str:
    """Describe a text that is longer than a limit; empty if it isn't."""
    if len(text) <= limit:
        return ""
    return f"the text has {len(text)} characters, the limit is {limit}"


def check_length(
    text: str,
    limit: int = MAX_CHARACTERS,
    *,
    where: str = "",
    error: type[CorpusError] = FormatError,
) -> None:
    """Refuse a text that is longer than a limit.

    Raises
    ------
    CorpusError
        An `error` that names the limit.
    """
    if problem := too_long(text, limit):
        raise error(problem, where=where, fix="shorten it, or give it in parts")
