"""Inference: time for a command by the number of objects, and beside re-scoring one by one.

``python -m benchmarks.inference`` trains the bundled model first, if it hasn't been.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.timing import heading, show
from corpus_tools.following.bundled_grounder import default_model
from corpus_tools.importers.authored.bundled import open_corpus
from g3.actions.grounding_candidates import object_groups
from g3.actions.robot_state import start_state
from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch
from g3.features.matrix import transform
from g3.groundings import Context, PhysicalObject, Prism, Trajectory
from g3.inference.grounder import Grounder
from g3.inference.problem.packed_scene import Scene, scene_of
from g3.inference.problem.scoring import Scorer
from g3.learning.examples import factor_words
from g3.sdc.clauses import SDC
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


def run() -> None:
    """Measure in processor time of one thread."""
    scorer = Scorer(default_model())
    grounder = Grounder(scorer)
    clauses = {name: parse_brackets(text) for name, text in COMMANDS.items()}
    medians = []
    for size in SIZES:
        context = world(size)
        heading(f"Inference in a world of {size} objects")
        for name, sdcs in clauses.items():
            times = [_timed(partial(grounder.follow, sdcs, context)) for _ in range(REPEATS)]
            show(name, 1000 * float(np.median(times)), "ms")
            medians.append((size, float(np.median(times))))
    sizes, times_of = np.log(np.array(medians)).T
    growth = np.polyfit(sizes, times_of, 1)[0]
    show("growth: time goes with the number of objects to the power of", growth, "")
    _against_one_by_one(scorer)


def world(size: int) -> Context:
    """A warehouse with a truck, a trailer, the robot and loads in rows, so many things in all."""
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


def _timed(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def _against_one_by_one(scorer: Scorer) -> None:
    """Score the candidates of a noun together, and each by itself as training does."""
    heading("OBJECT candidates in a world of 100 objects")
    state = start_state(world(100))
    scene = scene_of(state.context, object_groups(state.context))
    (sdc,) = parse_brackets("OBJ(f = the tire pallet)")
    together = min(_timed(lambda: _scores(scorer, scene, sdc)) for _ in range(REPEATS))
    alone = _timed(lambda: _one_by_one(scorer, scene, sdc))
    show("all together", 1000 * together, "ms")
    show("one by one", 1000 * alone, "ms")
    show("times faster", alone / together, "")


def _batch(scene: Scene, sdc: SDC, figure: IntArray) -> FactorBatch:
    factor = np.zeros(len(figure), dtype=np.intp)
    return scene.batch("OBJECT", [factor_words(sdc)], factor, figure=figure)


def _scores(scorer: Scorer, scene: Scene, sdc: SDC) -> object:
    return scorer.log_probability(_batch(scene, sdc, np.arange(len(scene.groups))))


def _one_by_one(scorer: Scorer, scene: Scene, sdc: SDC) -> object:
    model = scorer.model
    return [
        transform(_batch(scene, sdc, np.array([i])), model.sets, model.space_) @ model.weights_
        for i in range(len(scene.groups))
    ]


if __name__ == "__main__":
    run()
