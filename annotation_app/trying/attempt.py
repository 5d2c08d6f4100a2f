"""Following one command, in a process of its own that gives way to the server's.

An attempt is a folder. ``state.json`` says what there is so far, as :class:`Shown` has it;
``tree.svg``, ``picture.png`` and ``video.mp4`` come one after the other.
"""

from __future__ import annotations

import functools
import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from g3.errors import CorpusError
from g3.groundings import Grounding, Place
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    from corpus_tools.runtime.progress import OnProgress
    from corpus_tools.video.drawing.canvas import Image
    from corpus_tools.video.films import Film
    from g3.actions.robot_state import State
    from g3.inference.grounder import Grounder, Result

log = logging.getLogger(__name__)

STATE, TREE, PICTURE, VIDEO = "state.json", "tree.svg", "picture.png", "video.mp4"
PLANS = 10
"""Number of plans that are compared for a clause's other meanings."""
FPS, SIZE = 10, (640, 480)
"""Small, as somebody waits for it."""
TELL_S = 0.3
"""Seconds between reports of progress, at least."""

Phase = Literal["waiting", "learning", "reading", "moving", "drawing", "done"]


class Asked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command to try.

    `answers` are ids of the objects that clauses mean, by node: answers to questions. If people
    `insist`, the command is followed with the things that exist where others are missing.
    """

    scenario: str
    text: str
    answers: dict[int, str] = {}
    insist: bool = False


class Candidate(msgspec.Struct, frozen=True):
    """A clause's possible meaning; `things` are keys of :attr:`Picture.outlines`."""

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

    `missing` are nouns without a matching thing.
    """

    note: str
    steps: list[str]
    probability: float
    clauses: list[Clause]
    question: str = ""
    node: int = 0
    options: list[tuple[str, str]] = []
    missing: list[str] = []


class Picture(msgspec.Struct, frozen=True):
    """The first picture: its size, and the corners of things in its pixels."""

    width: int
    height: int
    outlines: dict[str, list[list[tuple[float, float]]]]


class Shown(msgspec.Struct, frozen=True):
    """Progress of an attempt, and of its phase; it ends where there is a problem."""

    asked: Asked
    phase: Phase = "waiting"
    done: int = 0
    total: int = 0
    problem: str = ""
    plan: Plan | None = None
    picture: Picture | None = None


def read_state(folder: Path) -> Shown | None:
    """Return the progress of an attempt; None if there is no such attempt."""
    try:
        return msgspec.json.decode((folder / STATE).read_bytes(), type=Shown)
    except (FileNotFoundError, NotADirectoryError):
        return None


def write_state(folder: Path, shown: Shown) -> None:
    """Write an attempt's progress."""
    write_bytes(folder / STATE, msgspec.json.encode(shown))


def attempt(folder: Path, model: Path | None) -> None:
    """Follow the command of an attempt's folder, and film what the robot does."""
    shown = read_state(folder)
    if shown is None:
        return
    progress = _Progress(folder, shown)
    try:
        _follow(progress, model)
    except CorpusError as error:
        progress.update(problem=str(error))
    except Exception:
        log.exception("an attempt failed")
        progress.update(problem="Something went wrong here. Try another command.")


class _Progress:
    """Progress of an attempt, written whenever it changes, but steps not too often."""

    def __init__(self, folder: Path, shown: Shown) -> None:
        self.folder, self.shown, self.told_at = folder, shown, 0.0

    def update(self, **changes: Any) -> None:
        self.shown = msgspec.structs.replace(self.shown, **changes)
        write_state(self.folder, self.shown)

    def step(self, _what: str, done: int, total: int) -> None:
        if time.monotonic() - self.told_at > TELL_S:
            self.told_at = time.monotonic()
            write_state(self.folder, msgspec.structs.replace(self.shown, done=done, total=total))


def _follow(progress: _Progress, model: Path | None) -> None:
    from corpus_tools.following.plan_execution import (  # noqa: PLC0415 - only the process that tries has all this
        run_plan,
        why_not,
    )
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415
    from g3.sdc.sdc_drawing import to_svg  # noqa: PLC0415

    asked, folder = progress.shown.asked, progress.folder
    progress.update(phase="learning")
    grounder = _grounder(model, progress.step)
    progress.update(phase="reading")
    start = _start(asked.scenario)
    # One tree, as answers are for the clauses of one.
    result = grounder.follow(
        asked.text, start, top=PLANS, answers=asked.answers, insist=asked.insist, parses=1
    )
    write_bytes(folder / TREE, to_svg(result.sdcs).encode())
    places: list[Place] = []
    progress.update(plan=_plan(result, places))
    if result.plan is None:
        progress.update(phase="done")
        return
    progress.update(phase="moving")
    if problem := why_not(start, result.plan.actions):
        progress.update(phase="done", problem=f"The plan can't be carried out: {problem}")
        return

    def on_frame(film: Film, k: int, picture: Image) -> None:
        if k == 0:
            outlines = _first_picture(folder / PICTURE, film, picture, places)
            progress.update(phase="drawing", picture=outlines)
        progress.step("drawing", k, len(film.recording.t_ns))

    how = Settings(size=SIZE, fps=FPS)
    done = run_plan(
        start, result.plan.actions, video=folder / VIDEO, settings=how, on_frame=on_frame
    )
    if done.failure is not None:
        problem = f"The plan couldn't be carried out to its end: {done.failure}"
    progress.update(phase="done", problem=problem)


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


def scenarios() -> dict[str, Path]:
    """Return the files of the scenarios that can be chosen, by name."""
    from corpus_tools.world.scenarios.library import (  # noqa: PLC0415 - as above
        dataset_folder,
        scenario_files,
    )

    return dict(scenario_files(dataset_folder("warehouse")))


@functools.lru_cache(maxsize=100)
def _start(scenario: str) -> State:
    from corpus_tools.following.start_states import scenario_start  # noqa: PLC0415 - as above

    return scenario_start(scenarios()[scenario])


def _plan(result: Result, places: list[Place]) -> Plan:
    """Return the shown part of a result; add the places that it names to `places`."""
    from g3.actions.action_words import described  # noqa: PLC0415 - as above

    question = result.question
    return Plan(
        note=result.note,
        steps=[described(a, result.plan.state.frame) for a in result.plan.actions]
        if result.plan
        else [],
        probability=result.plan.probability if result.plan else 0.0,
        clauses=list(_clauses(result, places)),
        question=question.text if question else "",
        node=question.node if question else 0,
        options=list(question.options) if question else [],
        missing=list(result.missing),
    )


def _clauses(result: Result, places: list[Place]) -> Iterator[Clause]:
    """Yield the meanings of OBJECTs and PLACEs in the best plans, each with its top probability."""
    found: dict[int, dict[tuple[str, ...], Candidate]] = {}
    clauses = {}
    for plan in result.plans:
        for grounded in plan.groundings:
            if grounded.sdc.type not in ("OBJECT", "PLACE") or not grounded.text:
                continue
            clauses[grounded.node] = grounded
            things = tuple(_key(thing, places) for thing in grounded.group)
            known = found.setdefault(grounded.node, {}).get(things)
            if known is None or known.probability < grounded.probability:
                words = " and ".join(_name(thing, plan.state.frame) for thing in grounded.group)
                candidate = Candidate(list(things), words, round(grounded.probability, 4))
                found[grounded.node][things] = candidate
    for node in sorted(found):
        likeliest = sorted(found[node].values(), key=lambda c: (-c.probability, c.words))
        yield Clause(node, clauses[node].sdc.type, clauses[node].text, likeliest)


def _key(thing: Grounding, places: list[Place]) -> str:
    if not isinstance(thing, Place):
        return f"object {getattr(thing, 'id', '')}"
    same = (i for i, place in enumerate(places) if place is thing)
    index = next(same, len(places))
    if index == len(places):
        places.append(thing)
    return f"place {index}"


def _name(thing: Grounding, frame: tuple[float, float, float]) -> str:
    from g3.actions.action_words import place_called  # noqa: PLC0415 - as above

    if isinstance(thing, Place):
        return thing.name or f"a place at {place_called(thing, frame)}, in metres"
    return str(getattr(thing, "id", "what the robot does"))


def _first_picture(path: Path, film: Film, picture: Image, places: Sequence[Place]) -> Picture:
    """Write the first frame as PNG, and return the outlines of things and places in it."""
    import cv2  # noqa: PLC0415 - as above

    from corpus_tools.video.drawing.segmentation import describe  # noqa: PLC0415

    _, content = cv2.imencode(".png", picture[..., ::-1])
    write_bytes(path, content.tobytes())
    start = replace(film.recording.start, places=tuple(places))
    return _picture(describe(film.objects, start, film.cameras[0]))


def _picture(outlines: dict[str, Any]) -> Picture:
    things = {f"object {thing['id']}": thing["polygons"] for thing in outlines["objects"]}
    areas = {
        f"place {place['index']}": [place["polygon"]]
        for place in outlines["places"]
        if place["polygon"]
    }
    return Picture(outlines["width"], outlines["height"], {**things, **areas})
