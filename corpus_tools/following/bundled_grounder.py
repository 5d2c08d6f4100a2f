"""Following commands in simulated worlds: bundled models, plans as scripts, physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.decoding import read_manifest
from corpus_tools.corpus.labelled_corpus import scenario_ids
from corpus_tools.importers.authored.bundled import resolve
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.world.state import robot_script
from corpus_tools.world.state.dimensions import LOW
from corpus_tools.world.state.recording import Recording, to_context
from g3.actions.action_kinds import Action, move, result
from g3.actions.forklift_actions import FACE, TURN_AWAY
from g3.actions.grounding_candidates import GROUND_M, ground, square
from g3.actions.robot_state import State, moved_to, start_state
from g3.errors import ModelError
from g3.features.feature_registry import CATALOGUE_VERSION
from g3.geometry.footprints import centre
from g3.groundings import PhysicalObject, Place, Prism
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.examples import examples
from g3.learning.grounding_model import DEFAULT_L2, GroundingModel
from g3.learning.model_file import TrainingCard
from g3.short_repr import short_repr
from g3.storage.cache_folder import cache_folder

DEFAULT_CORPUS = "warehouse"
TRAINING_VERSION = 4
"""Version of the training, raised whenever the bundled model has to be retrained."""
WAIT_S = 2.0
DECK_SHARE = 3.0
"""Width of a place on a deck for the simulated robot, relative to its own footprint; the robot puts
loads on the spot that is nearest to the middle."""


def default_model(on_progress: OnProgress | None = None) -> GroundingModel:
    """Return the model of the bundled corpus; it is trained at the first call, then kept.

    It is kept where the bundled corpora are, under a name that has the corpus's hash and the
    version of the features.
    """
    model = kept_model()
    if model is not None:
        return model
    corpus = Corpus.load(resolve(DEFAULT_CORPUS))
    path = kept_at(corpus.hash)
    path.parent.mkdir(parents=True, exist_ok=True)
    following_model(corpus, on_progress=on_progress).save(path)
    return GroundingModel.load(path)


def kept_model() -> GroundingModel | None:
    """Return the model that :func:`default_model` has kept; None if there is none yet."""
    corpus_hash = read_manifest(resolve(DEFAULT_CORPUS)).hash
    try:
        return GroundingModel.load(kept_at(corpus_hash), corpus_hash=corpus_hash)
    except ModelError:
        return None


def kept_at(corpus_hash: str) -> Path:
    """Return the path of the model that was trained on a bundled corpus."""
    digest = corpus_hash.rpartition(":")[2][:16]
    return cache_folder() / f"follow{TRAINING_VERSION}-{digest}-{CATALOGUE_VERSION}"


def following_model(
    corpus: Corpus, *, l2: float = DEFAULT_L2, on_progress: OnProgress | None = None
) -> GroundingModel:
    """Train a model that follows commands on the candidates of search in a corpus's scenes."""
    data = training_data(corpus.annotations, search_sets(), on_progress=on_progress)
    card: TrainingCard = {
        "corpus_hash": corpus.hash,
        "scenarios": tuple(sorted(scenario_ids(examples(corpus.annotations)))),
        "training": {"corpus": corpus.name},
    }
    return GroundingModel(l2=l2, tolerance=TOLERANCE, card=card).fit(data)


@short_repr
@dataclass(frozen=True, slots=True)
class Told:
    """A plan as a script."""

    script: robot_script.Script
    places: dict[str, Place]
    """Places by the names that the steps use."""
    clause: tuple[int, ...]
    """Index of the top-level clause of each step."""


def to_script(start: State, actions: Sequence[Action]) -> Told:
    """Write a plan as a script for the simulated robot."""
    state = start
    steps: list[robot_script.ScriptStep] = []
    places: dict[str, Place] = {}
    clause: list[int] = []
    for number, action in enumerate(actions):
        motion = move(state, [action])
        end = square(motion.xyz[0, -1, :2], float(motion.yaw[0, -1]), ground(state))
        turned = float(motion.yaw[0, -1] - motion.yaw[0, 0])
        own = _steps(action, end, places, ground(state), turned)
        steps += own
        clause += [number] * len(own)
        state = result(state, action, motion, 0)
    return Told(tuple(steps), places, tuple(clause))


def _steps(
    action: Action, end: Place, places: dict[str, Place], floor_m: float, turned: float
) -> list[robot_script.ScriptStep]:
    """Return the steps of an action that ends in a place, turned by `turned`; name the places."""
    kind = action.kind
    if (told := robot_script.in_script(kind, "number")) is not None:
        return [robot_script.ScriptStep(told.name, _number(action))]
    if not kind.handles:
        return [_drive(action, end, places, turned)]
    steps = []
    if kind.takes:
        steps.append(robot_script.ScriptStep(robot_script.PICK_UP.name, action.object_id))
    if kind.leaves and action.place is not None:
        place = _within_reach(action.place, floor_m)
        steps.append(robot_script.ScriptStep(robot_script.PUT_DOWN.name, _placed(place, places)))
    return steps


def _number(action: Action) -> float:
    """Return an action's amount in the unit of scripts, which never count backwards metres."""
    if action.kind.unit == "rad":
        return float(np.rad2deg(action.amount))
    return abs(action.amount) if action.kind.unit == "m" else action.amount or WAIT_S


def _within_reach(place: Place, floor_m: float) -> Place:
    """Return a place to put a load; wider on a deck, as forks don't reach to its middle."""
    if place.prism.z_min < floor_m + GROUND_M:
        return place
    middle = centre(place.prism)
    xy = middle + DECK_SHARE * (place.prism.xy - middle)
    return Place(Prism(xy, place.prism.z_min, place.prism.z_max), place.name)


def _drive(
    action: Action, end: Place, places: dict[str, Place], turned: float
) -> robot_script.ScriptStep:
    """Return the step of an action that drives; where scripts lack it, a drive to its end."""
    target = action.target[0] if len(action.target) == 1 else None
    if isinstance(target, PhysicalObject) and (
        told := robot_script.in_script(action.kind, "object")
    ):
        return robot_script.ScriptStep(told.name, target.id)
    if isinstance(target, Place) and (told := robot_script.in_script(action.kind, "place")):
        return robot_script.ScriptStep(told.name, _placed(target, places))
    if action.kind in (FACE, TURN_AWAY):
        return robot_script.ScriptStep(robot_script.TURN.name, float(np.rad2deg(turned)))
    return robot_script.ScriptStep(robot_script.DRIVE_TO.name, _placed(end, places))


def _placed(place: Place, places: dict[str, Place]) -> str:
    name = f"place-{len(places) + 1}"
    places[name] = place
    return name


def state_after(recording: Recording, held: str | None) -> State:
    """Return the state that a recording ends in."""
    last = to_context(recording)
    moved = tuple(_at_end(o) for o in last.objects)
    state = replace(start_state(replace(last, objects=moved)), held=held)
    empty_m = float(recording.fork_height_m[-1]) - LOW
    return state if held else replace(state, forks_m=max(empty_m, 0.0))


def _at_end(thing: PhysicalObject) -> PhysicalObject:
    track = thing.trajectory
    pose = np.array([*track.xyz[-1, :2], track.yaw[-1]])
    rise = float(track.xyz[-1, 2] - track.xyz[0, 2])
    return moved_to(thing, pose, thing.prism.z_min + rise)
