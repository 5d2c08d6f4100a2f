"""What our own ways of computing gain beside simpler ones: ``python -m benchmarks.own_rooms``.

Each takes turns with the simpler way, in one process, on the same data. It needs the extras
``speed`` and ``test``, and WordNet.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import shapely

from benchmarks.candidates import CLAUSES, extract
from benchmarks.inference import world
from benchmarks.timing import best_of, heading, show
from g3.actions.grounding_candidates import object_groups
from g3.errors import ModelError
from g3.features.avs import vector_sums
from g3.geometry import plane
from g3.groundings import FloatArray
from g3.inference.problem.packed_scene import scene_of
from g3.language.similarity import resources
from g3.language.similarity.wordnet_tables import wordnet_from_bytes, wordnet_to_bytes

PAIRS, CORNERS = 20_000, 6
OBJECTS = 60


def compare(title: str, ways: Mapping[str, Callable[[], object]], unit: str, scale: float) -> None:
    """Show the least processor time of each way, and what the first one gains."""
    load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    heading(f"{title} ({load})")
    for way in ways.values():
        way()  # compiles, and fills caches
    times = {name: s for name, (s, _) in best_of(ways, 5, time.process_time).items()}
    first = next(iter(times.values()))
    for name, seconds in times.items():
        show(name, seconds * scale, unit, f"{seconds / first:.1f} times the first")


def without_compiler(module: object, action: Callable[[], object]) -> object:
    """Do something with the sums of a module made on arrays, as without Numba."""
    vars(module)["HAS_COMPILER"] = False
    try:
        return action()
    finally:
        vars(module)["HAS_COMPILER"] = True


def polygons(rng: np.random.Generator) -> FloatArray:
    """Convex ones in metres, shape (PAIRS, CORNERS, 2), that lie about in a yard."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, (PAIRS, CORNERS)))
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return corners + rng.uniform(-20, 20, (PAIRS, 1, 2))


def run() -> None:
    """Measure in processor time of one process."""
    # First: sums on arrays are faster where large arrays were made and freed before.
    context = world(OBJECTS)
    scene = scene_of(context, object_groups(context))
    features = partial(extract, scene, *CLAUSES["noun with a landmark"])
    compare(
        "All base features of candidates with a landmark",
        {
            "machine code": features,
            "distances in steps on arrays": partial(without_compiler, plane, features),
            "directions in steps on arrays": partial(without_compiler, vector_sums, features),
        },
        "µs a candidate",
        1e6 / features(),
    )
    rng = np.random.default_rng(0)
    a, b = polygons(rng), polygons(rng)
    one, other = shapely.polygons(a), shapely.polygons(b)
    distances = partial(plane.gap, a, b)
    compare(
        "Distances between footprints",
        {
            "machine code": distances,
            "steps on arrays": partial(without_compiler, plane, distances),
            "Shapely": partial(shapely.distance, one, other),
        },
        "µs a pair",
        1e6 / PAIRS,
    )
    try:
        folder = resources._wordnet_folder()
    except ModelError as error:
        heading(str(error))
        return
    kept = wordnet_to_bytes(resources._parse_wordnet(folder))
    compare(
        "Reading WordNet's nouns",
        {
            "as they were kept": partial(wordnet_from_bytes, kept, where="", fix=""),
            "its own files": partial(resources._parse_wordnet, folder),
        },
        "ms",
        1e3,
    )


if __name__ == "__main__":
    run()
