"""The toolkit from Python: load a corpus, train, evaluate, parse, follow, film, export.

A handful of functions that hand over to the packages :mod:`g3`, :mod:`corpus_tools` and
:mod:`eval`, which do the work and can do more. Heavy packages are imported when a function needs
them.

>>> import ct
>>> corpus = ct.load("warehouse")
>>> corpus[0].text
'Drive past the person to the end of the aisle.'

For each importer (``ct import --help``) there is a function named after it, such as
``ct.import_slu_core(path)``: :func:`import_corpus` with that format.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ct.acting import follow, parse, render
from ct.corpus_access import export, import_corpus, import_function, load
from ct.measurement import evaluate
from ct.modelling import train
from g3 import __version__

__all__ = [
    "__version__",
    "evaluate",
    "export",
    "follow",
    "import_corpus",
    "load",
    "parse",
    "render",
    "train",
]

_IMPORT = "import_"

if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """Return the function of an importer: ``import_`` and its name."""
        if name.startswith(_IMPORT) and name in _of_importers():
            return import_function(_of_importers()[name], name)
        has = ", ".join(part for part in __dir__() if not part.startswith("_"))
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {has}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_of_importers()])


def _of_importers() -> dict[str, Any]:
    """Return the importers by the names of their functions."""
    from corpus_tools.importers.importer_registry import importers

    return {_IMPORT + importer.name.replace("-", "_"): importer for importer in importers()}
