"""A language for tests: Arabic letters in the place of English ones, written from right to left."""

from __future__ import annotations

import re
import string
from pathlib import Path

from babel.messages.pofile import read_po, write_po

from annotation_app.core.languages import FILE, FOLDER

ALPHABET = str.maketrans(
    string.ascii_lowercase + string.ascii_uppercase, 2 * "ابتثجحخدذرزسشصضطظعغفقكلمنه"
)
KEPT = re.compile(r"(%\(\w+\)s|\{\w+\})")


def pseudo(text: str) -> str:
    """A text in the pseudo-language."""
    parts = KEPT.split(text)
    return "".join(p if KEPT.fullmatch(p) else p.translate(ALPHABET) for p in parts)


def write_pseudo(folder: Path) -> None:
    """Write a catalogue that says all that there is to say in Arabic letters."""
    with (FOLDER / "de" / FILE).open("rb") as stream:
        catalogue = read_po(stream, locale="ar")
    for message in catalogue:
        if isinstance(message.id, str):
            message.string = pseudo(message.id) if message.id else message.string
        else:
            message.string = tuple(pseudo(message.id[1]) for _ in range(catalogue.num_plurals))
    file = folder / "ar" / FILE
    file.parent.mkdir(parents=True)
    with file.open("wb") as stream:
        write_po(stream, catalogue)
