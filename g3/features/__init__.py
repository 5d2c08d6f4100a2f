"""Features of factors: geometry, trajectories, ranks and words (section 3.3).

:mod:`g3.features.registry` is the catalogue; :mod:`g3.features.batch` is what features
see; each other module holds one family; :mod:`g3.features.matrix` makes the binary
matrix. Importing the package registers everything, and what other distributions name in the
entry point group ``g3.features``.
"""

from g3.extensions import load_extensions
from g3.features import (
    artefacts,
    frames,
    moments,
    named,
    order,
    prisms,
    ranks,
    scene,
    trajectories,
    words,
)

__all__ = [
    "artefacts",
    "frames",
    "moments",
    "named",
    "order",
    "prisms",
    "ranks",
    "scene",
    "trajectories",
    "words",
]

load_extensions("g3.features")
