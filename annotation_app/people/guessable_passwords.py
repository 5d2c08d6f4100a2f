"""Passwords that are guessed first: a word that many use, a row of keys, one thing again and again.

Guessable parts are taken out of a password. Something must remain.
"""

from __future__ import annotations

import re

FEWEST_CHARACTERS = 5
"""A password has so many different characters, and so many that aren't easy to guess."""
_RUN = 3
"""Least number of characters in a known order that count as one thing."""
_ROWS = (
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890",
    "qwertyuiop",
    "qwertzuiop",
    "azertyuiop",
    "asdfghjkl",
    "zxcvbnm",
    "yxcvbnm",
    "qazwsxedcrfvtgb",
    "1q2w3e4r5t6y7u8i9o0p",
    "1qaz2wsx3edc4rfv",
)
_WORDS = (  # noqa: SIM905 - a line for each would be fifty
    "password passwort passwd geheim secret hallo hello world welcome willkommen letmein login "
    "admin administrator root user guest gast master default changeme change temp test testing "
    "iloveyou love liebe dragon monkey football baseball fussball princess sunshine shadow "
    "superman batman summer sommer winter spring autumn herbst monday montag freedom whatever "
    "trustno access annotate annotation annotator adjudicator worker corpus study robot forklift "
    "schatz qwerty qwertz computer internet google"
).split()
_LOOKS_LIKE = str.maketrans("@$!|0134578", "asiloieastb")
"""Signs that stand for letters."""


def is_guessable(password: str, login: str) -> bool:
    """Check that a password is among those that are tried first.

    >>> is_guessable("aaaaaaaaaa", "maria"), is_guessable("Passw0rd2024", "maria")
    (True, True)
    >>> is_guessable("maria12345", "maria"), is_guessable("correct horse battery", "maria")
    (True, False)
    """
    text = password.casefold()
    if len(set(text)) < FEWEST_CHARACTERS:
        return True
    text = _once(re.sub(r"\s+", "", text))
    text = re.sub(r"(?:19|20)\d\d", "", text)
    name = re.sub(r"\s+", "", login.strip().casefold())
    for known in sorted({*_WORDS, name, name[::-1]}, key=len, reverse=True):
        if len(known) >= _RUN:
            text = text.replace(known, "")
            if known in (plain := text.translate(_LOOKS_LIKE)):
                start = plain.index(known)
                text = text[:start] + text[start + len(known) :]
    text = _without_runs(re.sub(r"(.)\1+", r"\1", text))
    return len(set(re.sub(r"\W", "", text))) < FEWEST_CHARACTERS


def _once(text: str) -> str:
    """Return a text with immediate repetitions written once."""
    for length in range(1, len(text) // 2 + 1):
        if all(text[i] == text[i % length] for i in range(length, len(text))):
            return text[:length]
    return text


def _without_runs(text: str) -> str:
    """Remove runs of keys, of letters in order and of digits in order, in either direction."""
    rows = [*_ROWS, *(row[::-1] for row in _ROWS)]
    kept, at = "", 0
    while at < len(text):
        longest = max(
            (
                n
                for n in range(_RUN, len(text) - at + 1)
                if any(text[at : at + n] in r for r in rows)
            ),
            default=1,
        )
        kept += text[at] if longest == 1 else ""
        at += longest
    return kept
