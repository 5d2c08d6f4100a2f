"""The hand-written rules of inference, registered like feature sets.

:mod:`~g3.inference.potentials.potential_registry` is the catalogue, and
:mod:`~g3.inference.potentials.cases` are what potentials score. Importing the package registers all
potentials, and what other distributions name in the entry point group ``g3.potentials``.
"""

from g3.inference.potentials import (
    attributes,
    changes,
    command_words,
    directions,
    loaded,
    meant,
    place_rules,
    referents,
    rows,
    salience,
    sides,
    verbs,
)
from g3.inference.potentials.potential_registry import POTENTIALS

__all__ = [
    "attributes",
    "changes",
    "command_words",
    "directions",
    "loaded",
    "meant",
    "place_rules",
    "referents",
    "rows",
    "salience",
    "sides",
    "verbs",
]

POTENTIALS.load_others()
