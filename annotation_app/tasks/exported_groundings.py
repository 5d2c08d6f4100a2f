"""Conversion of answers and groundings: shown by people, drawn at random, suggested by a model.

The model that suggests is the installation's own (``--model`` of ``ct annotate serve``); without
one there are no suggestions, for training the bundled model takes minutes. It is never asked when
something happens in a video: people choose that without a preset.
"""

from __future__ import annotations

import functools
import threading
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.items.scenes import footprint_at
from annotation_app.store.installation import installation
from annotation_app.store.models import Answer, Item, Record
from annotation_app.tasks.clause_words import HAPPENING
from annotation_app.tasks.corpus_parts import World
from annotation_app.tasks.task_record import Suggestion
from g3.annotation import Annotation, Command
from g3.errors import CorpusError
from g3.geometry.footprints import covers
from g3.groundings import Context, Grounding, PhysicalObject, Place, Prism, Trajectory
from g3.groundings import Path as GroundedPath
from g3.sdc.clauses import SDC, breadth_first, child_indices
from g3.sdc.sdc_notation import from_json

if TYPE_CHECKING:
    from g3.inference.grounder import Grounder

PLACE_HEIGHT_M = 0.3
_ONE_AT_A_TIME = threading.Lock()


def positive(
    answer: Answer, item: Item, command: Command, worlds: Mapping[str, World]
) -> Annotation:
    """Return a person's groundings as the annotation of a command."""
    world = worlds[item.payload["video"]]
    sdcs = from_json(item.payload["sdcs"])
    trims = _trims(sdcs, answer.body["trims"])
    things = {thing.id: thing for thing in world.context.objects}
    groundings: list[tuple[Grounding, ...]] = []
    for node, sdc in enumerate(breadth_first(sdcs)):
        if sdc.type in HAPPENING:
            # In a world of which no log tells what moved, nothing happens.
            moves = len(world.context.agent.trajectory) > 1
            groundings.append((_happening(world, sdc, trims[node]),) if moves else ())
            continue
        given = answer.body["groundings"].get(str(node))
        found: list[Grounding] = []
        if given is not None:
            found += [things[thing] for thing in given["objects"]]
            found += [_place(place, world.context) for place in given["places"]]
        groundings.append(tuple(found))
    return Annotation(
        id=f"{command.id}/positive",
        command=command,
        context=world.context,
        sdcs=sdcs,
        groundings=tuple(groundings),
        correct=tuple(True if found else None for found in groundings),
        source="positive",
    )


def checked_negative(
    item: Item, command: Command, worlds: Mapping[str, World], verdicts: Sequence[Record]
) -> Annotation:
    """Return a command's random groundings, labelled by the majority of verdicts."""
    sdcs = from_json(item.payload["sdcs"])
    groundings: list[tuple[Grounding, ...]] = []
    correct: list[bool | None] = []
    for node, sdc in enumerate(breadth_first(sdcs)):
        shown = item.payload["shown"].get(str(node))
        if shown is None:
            groundings.append(())
            correct.append(None)
            continue
        world = worlds[shown["video"]]
        things = {thing.id: thing for thing in world.context.objects}
        happens = sdc.type in HAPPENING
        groundings.append(
            (_happening(world, sdc, None),)
            if happens
            else (
                *(things[thing] for thing in shown["objects"]),
                *(world.context.places[index] for index in shown["places"]),
            )
        )
        correct.append(_majority(verdict.get(str(node)) for verdict in verdicts))
    return Annotation(
        id=f"{command.id}/random",
        command=command,
        context=worlds[item.payload["video"]].context,
        sdcs=sdcs,
        groundings=tuple(groundings),
        correct=tuple(correct),
        source="random",
    )


def shown_groundings(annotation: Annotation) -> Record:
    """Return OBJECT and PLACE groundings as in answers, for an editor to start from."""
    found: Record = {}
    pairs = zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    for node, (sdc, groundings) in enumerate(pairs):
        if sdc.type in ("OBJECT", "PLACE") and groundings:
            found[str(node)] = as_answered(groundings, annotation.context)
    return found


def as_answered(groundings: Iterable[Grounding], context: Context) -> Record:
    """Return a clause's groundings as in answers: things or places of the map, or corners."""
    places = {id(place): i for i, place in enumerate(context.places)}
    known = {item.id for item in context.objects}
    found = tuple(groundings)
    return {
        "objects": [g.id for g in found if isinstance(g, PhysicalObject) and g.id in known],
        "places": [
            {"place": places[id(g)]} if id(g) in places else {"xy": g.prism.xy.tolist()}
            for g in found
            if isinstance(g, Place)
        ],
        "cant_tell": False,
        "time_s": 0.0,
    }


def suggested(session: Session, item: Item) -> Suggestion | None:
    """Suggest ``{"groundings": {node: grounding}}``; None without a model or anything to do.

    An item may come with a suggestion of its own.
    """
    given: Record | None = item.payload.get("suggestion")
    model = installation().config.model
    if given is not None or model is None:
        return Suggestion(given) if given is not None else None
    scene = scene_of(session, item.study_id, item.payload["video"])
    if scene.is_picture:  # where things lie in a picture is no world
        return None
    return _proposed(model, from_json(item.payload["sdcs"]), scene.context)


def _proposed(model: Path, sdcs: tuple[SDC, ...], context: Context) -> Suggestion | None:
    try:
        with _ONE_AT_A_TIME:
            plan = _grounder(model).follow(sdcs, context, least=0.0, insist=True).plan
    except CorpusError:  # the model's file can't be read, or the clauses can't be followed
        return None
    found = {
        str(clause.node): as_answered(clause.group, context)
        for clause in (plan.groundings if plan else ())
        if clause.sdc.type in ("OBJECT", "PLACE") and not clause.sdc.is_implicit
    }
    named = {node: one for node, one in found.items() if one["objects"] or one["places"]}
    return Suggestion({"groundings": named}, plan.probability) if plan and named else None


@functools.lru_cache(maxsize=1)
def _grounder(model: Path) -> Grounder:
    from g3.inference.grounder import Grounder  # noqa: PLC0415 - slow to import
    from g3.learning.grounding_model import GroundingModel  # noqa: PLC0415 - as above

    return Grounder.load(GroundingModel.load(model))


def _trims(
    sdcs: tuple[SDC, ...], trims: Mapping[str, Sequence[float]]
) -> dict[int, Sequence[float] | None]:
    """Return the part of the video for each clause: its own, else that of the clause above it."""
    found: dict[int, Sequence[float] | None] = {}
    for node, children in enumerate(child_indices(sdcs)):
        found[node] = trims.get(str(node), found.get(node))
        for child in (c for group in children.values() for c in group):
            found[child] = found[node]
    return found


def _happening(world: World, sdc: SDC, trim: Sequence[float] | None) -> Grounding:
    """Return the robot's motion as a grounding: all of the log, or a part."""
    agent = world.context.agent
    if trim is not None:
        start, end = (world.start_s + world.scene.since_start(moment) for moment in trim)
        agent = _trimmed(agent, start, end)
    return agent if sdc.type == "EVENT" else GroundedPath(agent.trajectory)


def _trimmed(item: PhysicalObject, start: float, end: float) -> PhysicalObject:
    """Return an object's motion between two times of its clock, with its shape at the first."""
    path = item.trajectory
    first, last = np.clip([start, end], path.t[0], path.t[-1])
    inner = path.t[(path.t > first) & (path.t < last)]
    t = np.unique(np.concatenate(([first], inner, [last])))
    xyz = np.column_stack([np.interp(t, path.t, path.xyz[:, k]) for k in range(3)])
    part = Trajectory(t, xyz, np.interp(t, path.t, np.unwrap(path.yaw)))
    rise = float(xyz[0, 2] - path.xyz[0, 2])
    prism = Prism(
        footprint_at(item, float(first)), item.prism.z_min + rise, item.prism.z_max + rise
    )
    return replace(item, prism=prism, trajectory=part)


def _place(place: Record, context: Context) -> Place:
    """Return one of the context's places, or a marked one, on top of the things there."""
    if "place" in place:
        return context.places[place["place"]]
    xy = np.array(place["xy"], dtype=np.float64)
    middle = xy.mean(axis=0)
    tops = [
        thing.prism.z_max
        for thing in context.objects
        if thing.id != context.agent_id and covers(thing.prism, middle)
    ]
    bottom = max(tops, default=float(context.agent.trajectory.xyz[0, 2]))
    return Place(Prism(xy, bottom, bottom + PLACE_HEIGHT_M))


def _majority(verdicts: Iterable[object]) -> bool | None:
    counts = Counter(verdict for verdict in verdicts if isinstance(verdict, bool))
    return None if counts[True] == counts[False] else counts[True] > counts[False]
