"""Plans as scripts: checked before anything moves, carried out in physics, logged and filmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from corpus_tools.world.physics.rehearsal import rehearse
from corpus_tools.world.state import robot_script
from corpus_tools.world.state.dimensions import LOW
from corpus_tools.world.state.onlookers import with_onlookers
from corpus_tools.world.state.recording import Recording, to_context
from corpus_tools.world.state.robot_script import Script, ScriptStep
from g3.actions.action_kinds import Action, move
from g3.actions.action_kinds import result as after_action
from g3.actions.forklift_actions import FACE, TURN_AWAY
from g3.actions.grounding_candidates import ground, square
from g3.actions.robot_state import State, moved_to, start_state
from g3.errors import CorpusError
from g3.geometry.footprints import centre
from g3.geometry.relations import LEVEL_M
from g3.groundings import PhysicalObject, Place, Prism
from g3.inference.grounder import Result
from g3.short_repr import short_repr

if TYPE_CHECKING:
    from corpus_tools.video.films import OnFrame
    from corpus_tools.video.manifest import Settings
    from corpus_tools.world.physics.behaviours import ActionError

RATE_HZ = 50.0
"""Number of states a second in the recording of an episode."""
FPS = 15
"""Frames a second of its video, for which somebody waits."""
WAIT_S = 2.0
DECK_SHARE = 3.0
"""Width of a place on a deck for the simulated robot, relative to its own footprint; the robot puts
loads on the spot that is nearest to the middle."""


class KeptPlace(msgspec.Struct, frozen=True):
    """A place that a script names: corners in metres, heights of bottom and top."""

    xy: tuple[tuple[float, float], ...]
    z_min: float
    z_max: float
    name: str = ""


class PlanScript(msgspec.Struct, frozen=True):
    """A plan as a script: steps, and the places that these name."""

    steps: Script
    kept_places: dict[str, KeptPlace] = {}

    @property
    def places(self) -> dict[str, Place]:
        """The places by their names, as :func:`~corpus_tools.world.physics.execute` takes them."""
        return {
            key: Place(Prism(np.array(p.xy), p.z_min, p.z_max), p.name)
            for key, p in self.kept_places.items()
        }


@short_repr
@dataclass(frozen=True, slots=True)
class Episode:
    """Execution of a plan in physics."""

    start: State
    recording: Recording
    """Recording of the execution, to the end or to its failure."""
    failure: ActionError | None
    """Reason why a step could not be carried out; None if all were."""
    held: str | None
    """Id of the load on the forks at the end."""

    @property
    def end(self) -> State:
        """The state that the episode ends in."""
        last = to_context(self.recording)
        moved = tuple(_at_end(o) for o in last.objects)
        state = replace(
            start_state(replace(last, objects=moved)),
            held=self.held,
            site=self.start.site,
            frame=self.start.frame,
        )
        empty_m = float(self.recording.fork_height_m[-1]) - LOW
        return state if self.held else replace(state, forks_m=max(empty_m, 0.0))


def run_plan(
    start: State,
    plan: Sequence[Action] | PlanScript,
    *,
    rate_hz: float = RATE_HZ,
    video: Path | None = None,
    settings: Settings | None = None,
    on_frame: OnFrame | None = None,
) -> Episode:
    """Carry a plan out in physics, and film it.

    The same arguments give the same episode, bit for bit, and the same files.

    Parameters
    ----------
    start
        The state that the plan begins in.
    plan
        Its actions, or its script.
    rate_hz
        Number of states a second in the recording.
    video
        An MP4 file to write; the MCAP log comes beside it, as ``NAME.mcap``.
    settings, on_frame
        As in :func:`corpus_tools.video.films.film`, but with :data:`FPS` frames a second.
    """
    if video is not None:
        # Before MuJoCo is imported, which reads what this chooses.
        from corpus_tools.video.drawing.gl import choose_back_end  # noqa: PLC0415 - of an extra

        choose_back_end()
    try:
        from corpus_tools.world.physics.execute import execute  # noqa: PLC0415 - brings MuJoCo
    except ModuleNotFoundError as error:
        raise CorpusError(
            f"carrying plans out needs the package {error.name}",
            fix="pip install 'corpus-tools-g3[render]', or only plan (ct follow --plan-only)",
        ) from error
    script = plan if isinstance(plan, PlanScript) else to_script(start, plan)
    done = execute(
        start.context,
        script.steps,
        places=script.places,
        rate_hz=rate_hz,
        forks_m=start.forks_m,
        held=start.held,
    )
    if video is not None:
        from corpus_tools.logs.log_writing import write_log  # noqa: PLC0415 - of an extra
        from corpus_tools.video.films import film  # noqa: PLC0415 - of an extra
        from corpus_tools.video.manifest import Settings  # noqa: PLC0415 - of an extra

        how, shown = settings or Settings(fps=FPS), with_onlookers(done.recording)
        film(shown, video, how, site=start.site, on_frame=on_frame)
        write_log(shown, video.with_suffix(".mcap"), name=video.stem, metadata={})
    return Episode(start, done.recording, done.failure, done.held)


def why_not(start: State, actions: Sequence[Action]) -> str:
    """Return the reason why a plan can't be carried out; empty if it can.

    The plan is rehearsed with the behaviours of the simulated robot: their tests of free space say
    what the forks reach, where there is room, and where a way leads. This needs no simulator.

    Parameters
    ----------
    start
        The state that the plan begins in.
    actions
        The plan.
    """
    script = to_script(start, actions)
    problem = rehearse(
        start.context,
        script.steps,
        places=script.places,
        forks_m=start.forks_m,
        held=start.held,
    )
    return "" if problem is None else str(problem)


def checked(result: Result) -> Result:
    """Return the result with the reason of each plan that can't be carried out."""
    start = result.start
    if start is None:
        return result
    plans = (replace(plan, why_not=why_not(start, plan.actions)) for plan in result.plans)
    return replace(result, plans=tuple(plans))


def to_script(start: State, actions: Sequence[Action]) -> PlanScript:
    """Write a plan as a script for the simulated robot."""
    state = start
    steps: list[ScriptStep] = []
    places: dict[str, Place] = {}
    for action in actions:
        motion = move(state, [action])
        end = square(motion.xyz[0, -1, :2], float(motion.yaw[0, -1]), ground(state))
        turned = float(motion.yaw[0, -1] - motion.yaw[0, 0])
        steps += _steps(action, end, places, ground(state), turned)
        state = after_action(state, action, motion, 0)
    return PlanScript(tuple(steps), {name: _kept(place) for name, place in places.items()})


def _kept(place: Place) -> KeptPlace:
    corners = tuple((float(x), float(y)) for x, y in place.prism.xy)
    return KeptPlace(corners, float(place.prism.z_min), float(place.prism.z_max), place.name)


def _steps(
    action: Action, end: Place, places: dict[str, Place], floor_m: float, turned: float
) -> list[ScriptStep]:
    """Return the steps of an action that ends in a place, turned by `turned`; name the places."""
    kind = action.kind
    if (action_of_script := robot_script.in_script(kind, "number")) is not None:
        return [ScriptStep(action_of_script.name, _number(action))]
    if not kind.handles:
        return [_drive(action, end, places, turned)]
    steps = []
    if kind.takes:
        steps.append(ScriptStep(robot_script.PICK_UP.name, action.object_id))
    if kind.leaves and action.place is not None:
        place = _within_reach(action.place, floor_m)
        steps.append(ScriptStep(robot_script.PUT_DOWN.name, _placed(place, places)))
    return steps


def _number(action: Action) -> float:
    """Return an action's amount in the unit of scripts, which never count backwards metres."""
    if action.kind.unit == "rad":
        return float(np.rad2deg(action.amount))
    return abs(action.amount) if action.kind.unit == "m" else action.amount or WAIT_S


def _within_reach(place: Place, floor_m: float) -> Place:
    """Return a place to put a load; wider on a deck, as forks don't reach to its middle."""
    if place.prism.z_min < floor_m + LEVEL_M:
        return place
    middle = centre(place.prism)
    xy = middle + DECK_SHARE * (place.prism.xy - middle)
    return Place(Prism(xy, place.prism.z_min, place.prism.z_max), place.name)


def _drive(action: Action, end: Place, places: dict[str, Place], turned: float) -> ScriptStep:
    """Return the step of an action that drives; where scripts lack it, a drive to its end."""
    target = action.target[0] if len(action.target) == 1 else None
    if isinstance(target, PhysicalObject) and (
        action_of_script := robot_script.in_script(action.kind, "object")
    ):
        return ScriptStep(action_of_script.name, target.id)
    if isinstance(target, Place) and (
        action_of_script := robot_script.in_script(action.kind, "place")
    ):
        return ScriptStep(action_of_script.name, _placed(target, places))
    if action.kind in (FACE, TURN_AWAY):
        return ScriptStep(robot_script.TURN.name, float(np.rad2deg(turned)))
    return ScriptStep(robot_script.DRIVE_TO.name, _placed(end, places))


def _placed(place: Place, places: dict[str, Place]) -> str:
    name = f"place-{len(places) + 1}"
    places[name] = place
    return name


def _at_end(thing: PhysicalObject) -> PhysicalObject:
    track = thing.trajectory
    pose = np.array([*track.xyz[-1, :2], track.yaw[-1]])
    rise = float(track.xyz[-1, 2] - track.xyz[0, 2])
    return moved_to(thing, pose, thing.prism.z_min + rise)
