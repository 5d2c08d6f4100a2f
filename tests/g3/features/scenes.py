"""Scenes, rows and motions that the feature tests are built from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from g3.annotation import Annotation, Command
from g3.features.factor_batch import FactorBatch, FieldWords
from g3.features.feature_registry import catalogue, values
from g3.geometry.plane import rotate
from g3.groundings import (
    Context,
    FloatArray,
    Grounding,
    Path,
    PhysicalObject,
    Place,
    Trajectory,
)
from g3.language.lexicon.field_words import normalise
from g3.learning.examples import Example, to_batch
from g3.sdc.clauses import SDC, SDCType
from tests.worlds import line, log, prism, robot, scene, thing

Groundings = tuple[Grounding, ...]


def row(
    context: Context,
    type: SDCType,
    figure: Grounding | Groundings,
    *,
    landmark: Groundings = (),
    theme: Groundings = (),
    goal: Groundings = (),
    relation: str = "",
    words: str = "",
    correct: bool = True,
) -> Example:
    """One factor with its groundings; `words` are the figure's."""
    sdc = SDC(type)
    annotation = Annotation(
        "a", Command("c", "text", "scenario"), context, (sdc,), ((),), (None,), "positive"
    )
    fields: FieldWords = {
        "figure": tuple(map(normalise, words.split())),
        "name": tuple(words.lower().split()),
        "relation": tuple(map(normalise, relation.split())),
        "goal": (),
        "landmark": (),
    }
    figure = figure if isinstance(figure, tuple) else (figure,)
    return Example(annotation, 0, sdc, figure, landmark, theme, goal, fields, correct)


def table(name: str, batch: FactorBatch) -> dict[str, FloatArray]:
    """Values of a feature set by the names of its columns."""
    (feature,) = (s for s in catalogue() if s.name == name)
    columns = feature.columns_for(batch)
    return {c.name: v for c, v in zip(columns, values(feature, batch).T, strict=True)}


def one(name: str, example: Example) -> dict[str, float]:
    """Values of a feature set for one row."""
    return {column: float(v[0]) for column, v in table(name, to_batch([example])).items()}


Change = Callable[[Trajectory], Trajectory]


def change(
    rows: Sequence[Example],
    trajectory: Change = lambda log: log,
    footprint: Callable[[FloatArray], FloatArray] = lambda xy: xy,
) -> list[Example]:
    """The rows with every trajectory and footprint changed, in the contexts too."""
    done: dict[int, Grounding] = {}
    contexts: dict[int, Context] = {}

    def apply(g: Grounding) -> Grounding:
        if id(g) not in done:
            if isinstance(g, Path):
                done[id(g)] = Path(trajectory(g.trajectory))
            else:
                done[id(g)] = replace(g, prism=replace(g.prism, xy=footprint(g.prism.xy)))
            if isinstance(g, PhysicalObject):
                done[id(g)] = replace(done[id(g)], trajectory=trajectory(g.trajectory))
        return done[id(g)]

    def elsewhere(context: Context) -> Context:
        if id(context) not in contexts:
            objects = tuple(apply(o) for o in context.objects)
            contexts[id(context)] = replace(context, objects=objects)
        return contexts[id(context)]

    return [
        replace(
            example,
            annotation=replace(example.annotation, context=elsewhere(example.annotation.context)),
            **{
                role: tuple(map(apply, getattr(example, role)))
                for role in ("figure", "landmark", "theme", "goal")
            },
        )
        for example in rows
    ]


def rigid(rows: Sequence[Example], angle: float, shift: Sequence[float]) -> list[Example]:
    """The rows with the whole world turned about the origin and shifted."""

    def move(xy: FloatArray) -> FloatArray:
        return rotate(xy, np.full(len(xy), angle)) + np.array(shift)

    def carry(log: Trajectory) -> Trajectory:
        xyz = np.column_stack((move(log.xyz[:, :2]), log.xyz[:, 2]))
        return Trajectory(log.t, xyz, log.yaw + angle)

    return change(rows, carry, move)


def denser(rows: Sequence[Example], factor: int) -> list[Example]:
    """The rows with `factor` poses for one in every trajectory."""

    def refine(log: Trajectory) -> Trajectory:
        n = len(log)
        at = np.linspace(0, n - 1, (n - 1) * factor + 1)
        columns = (log.t, *log.xyz.T, np.unwrap(log.yaw))
        t, x, y, z, yaw = (np.interp(at, np.arange(n), column) for column in columns)
        return Trajectory(t, np.column_stack((x, y, z)), yaw)

    return change(rows, refine)


def yard() -> list[Example]:
    """Every type of clause about one hand-built scene with many ties, seen from the origin.

    The robot drives to a pallet at (6, 0), lifts it 1 m and takes it onto a trailer
    at (6, 8).
    """
    to_pallet, to_trailer = line((0, 0), (5, 0), 26), line((5, 0), (5, 7), 36)[1:]
    turned = np.linspace(0, np.pi / 2, len(to_trailer))
    xy = np.concatenate([to_pallet, to_trailer])
    driven = log(xy, yaw=np.concatenate([np.zeros(26), turned]))
    ahead = to_trailer + np.column_stack((np.cos(turned), np.sin(turned)))
    held = log(
        np.concatenate([[(6, 0)], ahead]),
        np.append(0, turned),
        z=[0, *[1.0] * 35],
        t=np.arange(25, 61),
    )
    pallet = thing("pallet", "tire pallet", 6, 0, trajectory=held)
    left = thing("left", "tire pallet", 10, 4)
    right = thing("right", "tire pallet", 10, -4, (2, 1.4))
    trailer = thing("trailer", "trailer", 6, 8, (6, 3))
    load = thing("load", "box pallet", 5, 8, z=(1, 2))
    agent = robot(driven)
    world = scene(pallet, left, right, trailer, load, agent=agent)
    on_trailer, floor = Place(prism(7, 8, z=(1, 2))), Place(prism(0, 6))
    path = Path(driven)
    pairs = [(load, trailer), (left, right), (pallet, trailer), (pallet, left), (agent, pallet)]
    return [
        *(
            row(world, "OBJECT", f, landmark=(g,), relation=relation, words="tires")
            for f, g in pairs
            for relation in ("on", "to the left of", "near", "in front of", "behind")
        ),
        row(world, "OBJECT", pallet, landmark=(left, right), relation="between", words="skid"),
        row(world, "OBJECT", (left, right), words="the tire pallets"),
        row(world, "OBJECT", left, words="the leftmost tire pallet"),
        row(world, "OBJECT", right, words="the second pallet"),
        row(world, "PLACE", on_trailer, landmark=(trailer,), relation="on"),
        row(world, "PLACE", floor, landmark=(pallet,), relation="left"),
        row(world, "PLACE", floor, words="there"),
        row(world, "PLACE", path, landmark=(trailer,), relation="near"),
        row(world, "PATH", path, landmark=(trailer,), relation="to"),
        row(world, "PATH", path, landmark=(pallet,), relation="past"),
        row(world, "EVENT", agent, relation="turn left"),
        row(world, "EVENT", agent, theme=(pallet,), relation="lift"),
        row(world, "EVENT", path, theme=(pallet,), goal=(on_trailer,), relation="put"),
        row(world, "EVENT", path, theme=(left,), goal=(floor,), relation="put"),
        row(world, "EVENT", path, goal=(trailer,), relation="go"),
    ]


def random_rows(seed: int) -> list[Example]:
    """Every type of clause about a scene without ties: nothing is straight or level."""
    rng = np.random.default_rng(seed)

    def drive() -> Trajectory:
        n = int(rng.integers(2, 40))
        yaw = rng.uniform(-np.pi, np.pi) + np.cumsum(rng.normal(0, 0.2, n))
        way = rng.choice([-0.7, 0.7, 0.7], n)[:, None] * np.column_stack((np.cos(yaw), np.sin(yaw)))
        return log(rng.uniform(-5, 5, 2) + np.cumsum(way, axis=0), yaw)

    def box(id: str, labels: str) -> PhysicalObject:
        x, y = rng.uniform(-8, 8, 2)
        bottom = float(rng.uniform(0, 2))
        size = tuple(rng.uniform(0.5, 4, 2))
        made = thing(id, labels, x, y, size, (bottom, bottom + float(rng.uniform(0.3, 2))))
        (turned,) = rigid([row(scene(made), "OBJECT", made)], rng.uniform(0, 7), (0, 0))
        return turned.figure[0]

    driven = drive()
    start = driven.xyz[0, :2] + rng.uniform(0, 1, 2)
    way = driven.xyz[:, :2] - driven.xyz[0, :2] + start
    held = log(way, driven.yaw, z=rng.uniform(0, 1, len(driven)))
    load = thing("load", "tire pallet", *start, trajectory=held)
    kinds = ("tire pallet", "tire pallet", "box pallet", "trailer")
    boxes = [box(f"box {i}", kinds[i % 4]) for i in range(int(rng.integers(2, 6)))]
    agent = robot(driven)
    world = scene(load, *boxes, agent=agent)
    place, path = Place(boxes[0].prism), Path(drive())
    a, b = boxes[:2]
    return [
        row(world, "OBJECT", a, landmark=(b,), relation="left of", words="furthest tires"),
        row(world, "OBJECT", load, landmark=(a, b), relation="between", words="pallet"),
        row(world, "OBJECT", (a, b), landmark=(load,), relation="on", words="pallets"),
        row(world, "OBJECT", agent, landmark=(b,), relation="front", words="you"),
        row(world, "PLACE", place, landmark=(b,), relation="behind"),
        row(world, "PLACE", path, landmark=(b,), relation="near"),
        row(world, "PATH", path, landmark=(b,), relation="to the right"),
        row(world, "PATH", agent, landmark=(load,), relation="back"),
        row(world, "EVENT", agent, theme=(load,), goal=(place,), relation="put"),
        row(world, "EVENT", path, theme=(load,), goal=(b,), relation="forward"),
    ]
