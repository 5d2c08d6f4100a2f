"""Whether the groundings of a command fit what the log shows."""

from __future__ import annotations

import numpy as np

from corpus_tools.importers.authored.authored_clauses import Clauses
from corpus_tools.importers.authored.authored_worlds import World, ends
from corpus_tools.world.scenarios.scenario_files import SCENARIOS
from g3.errors import FormatError
from g3.geometry.plane import convex_hull, point_gap
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.sdc.clauses import breadth_first, child_indices

GOAL_TOLERANCE_M = 0.5


def check_log(world: World) -> None:
    """Check that the log shows what the script says.

    FormatError if the robot, or what it moves, doesn't move or doesn't end in the place it should.
    """
    where = f"{SCENARIOS}/{world.scenario.id}.yaml: script"
    for thing in filter(None, (world.context.agent, world.moved)):
        if np.ptp(thing.trajectory.xyz, axis=0).max() == 0:
            raise FormatError(
                f"{thing.id} doesn't move in the log", where=where, fix="correct the scenario"
            )
    for name, place in ends(world.scenario).items():
        if _distance(world.objects[name], world.places[place]) > 0:
            raise FormatError(
                f"{name} doesn't end in {place} in the log", where=where, fix="make the way free"
            )


def check_clauses(clauses: Clauses, world: World) -> None:
    """Check that a command's groundings fit the log.

    A command that names loads names the one that moves. A PLACE of an EVENT is where what moves
    ends, or the robot. If they don't, the FormatError's ``where`` is the field.
    """
    nodes = list(breadth_first(clauses.sdcs))
    named = [
        item
        for sdc, groundings in zip(nodes, clauses.groundings, strict=True)
        for item in groundings
        if sdc.type == "OBJECT" and isinstance(item, PhysicalObject)
    ]
    loads = any("pallet" in item.labels for item in named)
    if world.moved is not None and loads and world.moved.id not in {item.id for item in named}:
        raise FormatError(
            f"{world.moved.id}, which moves in the log, is no clause's grounding",
            where="groundings",
            fix="correct the ids",
        )
    for sdc, below in zip(nodes, child_indices(clauses.sdcs), strict=True):
        if sdc.type != "EVENT":
            continue
        for child in (*below.get("l", ()), *below.get("l2", ())):
            if nodes[child].type == "PLACE":
                _check_goal(clauses, child, world)


def _check_goal(clauses: Clauses, node: int, world: World) -> None:
    ends = [item for item in (world.moved, world.context.agent) if item is not None]
    for place in clauses.groundings[node]:
        if not isinstance(place, Place):
            raise FormatError(
                f"{clauses.names[node]} is grounded in an object",
                where=f"groundings.{clauses.names[node]}",
                fix="give a place",
            )
        if min(_distance(item, place) for item in ends) > GOAL_TOLERANCE_M:
            raise FormatError(
                f"neither {' nor '.join(item.id for item in ends)} ends in the place of "
                f"{clauses.names[node]}",
                where=f"groundings.{clauses.names[node]}",
                fix="correct the place",
            )


def _distance(item: PhysicalObject, place: Place) -> float:
    """Metres from where an object ends to a place's footprint."""
    end: FloatArray = item.trajectory.xyz[None, -1:, :2]
    return float(point_gap(end, convex_hull(place.prism.xy)[None])[0, 0])
