"""Generalized Grounding Graphs: the model of Tellex et al. (AAAI 2011).

The package knows nothing of corpora on disk, simulators, web servers or the command line.
The only files that it writes are models: :meth:`GroundingModel.save`, :meth:`SDCParser.save`.
Read :mod:`g3.sdc.clauses` first (what a command is made of), then :mod:`g3.groundings`
(what it can mean), :mod:`g3.annotation` (both together), :mod:`g3.graph.grounding_graph` (the
factor graph), :mod:`g3.features` and :mod:`g3.learning.crf` (the learned model).
``g3.parse`` extracts the clauses of a command, ``g3.Grounder`` follows it. ``g3.SDCParser``
and ``g3.GroundingModel`` are what they learn from annotations, with `fit` and `predict`.
"""

from __future__ import annotations

import importlib
import warnings
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from g3.inference.grounder import Grounder
    from g3.language.parsing.parser import parse, parse_many
    from g3.language.parsing.sdc_parser import SDCParser
    from g3.learning.grounding_model import GroundingModel

__all__ = ["Grounder", "GroundingModel", "SDCParser", "parse", "parse_many"]

__version__ = "0.3.0"

_MODULES = {
    "Grounder": "g3.inference.grounder",
    "GroundingModel": "g3.learning.grounding_model",
    "SDCParser": "g3.language.parsing.sdc_parser",
    "parse": "g3.language.parsing.parser",
    "parse_many": "g3.language.parsing.parser",
}


def __getattr__(name: str) -> Any:
    """Load the parser, the grounder and the models on first use."""
    if name == "SDCExtractor":
        warnings.warn("g3.SDCExtractor is g3.SDCParser now", DeprecationWarning, stacklevel=2)
        name = "SDCParser"
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULES[name]), name)
