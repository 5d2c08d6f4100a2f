"""Parts of an exported corpus, gathered task by task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import films_of, scene_of
from annotation_app.items.media import media_path
from annotation_app.items.new_items import REPLACED, videos_of
from annotation_app.items.scenes import Scene
from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Item, Media, Person, Study, TaskName
from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation, Command, Judgment
from g3.groundings import Context, PhysicalObject, Trajectory
from g3.short_repr import short_repr

LOG_INTERVAL_S = 10_000.0
"""Logs of different videos don't overlap on the corpus's clock."""


@short_repr
@dataclass(frozen=True, slots=True)
class World:
    """A video's scene and its context on the corpus's clock."""

    scene: Scene
    context: Context

    @property
    def start_s(self) -> float:
        """When the log begins."""
        return float(self.context.agent.trajectory.t[0])


@short_repr
@dataclass(slots=True)
class CorpusParts:
    """Parts that tasks add to: first those whose answers are commands, then the others in order."""

    session: Session
    study: Study
    original: Corpus | None
    """The corpus that the study is of, if it is of one."""
    worlds: Mapping[str, World]
    """By video."""
    people: Mapping[str, str]
    """Names of people in exports, by their ids."""
    commands: dict[int, Command] = field(default_factory=dict)
    """By the id of the answer that the command is."""
    annotations: list[Annotation] = field(default_factory=list)
    judgments: list[Judgment] = field(default_factory=list)


def gather(session: Session, study: Study) -> CorpusParts:
    """Return the parts that no answer makes: worlds, people, and the study's corpus."""
    return CorpusParts(
        session, study, _imported(session, study), _worlds(session, study), people_of(session)
    )


def answers_of(
    session: Session, study: Study, task: TaskName, *, adopted: bool | None = None
) -> Iterator[tuple[Answer, Item]]:
    """Yield the answers to a task that belong into a corpus, in the order of their arrival."""
    rows = session.execute(
        select(Answer, Item)
        .join(Item, Item.id == Answer.item_id)
        .where(
            Item.study_id == study.id,
            Item.task == task,
            Item.attention.is_(False),
            Answer.excluded.is_(False),
            ~Item.subject.startswith(REPLACED),
        )
        .order_by(Answer.id)
    )
    return ((a, item) for a, item in rows if adopted is None or a.adopted == adopted)


def add_commands(parts: CorpusParts, task: TaskName) -> None:
    """Add the answers to a task as commands for their items' videos, also those that came late."""
    for answer, item in answers_of(parts.session, parts.study, task):
        parts.commands[answer.id] = Command(
            id=answer.body.get("imported", f"{parts.study.name}-{answer.id:05d}"),
            text=answer.body["text"],
            scenario=str(answer.body.get("scenario", item.payload["video"])),
            video=str(answer.body.get("video", item.payload["video"])),
            subject=answer.body.get("subject", parts.people[answer.person_id]),
        )


def people_of(session: Session) -> dict[str, str]:
    """Return the names of people in exports, by their ids."""
    return {person.id: subject_of(person) for person in session.scalars(select(Person))}


def _imported(session: Session, study: Study) -> Corpus | None:
    path = session.scalar(
        select(Media.path).where(Media.study_id == study.id, Media.role == "corpus").limit(1)
    )
    return None if path is None else Corpus.load(path)


def _worlds(session: Session, study: Study) -> dict[str, World]:
    """Return worlds by video; logs of videos get a clock of their own each, a corpus's have theirs.

    Videos without a scene have no world.
    """
    worlds, films = {}, films_of(session, study.id)
    for number, video in enumerate(videos_of(session, study.id)):
        if video in films and not films[video].has_scene:
            continue
        scene = scene_of(session, study.id, video)
        context = scene.context
        if media_path(session, study.id, video, "corpus") is None:
            objects = tuple(_shifted(o, number * LOG_INTERVAL_S) for o in context.objects)
            context = replace(context, objects=objects)
        worlds[video] = World(scene, context)
    return worlds


def _shifted(item: PhysicalObject, seconds: float) -> PhysicalObject:
    """Return the object on a clock shifted by some seconds."""
    path = item.trajectory
    return replace(item, trajectory=Trajectory(path.t + seconds, path.xyz, path.yaw))
