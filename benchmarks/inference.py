"""Time for a command by the number of objects: ``python -m benchmarks.inference``.

The bundled model is trained first, if it hasn't been.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.timing import best, growth, row, show
from corpus_tools.following.bundled_grounder import default_model
from corpus_tools.importers.authored.bundled import open_corpus
from g3.groundings import Context, PhysicalObject, Prism, Trajectory
from g3.inference.grounder import Grounder
from g3.inference.problem.scoring import Scorer
from g3.sdc.sdc_notation import parse_brackets

COMMANDS = {
    "pick up": "EVENT(r = Pick up, l = OBJ(f = the tire pallet))",
    "put": "EVENT(r = Put, l = OBJ(f = the tire pallet), "
    "l2 = PLACE(r = on, l = OBJ(f = the truck)))",
    "go": "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))",
}
SIZES = (8, 16, 32, 64, 100)
REPEATS = 5
LABELS = (("tire", "pallet"), ("box", "pallet"), ("crate",), ("barrel",))


def main() -> None:
    """Measure in processor time of one thread."""
    grounder = Grounder(Scorer(default_model()))
    clauses = {name: parse_brackets(text) for name, text in COMMANDS.items()}
    rows = []
    for size in SIZES:
        context = world(size)
        print(f"Inference in a world of {size} objects")
        for name, sdcs in clauses.items():
            follow = partial(grounder.follow, sdcs, context)
            seconds, _ = best(follow, REPEATS, time.process_time)
            show(name, 1000 * seconds, "ms")
            rows.append((size, seconds))
    objects, times_of = zip(*rows, strict=True)
    row(
        f"a command of one clause, {SIZES[0]} to {SIZES[-1]} objects",
        f"{1000 * min(times_of):.0f} to {1000 * max(times_of):.0f} ms",
        f"grows with objects to {growth(objects, times_of):.2f}",
    )


def world(size: int) -> Context:
    """Return a warehouse with a truck, a trailer, the robot and rows of loads, of a given size."""
    base = open_corpus("warehouse").contexts["court_go_to_second_truck"]
    things = [o for o in base.objects if o.id in ("truck-1", "trailer-1", base.agent_id)]
    loads = [_load(i) for i in range(size - len(things))]
    return replace(base, id=f"world-{size}", objects=(*loads, *things), places=())


def _load(number: int) -> PhysicalObject:
    middle = np.array([20.0 + 3.0 * (number // 10), -15.0 + 3.0 * (number % 10)])
    corners = middle + 0.6 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    pose = Trajectory(np.zeros(1), np.array([[*middle, 0.4]]), np.zeros(1))
    labels = LABELS[number % len(LABELS)]
    return PhysicalObject(f"load-{number}", labels, Prism(corners, 0.0, 0.8), pose)


if __name__ == "__main__":
    main()
