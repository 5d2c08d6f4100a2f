"""Features of factors: geometry, trajectories, ranks and words (section 3.3).

:mod:`g3.features.feature_registry` is the catalogue; :mod:`g3.features.factor_batch` is what
features see; each module of ``sets`` holds one family; :mod:`g3.features.matrix` makes the binary
matrix. Importing the package registers everything, and what other distributions name in the
entry point group ``g3.features``.
"""

from g3.features.feature_registry import FEATURES
from g3.features.sets import (  # noqa: F401 - each registers its own
    label_words,
    named,
    order,
    prisms,
    ranks,
    reference_frames,
    scene_places,
    trajectories,
)

FEATURES.load_others()
