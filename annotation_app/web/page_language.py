"""The language of a page: its study's, else the browser's preference."""

from __future__ import annotations

import functools
from collections.abc import Collection
from gettext import NullTranslations
from typing import Any

import flask
from babel import Locale
from babel.numbers import format_currency, format_decimal
from flask import Flask

from annotation_app.core.languages import (
    SOURCE,
    catalogue,
    gettext,
    languages,
    speak,
    spoken,
    translations,
)
from annotation_app.people.participants import ROLE_NAMES
from annotation_app.store.models import Role

SCRIPTS = ".js"
AMOUNT = "#,##0.00 ¤¤"
"""Format with the currency's code, which is unambiguous where a sign may not be."""


def install(app: Flask, in_english: Collection[str]) -> None:
    """Install the choice of language in an app.

    The pages of some blueprints, researchers', are English, regardless of the browser's language.
    """

    @app.before_request
    def begin() -> None:
        asked = flask.request.accept_languages.best_match(languages(), SOURCE)
        speak(SOURCE if flask.request.blueprint in in_english else asked)

    @app.teardown_request
    def end(_error: BaseException | None) -> None:
        # The thread serves somebody else next.
        speak(SOURCE)

    app.context_processor(_about_language)
    app.add_template_filter(_money, "money")
    app.add_template_filter(_number, "number")
    app.add_template_filter(_role_name, "role_name")
    app.jinja_env.add_extension("jinja2.ext.i18n")
    app.jinja_env.install_gettext_callables(  # type: ignore[attr-defined]
        lambda text: translations().gettext(text),
        lambda one, many, num: translations().ngettext(one, many, num),
        newstyle=True,
    )


def _about_language() -> dict[str, Any]:
    locale = spoken()
    return {
        "language": str(locale).replace("_", "-"),
        "direction": locale.text_direction,
        "texts_of_scripts": _texts_of_scripts,
    }


def _texts_of_scripts() -> dict[str, Any]:
    """Return the texts of the pages' scripts: each text, or its plural forms."""
    return {} if spoken().language == SOURCE else _texts(spoken(), translations())


@functools.cache
def _texts(locale: Locale, told: NullTranslations) -> dict[str, Any]:
    first = {locale.plural_form(n): n for n in range(200, -1, -1)}
    texts: dict[str, Any] = {}
    for message in catalogue(str(locale).replace("_", "-")):
        if not any(file.endswith(SCRIPTS) for file, _ in message.locations):
            continue
        if isinstance(message.id, str):
            texts[message.id] = message.string
        else:
            one, many = message.id
            texts[one] = {form: told.ngettext(one, many, n) for form, n in first.items()}
    return texts


def _money(amount: float, currency: str) -> str:
    return format_currency(amount, currency, AMOUNT, locale=spoken(), currency_digits=False)


def _role_name(role: Role) -> str:
    return gettext(ROLE_NAMES[role])


def _number(value: float) -> str:
    return format_decimal(value, locale=spoken())
