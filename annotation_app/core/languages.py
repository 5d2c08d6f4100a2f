"""Texts in people's languages: gettext's catalogues, and the current language.

A catalogue is ``translations/LANGUAGE/LC_MESSAGES/messages.po``. It is read as translators write
it, when its language is first spoken: nothing has to be compiled, in a clone or in a wheel. Texts
in the code are English; ``docs/how-to/translate.md`` shows how they are translated.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from gettext import GNUTranslations, NullTranslations
from io import BytesIO
from pathlib import Path

from babel import Locale
from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po

SOURCE = "en"
"""The language that texts are written in."""
FOLDER = Path(__file__).parents[1] / "translations"
FILE = "LC_MESSAGES/messages.po"

_spoken: ContextVar[str] = ContextVar("spoken", default=SOURCE)


def languages() -> tuple[str, ...]:
    """Return the languages that have texts, as study files name them; English is the first."""
    return _languages_in(FOLDER)


def language_name(language: str) -> str:
    """Return a language's name in that language."""
    locale = Locale.parse(language, sep="-")
    return str(locale.display_name)


def spoken() -> Locale:
    """Return the current language."""
    return Locale.parse(_spoken.get(), sep="-")


def speak(language: str) -> None:
    """Speak a language from now on; English if there is no catalogue of it."""
    _spoken.set(language if language in languages() else SOURCE)


@contextmanager
def speaking(language: str) -> Iterator[None]:
    """Speak a language for a while."""
    before = _spoken.get()
    speak(language)
    try:
        yield
    finally:
        _spoken.set(before)


def N_(text: str) -> str:  # noqa: N802 - gettext's own name for it
    """Mark a text that is translated where it is shown."""
    return text


def gettext(text: str, **values: object) -> str:
    """Return a text in the current language, with values for its ``%(name)s``."""
    told = translations().gettext(text) if text else ""
    return told % values if values else told


def ngettext(one: str, many: str, num: int, **values: object) -> str:
    """Return a text about a number of things, which is its ``%(num)s``."""
    return translations().ngettext(one, many, num) % {"num": num, **values}


def translations() -> NullTranslations:
    """Return the texts of the current language."""
    return _translations(FOLDER, _spoken.get())


def catalogue(language: str) -> Catalog:
    """Return a language's catalogue as it is written."""
    name = language.replace("-", "_")
    with (FOLDER / name / FILE).open("rb") as stream:
        return read_po(stream, locale=name)


@functools.cache
def _languages_in(folder: Path) -> tuple[str, ...]:
    others = {file.parents[1].name.replace("_", "-") for file in folder.glob(f"*/{FILE}")}
    return (SOURCE, *sorted(others - {SOURCE}))


@functools.cache
def _translations(_folder: Path, language: str) -> NullTranslations:
    if language == SOURCE:
        return NullTranslations()
    compiled = BytesIO()
    write_mo(compiled, catalogue(language))
    compiled.seek(0)
    return GNUTranslations(compiled)
