"""The contexts of scenarios, with the logs of what the robot did in them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from corpus_tools.importers.authored.authored_files import note_file
from corpus_tools.importers.report import Journal
from corpus_tools.world.scenarios.contexts import scenario_places
from corpus_tools.world.scenarios.scenario import ROBOT, Scenario
from corpus_tools.world.scenarios.scenario_logs import log_file, scenario_log
from corpus_tools.world.state.recording import to_context
from corpus_tools.world.state.robot_script import DRIVE_TO
from g3.actions.forklift_actions import PICK_UP, PUT_DOWN, WAIT
from g3.groundings import Context, PhysicalObject, Place
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class World:
    """A scenario's context with its log."""

    scenario: Scenario
    context: Context
    """Agent and objects have their trajectories in the log."""
    places: dict[str, Place]
    moved: PhysicalObject | None
    """The object that the robot last picks up or puts down, if any."""

    @property
    def objects(self) -> dict[str, PhysicalObject]:
        """The context's objects by id, the robot among them."""
        return {item.id: item for item in self.context.objects}


def read_world(folder: Path, scenario: Scenario, start_s: float, journal: Journal) -> World:
    """Read a scenario's log, which starts at `start_s` on the corpus's clock.

    Logs of different scenarios must not overlap in time: whether two things moved together is seen
    from their clocks. FormatError if there is no log, or it shows what the scenario said before it
    was changed.
    """
    log = scenario_log(scenario, folder)
    path = log_file(scenario, folder)
    name = path.relative_to(folder).as_posix()
    note_file(name, path.read_bytes(), len(log.recording.t_ns), journal)
    context = to_context(log.recording, start_s)
    moved = _moved(scenario)
    return World(
        scenario,
        context,
        scenario_places(scenario),
        next((item for item in context.objects if item.id == moved), None),
    )


def ends(scenario: Scenario) -> dict[str, str]:
    """In which place each thing that the script brings to one shall be at the end."""
    held = scenario.robot.carries
    found: dict[str, str] = {}
    for step in scenario.script:
        argument = str(step.argument)
        if step.kind is PICK_UP:
            held = argument
            found.pop(held, None)
        elif step.kind is PUT_DOWN and held is not None:
            found[held] = argument
            held = None
        if step.action == DRIVE_TO.name:
            found[ROBOT] = argument
        elif step.kind is not WAIT:
            found.pop(ROBOT, None)
    return found


def _moved(scenario: Scenario) -> str | None:
    held, moved = scenario.robot.carries, None
    for step in scenario.script:
        if step.kind is PICK_UP:
            held = moved = str(step.argument)
        elif step.kind is PUT_DOWN:
            moved = held
    return moved
