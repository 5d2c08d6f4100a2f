"""Factor candidates a second: base features of groundings that inference chooses between.

``python -m benchmarks.candidates``. All candidates differ in their groundings, so that nothing is
computed for one that another has computed.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np

from benchmarks.inference import world
from benchmarks.timing import best, heading, show
from g3.actions.grounding_candidates import object_groups
from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import select, values
from g3.inference.problem.packed_scene import Scene, scene_of
from g3.learning.examples import factor_words
from g3.sdc.clauses import SDCType
from g3.sdc.sdc_notation import parse_brackets

OBJECTS = (8, 60, 100)
CLAUSES: Mapping[str, tuple[SDCType, str, bool]] = {
    "noun": ("OBJECT", "OBJ(f = the tire pallet)", False),
    "noun with a landmark": (
        "OBJECT",
        "OBJ(f = OBJ(f = the pallet), r = near, l = OBJ(f = the truck))",
        True,
    ),
    "place at a landmark": ("PLACE", "PLACE(r = on, l = OBJ(f = the truck))", True),
}


def run() -> None:
    """Measure in processor time of one thread."""
    for objects in OBJECTS:
        context = world(objects)
        scene = scene_of(context, object_groups(context))
        heading(f"Base features of candidates: {objects} objects, {len(scene.groups)} with groups")
        for name, (kind, text, related) in CLAUSES.items():
            action = partial(extract, scene, kind, text, related)
            seconds, n = best(action, clock=time.process_time)
            each = f"{n} candidates, {1e6 * seconds / n:.1f} µs each"
            show(name, n / seconds, "candidates/s", each)


def extract(scene: Scene, kind: SDCType, text: str, related: bool) -> int:
    """Compute all base features; how many candidates there are."""
    batch = _batch(scene, kind, text, related)
    for feature in select():
        if kind in feature.types:
            values(feature, batch)
    return len(batch)


def _batch(scene: Scene, kind: SDCType, text: str, related: bool) -> FactorBatch:
    (sdc,) = parse_brackets(text)
    figure = np.arange(len(scene.groups))
    roles = {"figure": figure}
    if related:
        some = figure[: len(scene.context.objects)]
        pairs = np.array([(a, b) for a in some for b in some if a != b], dtype=np.intp)
        roles = {"figure": pairs[:, 0], "landmark": pairs[:, 1]}
    factor = np.zeros(len(roles["figure"]), dtype=np.intp)
    return scene.batch(kind, [factor_words(sdc)], factor, None, **roles)


if __name__ == "__main__":
    run()
