"""A corpus as a study, and a table's commands: adopted answers, which annotators may replace."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.items.new_items import GIVEN, about_answer, new_slots
from annotation_app.people.participants import hashed
from annotation_app.store.database import lock_set_up
from annotation_app.store.installation import now
from annotation_app.store.models import (
    Answer,
    Base,
    Event,
    Handout,
    Item,
    Person,
    Record,
    Study,
    TaskName,
)
from annotation_app.studies.study_file import StudyConfig, TaskConfig, stored
from annotation_app.study_setup.own_videos import GivenCommand
from annotation_app.study_setup.rendered_study import Rendered, add_video, put_media, spelled_names
from annotation_app.tasks.exported_groundings import shown_groundings
from annotation_app.work.adoption import answered
from annotation_app.work.answer_flags import odd_below
from annotation_app.work.answer_reading import gist_of
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.task_outcomes import contexts_of_commands
from corpus_tools.tables.file_names import normal_name
from g3.annotation import Annotation, Command
from g3.errors import FormatError
from g3.sdc.sdc_notation import to_json

PROVIDER = "import"
ID_CHARACTERS = 12


def import_corpus(
    session: Session,
    corpus: Corpus,
    folder: Path,
    videos: list[Rendered] | None,
    *,
    name: str,
    salt: bytes,
) -> Mapping[str, int]:
    """Add a study that holds a corpus, and return counts of its contents.

    Parameters
    ----------
    folder
        Folder of the corpus; the study keeps reading its contexts there.
    videos
        Replays of its contexts. Without them it is a study of texts: people correct the clauses
        that commands have, or mark those of commands that have none.

    Raises
    ------
    FormatError
        If there is such a study already, or a context has no video.
    """
    if session.scalar(select(Study.id).where(Study.name == name)) is not None:
        raise FormatError("there is a study of this name", where=name, fix="give --study")
    shown = {item.video: item for item in videos or ()}
    missing = [] if videos is None else [key for key in corpus.contexts if key not in shown]
    if missing:
        raise FormatError(
            f"the context {missing[0]} has no video",
            where=str(folder),
            fix=f"make it with `ct render-videos --corpus {folder} --out FOLDER`",
        )
    config = StudyConfig(
        name=name,
        title=corpus.name,
        tasks={
            task: TaskConfig(role="annotator", practice=False)
            for task in (("segment",) if videos is None else ("describe", "segment", "ground"))
        },
    )
    study = Study(id=new_id(), name=name, config=stored(config), created_at=now())
    session.add(study)
    session.flush()
    for key in corpus.contexts:
        if videos is not None:
            add_video(session, study.id, shown[key])
        put_media(session, study.id, key, {"corpus": folder})
    contexts = contexts_of_commands(corpus)
    annotated: dict[str, list[Annotation]] = {}
    for annotation in corpus.annotations:
        if annotation.source == "positive":
            if annotation.context.id != contexts[annotation.command.id]:
                raise FormatError(
                    "the command is annotated in several contexts, and so has no video of its own",
                    where=f"{folder}: {annotation.command.id}",
                    fix="import a corpus whose commands have one context each",
                )
            annotated.setdefault(annotation.command.id, []).append(annotation)
    found = [
        (command, video, annotated.get(command.id, []))
        for command in corpus.commands.values()
        if (video := contexts.get(command.id)) is not None
    ]
    loader = AnswerLoader(session, study, corpus.hash, salt)
    return loader.load_texts(found) if videos is None else loader.load(found)


@dataclass(frozen=True, slots=True)
class GivenAnswer:
    """An answer, and what it answers."""

    task: TaskName
    subject: str
    payload: Record
    person: Person
    body: Record
    rank: int


@dataclass(slots=True)
class AnswerLoader:
    """Adds items with answers, those of one task after those of the other.

    `corpus_hash` is of what names people: the same name elsewhere is somebody else. The salt is the
    installation's.
    """

    session: Session
    study: Study
    corpus_hash: str
    salt: bytes
    people: dict[str, Person] = field(default_factory=dict)

    def load(self, found: Sequence[tuple[Command, str, list[Annotation]]]) -> Mapping[str, int]:
        """Add commands, each with its video and what it is annotated with; count them."""
        described = self.answers([self.typed(c, video, i) for i, (c, video, _) in enumerate(found)])
        trees: list[tuple[Annotation, GivenAnswer]] = []
        for rank, (typed, (command, video, annotated)) in enumerate(
            zip(described, found, strict=True)
        ):
            about = {"text": command.text, "command": typed.id, "video": video}
            if not annotated:
                self.session.add(self.item("segment", typed.subject, about, rank))
            for annotation in annotated:
                sdcs = to_json(annotation.sdcs)
                given = GivenAnswer(
                    "segment",
                    f"study {self.study.name} {annotation.id}",
                    {**about, "suggestion": sdcs},
                    self.person(command),
                    {"sdcs": sdcs},
                    rank,
                )
                trees.append((annotation, given))
        segmented = self.answers([given for _, given in trees])
        groundings = [
            GivenAnswer(
                "ground",
                about_answer(answer),
                {name: given.payload[name] for name in ("text", "command", "video")} | given.body,
                given.person,
                {
                    "groundings": shown_groundings(annotation),
                    "trims": {},
                    "imported": annotation.id,
                },
                given.rank,
            )
            for (annotation, given), answer in zip(trees, segmented, strict=True)
        ]
        grounded = self.answers(groundings)
        return {
            "commands": len(described),
            "segmentations": len(segmented),
            "groundings": len(grounded),
        }

    def load_texts(
        self, found: Sequence[tuple[Command, str, list[Annotation]]]
    ) -> Mapping[str, int]:
        """Add commands, each with an item to correct its clauses or to mark them; count both."""
        described = self.answers([self.typed(c, video, i) for i, (c, video, _) in enumerate(found)])
        items = []
        for rank, (typed, (command, video, annotated)) in enumerate(
            zip(described, found, strict=True)
        ):
            about = {"text": command.text, "command": typed.id, "video": video, "corrects": True}
            known = {"suggestion": to_json(annotated[0].sdcs)} if annotated else {}
            items.append(self.item("segment", typed.subject, about | known, rank))
        self._add(items)
        count = sum(bool(annotated) for _, _, annotated in found)
        return {
            "commands": len(described),
            "to correct": count,
            "to segment": len(described) - count,
        }

    def typed(self, command: Command, video: str, rank: int) -> GivenAnswer:
        """Return a command as the answer of the person who typed it."""
        body = {
            "text": command.text,
            "watched_s": 0.0,
            "imported": command.id,
            "scenario": command.scenario,
            "video": command.video,
            "subject": command.subject,
        }
        subject = f"study {self.study.name} {command.id}"
        return GivenAnswer("describe", subject, {"video": video}, self.person(command), body, rank)

    def person(self, command: Command) -> Person:
        """Return the person that the command's subject stands for."""
        subject = command.subject or command.id
        if subject not in self.people:
            digest = hashed(self.salt, PROVIDER, f"{self.corpus_hash} {subject}")
            known = self.session.scalars(
                select(Person).where(Person.provider == PROVIDER, Person.external_hash == digest)
            ).first()
            person = known or Person(
                id=new_id(),
                role="worker",
                provider=PROVIDER,
                external_hash=digest,
                profile={},
                created_at=now(),
            )
            self.session.add(person)
            self.session.flush()
            self.people[subject] = person
        return self.people[subject]

    def item(self, task: TaskName, subject: str, payload: Record, rank: int) -> Item:
        """Return an item with one slot."""
        item = Item(
            id=new_id(),
            study_id=self.study.id,
            task=task,
            subject=subject,
            payload=payload,
            rank=float(rank),
            attention=False,
        )
        item.slots = new_slots(item, 1)
        return item

    def answers(self, given: Sequence[GivenAnswer]) -> list[Answer]:
        """Add items that are answered."""
        at = now()
        items = [self.item(g.task, g.subject, g.payload, g.rank) for g in given]
        for g, item in zip(given, items, strict=True):
            (slot,) = item.slots
            slot.answered, slot.person_id, slot.expires_at = True, g.person.id, at
        self._add(items)
        events = [
            Event(
                uuid=str(uuid.uuid4()),
                item_id=item.id,
                person_id=g.person.id,
                name="submit",
                body=g.body,
                at=at,
            )
            for g, item in zip(given, items, strict=True)
        ]
        self._add(events)
        self._add([Handout(item_id=e.item_id, person_id=e.person_id, at=at) for e in events])
        answers = [
            Answer(
                item_id=event.item_id,
                study_id=self.study.id,
                kind="usual",
                person_id=event.person_id,
                task=g.task,
                subject=g.subject,
                event_id=event.id,
                body=g.body,
                gist=gist_of(g.task, g.body),
                odd_below_s=odd_below(g.payload, g.body, None),
                surplus=False,
                adopted=True,
                seconds=None,
                at=at,
            )
            for g, event in zip(given, events, strict=True)
        ]
        self._add(answers)
        return answers

    def _add(self, rows: Sequence[Base]) -> None:
        self.session.add_all(rows)
        self.session.flush()


def put_commands(
    session: Session, study: Study, commands: Sequence[GivenCommand], salt: bytes
) -> int:
    """Add the missing commands, and return their number."""
    lock_set_up(session.connection())
    loader = AnswerLoader(session, study, f"study {study.name}", salt)
    subjects = select(Item.subject).where(Item.study_id == study.id, Item.subject.startswith(GIVEN))
    known = set(session.scalars(subjects))
    there = spelled_names(session, study.id)
    new = []
    for rank, one in enumerate(commands):
        given = replace(one, video=there.get(normal_name(one.video), one.video))
        digest = hashlib.sha256(f"{given.video}\0{given.text}".encode()).hexdigest()
        subject = f"{GIVEN}{digest}"
        if subject in known:
            continue
        known.add(subject)
        metadata = dict(given.metadata)
        named = metadata.pop("subject", "")
        # Whoever it names is told by a hash, as everybody else.
        who = hashed(salt, PROVIDER, f"{study.name} {named}")[:ID_CHARACTERS] if named else ""
        command = Command(
            f"{study.name}-{digest[:ID_CHARACTERS]}", given.text, given.video, given.video, who
        )
        typed = loader.typed(command, given.video, rank)
        new.append(replace(typed, subject=subject, body={**typed.body, "metadata": metadata}))
    for answer in loader.answers(new):
        answered(session, answer.task, answer.id)
    return len(new)
