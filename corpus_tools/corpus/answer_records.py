"""Records of plans and predictions that other programs have made, one a line.

``ct eval table3 --plans`` reads plans, ``ct eval table1 --predictions`` reads predictions, and
``--write-tasks`` writes the same records with what is asked and without answers. They are read with
the numbers of their lines.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import msgspec

from g3.groundings import Colour
from g3.sdc.clauses import SDCType
from g3.storage.atomic_file import replacing

Probability = Annotated[float, msgspec.Meta(ge=0, le=1)]
Point = tuple[float, float]


class PlanStep(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True
):
    """One action of a plan.

    Parameters
    ----------
    action
        A kind of action, such as "pick up", "carry", "put down" or "drive to".
    object
        Id of the load that is picked up, carried or put down.
    target
        Ids of the things, or names of the places, that the robot drives to, past, around, between,
        faces or leaves.
    to
        A point to drive to, instead of a target: x and y in metres.
    on, near, at
        Where a load is put down: on a thing, on the ground near one, or at a point (x and y, and
        maybe the height that it stands at, in metres). Give one of them.
    amount
        Metres to drive straight on, to back up, or to move the forks; degrees to turn, to the left
        if positive; seconds to wait.
    """

    action: str
    object: str = ""
    target: tuple[str, ...] = ()
    to: Point | None = None
    on: str = ""
    near: str = ""
    at: Annotated[tuple[float, ...], msgspec.Meta(min_length=2, max_length=3)] | None = None
    amount: float | None = None


class ThingInScene(msgspec.Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A thing as a task shows it.

    Parameters
    ----------
    labels
        What it is called in the semantic map.
    middle
        Of its footprint: x and y in metres.
    size
        Along and across its heading, and its height, in metres.
    bottom
        How high it stands, in metres.
    heading
        In degrees, counter-clockwise from +x.
    seen
        Its middle as the robot sees it: metres ahead, and metres to the left.
    liftable
        Whether the robot can lift it.
    on
        Id of the thing that it stands on; empty for the ground.
    colours
        What colours it has; none where nobody has said.
    """

    id: str
    labels: tuple[str, ...]
    middle: Point
    size: tuple[float, float, float]
    bottom: float
    heading: float
    seen: Point
    liftable: bool = False
    on: str = ""
    colours: tuple[Colour, ...] = ()


class PlaceInScene(msgspec.Struct, frozen=True, omit_defaults=True):
    """A place with a name: its middle, and its middle as the robot sees it."""

    name: str
    middle: Point
    seen: Point


class SceneShown(msgspec.Struct, frozen=True, omit_defaults=True, kw_only=True):
    """The world when a command is given.

    Parameters
    ----------
    robot
        Id of the robot.
    position
        Its x and y in metres.
    heading
        In degrees, counter-clockwise from +x.
    holds
        Id of what is on its forks; empty for nothing.
    """

    robot: str
    position: Point
    heading: float
    things: tuple[ThingInScene, ...]
    places: tuple[PlaceInScene, ...] = ()
    holds: str = ""


class PlanLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A command, and the plan that somebody has made for it.

    Parameters
    ----------
    command
        Id of the command in its corpus.
    heading
        Which way the robot faces at the start, where a table has several; else empty.
    actions
        What to do, one after the other. An empty list refuses the command; null is not filled in.
    probability
        How probably the plan is right; 0 if nothing is known of it.
    note
        Why a command is refused, or anything else.
    text
        The command, which readers of plans ignore.
    scene
        The world, which readers of plans ignore.
    """

    command: str
    heading: str = ""
    actions: tuple[PlanStep, ...] | None = None
    probability: Probability = 0.0
    note: str = ""
    text: str = ""
    scene: SceneShown | None = None


class PredictionLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A clause with groundings, and how probably they are right.

    Parameters
    ----------
    example
        What identifies it. It says nothing of how the groundings came about.
    probability
        Of φ = true; null is not filled in.
    command, text, type, words
        Id and text of the command, the clause's type and words. Readers of predictions ignore them.
    groundings
        By role, the things, places and trajectories that are claimed. Readers ignore them too.
    """

    example: str
    probability: Probability | None = None
    command: str = ""
    text: str = ""
    type: SDCType | None = None
    words: str = ""
    groundings: dict[str, tuple[dict[str, object], ...]] = {}


ANSWER_RECORDS: dict[str, type[msgspec.Struct]] = {
    "plans.jsonl": PlanLine,
    "predictions.jsonl": PredictionLine,
}
"""The record of each sort of file."""


def write_lines(path: Path, records: Iterable[msgspec.Struct]) -> int:
    """Write records, one a line, and return how many there are."""
    encoder, count = msgspec.json.Encoder(), 0
    with replacing(path) as file:
        for record in records:
            file.write(encoder.encode(record) + b"\n")
            count += 1
    return count
