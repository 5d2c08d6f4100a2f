"""Whether the robot can do what a script says, as far as that is seen without driving."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from corpus_tools.world.scenarios.boxes import Box, overlapping, put_box
from corpus_tools.world.scenarios.documents import Problem
from corpus_tools.world.scenarios.scenario import ROBOT, Robot, Thing, may_be_lifted
from corpus_tools.world.state.robot_script import ACTIONS, DRIVE_TO, TURN, Script, ScriptStep
from g3.errors import unknown_name
from g3.geometry.plane import point_gap

STANDING_ROOM_M = 0.6
"""The robot's middle keeps this far from anything where it stops in a place."""


def script_problems(
    script: Script,
    objects: Mapping[str, Thing],
    robot: Robot,
    boxes: Mapping[str, Box],
    regions: Mapping[str, Box],
) -> list[Problem]:
    """What is wrong with a script; it is followed up to the first step that can't be.

    `boxes` are everything at the start, `regions` the places.
    """
    state = _State(objects, dict(boxes), regions, robot.carries)
    for i, step in enumerate(script):
        for what, fix in state.follow(step):
            return [Problem(("script", i, step.action), what, fix)]
    return []


@dataclass(slots=True)
class _State:
    """Where everything is between two steps, as far as the steps say."""

    objects: Mapping[str, Thing]
    boxes: dict[str, Box]
    regions: Mapping[str, Box]
    held: str | None
    moved: set[str] = field(default_factory=set)

    def follow(self, step: ScriptStep) -> Iterator[tuple[str, str]]:
        """Do a step, if nothing is wrong with it."""
        action = ACTIONS.get(step.action)
        if action is None:
            yield unknown_name("action", step.action, ACTIONS)
            return
        wrong = {
            "object": self.wrong_object,
            "place": self.wrong_place,
            "number": self.wrong_number,
        }[action.argument](step)
        if wrong is not None:
            yield wrong
        elif action.kind.takes:
            yield from self.pick_up(str(step.argument))
        elif action.kind.leaves:
            yield from self.put_down(str(step.argument))
        elif action is DRIVE_TO:
            yield from self.drive_to(str(step.argument))

    def wrong_object(self, step: ScriptStep) -> tuple[str, str] | None:
        if step.argument not in self.objects:
            return unknown_name("object", step.argument, self.objects)
        if step.argument == self.held and step.kind is not None and step.kind.aims:
            return f"{step.argument} is on the forks", "name another object"
        return None

    def wrong_place(self, step: ScriptStep) -> tuple[str, str] | None:
        if step.argument not in self.regions:
            return unknown_name("place", step.argument, self.regions)
        return None

    def wrong_number(self, step: ScriptStep) -> tuple[str, str] | None:
        if isinstance(step.argument, str):
            return f"{step.argument!r} is no number", "give one"
        if step.action != TURN.name and step.argument <= 0:
            return f"{step.argument:g} is not more than 0", "correct it"
        return None

    def pick_up(self, load: str) -> Iterator[tuple[str, str]]:
        if not may_be_lifted(self.objects[load]):
            yield f"the forks can't lift {load}", "name a load"
        elif self.held is not None:
            yield f"{self.held} is on the forks already", "put it down before"
        else:
            self.held = load

    def put_down(self, place: str) -> Iterator[tuple[str, str]]:
        if self.held is None:
            yield "nothing is on the forks", "pick something up before"
            return
        box = put_box(self.boxes[self.held], self.regions[place])
        others = [(n, b) for n, b in self.boxes.items() if n not in (ROBOT, self.held)]
        for other in overlapping(box, others):
            yield f"{other} is in {place}, where {self.held} is to stand", "make room"
            return
        self.boxes[self.held] = box
        self.held = None

    def drive_to(self, place: str) -> Iterator[tuple[str, str]]:
        region = self.regions[place]
        if region.z_min > 0:
            yield f"{place} is on a deck, where the robot can't drive", "name another place"
            return
        for name, box in self.boxes.items():
            if name in (ROBOT, self.held):
                continue
            gap = point_gap(region.middle[None, None], box.footprint[None])[0, 0]
            if gap < STANDING_ROOM_M:
                yield f"{name} is in the middle of {place}", "make room"
                return
