"""spaCy without its command line, which takes a third of the time that importing spaCy takes."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType

_COMMAND_LINE = ("spacy.cli", "spacy.cli.info")


def import_spacy() -> ModuleType:
    """Import spaCy; its command line is imported when somebody first asks for it.

    Raises
    ------
    ImportError
        If spaCy isn't installed.
    """
    if "spacy" in sys.modules:
        return import_module("spacy")
    stands_in = {name: ModuleType(name) for name in _COMMAND_LINE}
    stands_in["spacy.cli.info"].__dict__["info"] = _info
    sys.modules.update(stands_in)
    try:
        return import_module("spacy")
    finally:
        for name in _COMMAND_LINE:
            sys.modules.pop(name, None)


def _info(*arguments: object, **options: object) -> object:
    """``spacy.info``, as spaCy has it."""
    return import_module("spacy.cli.info").info(*arguments, **options)
