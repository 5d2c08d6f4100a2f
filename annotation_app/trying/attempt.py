"""Following one command, in processes that give way to the server's: one plans, one films.

An attempt is a folder. ``state.json`` says what there is so far, as :class:`Shown` has it;
``tree.svg`` and ``video.mp4`` with its log come one after the other. The scene of a scenario is a
folder, too (:mod:`annotation_app.trying.start_scene`).
"""

from __future__ import annotations

import logging
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import msgspec
import numpy as np

from annotation_app.trying.start_scene import (
    Area,
    camera_of,
    scenario_state,
    scenarios,
    write_scene,
)
from g3.errors import AnswerError, CorpusError
from g3.groundings import Grounding, PhysicalObject, Place
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    from corpus_tools.runtime.progress import OnProgress
    from corpus_tools.video.drawing.canvas import Image
    from corpus_tools.video.films import Film
    from g3.actions.action_kinds import Action
    from g3.actions.action_words import PlanWords
    from g3.actions.robot_state import State
    from g3.inference.grounder import Grounder, Result

log = logging.getLogger(__name__)

STATE, TREE, VIDEO, LEFT = "state.json", "tree.svg", "video.mp4", "left"
PLANS = 10
"""Number of plans that are compared for a clause's other meanings."""
FPS, SIZE = 10, (640, 480)
"""Small, as somebody waits for it."""
SAME_M = 0.1
"""Places whose middles are as near are one."""
WARMING = (
    "Pick up the box pallet on the left, then put it down beside the person",
    "Take both tire pallets to the truck and go past the shelf",
)
TELL_S = 0.3
"""Seconds between reports of progress, at least."""

Actions: TypeAlias = "Sequence[Action]"
Phase = Literal["waiting", "learning", "reading", "moving", "drawing", "done"]


class Asked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command to try.

    `answers` are answers to questions by node: ids of objects, or words. If people
    `insist`, the command is followed with the things that exist where others are missing.
    """

    scenario: str
    text: str
    answers: dict[int, str] = {}
    insist: bool = False


class Candidate(msgspec.Struct, frozen=True):
    """A clause's possible meaning: keys of a scene's things and of :attr:`Plan.places`.

    The probability is the part of the best plans, by their scores, in which the clause means this.
    """

    things: list[str]
    words: str
    probability: float


class Clause(msgspec.Struct, frozen=True):
    """A clause and its possible meanings, the likeliest first."""

    node: int
    type: str
    text: str
    candidates: list[Candidate]


class Plan(msgspec.Struct, frozen=True):
    """The result; without steps if there is nothing to do, and then `note` gives the reason.

    `places` are the places that clauses may mean; `missing` are nouns without a matching thing.
    """

    note: str
    steps: list[str]
    probability: float
    clauses: list[Clause]
    question: str = ""
    node: int = 0
    options: list[tuple[str, str]] = []
    missing: list[str] = []
    places: list[Area] = []


class Shown(msgspec.Struct, frozen=True):
    """Progress of an attempt, and of its phase; it ends where there is a problem."""

    asked: Asked
    phase: Phase = "waiting"
    done: int = 0
    total: int = 0
    problem: str = ""
    plan: Plan | None = None
    has_video: bool = False


def read_state(folder: Path) -> Shown | None:
    """Return the progress of an attempt; None if there is no such attempt."""
    try:
        return msgspec.json.decode((folder / STATE).read_bytes(), type=Shown)
    except (FileNotFoundError, NotADirectoryError):
        return None


def write_state(folder: Path, shown: Shown) -> None:
    """Write an attempt's progress."""
    write_bytes(folder / STATE, msgspec.json.encode(shown))


def plan(folder: Path, model: Path | None) -> Actions | None:
    """Plan the command of an attempt's folder; return the actions to carry out, if any."""
    progress = _Progress.of(folder)
    if progress is not None:
        with progress.told():
            return _plan_of(progress, model)
    return None


def film(folder: Path, actions: Actions) -> None:
    """Carry the actions of an attempt out, and film it, unless people have left it."""
    progress = _Progress.of(folder)
    if progress is not None and not is_left(folder):
        with progress.told():
            _film(progress, actions)


class _Progress:
    """Progress of an attempt, written whenever it changes, but steps not too often."""

    def __init__(self, folder: Path, shown: Shown) -> None:
        self.folder, self.shown, self.told_at = folder, shown, 0.0

    @classmethod
    def of(cls, folder: Path) -> _Progress | None:
        shown = read_state(folder)
        return None if shown is None else cls(folder, shown)

    @contextmanager
    def told(self) -> Iterator[None]:
        """Report what goes wrong in the block to those who wait."""
        try:
            yield
        except CorpusError as error:
            self.update(phase="done", problem=str(error))
        except Exception:
            log.exception("an attempt failed")
            problem = "Something went wrong here. Try another command."
            self.update(phase="done", problem=problem)

    def update(self, **changes: Any) -> None:
        self.shown = msgspec.structs.replace(self.shown, **changes)
        write_state(self.folder, self.shown)

    def step(self, _what: str, done: int, total: int) -> None:
        if time.monotonic() - self.told_at > TELL_S:
            self.told_at = time.monotonic()
            write_state(self.folder, msgspec.structs.replace(self.shown, done=done, total=total))


def _plan_of(progress: _Progress, model: Path | None) -> Actions | None:
    from g3.sdc.sdc_drawing import to_svg  # noqa: PLC0415 - only the process that plans has all this

    asked, folder = progress.shown.asked, progress.folder
    progress.update(phase="learning")
    grounder = _grounder(model, progress.step)
    progress.update(phase="reading")
    start = scenario_state(asked.scenario)
    # One tree, as answers are for the clauses of one.
    how_to: dict[str, Any] = {"top": PLANS, "insist": asked.insist, "parses": 1}
    unclear = ""
    try:
        result = grounder.follow(asked.text, start, answers=asked.answers, **how_to)
    except AnswerError as error:
        result, unclear = grounder.follow(asked.text, start, **how_to), str(error)
    write_bytes(folder / TREE, to_svg(result.sdcs).encode())
    shown = _plan(result, start)
    if result.plan is None or unclear:
        progress.update(plan=shown, phase="done", problem=unclear)
        return None
    progress.update(plan=shown, phase="waiting")
    return result.plan.actions


def leave(folder: Path) -> None:
    """Note that nobody waits for an attempt any more."""
    (folder / LEFT).touch()


def is_left(folder: Path) -> bool:
    """Check that nobody waits for an attempt any more."""
    return (folder / LEFT).exists()


def _film(progress: _Progress, actions: Actions) -> None:
    from corpus_tools.following.plan_execution import run_plan, why_not  # noqa: PLC0415 - as above
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415

    def on_frame(film: Film, k: int, _picture: Image) -> None:
        if is_left(progress.folder):
            raise CorpusError("Another command was tried before the video was made.")
        if progress.shown.phase != "drawing":
            progress.update(phase="drawing")
        progress.step("drawing", k, len(film.recording.t_ns))

    progress.update(phase="moving")
    start = scenario_state(progress.shown.asked.scenario)
    if problem := why_not(start, actions):
        progress.update(phase="done", problem=f"The plan can't be carried out: {problem}")
        return
    done = run_plan(
        start,
        actions,
        video=progress.folder / VIDEO,
        settings=Settings("overview", SIZE, FPS),
        on_frame=on_frame,
    )
    if done.failure is not None:
        problem = f"The plan couldn't be carried out to its end: {done.failure}"
    progress.update(phase="done", problem=problem, has_video=True)


_grounders: dict[Path | None, Grounder] = {}


def _grounder(model: Path | None, on_progress: OnProgress) -> Grounder:
    """Return a model's grounder, which is kept; without a model, the bundled one's."""
    from corpus_tools.following.bundled_grounder import default_model  # noqa: PLC0415 - as above
    from g3.inference.grounder import Grounder  # noqa: PLC0415
    from g3.learning.grounding_model import GroundingModel  # noqa: PLC0415

    if model not in _grounders:
        found = default_model(on_progress) if model is None else GroundingModel.load(model)
        _grounders[model] = Grounder.load(found)
    return _grounders[model]


def first_scenario() -> str:
    """Return the scenario that the page shows first."""
    return min(scenarios())


def warm_up(model: Path | None) -> None:
    """Load the model and the language, and plan commands, so that the first one isn't slow."""
    from g3.sdc.sdc_drawing import to_svg  # noqa: PLC0415 - as above

    try:
        grounder = _grounder(model, lambda _what, _done, _total: None)
        start = scenario_state(first_scenario())
        for text in WARMING:
            shown = grounder.follow(text, start, top=PLANS, parses=1, insist=True)
            _plan(shown, start)
            to_svg(shown.sdcs)
    except CorpusError:
        log.info("the model that follows commands isn't ready", exc_info=True)


def prepare(folder: Path, scenario: str) -> None:
    """Write a scenario's scene."""
    try:
        write_scene(folder, scenario)
    except CorpusError:
        log.info("a scene wasn't prepared", exc_info=True)


def _plan(result: Result, start: State) -> Plan:
    """Return the shown part of a result."""
    from g3.actions.action_words import PlanWords  # noqa: PLC0415 - as above

    plan, question = result.plan, result.question
    words = PlanWords(start, plan.actions if plan else (), points=False)
    places = _Places(words)
    clauses = list(_clauses(result, places))
    camera = camera_of(start)
    return Plan(
        note=result.note,
        steps=list(map(words.action, plan.actions)) if plan else [],
        probability=plan.probability if plan else 0.0,
        clauses=clauses,
        question=question.text if question else "",
        node=question.node if question else 0,
        options=list(question.options) if question else [],
        missing=list(result.missing),
        places=[Area.of(place, start, camera) for place in places.found],
    )


class _Places:
    """The places of a result, each once, in words."""

    def __init__(self, words: PlanWords) -> None:
        self._words, self.found = words, list[Place]()

    def called(self, place: Place) -> Place:
        """Return a place with its words as its name."""
        return replace(place, name=self._words.group((place,)) or "a place")

    def key(self, thing: Grounding) -> str:
        """Return what a thing or place is known by on the page."""
        if not isinstance(thing, Place):
            return f"object {getattr(thing, 'id', '')}"
        named = self.called(thing)
        for number, other in enumerate(self.found):
            apart = np.abs(other.prism.xy.mean(axis=0) - thing.prism.xy.mean(axis=0)).max()
            if other.name == named.name and apart < SAME_M:
                return f"place {number}"
        self.found.append(named)
        return f"place {len(self.found) - 1}"

    def words(self, thing: Grounding) -> str:
        """Return what a thing or place is called."""
        if isinstance(thing, Place):
            return self.called(thing).name
        if isinstance(thing, PhysicalObject):
            return f"{' '.join(thing.labels)} ({thing.id})"
        return "what the robot does"


def _clauses(result: Result, places: _Places) -> Iterator[Clause]:
    """Yield the meanings of OBJECTs and PLACEs in the best plans, each with its part of them."""
    scores = np.array([plan.score for plan in result.plans])
    weights = np.exp(scores - scores.max()) if len(scores) else scores
    found: dict[int, dict[tuple[str, ...], float]] = defaultdict(lambda: defaultdict(float))
    words, clauses = {}, {}
    for plan, weight in zip(result.plans, weights, strict=True):
        for grounded in plan.groundings:
            if grounded.sdc.type not in ("OBJECT", "PLACE") or not grounded.text:
                continue
            clauses[grounded.node] = grounded
            things = tuple(places.key(thing) for thing in grounded.group)
            words[things] = " and ".join(places.words(thing) for thing in grounded.group)
            found[grounded.node][things] += float(weight)
    for node in sorted(found):
        total = sum(found[node].values())
        candidates = [
            Candidate(list(things), words[things], round(weight / total, 4))
            for things, weight in found[node].items()
        ]
        candidates.sort(key=lambda c: (-c.probability, c.words))
        yield Clause(node, clauses[node].sdc.type, clauses[node].text, candidates)
