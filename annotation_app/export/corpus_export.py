"""From the database to a corpus: commands, adopted annotations, checked negatives, judgments."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.audit import SUBJECT_CHARACTERS
from annotation_app.store.models import Answer, Item, Person, Record, Study, Task
from annotation_app.tasks.media import media_path
from annotation_app.tasks.payloads import scene_of
from annotation_app.tasks.pipeline import REPLACED, videos_of
from annotation_app.tasks.scenes import Scene
from annotation_app.tasks.trims import shifted, trimmed
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.encoding import make_corpus
from g3.actions.logged_actions import covers
from g3.annotation import RATINGS, Annotation, Command, Judgment
from g3.errors import FormatError
from g3.groundings import Context, Grounding, Place, Prism
from g3.groundings import Path as GroundedPath
from g3.sdc.clauses import SDC, breadth_first, child_indices
from g3.sdc.sdc_notation import from_json

LOG_INTERVAL_S = 10_000.0
"""Logs of different videos don't overlap on the corpus's clock."""
PLACE_HEIGHT_M = 0.3


@dataclass(frozen=True, slots=True)
class _World:
    """A video's scene and its context on the corpus's clock."""

    scene: Scene
    context: Context

    @property
    def start_s(self) -> float:
        return float(self.context.agent.trajectory.t[0])


def find_only_study(session: Session, name: str | None) -> Study:
    """The study of a name, or the only one.

    Raises
    ------
    FormatError
        If there is none, or several and no name.
    """
    studies = session.scalars(select(Study).order_by(Study.name)).all()
    found = [study for study in studies if name in (None, study.name)]
    if len(found) != 1:
        names = ", ".join(study.name for study in studies) or "none"
        what = "there is no such study" if name else "there are several studies, or none"
        raise FormatError(what, where=name or "", fix=f"the studies are: {names}")
    return found[0]


def subject_of(person: Person) -> str:
    """What exports tell of who somebody is: a part of a salted hash."""
    return person.external_hash[:SUBJECT_CHARACTERS]


def export_corpus(session: Session, study: Study, *, licence: str = "") -> Corpus:
    """A study's corpus.

    Every command is there, also those that came late. An annotation is positive if its
    grounding was adopted; its random one has the labels that most people gave who checked
    it, and none where they disagree, couldn't tell, or nobody has checked. What a corpus
    held that was imported is there as it was, where nobody has changed it.
    """
    original = _imported(session, study)
    worlds = _worlds(session, study)
    commands = _commands(session, study)
    known = {a.id: a for a in original.annotations} if original else {}
    annotations = []
    for answer, item in _answers(session, study, "ground", adopted=True):
        unchanged = known.get(answer.body.get("imported", ""))
        command = commands[item.payload["command"]]
        annotations.append(unchanged or _positive(answer, item, command, worlds))
    annotations += [a for a in known.values() if a.source != "positive"]
    annotations += _random(session, study, commands, worlds)
    return make_corpus(
        study.name,
        contexts=[world.context for world in worlds.values()],
        commands=commands.values(),
        annotations=annotations,
        judgments=[*(original.judgments if original else ()), *export_judgments(session, study)],
        outcomes=original.outcomes if original else (),
        source=f"ct annotate, study {study.name}",
        licence=licence,
    )


def _imported(session: Session, study: Study) -> Corpus | None:
    """The corpus that the study is of, if it is of one."""
    for video in videos_of(session, study.id):
        path = media_path(session, study.id, video, "corpus")
        if path is not None:
            return load_corpus(path)
    return None


def _worlds(session: Session, study: Study) -> dict[str, _World]:
    """By video. Logs of videos get a clock of their own each; a corpus's have theirs."""
    worlds = {}
    for number, video in enumerate(videos_of(session, study.id)):
        scene = scene_of(session, study.id, video)
        context = scene.context
        if media_path(session, study.id, video, "corpus") is None:
            objects = tuple(shifted(o, number * LOG_INTERVAL_S) for o in context.objects)
            context = replace(context, objects=objects)
        worlds[video] = _World(scene, context)
    return worlds


def _answers(
    session: Session, study: Study, task: Task, *, adopted: bool | None = None
) -> Iterator[tuple[Answer, Item]]:
    rows = session.execute(
        select(Answer, Item)
        .join(Item, Item.id == Answer.item_id)
        .where(
            Item.study_id == study.id,
            Item.task == task,
            Item.attention.is_(False),
            ~Item.subject.startswith(REPLACED),
        )
        .order_by(Answer.id)
    )
    return ((a, item) for a, item in rows if adopted is None or a.adopted == adopted)


def _commands(session: Session, study: Study) -> dict[int, Command]:
    """By the id of the answer."""
    people = _people(session)
    return {
        answer.id: Command(
            id=answer.body.get("imported", f"{study.name}-{answer.id:05d}"),
            text=answer.body["text"],
            scenario=str(answer.body.get("scenario", item.payload["video"])),
            video=str(answer.body.get("video", item.payload["video"])),
            subject=answer.body.get("subject", people[answer.person_id]),
        )
        for answer, item in _answers(session, study, "describe")
    }


def _people(session: Session) -> dict[str, str]:
    return {person.id: subject_of(person) for person in session.scalars(select(Person))}


def _positive(
    answer: Answer, item: Item, command: Command, worlds: Mapping[str, _World]
) -> Annotation:
    world = worlds[item.payload["video"]]
    sdcs = from_json(item.payload["sdcs"])
    trims = _trims(sdcs, answer.body["trims"])
    things = {thing.id: thing for thing in world.context.objects}
    groundings: list[tuple[Grounding, ...]] = []
    for node, sdc in enumerate(breadth_first(sdcs)):
        if sdc.type in ("EVENT", "PATH"):
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


def _trims(
    sdcs: tuple[SDC, ...], trims: Mapping[str, Sequence[float]]
) -> dict[int, Sequence[float] | None]:
    """For each clause the part of the video it refers to: its own, else that of what it is in."""
    found: dict[int, Sequence[float] | None] = {}
    for node, children in enumerate(child_indices(sdcs)):
        found[node] = trims.get(str(node), found.get(node))
        for child in (c for group in children.values() for c in group):
            found[child] = found[node]
    return found


def _happening(world: _World, sdc: SDC, trim: Sequence[float] | None) -> Grounding:
    """What the robot does: all of the log, or a part."""
    agent = world.context.agent
    if trim is not None:
        agent = trimmed(agent, world.start_s + trim[0], world.start_s + trim[1])
    return agent if sdc.type == "EVENT" else GroundedPath(agent.trajectory)


def _place(place: Record, context: Context) -> Place:
    """One of the context's places, or what was marked, on top of what is there."""
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


def _random(
    session: Session,
    study: Study,
    commands: Mapping[int, Command],
    worlds: Mapping[str, _World],
) -> list[Annotation]:
    items = session.scalars(
        select(Item).where(Item.study_id == study.id, Item.task == "check").order_by(Item.subject)
    )
    verdicts: dict[str, list[Record]] = {}
    for answer, item in _answers(session, study, "check", adopted=True):
        verdicts.setdefault(item.id, []).append(answer.body["verdicts"])
    still_adopted = {answer.id for answer, _ in _answers(session, study, "ground", adopted=True)}
    return [
        _negative(item, commands[item.payload["command"]], worlds, verdicts[item.id])
        for item in items
        if item.id in verdicts and item.payload["grounding"] in still_adopted
    ]


def _negative(
    item: Item, command: Command, worlds: Mapping[str, _World], verdicts: Sequence[Record]
) -> Annotation:
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
        happens = sdc.type in ("EVENT", "PATH")
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


def _majority(verdicts: Iterable[object]) -> bool | None:
    counts = Counter(verdict for verdict in verdicts if isinstance(verdict, bool))
    return None if counts[True] == counts[False] else counts[True] > counts[False]


def export_judgments(session: Session, study: Study) -> list[Judgment]:
    """The ratings that people have given in a study."""
    people = _people(session)
    return [
        Judgment(
            id=f"{study.name}-rating-{answer.id:05d}",
            command=item.payload["text"],
            command_video=item.payload["own_video"],
            shown_video=item.payload["video"],
            rating=RATINGS[answer.body["rating"] - 1],
            subject=people[answer.person_id],
            study=study.name,
        )
        for answer, item in _answers(session, study, "rate")
    ]
