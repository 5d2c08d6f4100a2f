"""The toolkit from Python: load a corpus, train, evaluate, parse, follow, film, export.

A handful of functions that hand over to the packages :mod:`g3`, :mod:`corpus_tools` and
:mod:`eval`, which do the work and can do more. Heavy packages are imported when a function needs
them.

>>> import ct
>>> corpus = ct.load("warehouse")
>>> corpus[0].text
'Drive past the person to the end of the aisle.'
"""

from __future__ import annotations

from ct.acting import follow, parse, render
from ct.corpus_access import (
    export,
    import_authored,
    import_corpus,
    import_slu_core,
    import_treebank,
    load,
)
from ct.measurement import evaluate, learning_curve, train
from g3 import __version__

__all__ = [
    "__version__",
    "evaluate",
    "export",
    "follow",
    "import_authored",
    "import_corpus",
    "import_slu_core",
    "import_treebank",
    "learning_curve",
    "load",
    "parse",
    "render",
    "train",
]


def __dir__() -> list[str]:
    return __all__
